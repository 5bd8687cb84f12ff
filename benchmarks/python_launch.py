#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure what launch files in Python take, beside `ros2 launch`.

usage: python benchmarks/python_launch.py [--runs N]

It needs the extra `test`, and a ROS 2 that has `launch`, whose `setup.bash`
COLCON_LAUNCH_TEST_SETUP names. Prints a table: what was measured, the figure,
and the one to reach. Times are medians of several runs, from the command to
the first thing that the first process does; each run takes all launches in
turn, so that they find the same machine.
"""

import argparse
from collections import defaultdict
from collections.abc import Callable, Mapping
import os
from pathlib import Path
import select
import statistics
import subprocess
import sys
import tempfile
import time

TESTS = Path(__file__).resolve().parents[1] / 'tests'
sys.path.insert(0, str(TESTS))

# ruff: noqa: E402
from support.ros_setup import read_setup, SKIPPED

FILES = 5
#: Seconds from the import of `launch` to the first process, beside those that
#: a launch file in YAML takes.
TARGET = 0.2
PATIENCE = 60.0

YAML = """\
launch:
  - executable: {cmd: sh -c "echo > $FIRST"}
"""
PYTHON = """\
from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch_ros.actions import Node


def generate_launch_description():
    return LaunchDescription(
        [ExecuteProcess(cmd=['sh', '-c', 'echo > "$FIRST"'])]
    )
"""
MORE = """\
from launch import LaunchDescription
from launch.actions import SetLaunchConfiguration


def generate_launch_description():
    return LaunchDescription([SetLaunchConfiguration('more', 'yes')])
"""
INCLUDES = (
    'launch:\n'
    + '  - include: {file: $(dirname)/more.launch.py}\n' * (FILES - 1)
    + '  - include: {file: $(dirname)/one.launch.py}\n'
)
#: The same with a handler, for which the worker stays alive.
HANDLED = PYTHON.replace(
    '[Exec',
    """[
            RegisterEventHandler(OnShutdown(on_shutdown=[])),
            Exec""",
).replace(
    'from launch_ros',
    """from launch.actions import RegisterEventHandler
from launch.event_handlers import OnShutdown
from launch_ros""",
)
IMPORTS = 'import launch, launch_ros.actions'


class Stopwatch:
    """
    Takes the time from a command to its first process.

    :param folder: With the launch files
    :param environment: With ROS 2 sourced
    """

    def __init__(self, folder: Path, environment: Mapping[str, str]) -> None:
        self._folder = folder
        fifo = folder / 'first'
        os.mkfifo(fifo)
        # both ends, so that no one waits for the other
        self._fifo = os.open(fifo, os.O_RDWR)
        self._environment = {
            **environment,
            'FIRST': str(fifo),
            'HOME': str(folder),
            'ROS_HOME': str(folder),
        }

    def launch(self, *command: str) -> float:
        """Return the seconds until the first process writes."""
        begin = time.monotonic()
        process = self._start(command)
        ready, _, _ = select.select([self._fifo], [], [], PATIENCE)
        seconds = time.monotonic() - begin
        assert ready, f'{command} starts nothing'
        os.read(self._fifo, 100)
        process.wait(PATIENCE)
        return seconds

    def run(self, *command: str) -> float:
        """Return the seconds that a command takes."""
        begin = time.monotonic()
        assert self._start(command).wait(PATIENCE) == 0
        return time.monotonic() - begin

    def _start(self, command: tuple[str, ...]) -> 'subprocess.Popen[bytes]':
        return subprocess.Popen(
            command,
            cwd=self._folder,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )


def measure(watch: Stopwatch, python: str, runs: int) -> dict[str, float]:
    """Return the medians of all that is measured, in seconds."""
    everything: dict[str, Callable[[], float]] = {
        'python': lambda: watch.run(python, '-c', 'pass'),
        'imports': lambda: watch.run(python, '-c', IMPORTS),
    }
    for name in ('one.launch.py', 'handled.launch.py', 'five.launch.yaml'):
        for program in ('colcon', 'ros2'):
            command = (program, 'launch', name)
            everything[f'{program} {name}'] = lambda c=command: watch.launch(
                *c
            )
    command = ('colcon', 'launch', 'one.launch.yaml')
    everything['colcon one.launch.yaml'] = lambda: watch.launch(*command)
    times = defaultdict(list)
    # the first round fills caches
    for round_ in range(runs + 1):
        for name, one in everything.items():
            seconds = one()
            if round_:
                times[name].append(seconds)
    return {name: statistics.median(taken) for name, taken in times.items()}


def rows(found: Mapping[str, float]) -> list[tuple[str, str, str]]:
    """Return the table."""
    one = found['colcon one.launch.py']
    imports = found['imports'] - found['python']
    above = one - found['colcon one.launch.yaml'] - imports
    more = (found['colcon five.launch.yaml'] - one) / (FILES - 1)
    return [
        (
            'a launch file in YAML',
            f'{found["colcon one.launch.yaml"]:.2f} s',
            '',
        ),
        ('the same in Python', f'{one:.2f} s', ''),
        ('  the import of launch and launch_ros', f'{imports:.2f} s', ''),
        ('  above that and the one in YAML', f'{above:.2f} s', f'{TARGET} s'),
        (
            '  with `ros2 launch`',
            f'{found["ros2 one.launch.py"]:.2f} s',
            '',
        ),
        (
            'with an event handler',
            f'{found["colcon handled.launch.py"]:.2f} s',
            '',
        ),
        (
            '  with `ros2 launch`',
            f'{found["ros2 handled.launch.py"]:.2f} s',
            '',
        ),
        (
            f'{FILES} files in Python',
            f'{found["colcon five.launch.yaml"]:.2f} s',
            '',
        ),
        ('  for each more', f'{1000 * more:.0f} ms', ''),
        (
            '  with `ros2 launch`',
            f'{found["ros2 five.launch.yaml"]:.2f} s',
            '',
        ),
    ]


def main() -> str | None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--runs', type=int, default=7)
    runs = parser.parse_args().runs
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        setup = read_setup(folder)
        if setup is None:
            return f'It {SKIPPED}'
        for file, text in {
            'one.launch.yaml': YAML,
            'one.launch.py': PYTHON,
            'handled.launch.py': HANDLED,
            'more.launch.py': MORE,
            'five.launch.yaml': INCLUDES,
        }.items():
            (folder / file).write_text(text, encoding='utf-8')
        watch = Stopwatch(folder, setup.environment)
        table = rows(measure(watch, setup.python, runs))
    for what, figure, target in table:
        print(f'{what:42} {figure:>8}   {target}'.rstrip())
    return None


if __name__ == '__main__':
    sys.exit(main())
