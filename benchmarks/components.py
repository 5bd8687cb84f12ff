#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure what loading components takes, and what the ROS client costs.

usage: python benchmarks/components.py [--runs N] [--parts FOLDER] [WORD ...]

It needs the extras `ros` and `test`, and builds the containers of the tests
first, which takes half a minute; with `--parts` they stay in that folder for
the next time. Prints a table: what was measured, the figure, and the one to
reach. Times are medians of several runs. A row is measured if it contains one
of the words; without words all are.

A component is in Python here, and so takes longer to construct than one in
C++: the container says how long, and that is left out where the table says so.
The first rows drive the client alone, through its pipes; the last one takes
whole launches.
"""

import argparse
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
import json
import os
from pathlib import Path
import random
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time

TESTS = Path(__file__).resolve().parents[1] / 'tests'
sys.path.insert(0, str(TESTS))

# ruff: noqa: E402
from support.ros_parts import build_once, sourced
from support.ros_talk import talking

COMPONENTS = 10
PROCESSES = 20
#: Seconds that a client is watched while nothing happens.
QUIET_SECONDS = 20.0
#: Seconds that the nodes get to find each other before.
SETTLING = 3.0
PATIENCE = 60.0
CONTAINER = 'lib/rclcpp_components/component_container'
#: What a container says of each constructor.
CONSTRUCTED = re.compile(r'Constructed in ([\d.]+) s')
PLUGIN = 'composition::Listener'


@dataclass(frozen=True)
class Row:
    """
    A line of the table.

    :param what: What is measured
    :param target: What to reach
    :param measure: Measures it, in an environment and a number of runs
    """

    what: str
    target: str
    measure: Callable[[Mapping[str, str], int], str]


@contextmanager
def container(
    environment: Mapping[str, str],
) -> Iterator['subprocess.Popen[str]']:
    """Have a container run."""
    program = Path(environment['COLCON_PREFIX_PATH'].split(':')[0], CONTAINER)
    process = subprocess.Popen(
        [program, '--ros-args', '-r', '__node:=box'],
        env=dict(environment),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        with process:
            pass


def client_ready(environment: Mapping[str, str], runs: int) -> str:
    """Take the time until the client is up."""
    times = []
    for _ in range(runs):
        begin = time.monotonic()
        with talking(environment) as talk:
            talk.event(event='ready')
            times.append(time.monotonic() - begin)
    return f'{statistics.median(times):.3f} s'


def loaded(environment: Mapping[str, str], runs: int) -> str:
    """Take the time from the container's service to the last component."""
    results = []
    for _ in range(runs):
        with talking(environment) as talk, container(environment) as box:
            requests = [
                talk.load('Listener', name=f'n{n}') for n in range(COMPONENTS)
            ]
            talk.event(event='container', there=True)
            begin = time.monotonic()
            for request in requests:
                assert talk.answer(request)['ok']
            seconds = time.monotonic() - begin
            box.kill()
            assert box.stderr is not None
            said = CONSTRUCTED.findall(box.stderr.read())
        constructed = sum(map(float, said))
        results.append((seconds - constructed, constructed))
    rest, constructed = (
        statistics.median(column) for column in zip(*results, strict=True)
    )
    return f'{rest:.3f} s, constructors {constructed:.3f} s'


def idle(environment: Mapping[str, str], _: int) -> str:
    """Measure a client that has loaded, and has nothing to do."""
    with talking(environment) as talk, container(environment):
        for number in range(COMPONENTS):
            assert talk.answer(talk.load('Listener', name=f'n{number}'))['ok']
        talk.result('follow', node='/n0')
        time.sleep(SETTLING)
        pid = talk.process.pid
        before = _cpu_seconds(pid)
        time.sleep(QUIET_SECONDS)
        used = _cpu_seconds(pid) - before
        memory = _proportional_size(pid)
    return f'{100 * used / QUIET_SECONDS:.3f} %, {memory:.0f} MiB'


def last_process(environment: Mapping[str, str], runs: int) -> str:
    """
    Take the time from the command to the start of the last plain process.

    Launches without and with a container take turns.
    """
    plain = [{'executable': {'cmd': 'sleep 1000'}}] * PROCESSES
    components = [
        {'pkg': 'composition', 'plugin': PLUGIN, 'name': f'n{number}'}
        for number in range(COMPONENTS)
    ]
    box = {
        'pkg': 'rclcpp_components',
        'exec': 'component_container',
        'name': 'box',
        'namespace': '',
        'composable_node': components,
    }
    launches = (plain, [{'node_container': box}, *plain])
    times: list[list[float]] = [[], []]
    for _ in range(runs):
        for entries, column in zip(launches, times, strict=True):
            with tempfile.TemporaryDirectory() as name:
                file = Path(name, 'benchmark.yaml')
                file.write_text(json.dumps({'launch': entries}))
                column.append(_seconds_to_last(environment, file))
    without, beside = map(statistics.median, times)
    return f'{without:.3f} s, beside one {beside:.3f} s'


def _seconds_to_last(environment: Mapping[str, str], file: Path) -> float:
    begin = time.time()
    launch = subprocess.Popen(
        ['colcon', 'launch', str(file)],
        cwd=file.parent,
        env={**environment, 'COLCON_LOG_PATH': str(file.parent / 'log')},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    events = file.parent / 'log/latest_launch/events.jsonl'
    try:
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            starts = list(_starts(events))
            if len(starts) == PROCESSES:
                return max(starts) - begin
            time.sleep(0.05)
        sys.exit(f'{file}: the processes are not up')
    finally:
        launch.send_signal(signal.SIGINT)
        launch.wait()


def _starts(events: Path) -> Iterator[float]:
    """Return the times at which plain processes were started."""
    try:
        lines = events.read_text(encoding='utf-8').splitlines()
    except OSError:
        return
    for line in lines:
        try:
            event = json.loads(line)
        except ValueError:
            # not whole yet
            return
        if event['event'] == 'started' and event['label'].startswith('sleep'):
            yield event['time']


ROWS = (
    Row('client up', '', client_ready),
    Row(
        f'{COMPONENTS} components loaded, without constructors',
        '<= 0.35 s',
        loaded,
    ),
    Row('CPU and memory (PSS) of a quiet client', '< 0.5 %, <= 60 MiB', idle),
    Row(
        f'{PROCESSES} plain processes without a container',
        'the same',
        last_process,
    ),
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--runs', type=int, default=5)
    parser.add_argument('--parts', type=Path)
    parser.add_argument('words', nargs='*', metavar='WORD')
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = (arguments.parts or Path(name)).absolute()
        folder.mkdir(parents=True, exist_ok=True)
        environment = sourced(build_once(folder)) | {
            'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
            'ROS_DOMAIN_ID': str(random.randint(1, 101)),
        }
        print(f'load of the machine: {os.getloadavg()[0]:.1f}')
        print(_columns('what', 'figure', 'to reach'))
        for row in ROWS:
            words = arguments.words
            if not words or any(word in row.what for word in words):
                figure = row.measure(environment, arguments.runs)
                print(_columns(row.what, figure, row.target), flush=True)


def _columns(what: str, figure: str, target: str) -> str:
    return f'{what:<46}{figure:<36}{target}'


def _cpu_seconds(pid: int) -> float:
    tasks = Path(f'/proc/{pid}/task').glob('*/schedstat')
    return sum(int(task.read_text().split()[0]) for task in tasks) / 1e9


def _proportional_size(pid: int) -> float:
    rollup = Path(f'/proc/{pid}/smaps_rollup').read_text()
    return int(rollup.partition('Pss:')[2].split()[0]) / 1024


if __name__ == '__main__':
    main()
