#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure what a launch takes until its first process runs, feature by feature.

usage: python benchmarks/start.py [--packages N] [--runs N]

It measures the `colcon` that is first on the PATH, in a workspace of N CMake
packages that it builds once. In a clone with a virtual environment in `.venv`:

    PATH=$PWD/.venv/bin:$PATH python benchmarks/start.py --packages 100

Each row is a command. `seconds` is the time until its first process prints
the time, or until the command ends; `CPU` is the processor time of the command
with the helper processes that it waited for, which a busy machine changes
less; `modules` are those of this package that all of these imported, besides
the verbs, which colcon loads for every command. Times are medians; the
commands take turns. The factors compare a row with the floor,
which is what `colcon --help` without our verbs and `source install/setup.bash`
take. `--watch` is measured if watchfiles is installed, launch files in Python
if `launch` is.

An editable installation starts some milliseconds later than an installed one,
and one that was never compiled much later: unset PYTHONDONTWRITEBYTECODE.
"""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, field
import importlib.util
import os
from pathlib import Path
import re
import shlex
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time

from build import BLOCKED, Case, LAUNCH, make, package, run, write

#: What the process of a launch prints: the time.
_STAMP = re.compile(r'\b\d{10}\.\d{9}\b')
_OURS = re.compile(r'^import time: .*\| +(colcon_yamllaunch\S*)$', re.M)
PYTHON_LAUNCH = """\
from launch import LaunchDescription
from launch.actions import ExecuteProcess

def generate_launch_description():
    return LaunchDescription([ExecuteProcess(cmd=['date', '+%s.%N'])])
"""
DEPLOYMENT = """\
machines:
  other: {{connect: {connect}}}
processes:
  - {{match: '*', machine: other}}
"""


@dataclass
class Row:
    """
    A command to be measured.

    :param title: What it is called in the table
    :param folder: Where it runs
    :param variables: The environment variables that it has besides
    :param is_launch: Whether a process of it prints the time
    :param seconds: The times measured
    :param processor: The processor times measured
    :param modules: How many modules of this package it imported
    """

    title: str
    command: list[str]
    folder: Path
    variables: dict[str, str] = field(default_factory=dict)
    is_launch: bool = True
    seconds: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)
    modules: int = 0

    def measure(self) -> None:
        """Run the command once; a launch is stopped when its process ran."""
        begin = time.time()
        process = self._start()
        assert process.stdout is not None
        output, stamp = '', None
        for line in process.stdout:
            output += line
            stamp = stamp or _STAMP.search(line)
            if stamp and self.is_launch:
                # one that watches would go on
                process.send_signal(signal.SIGINT)
                break
        process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if self.is_launch and stamp is None:
            sys.exit(f'{self.title} printed no time:\n{output}')
        end = float(stamp[0]) if self.is_launch and stamp else time.time()
        self.seconds.append(end - begin)
        self.processor.append(usage.ru_utime + usage.ru_stime)

    def count_modules(self) -> None:
        """Run the command once more, and note what it imported."""
        traced = Row(self.title, self.command, self.folder, is_launch=False)
        traced.variables = self.variables | {'PYTHONPROFILEIMPORTTIME': '1'}
        self.modules = len(set(_OURS.findall(traced.output())))

    def output(self) -> str:
        """Run the command to its end, or interrupt it after ten seconds."""
        process = self._start()
        try:
            return process.communicate(timeout=10)[0]
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGINT)
            return process.communicate()[0]

    def _start(self) -> 'subprocess.Popen[str]':
        return subprocess.Popen(
            self.command,
            cwd=self.folder,
            env=os.environ | self.variables,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument('--packages', type=int, default=10, metavar='N')
    parser.add_argument('--runs', type=int, default=15, metavar='N')
    options = parser.parse_args()
    if shutil.which('colcon') is None:
        sys.exit('there is no colcon on the PATH')
    with tempfile.TemporaryDirectory(prefix='benchmark-') as temporary:
        folder = Path(temporary)
        # so that no other launch of the user is seen
        (folder / 'run').mkdir(mode=0o700)
        os.environ['XDG_RUNTIME_DIR'] = str(folder / 'run')
        for line in report(folder, options.packages, options.runs):
            print(line, flush=True)


def report(folder: Path, packages: int, runs: int) -> Iterator[str]:
    """Return the lines of the table."""
    bare, source, *others = rows = list(commands(folder, packages))
    # what is measured trusts files by their times, as it does the second time
    for row in rows:
        row.measure()
        row.seconds.clear()
        row.processor.clear()
    for _ in range(runs):
        for row in rows:
            row.measure()
    for row in rows:
        row.count_modules()
    yield f'{packages} packages, {os.cpu_count()} cores, {runs} runs each'
    yield (
        f'{"command":<36}{"seconds":>9}{"/ floor":>9}{"CPU":>9}'
        f'{"/ floor":>9}{"modules":>9}'
    )
    floor, floor_processor = (
        statistics.median(times) + statistics.median(sourcing)
        for times, sourcing in (
            (bare.seconds, source.seconds),
            (bare.processor, source.processor),
        )
    )
    yield (
        f'{"floor":<36}{floor:>9.3f}{1:>9.2f}{floor_processor:>9.3f}{1:>9.2f}'
    )
    for row in (bare, source, *others):
        seconds = statistics.median(row.seconds)
        processor = statistics.median(row.processor)
        yield (
            f'{row.title:<36}{seconds:>9.3f}{seconds / floor:>9.2f}'
            f'{processor:>9.3f}{processor / floor_processor:>9.2f}'
            f'{row.modules:>9}'
        )


def commands(folder: Path, packages: int) -> Iterator[Row]:
    """Return the commands; the first two make up the floor."""
    root = folder / 'workspace'
    make(root, Case('', 'cmake', packages, 1, 0))
    run(root, 'colcon build')
    launch = ['colcon', 'launch', package(0), 'demo.yaml']
    alone = folder / 'alone'
    write(alone / 'demo.yaml', LAUNCH)
    helped = ['colcon', '--help']
    title = 'colcon --help'
    yield Row(f'{title} without launch', helped, root, BLOCKED, False)
    yield Row(
        'source install/setup.bash',
        ['bash', '-c', 'source install/setup.bash'],
        root,
        is_launch=False,
    )
    yield Row(title, helped, root, is_launch=False)
    yield Row('colcon list', ['colcon', 'list'], root, is_launch=False)
    yield Row(
        'launch without a workspace', ['colcon', 'launch', 'demo.yaml'], alone
    )
    yield Row('launch with nothing to build', launch, root)
    if importlib.util.find_spec('watchfiles'):
        yield Row('  with --watch', [*launch, '--watch'], root)
    if importlib.util.find_spec('launch'):
        write(alone / 'demo.launch.py', PYTHON_LAUNCH)
        yield Row(
            '  without a workspace, in Python',
            ['colcon', 'launch', 'demo.launch.py'],
            alone,
        )
    # a machine that is this one, with a home folder of its own
    home = folder / 'home'
    home.mkdir()
    connect = shlex.join(['env', f'HOME={home}'])
    deployment = root / 'deployment.yaml'
    write(deployment, DEPLOYMENT.format(connect=connect))
    yield Row(
        '  with --deploy, one machine',
        [*launch, '--deploy', str(deployment)],
        root,
    )


if __name__ == '__main__':
    main()
