#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure what it takes to start processes once others are ready.

usage: python benchmarks/readiness.py [--runs N] [--nodes N] [WORD ...]

It needs the extra `ros`. Prints a table: what was measured, the figure, and
the one to reach. Times are medians of several runs. A row is measured if it
contains one of the words; without words all are.

The nodes are real ones, with rclpy. The time of a publisher is that just
before its node creates it, so it includes the time that DDS takes to announce
it.
"""

import argparse
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
import json
import os
from pathlib import Path
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from typing import Any

#: Seconds that a launch is watched while nothing happens.
QUIET_SECONDS = 20.0
#: Seconds that nodes get to find each other before.
SETTLING = 5.0
PATIENCE = 300.0
STAGES = 5
#: Conditions that hold, and as many that never do, in the row about rest.
PENDING = 5
#: Fast DDS has at most 100 processes in a domain.
NODES_PER_PROCESS = 4
#: Has nodes with the names in its arguments. After a number of seconds, the
#: first of these, it publishes a topic, and writes when it did.
NODE = """\
import sys, time
import rclpy
from rclpy.node import Node
from std_msgs.msg import String
_, seconds, *names = sys.argv
with rclpy.init():
    nodes = [Node(name) for name in names]
    time.sleep(float(seconds))
    with open('published_at', 'w') as file:
        file.write(str(time.time()))
    nodes[0].create_publisher(String, 'scan', 1)
    rclpy.spin(nodes[0])
"""


@dataclass(frozen=True)
class Row:
    """
    A line of the table.

    :param what: What is measured
    :param target: What to reach
    :param measure: Measures it
    """

    what: str
    target: str
    measure: Callable[['Options'], str]


@dataclass(frozen=True)
class Options:
    """
    What is measured, and how often.

    :param environment: That of launches, with its own ROS domain
    :param runs: How often what takes a few seconds is measured
    :param nodes: How many nodes are started in stages
    """

    environment: Mapping[str, str]
    runs: int
    nodes: int


@dataclass(frozen=True)
class Launch:
    """
    A launch that runs.

    :param pid: The process of the launcher
    :param folder: The folder of its log
    """

    pid: int
    folder: Path

    def wait_for(self, name: str, count: int) -> float:
        """Wait for so many events, and return the time of the last one."""
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            times = list(self._times_of(name))
            if len(times) >= count:
                return max(times)
            time.sleep(0.1)
        sys.exit(f'there are not {count} events {name!r}')

    def _times_of(self, name: str) -> Iterator[float]:
        path = self.folder / 'log/latest_launch/events.jsonl'
        if not path.exists():
            return
        for line in path.read_text(encoding='utf-8').splitlines():
            try:
                event = json.loads(line)
            except ValueError:
                # not whole yet
                return
            if event['event'] == name:
                yield float(event['time'])


@contextmanager
def launched(
    options: Options,
    processes: list[dict[str, Any]],
    rules: list[dict[str, Any]],
) -> Iterator[Launch]:
    """
    Run a launch.

    :param processes: The attributes of each `executable`
    :param rules: Those of a deployment file; without any there is no file
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        entries = [{'executable': process} for process in processes]
        (folder / 'node.py').write_text(NODE)
        (folder / 'l.yaml').write_text(json.dumps({'launch': entries}))
        words = ['colcon', 'launch', 'l.yaml', '--no-status']
        if rules:
            (folder / 'd.yaml').write_text(json.dumps({'processes': rules}))
            words += ['--deploy', 'd.yaml']
        launch = subprocess.Popen(
            words,
            cwd=folder,
            env={**options.environment, 'COLCON_LOG_PATH': f'{folder}/log'},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            yield Launch(launch.pid, folder)
        finally:
            launch.send_signal(signal.SIGINT)
            launch.wait()


def node(name: str, seconds: float, *others: str) -> dict[str, Any]:
    """
    Return the attributes of a process that is a node.

    :param seconds: When it publishes a topic
    :param others: The names of further nodes in the process
    """
    command = f'{sys.executable} node.py {seconds}'
    return {
        'cmd': ' '.join((command, name, *others)),
        'name': name,
        'sigterm_timeout': '1',
    }


def latency(options: Options) -> str:
    """Take the time from a publisher to the start of the next process."""
    times = []
    for number in range(options.runs):
        # so that it is not in step with anything
        processes = [
            node('lidar', 3 + 0.37 * number),
            {'cmd': 'sleep 1000', 'name': 'planner'},
        ]
        rules = [
            {'match': {'executable': 'lidar*'}, 'ready': {'topic': 'scan'}},
            {'match': {'executable': 'planner*'}, 'after': 'lidar-1'},
        ]
        with launched(options, processes, rules) as launch:
            started = launch.wait_for('started', 2)
            published = (launch.folder / 'published_at').read_text()
        times.append(started - float(published))
    return f'{statistics.median(times):.3f} s, at most {max(times):.3f} s'


def stages(options: Options) -> str:
    """Take the time until all nodes are ready, at once and in stages."""
    return ', '.join(
        f'{_seconds_to_ready(options, number):.1f} s' for number in (1, STAGES)
    )


def rest(options: Options) -> str:
    """
    Measure launches with and without readiness while nothing happens.

    The CPU is that of the launcher and of the ROS client.
    """
    names = [f'n{number}' for number in range(2 * PENDING)]
    processes = [node(name, 0) for name in names]
    rules = [
        {
            'match': {'executable': f'{name}*'},
            'ready': {'topic': 'never' if index % 2 else 'scan'},
            'ready_timeout': 3600,
        }
        for index, name in enumerate(names)
    ]
    shares = []
    for given in (rules, []):
        with launched(options, processes, given) as launch:
            launch.wait_for('started', len(names))
            if given:
                launch.wait_for('ready', PENDING)
            time.sleep(SETTLING)
            pids = [launch.pid, *_clients_of(launch.pid)]
            before = sum(map(_cpu_seconds, pids))
            time.sleep(QUIET_SECONDS)
            used = sum(map(_cpu_seconds, pids)) - before
        shares.append(100 * used / QUIET_SECONDS)
    both, without = shares
    return f'{both:.3f} %, without it {without:.3f} %'


def _seconds_to_ready(options: Options, number: int) -> float:
    """
    Take the time from the command until all nodes are in the graph.

    :param number: The number of stages
    """
    count = options.nodes // NODES_PER_PROCESS
    groups = [
        [f's{i % number}p{i}n{n}' for n in range(NODES_PER_PROCESS)]
        for i in range(count)
    ]
    rules: list[dict[str, Any]] = [
        {
            'match': {'executable': names[0]},
            'ready': [{'node': f'/{name}'} for name in names],
        }
        for names in groups
    ]
    rules += [
        {'match': {'executable': f's{stage}p*'}, 'after': f's{stage - 1}p*'}
        for stage in range(1, number)
    ]
    processes = [node(first, 0, *rest) for first, *rest in groups]
    begin = time.time()
    with launched(options, processes, rules) as launch:
        return launch.wait_for('ready', count) - begin


def _clients_of(pid: int) -> list[int]:
    children = Path(f'/proc/{pid}/task/{pid}/children').read_text().split()
    return [
        int(child)
        for child in children
        if b'ros_client' in Path(f'/proc/{child}/cmdline').read_bytes()
    ]


def _cpu_seconds(pid: int) -> float:
    tasks = Path(f'/proc/{pid}/task').glob('*/schedstat')
    return sum(int(task.read_text().split()[0]) for task in tasks) / 1e9


ROWS = (
    Row('from a publisher to the next process', '<= 0.15 s', latency),
    Row(f'nodes ready, at once and in {STAGES} stages', '', stages),
    Row('CPU of a launch with readiness at rest', '<= 0.3 %', rest),
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--runs', type=int, default=5)
    parser.add_argument('--nodes', type=int, default=100)
    parser.add_argument('words', nargs='*', metavar='WORD')
    arguments = parser.parse_args()
    programs = Path(sys.executable).parent
    options = Options(
        environment=os.environ
        | {
            'PATH': f'{programs}:{os.environ["PATH"]}',
            'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
            'ROS_DOMAIN_ID': str(random.randint(1, 101)),
        },
        runs=arguments.runs,
        nodes=arguments.nodes,
    )
    print(f'load of the machine: {os.getloadavg()[0]:.1f}')
    processes = arguments.nodes // NODES_PER_PROCESS
    print(f'{arguments.nodes} nodes in {processes} processes')
    print(_columns('what', 'figure', 'to reach'))
    for row in ROWS:
        words = arguments.words
        if not words or any(word in row.what for word in words):
            figure = row.measure(options)
            print(_columns(row.what, figure, row.target), flush=True)


def _columns(what: str, figure: str, target: str) -> str:
    return f'{what:<46}{figure:<36}{target}'


if __name__ == '__main__':
    main()
