#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Time `colcon launch --watch`, from a saved file to the process that runs it.

usage: python benchmarks/watch.py [--runs N] [--keep FOLDER] [WORD ...]

It measures the `colcon` that is first on the PATH, which needs the extra
`watch`. In a clone with a virtual environment in `.venv`:

    PATH=$PWD/.venv/bin:$PATH python benchmarks/watch.py

Prints a table: what was measured, the figure, and the one to reach. Times are
medians in seconds, from just before a file is written to the moment that the
new process tells. Beside, in the same run and with the same script, stand the
commands of `watchfiles` and `watchmedo` where they are installed. A row is
measured if its title contains one of the words; without words all are.

Memory is the proportional set size (PSS) of the launcher and what it has
started for itself, beyond that of a launch without --watch.
"""

import argparse
from collections.abc import Callable
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
import os
from pathlib import Path
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time

import build

PATIENCE = 120.0
#: Seconds that a launch is watched while nothing happens.
QUIET_SECONDS = 20.0
PACKAGES = 100
FILES = 10_000
LARGE_FILES = 100
LARGE_LINES = 5_000

_STAMP = re.compile(r'runs since (\d{10}\.\d+)')
SCRIPT = """\
import signal, time
print('runs since %.9f' % time.time(), flush=True)
signal.signal(signal.SIGINT, signal.SIG_DFL)
signal.pause()
"""
CODE = """\
#include <cstdio>
#include <ctime>
#include <unistd.h>
int main() {{
  timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  printf("runs since %ld.%09ld ({number})\\n", now.tv_sec, now.tv_nsec);
  fflush(stdout);
  while (true) pause();
}}
"""
CMAKE = """\
add_executable(flow src/flow.cpp)
install(TARGETS flow DESTINATION lib/flow)
install(PROGRAMS src/node.py DESTINATION lib/flow)
"""
LAUNCH = """\
launch:
- node: {{pkg: flow, exec: {program}, param: [{{name: x, value: {value}}}]}}
"""


@dataclass(frozen=True)
class Row:
    """
    A row of the table.

    :param limit: The figure to reach, None where there is none
    :param unit: What the figure is in
    """

    title: str
    figure: float
    limit: float | None = None
    unit: str = 's'

    def __str__(self) -> str:
        limit = '' if self.limit is None else f'{self.limit:>9.3f}'
        return f'{self.title:<62}{self.figure:>9.3f}{limit} {self.unit}'


class Running:
    """A command that goes on, and the stamps that its processes print."""

    def __init__(self, root: Path, command: 'list[str]') -> None:
        self._output = tempfile.TemporaryFile()  # noqa: SIM115
        self.process = subprocess.Popen(
            command,
            cwd=root,
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    @property
    def text(self) -> str:
        """All that was printed."""
        size = os.fstat(self._output.fileno()).st_size
        data = os.pread(self._output.fileno(), size, 0)
        return data.decode(errors='replace')

    def next_stamp(self, number: int) -> float:
        """Wait for the stamp with a number, and return it."""
        deadline = time.monotonic() + PATIENCE
        while len(stamps := _STAMP.findall(self.text)) < number:
            if time.monotonic() > deadline or self.process.poll() is not None:
                sys.exit(f'{self.process.args} started nothing:\n{self.text}')
            time.sleep(0.002)
        return float(stamps[number - 1])

    def settle(self) -> None:
        """Wait until all that was started is quiet."""
        before = -1.0
        while (now := processor_seconds(self.process.pid)) != before:
            before = now
            time.sleep(0.5)

    def end(self) -> None:
        """End it, and all that it has started."""
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        self._output.close()


@contextmanager
def running(root: Path, command: 'list[str]') -> Iterator[Running]:
    """Run a command as long as the block takes."""
    started = Running(root, command)
    try:
        yield started
    finally:
        started.end()


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument('words', nargs='*', metavar='WORD')
    parser.add_argument('--runs', type=int, default=9)
    parser.add_argument('--keep', metavar='FOLDER', type=Path)
    options = parser.parse_args()
    if shutil.which('colcon') is None:
        sys.exit('there is no colcon on the PATH')
    print(f'{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}')
    print(f'{"":<62}{"figure":>9}{"reach":>9}')
    measured: dict[str, Callable[[Path, int], Iterator[Row]]] = {
        'script': measure_script,
        'cpp': measure_cpp,
        'launch': measure_launch,
        'quiet': measure_quiet,
    }
    with tempfile.TemporaryDirectory(prefix='benchmark-') as temporary:
        folder = (options.keep or Path(temporary)).absolute()
        for name, measure in measured.items():
            if not options.words or name in options.words:
                for row in measure(folder / name, options.runs):
                    print(row, flush=True)


def measure_script(root: Path, runs: int) -> Iterator[Row]:
    """Measure a Python node that is saved."""
    make(root, 1)
    script = root / 'src/flow/src/node.py'
    write_launch(root, 'node.py')
    command = ['colcon', 'launch', 'flow', 'demo.yaml', '--watch']
    yield Row(
        'a Python node saved -> its new process runs',
        saved(root, command, runs, lambda number: save_script(script, number)),
        0.15,
    )
    others = {
        'watchfiles': ['--sigint-timeout', '5', f'{sys.executable} {script}'],
        'watchmedo': ['auto-restart', '-d', str(script.parent), '--'],
    }
    for name, arguments in others.items():
        program = shutil.which(name)
        if program is None:
            continue
        tail = (
            [str(script.parent)]
            if name == 'watchfiles'
            else [sys.executable, str(script)]
        )
        figure = saved(
            root,
            [program, *arguments, *tail],
            runs,
            lambda number: save_script(script, number),
        )
        yield Row(f'  the same by {name}', figure)


def measure_cpp(root: Path, runs: int) -> Iterator[Row]:
    """Measure a file in C++ that is saved."""
    make(root, PACKAGES)
    write_launch(root, 'flow')
    source = root / 'src/flow/src/flow.cpp'

    def save(number: int) -> None:
        build.write(source, CODE.format(number=number))

    command = ['colcon', 'launch', 'flow', 'demo.yaml', '--watch']
    numbers = count(1_000_000)
    alone: list[float] = []

    def by_hand() -> None:
        save(next(numbers))
        begun = time.time()
        for action in ('--build', '--install'):
            build.run(root, f'cmake {action} build/flow')
        alone.append(time.time() - begun)

    figure = saved(root, command, runs, save)
    for _ in range(runs):
        by_hand()
    bare = statistics.median(alone)
    yield Row('a C++ file saved -> its new process runs', figure, bare + 0.1)
    yield Row('  cmake --build and --install alone', bare)


def measure_launch(root: Path, runs: int) -> Iterator[Row]:
    """Measure a launch file that is saved."""
    make(root, 1)
    command = ['colcon', 'launch', 'flow', 'demo.yaml', '--watch']

    def save(number: int) -> None:
        write_launch(root, 'node.py', number)

    save(0)
    figure = saved(root, command, runs, save)
    yield Row('a launch file saved, a parameter differs', figure, 0.2)
    large = root.with_name('large')
    make(large, 1)
    lines = LARGE_LINES // LARGE_FILES
    for number in range(1, LARGE_FILES):
        arguments = ''.join(
            f'- let: {{name: x{number}_{line}, value: "{line}"}}\n'
            for line in range(lines - 1)
        )
        file = large / f'src/flow/launch/part{number}.yaml'
        build.write(file, f'launch:\n{arguments}')

    def save_large(number: int) -> None:
        includes = ''.join(
            f'- include: {{file: $(dirname)/part{part}.yaml}}\n'
            for part in range(1, LARGE_FILES)
        )
        write_launch(large, 'node.py', number, includes)

    save_large(0)
    figure = saved(large, command, runs, save_large)
    title = f'  one of {LARGE_LINES:,} lines in {LARGE_FILES} files'
    yield Row(title, figure, 0.35)


def measure_quiet(root: Path, _runs: int) -> Iterator[Row]:
    """Measure a launch while nothing happens."""
    make(root, PACKAGES)
    for number in range(FILES):
        package = build.package(number % (PACKAGES - 1))
        build.write(root / f'src/{package}/data/file{number}.txt', 'text\n')
    write_launch(root, 'node.py')
    command = ['colcon', 'launch', 'flow', 'demo.yaml', '--build-all']
    build.run(root, ['colcon', 'build', '--symlink-install'])
    with running(root, command) as launch:
        # what is remembered from now on
        launch.next_stamp(1)
    memory = []
    for watch in ([], ['--watch']):
        with running(root, [*command, *watch]) as launch:
            launch.next_stamp(1)
            launch.settle()
            memory.append(own_memory(launch.process.pid))
            if watch:
                begin = processor_seconds(launch.process.pid)
                time.sleep(QUIET_SECONDS)
                spent = processor_seconds(launch.process.pid) - begin
    share = 100 * spent / QUIET_SECONDS
    title = f'CPU while nothing changes, {PACKAGES} packages, {FILES:,} files'
    yield Row(title, share, 0.3, '%')
    title = 'memory beyond a launch without --watch'
    yield Row(title, memory[1] - memory[0], 40.0, 'MiB')


def make(root: Path, packages: int) -> None:
    """Make a workspace with the package `flow` among others."""
    build.make(root, build.Case('', 'cmake', packages - 1, 0, 0))
    folder = root / 'src/flow'
    text = build.CMAKE.format(name='flow', languages='CXX', code=CMAKE)
    build.write(folder / 'CMakeLists.txt', text)
    build.write(folder / 'src/flow.cpp', CODE.format(number=0))
    save_script(folder / 'src/node.py', 0)


def save_script(file: Path, number: int) -> None:
    """Write the node in Python."""
    build.write(file, f'#!/usr/bin/env python3\n{SCRIPT}# {number}\n')
    file.chmod(0o755)


def write_launch(
    root: Path, program: str, value: int = 0, more: str = ''
) -> None:
    """Write the launch file, whose node has a parameter."""
    text = LAUNCH.format(program=program, value=value) + more
    build.write(root / 'src/flow/launch/demo.yaml', text)


def saved(
    root: Path,
    command: 'list[str]',
    runs: int,
    save: Callable[[int], None],
) -> float:
    """Return how long it takes from a save to the new process."""
    times = []
    with running(root, command) as launch:
        launch.next_stamp(1)
        launch.settle()
        for number in range(1, runs + 1):
            begun = time.time()
            save(number)
            times.append(launch.next_stamp(number + 1) - begun)
            # as somebody who types
            time.sleep(0.5)
    return statistics.median(times)


def own_processes(pid: int) -> 'list[int]':
    """Return a launcher and what it has started for itself."""
    children = Path(f'/proc/{pid}/task/{pid}/children').read_text().split()
    nodes = [
        child
        for child in map(int, children)
        if b'node.py' in Path(f'/proc/{child}/cmdline').read_bytes()
    ]
    return [pid, *(int(c) for c in children if int(c) not in nodes)]


def own_memory(pid: int) -> float:
    """Return what a launcher takes, in MiB."""
    total = 0
    for process in own_processes(pid):
        text = Path(f'/proc/{process}/smaps_rollup').read_text()
        found = re.search(r'^Pss: +(\d+)', text, re.MULTILINE)
        total += 0 if found is None else int(found[1])
    return total / 1024


def processor_seconds(pid: int) -> float:
    """Return the processor time of a launcher and of what is its own."""
    ticks = 0
    for process in own_processes(pid):
        stat = Path(f'/proc/{process}/stat').read_text().rpartition(') ')[2]
        fields = stat.split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf('SC_CLK_TCK')


if __name__ == '__main__':
    main()
