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
new process tells. WORD is one of script, cpp, launch, quiet; without all are
measured.

script: beside, in turns with the same script, stand `watchfiles`, `watchmedo
auto-restart` and `dora start --hot-reload`, as far as they are on the PATH
(packages watchfiles, watchdog, dora-rs-cli with dora-rs on PyPI). dora runs an
operator, and reads its module again in the process that runs.

cpp: `cmake --build` and `cmake --install` alone, of the same package in the
same state in another workspace, take turns with the launch that watches. What
counts is the median of the differences, pair by pair.

quiet: processor time and memory are those of the launcher and of all that it
has started for itself. Memory is the proportional set size (PSS), as what
builds is a fork that shares much with the launcher, and the sum of the
resident sets (RSS) would have that twice.
"""

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager, ExitStack, suppress
from dataclasses import dataclass
from functools import partial
import os
from pathlib import Path
import re
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time

import build

#: What others are called where the same is done by them.
OTHERS = ('watchfiles', 'watchmedo', 'dora')

PATIENCE = 120.0
#: Seconds that a launch is watched while nothing happens.
QUIET_SECONDS = 20.0
#: How often it is looked whether what was started is quiet.
SETTLING = 12
#: Seconds between two saves, as of somebody who types.
BREATH = 0.5
#: Launches whose memory is measured, with --watch and without in turns.
MEMORY_RUNS = 3
#: Set, it has all files looked at again and again.
POLLING = 'WATCHFILES_FORCE_POLLING'
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
#: The same as an operator of dora, which must leave signals alone.
OPERATOR = """\
import time
print('runs since %.9f' % time.time(), flush=True)
class Operator:
    def on_event(self, event, send_output):
        from dora import DoraStatus
        return DoraStatus.CONTINUE
"""
DATAFLOW = """\
nodes:
- id: node
  operators:
  - {id: node, python: node.py, inputs: {tick: dora/timer/millis/500}}
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
#: What colcon sets for CMake, so that nothing is copied.
AS_COLCON = {'CMAKE_INSTALL_MODE': 'ABS_SYMLINK_OR_COPY'}
WATCH = ['colcon', 'launch', 'flow', 'demo.yaml', '--watch']
LAUNCH = """\
launch:
- node: {{pkg: flow, exec: {program}, param: [{{name: x, value: {value}}}]}}
"""


@dataclass(frozen=True)
class Row:
    """
    A row of the table.

    :param figure: None where it cannot be had
    :param limit: The figure to reach, None where there is none
    :param unit: What the figure is in
    """

    title: str
    figure: float | None
    limit: float | None = None
    unit: str = 's'

    def __str__(self) -> str:
        if self.figure is None:
            return self.title
        limit = '' if self.limit is None else f'{self.limit:>9.3f}'
        return f'{self.title:<62}{self.figure:>9.3f}{limit} {self.unit}'


class Running:
    """A command that goes on, and the stamps that its processes print."""

    def __init__(
        self,
        root: Path,
        command: 'list[str]',
        variables: 'dict[str, str] | None' = None,
    ) -> None:
        self._output = tempfile.TemporaryFile()  # noqa: SIM115
        self.process = subprocess.Popen(
            command,
            cwd=root,
            env=os.environ | (variables or {}),
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

    def stamp_after(self, moment: float = 0.0) -> float:
        """Wait for the first stamp after a moment, and return it."""
        deadline = time.monotonic() + PATIENCE
        while True:
            for stamp in map(float, _STAMP.findall(self.text)):
                if stamp > moment:
                    return stamp
            if time.monotonic() > deadline or self.process.poll() is not None:
                sys.exit(f'{self.process.args} started nothing:\n{self.text}')
            time.sleep(0.002)

    def saved(self, save: Callable[[int], None], number: int) -> float:
        """Save a file, and return how long it takes to the new process."""
        begun = time.time()
        save(number)
        took = self.stamp_after(begun) - begun
        time.sleep(BREATH)
        return took

    def settle(self) -> None:
        """Wait until all that was started is quiet, if it ever is."""
        before = -1.0
        for _ in range(SETTLING):
            now = processor_seconds(self.process.pid)
            if now == before:
                return
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
def running(
    root: Path,
    command: 'list[str]',
    variables: 'dict[str, str] | None' = None,
) -> Iterator[Running]:
    """Run a command as long as the block takes."""
    started = Running(root, command, variables)
    try:
        started.stamp_after()
        started.settle()
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
    """Measure a Python node that is saved, by us and by others."""
    make(root, 1)
    write_launch(root, 'node.py')
    commands = {'': (root, WATCH, root / 'src/flow/src/node.py')}
    times: dict[str, list[float]] = {'': []}
    with ExitStack() as stack:
        for name in OTHERS:
            program = shutil.which(name)
            if program is None:
                continue
            script = root.with_name(name) / 'node.py'
            save_script(script, 0, OPERATOR if name == 'dora' else SCRIPT)
            if name == 'dora' and not stack.enter_context(dora(script.parent)):
                continue
            command = other_command(name, program, script)
            commands[name] = script.parent, command, script
            times[name] = []
        launches = {
            name: stack.enter_context(running(folder, command))
            for name, (folder, command, _) in commands.items()
        }
        for number in range(1, runs + 1):
            for name, launch in launches.items():
                script = commands[name][2]
                text = OPERATOR if name == 'dora' else SCRIPT
                times[name].append(
                    launch.saved(
                        partial(save_script, script, text=text), number
                    )
                )
    title = 'a Python node saved -> its new process runs'
    yield Row(title, statistics.median(times['']), 0.15)
    titles = {
        'watchfiles': 'the same by watchfiles',
        'watchmedo': 'the same by watchmedo auto-restart',
        'dora': 'an operator saved -> dora start --hot-reload has read it',
    }
    for name in OTHERS:
        if name in times:
            yield Row(f'  {titles[name]}', statistics.median(times[name]))
        else:
            yield Row(f'  {titles[name]}: not to be had here', None)


def other_command(name: str, program: str, script: Path) -> 'list[str]':
    """Return how another tool runs a script anew when it is saved."""
    folder = str(script.parent)
    return {
        'watchfiles': [
            *(program, '--sigint-timeout', '5'),
            *(f'{sys.executable} {script}', folder),
        ],
        'watchmedo': [
            *(program, 'auto-restart', '-d', folder, '--'),
            *(sys.executable, str(script)),
        ],
        'dora': [program, 'start', 'flow.yml', '--attach', '--hot-reload'],
    }[name]


@contextmanager
def dora(folder: Path) -> Iterator[bool]:
    """Have dora's daemon run; tell whether it does."""
    build.write(folder / 'flow.yml', DATAFLOW)
    quiet = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
    # it runs the Python that is first on the PATH
    has_module = subprocess.run(['python', '-c', 'import dora'], **quiet)
    if has_module.returncode:
        yield False
        return
    with socket.socket() as free:
        # another one may run on the machine
        free.bind(('127.0.0.1', 0))
        os.environ['DORA_COORDINATOR_PORT'] = str(free.getsockname()[1])
    up = subprocess.run(['dora', 'up'], cwd=folder, **quiet)
    try:
        yield up.returncode == 0
    finally:
        subprocess.run(['dora', 'down', '--force'], cwd=folder, **quiet)


def measure_cpp(root: Path, runs: int) -> Iterator[Row]:
    """Measure a file in C++ that is saved, and its build by hand."""
    other = root.with_name('cpp_alone')
    for folder in (root, other):
        make(folder, PACKAGES)
        write_launch(folder, 'flow')
    select = ['colcon', 'build', '--symlink-install', '--packages-up-to']
    build.run(other, [*select, 'flow'])

    def save(number: int, folder: Path = root) -> None:
        file = folder / 'src/flow/src/flow.cpp'
        build.write(file, CODE.format(number=number))

    def by_hand(number: int) -> float:
        begun = time.time()
        save(number, other)
        for action in ('--build', '--install'):
            build.run(other, ['cmake', action, 'build/flow'], AS_COLCON)
        took = time.time() - begun
        time.sleep(BREATH)
        return took

    watched, alone = [], []
    with running(root, WATCH) as launch:
        for number in range(1, runs + 1):
            watched.append(launch.saved(save, number))
            alone.append(by_hand(number))
    pairs = list(zip(watched, alone, strict=True))
    more = statistics.median(one - bare for one, bare in pairs)
    ratio = statistics.median(one / bare for one, bare in pairs)
    title = f'a C++ file saved, {PACKAGES} packages -> its new process runs'
    yield Row(title, statistics.median(watched))
    title = '  cmake --build and --install alone'
    yield Row(title, statistics.median(alone))
    yield Row(f'  more than these, {ratio:.2f} times as long', more, 0.1)


def measure_launch(root: Path, runs: int) -> Iterator[Row]:
    """Measure a launch file that is saved."""
    make(root, 1)

    def save(number: int) -> None:
        write_launch(root, 'node.py', number)

    save(0)
    figure = saved(root, runs, save)
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
    figure = saved(large, runs, save_large)
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
    with running(root, command):
        # what is remembered from now on
        pass
    memory: list[list[float]] = [[], []]
    for _ in range(MEMORY_RUNS):
        for taken, watch in zip(memory, ([], ['--watch']), strict=True):
            with running(root, [*command, *watch]) as launch:
                taken.append(own_memory(launch.process.pid))
    watching = [*command, '--watch']
    title = f'CPU while nothing changes, {PACKAGES} packages, {FILES:,} files'
    yield Row(title, quiet_share(root, watching), 0.3, '%')
    share = quiet_share(root, watching, {POLLING: 'true'})
    yield Row('  the same where only polling works', share, None, '%')
    before, after = map(statistics.median, memory)
    title = f'memory (PSS) beyond a launch without --watch, {before:.1f} MiB'
    yield Row(title, after - before, 40.0, 'MiB')


def quiet_share(
    root: Path,
    command: 'list[str]',
    variables: 'dict[str, str] | None' = None,
) -> float:
    """Return what a launch takes of a processor while nothing happens (%)."""
    with running(root, command, variables) as launch:
        begin = processor_seconds(launch.process.pid)
        time.sleep(QUIET_SECONDS)
        spent = processor_seconds(launch.process.pid) - begin
    return 100 * spent / QUIET_SECONDS


def make(root: Path, packages: int) -> None:
    """Make a workspace with the package `flow` among others."""
    build.make(root, build.Case('', 'cmake', packages - 1, 0, 0))
    folder = root / 'src/flow'
    text = build.CMAKE.format(name='flow', languages='CXX', code=CMAKE)
    build.write(folder / 'CMakeLists.txt', text)
    build.write(folder / 'src/flow.cpp', CODE.format(number=0))
    save_script(folder / 'src/node.py', 0)


def save_script(file: Path, number: int, text: str = SCRIPT) -> None:
    """Write the node in Python."""
    build.write(file, f'#!/usr/bin/env python3\n{text}# {number}\n')
    file.chmod(0o755)


def write_launch(
    root: Path, program: str, value: int = 0, more: str = ''
) -> None:
    """Write the launch file, whose node has a parameter."""
    text = LAUNCH.format(program=program, value=value) + more
    build.write(root / 'src/flow/launch/demo.yaml', text)


def saved(root: Path, runs: int, save: Callable[[int], None]) -> float:
    """Return how long it takes from a save to the new process."""
    with running(root, WATCH) as launch:
        numbers = range(1, runs + 1)
        return statistics.median(launch.saved(save, n) for n in numbers)


def own_processes(pid: int) -> 'list[int]':
    """Return a launcher and all that it has started, but for the node."""
    found = [pid]
    # the list grows by the children of those that it has
    for parent in found:
        # what has just ended has none
        with suppress(OSError):
            text = Path(f'/proc/{parent}/task/{parent}/children').read_text()
            for child in map(int, text.split()):
                words = Path(f'/proc/{child}/cmdline').read_bytes()
                if b'node.py' not in words:
                    found.append(child)
    return found


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
        with suppress(OSError):
            stat = Path(f'/proc/{process}/stat').read_text()
            fields = stat.rpartition(') ')[2].split()
            ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf('SC_CLK_TCK')


if __name__ == '__main__':
    main()
