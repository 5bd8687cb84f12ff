#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure `colcon launch` and other launchers with the same work.

usage: python benchmarks/peers.py [--runs N] [--autoware FOLDER] [WORD ...]

Without words it measures everything and writes the results to
docs/benchmarks.md and docs/benchmarks_*.svg. With words it prints the rows
that contain one of them, and writes nothing.

It measures the `colcon` beside this Python. Other launchers are those on the
PATH. Those that are missing there are installed into a temporary folder, from
PyPI or as the binary of a release, if possible. To measure `ros2 launch` and
better_launch, source a ROS 2 that has them.

The processes are small shell scripts without ROS: a launcher of ROS 2 does
the same for them as for a node, and nothing is measured of the nodes. Each
one adds a line to a file when it starts, and then becomes `sleep`. All
launchers write to a terminal, except for the million lines, which go to a
file. The launchers take turns.

Autoware's launch files are read from FOLDER, a clone of autoware_launch; by
default, git clones it into a temporary folder.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
import os
from pathlib import Path
import re
import select
import shlex
import signal
import subprocess
import tempfile
import time

from peers_launchers import FailedError, find, Peer, PEERS, version
from peers_report import machine, Measured, Report, WORKS, write_report
from runtime import (
    Commands,
    FILE,
    KILLED_SECONDS,
    Launcher,
    LINE,
    OTHER_LINE,
    parent,
    PATIENCE,
    proportional_size,
    read_proc,
    ROUNDS,
    Running,
    SETTLING,
)

DOCS = Path(__file__).resolve().parents[1] / 'docs'
#: How many processes Autoware starts: nodes, containers, and components that
#: have a process each.
PROCESSES = 44 + 16 + 84
LINES = 1_000_000
#: Seconds after which a launch with many lines is given up.
LINES_PATIENCE = 600.0
#: Seconds that a quiet launch is watched.
QUIET_SECONDS = 5.0
#: Seconds between two looks at what has started.
LOOK = 0.001
AUTOWARE = 'https://github.com/autowarefoundation/autoware_launch'
SIMULATOR = 'planning_simulator.launch.xml'
STAND_IN = """\
#!/bin/sh
echo {word} >>{mark}
exec sleep 1000
"""


class Launch(Running):
    """
    A launch whose processes are counted as they start.

    :param mark: The file to which each process adds a line
    """

    def __init__(
        self,
        launcher: Launcher,
        folder: Path,
        commands: Commands,
        mark: Path,
        screen: str = 'terminal',
    ) -> None:
        self._mark_file = mark
        super().__init__(launcher, folder, commands, screen)

    def starts(self, count: int) -> None:
        """Wait until the file has `count` lines."""
        deadline = time.monotonic() + PATIENCE
        while (started := lines_in(self._mark_file)) < count:
            self._show(LOOK)
            if time.monotonic() > deadline:
                raise FailedError(f'{started} of {count} processes started')

    def rests(self, seconds: float) -> None:
        """Read its terminal for some seconds."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self._show(left)

    def interrupt(self) -> None:
        """Press Ctrl-C, and wait until nothing runs any more."""
        os.write(self.terminal, b'\x03')
        self.finishes()
        if not wait_for(lambda: not self.left()):
            raise FailedError('processes still ran after Ctrl-C')

    def finishes(self, patience: float = PATIENCE) -> None:
        """Wait for the end of the launcher, for some seconds."""
        deadline = time.monotonic() + patience
        while os.waitpid(self.pid, os.WNOHANG) == (0, 0):
            self._show(LOOK)
            if time.monotonic() > deadline:
                raise FailedError('the launcher did not end')
        self.pid = 0

    def own(self) -> list[int]:
        """Return the launcher and its helpers, without what it launched."""
        return [
            pid
            for pid in [*self.left(), *self.guards()]
            if not read_proc(pid, 'cmdline').startswith(b'sleep\0')
        ]

    def _show(self, seconds: float) -> None:
        readable, _, _ = select.select([self.terminal], [], [], seconds)
        if readable and not self._read():
            # the terminal was closed: there is nothing to wait for
            time.sleep(LOOK)


class Room:
    """
    A folder for one launch, with the programs that it starts.

    :param folder: The folder
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.mark = folder / 'mark'
        self.mark.touch()
        self.write_program('edited', 'first')
        self.write_program('stand_in', 'first')

    def write_program(self, name: str, word: str) -> None:
        """Write a program that adds `word` to the file and then sleeps."""
        new = self.folder / f'.{name}.new'
        text = STAND_IN.format(word=word, mark=shlex.quote(str(self.mark)))
        new.write_text(text, encoding='utf-8')
        new.chmod(0o755)
        # as an editor saves, since a running script must not change
        new.replace(self.folder / name)

    def commands(self, count: int) -> Commands:
        """Return the command lines of `count` processes; one can be edited."""
        stand_in = (str(self.folder / 'stand_in'),)
        return [(str(self.folder / 'edited'),), *[stand_in] * (count - 1)]

    @contextmanager
    def launching(
        self, launcher: Launcher, commands: Commands, screen: str = 'terminal'
    ) -> Iterator[Launch]:
        """Run a launch, and leave nothing of it."""
        one = Launch(launcher, self.folder, commands, self.mark, screen)
        try:
            yield one
        finally:
            guards = one.guards()
            one.clean_up()
            wait_for(lambda: not any(map(command_line, guards)))


def one_program(peer: Peer, room: Room) -> Measured:
    """Take the time until a program runs."""
    begin = time.monotonic()
    with room.launching(peer.launcher(), room.commands(1)) as launch:
        launch.starts(1)
        seconds = time.monotonic() - begin
        launch.rests(SETTLING / 2)
    return {'one': seconds}


def many_processes(peer: Peer, room: Room) -> Measured:
    """Take the time until all run and until all are stopped, and the costs."""
    begin = time.monotonic()
    commands = room.commands(PROCESSES)
    with room.launching(peer.launcher(), commands) as launch:
        launch.starts(PROCESSES)
        started = time.monotonic() - begin
        launch.rests(2 * SETTLING)
        own = launch.own()
        memory = sum(map(proportional_size, own))
        before = sum(map(cpu_seconds, own))
        launch.rests(QUIET_SECONDS)
        cpu = sum(map(cpu_seconds, own)) - before
        begin = time.monotonic()
        launch.interrupt()
        stopped = time.monotonic() - begin
    return {
        'many': started,
        'memory': memory,
        'cpu': 100 * cpu / QUIET_SECONDS,
        'stop': stopped,
    }


def edited(peer: Peer, room: Room) -> Measured:
    """Take the time from an edit of a program until the new one runs."""
    launcher = peer.launcher(options=peer.watches or '')
    commands = room.commands(PROCESSES)
    with room.launching(launcher, commands) as launch:
        launch.starts(PROCESSES)
        launch.rests(2 * SETTLING)
        begin = time.monotonic()
        room.write_program('edited', 'second')
        if peer.watches is not None:
            launch.starts(PROCESSES + 1)
            return {'edit': time.monotonic() - begin}
        launch.interrupt()
    with room.launching(launcher, commands) as launch:
        launch.starts(2 * PROCESSES)
        return {'edit': time.monotonic() - begin}


def killed(peer: Peer, room: Room) -> Measured:
    """Kill the launcher, and count the processes that are left."""
    # a shell that lives on, as in a terminal; else the kernel hangs up
    shell = ('sh', '-c', '"$@"; exec sleep 1000', 'sh')
    commands = room.commands(PROCESSES)
    with room.launching(peer.launcher(*shell), commands) as launch:
        launch.starts(PROCESSES)
        launch.rests(SETTLING)
        launcher = next(p for p in launch.left() if parent(p) == launch.pid)
        guards = launch.guards(launcher)
        os.kill(launcher, signal.SIGKILL)
        launch.rests(KILLED_SECONDS)
        left = [*launch.left(), *filter(command_line, guards)]
        return {'left': len(left) - 1}


def million_lines(peer: Peer, room: Room) -> Measured:
    """Take the time of a launch that writes many lines, and count them."""
    source = room.folder / 'source'
    source.write_bytes((LINE + OTHER_LINE) * (LINES // ROUNDS // 2))
    commands = [('cat', *[str(source)] * ROUNDS)]
    begin = time.monotonic()
    with room.launching(peer.launcher(), commands, 'file') as launch:
        launch.finishes(LINES_PATIENCE)
        seconds = time.monotonic() - begin
    text = (room.folder / 'screen').read_bytes()
    shown = text.count(b'published number')
    measured = {'lost': 100 * (1 - shown / LINES)}
    # the time of a launcher that loses lines would say nothing
    return measured | ({'lines': seconds} if shown == LINES else {})


def reading(autoware: Path, peer: Peer, room: Room) -> Measured:
    """Take the times to show the launch arguments of Autoware and to check."""
    if not peer.arguments:
        return {}
    (room.folder / 'src').symlink_to(autoware)
    file = next(autoware.rglob(SIMULATOR))
    words = peer.words(peer.arguments)
    words = tuple(str(file) if w == FILE else w for w in words)
    seconds, shown = timed(words, room.folder)
    if 'map_path' not in shown:
        raise FailedError('the launch arguments were not shown')
    measured = {'arguments': seconds}
    if peer.program == 'colcon':
        words = peer.words('colcon launch --check')
        measured['check'], _ = timed(words, room.folder)
    return measured


def timed(words: Sequence[str], folder: Path) -> tuple[float, str]:
    """Run a command; return its seconds and its output."""
    begin = time.monotonic()
    ended = subprocess.run(
        words,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    return time.monotonic() - begin, ended.stdout + ended.stderr


def cpu_seconds(pid: int) -> float:
    """Return the processor time of a process with all its threads."""
    # the clock of clock_getcpuclockid(3), for which Python has no function
    return time.clock_gettime(~pid << 3 | 2)


def command_line(pid: int) -> bytes:
    """Return the command line of a process; nothing if it has ended."""
    return read_proc(pid, 'cmdline')


def wait_for(condition: Callable[[], bool]) -> bool:
    """Wait until a condition holds; return False after PATIENCE."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(LOOK)
    return True


def lines_in(file: Path) -> int:
    """Return how many lines a file has."""
    return file.read_bytes().count(b'\n')


def clone_autoware(folder: Path) -> Path | None:
    """Clone Autoware's launch files; return None if git cannot."""
    command = ['git', 'clone', '--quiet', '--depth', '1', AUTOWARE]
    environment = os.environ | {'GIT_TERMINAL_PROMPT': '0'}
    ended = subprocess.run(
        [*command, str(folder)],
        env=environment,
        capture_output=True,
        check=False,
    )
    return None if ended.returncode else folder


def autoware_version(folder: Path) -> str:
    """Return the version of Autoware's launch files."""
    manifest = folder / 'autoware_launch/package.xml'
    text = manifest.read_text(encoding='utf-8')
    found = re.search('<version>(.+)</version>', text)
    return found[1] if found else 'unknown'


def measure(
    peers: Sequence[Peer], autoware: Path | None, options: argparse.Namespace
) -> Report:
    """Return all measurements; the launchers take turns."""
    works: list[tuple[set[str], Callable[[Peer, Room], Measured]]] = [
        ({'one'}, one_program),
        ({'many', 'memory', 'cpu', 'stop'}, many_processes),
        ({'edit'}, edited),
        ({'left'}, killed),
        ({'lines', 'lost'}, million_lines),
    ]
    if autoware:
        works.append(({'arguments', 'check'}, partial(reading, autoware)))
    report = Report()
    wanted = {
        work.key
        for work in WORKS
        if not options.words or any(w in work.title for w in options.words)
    }
    for keys, work in works:
        turns = options.runs if wanted & keys else 0
        for peer in [*peers] * turns:
            with tempfile.TemporaryDirectory() as name:
                try:
                    report.add(peer.name, work(peer, Room(Path(name))))
                except FailedError as e:
                    report.fail(peer.name, keys, str(e))
                except (OSError, IndexError, subprocess.TimeoutExpired) as e:
                    # such as a process that ended while it was measured
                    report.fail(peer.name, keys, type(e).__name__)
    return report


def main() -> None:
    """Measure, and print or write the results."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument('--runs', type=int, default=5, metavar='N')
    parser.add_argument('--autoware', type=Path, metavar='FOLDER')
    parser.add_argument('words', nargs='*', metavar='WORD')
    options = parser.parse_args()
    # a launcher that compiles its modules anew each time starts later
    os.environ.pop('PYTHONDONTWRITEBYTECODE', None)
    with tempfile.TemporaryDirectory(prefix='benchmark-') as temporary:
        folder = Path(temporary)
        # so that no other launch of the user is seen
        (folder / 'run').mkdir(mode=0o700)
        os.environ['XDG_RUNTIME_DIR'] = str(folder / 'run')
        peers, versions = [], {}
        for peer in PEERS:
            try:
                found = find(peer, folder)
                versions[peer.name] = version(found)
                peers.append(found)
            except FailedError as e:
                versions[peer.name] = str(e)
        autoware = options.autoware or clone_autoware(folder / 'autoware')
        versions['autoware_launch'] = 'not run: git could not clone it'
        if autoware:
            autoware = autoware.resolve()
            versions['autoware_launch'] = autoware_version(autoware)
        before = machine(options.runs)
        report = measure(peers, autoware, options)
    report.versions = versions
    report.machine = before
    print(report.table())
    if not options.words:
        write_report(report, DOCS)


if __name__ == '__main__':
    main()
