#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure launches over several machines, reached by ssh, all on this one.

usage: python benchmarks/machines.py [--runs N] [--lines N] [WORD ...]

It needs the extra `test`, and `sshd`. Prints a table: what was measured, the
figure, what it is to be seen beside, and the one to reach. Times are medians
of several runs. A row is measured if it contains one of the words; without
words all are.

The machines share the processors of this one with each other and with the
launcher, so a figure tells what all of them need together. Each is reached
through a link, a thread of this benchmark, that can be held; where lines are
counted and nothing is held, ssh goes to the server itself.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
import json
import os
from pathlib import Path
import re
import signal
import statistics
import sys
import tempfile
import time

TESTS = Path(__file__).resolve().parents[1] / 'tests'
sys.path.insert(0, str(TESTS))

# ruff: noqa: E402
from support.sshd import MACHINES, Sshd, why_not
from support.user import Launch, User

PROCESSES = 60
#: How many machines the launch grows over, and what each of them runs.
GROWTH = (2, 8, 32)
PROCESSES_EACH = 4
SLEEP = ('sleep', '1000')
LINE = b'[INFO] [1732000000.123456789] [counter]: published number 42\n'
#: How often a producer writes its file.
ROUNDS = 20
#: What prints numbered lines for as long as the link is held, and longer.
COUNTING = """\
import sys, time
count, seconds = int(sys.argv[1]), float(sys.argv[2])
pieces = 500
begin = time.monotonic()
for piece in range(pieces):
    first = count * piece // pieces
    last = count * (piece + 1) // pieces
    sys.stdout.write(''.join(f'line {n}\\n' for n in range(first, last)))
    sys.stdout.flush()
    time.sleep(max(0, begin + seconds * piece / pieces - time.monotonic()))
print('all printed', flush=True)
"""
COUNTING_SECONDS = 14.0
#: Seconds after the start at which the cable is pulled, and for how long.
HELD_AT, HELD_FOR = 2.0, 8.0
#: Seconds after which nothing may be left on a machine that lost its launcher.
GONE_AFTER = 16.0
PATIENCE = 120.0
#: What the launcher says once each.
STARTED = re.compile(r': started, pid')
LOST = re.compile(r'arm: the link is lost')
BACK = re.compile(r'arm: the link is back')
COLCON = str(Path(sys.executable).with_name('colcon'))


@dataclass(frozen=True)
class Row:
    """
    A line of the table.

    :param what: What is measured
    :param target: What to reach
    :param measure: Measures it, and says what to see it beside
    """

    what: str
    target: str
    measure: Callable[[], tuple[str, str]]


class Bench:
    """
    A user with machines.

    :param direct: Whether ssh goes to the server itself
    """

    def __init__(
        self, folder: Path, names: Sequence[str], direct: bool
    ) -> None:
        (folder / 'sshd').mkdir()
        (folder / 'user').mkdir()
        self.sshd = Sshd(folder / 'sshd', names)
        self.names = names
        self.user = User(folder / 'user')
        self._direct = direct

    def __enter__(self) -> 'Bench':
        self.sshd.__enter__()
        if self._direct:
            for machine in self.sshd.machines.values():
                self.sshd.configure(machine.name, f'Port {machine.port}')
        self.user.environment = self.sshd.environment(self.user.environment)
        return self

    def __exit__(self, *_: object) -> None:
        self.user.leave()
        self.sshd.__exit__()

    def deploy(self, commands: Sequence[Sequence[str]], **more: str) -> None:
        """Write a launch file, and place its processes one by one."""
        actions = []
        rules = []
        for number, command in enumerate(commands):
            name = f'p{number}'
            words = ' '.join(f"'{w}'" if ' ' in w else w for w in command)
            actions.append(
                {'executable': {'cmd': words, 'name': name, 'output': 'log'}}
            )
            machine = self.names[number % len(self.names)]
            rules.append({'match': name, 'machine': machine})
        machines = {
            name: {'ssh': name, 'sync': 'none', **more} for name in self.names
        }
        deployment = {'machines': machines, 'processes': rules}
        # JSON is YAML, too
        self.user.write('plain.yaml', json.dumps({'launch': actions}))
        self.user.write('robot.yaml', json.dumps(deployment))

    def launch(self, *options: str, deployed: bool = True) -> Launch:
        """Start a launch, and return at once."""
        deploy = ('--deploy', 'robot.yaml') if deployed else ()
        words = ('--verbose', *deploy, *options, 'plain.yaml')
        return self.user.start(COLCON, 'launch', *words)

    def slowest_ssh(self) -> float:
        """Return the seconds that `ssh host true` takes, all at once."""
        begin = time.monotonic()
        ends = [
            self.user.start('ssh', '-o', 'BatchMode=yes', name, 'true')
            for name in self.names
        ]
        for one in ends:
            if one.end():
                sys.exit(one.output)
        return time.monotonic() - begin

    def logged(self, name: str) -> Path:
        """Return the log of a process of the last launch."""
        logs = (self.user.root.parent / '.ros/log').glob('launch_*')
        last = max(logs, key=lambda path: path.stat().st_mtime_ns)
        (found,) = (p for p in last.glob('*/stdout.log') if name in str(p))
        return found


@contextmanager
def bench(
    names: Sequence[str] = MACHINES, direct: bool = False
) -> Iterator[Bench]:
    """Have machines, and a user who reaches them."""
    with (
        tempfile.TemporaryDirectory() as name,
        Bench(Path(name), names, direct) as one,
    ):
        yield one


def shows(launch: Launch, expression: re.Pattern[str], count: int = 1) -> None:
    """Wait until an expression was found so many times in the output."""
    deadline = time.monotonic() + PATIENCE
    while len(expression.findall(launch.output)) < count:
        if launch.process.poll() is not None or time.monotonic() > deadline:
            sys.exit(f'{expression.pattern!r} is missing in:\n{launch.output}')
        time.sleep(0.01)


def seconds_to_start(one: Bench, count: int, deployed: bool) -> float:
    """Take the time until so many processes have been started."""
    begin = time.monotonic()
    launch = one.launch(deployed=deployed)
    shows(launch, STARTED, count)
    seconds = time.monotonic() - begin
    launch.interrupt()
    return seconds


def started(runs: int, names: Sequence[str], count: int) -> tuple[str, str]:
    """Start processes on machines, and the same ones here."""
    with bench(names) as one:
        one.deploy([SLEEP] * count)
        first = seconds_to_start(one, count, deployed=True)
        there = [seconds_to_start(one, count, True) for _ in range(runs)]
        here = [seconds_to_start(one, count, False) for _ in range(runs)]
        ssh = [one.slowest_ssh() for _ in range(runs)]
    ssh_time, here_time = statistics.median(ssh), statistics.median(here)
    return (
        f'{statistics.median(there):.2f} s (first time {first:.2f} s)',
        f'slowest ssh {ssh_time:.2f} s + here {here_time:.2f} s',
    )


def relayed(runs: int, lines: int) -> tuple[str, str]:
    """Return how many lines a second get into the log folder."""
    each = lines // len(MACHINES) // ROUNDS
    seconds: dict[tuple[bool, int], float] = {}
    for size in (0, each):
        with bench(direct=True) as one:
            source = one.user.write('lines', '')
            source.write_bytes(LINE * size)
            producer = ('cat', *[str(source)] * ROUNDS)
            one.deploy([producer] * len(MACHINES))
            for deployed in (False, True):
                times = []
                for _ in range(runs):
                    begin = time.monotonic()
                    launch = one.launch(deployed=deployed)
                    if launch.end():
                        sys.exit(launch.output)
                    times.append(time.monotonic() - begin)
                seconds[deployed, size] = statistics.median(times)
    total = each * ROUNDS * len(MACHINES)
    there, here = (
        # the command itself takes its time without a line, too
        total / (seconds[deployed, each] - seconds[deployed, 0])
        for deployed in (True, False)
    )
    return f'{there:,.0f} lines/s', f'here {here:,.0f} lines/s'


def cut() -> tuple[str, str]:
    """Pull the cable of one machine, for good."""
    with bench() as one:
        one.deploy([SLEEP] * PROCESSES)
        launch = one.launch()
        shows(launch, STARTED, PROCESSES)
        time.sleep(1)
        before = len(one.sshd.left('arm'))
        begin = time.monotonic()
        one.sshd['arm'].link.hold()
        shows(launch, LOST)
        noticed = time.monotonic() - begin
        one.sshd.wait_until_empty('arm', seconds=PATIENCE)
        gone = time.monotonic() - begin
        launch.interrupt()
    return f'{noticed:.1f} s, gone after {gone:.1f} s', f'{before} ran there'


def counted(lines: int, pulled: bool) -> tuple[str, str]:
    """Pull the cable while lines are printed, and plug it in again."""
    with bench() as one:
        script = one.user.write('counting.py', COUNTING)
        argv = (sys.executable, str(script), str(lines), str(COUNTING_SECONDS))
        one.deploy([argv, SLEEP, SLEEP], on_lost='keep')
        launch = one.launch()
        shows(launch, STARTED, 3)
        time.sleep(HELD_AT)
        link = one.sshd['arm'].link
        if pulled:
            link.hold()
            time.sleep(HELD_FOR)
            link.release()
        else:
            link.break_off()
        begin = time.monotonic()
        shows(launch, BACK)
        back = time.monotonic() - begin
        shows(launch, re.compile(r'finished after'))
        launch.interrupt()
        text = one.logged('p0').read_bytes()
        numbers = [int(n) for n in re.findall(rb'line (\d+)$', text, re.M)]
    lost = lines - len(set(numbers))
    twice = len(numbers) - len(set(numbers))
    disordered = sum(a >= b for a, b in pairwise(numbers))
    return (
        f'{lost} lost, {twice} twice, {disordered} out of order',
        f'connected again after {back:.1f} s',
    )


def synced(runs: int) -> tuple[str, str]:
    """Take the time of the second launch of a package, beside a local one."""
    times: dict[str, list[float]] = {'there': [], 'here': []}
    with bench() as one:
        for number in range(10):
            one.user.package(f'pkg{number}')
            one.user.manifest(f'pkg{number}')
        machines = {name: {'ssh': name} for name in one.names}
        rules = [{'match': '*', 'machine': one.names[0]}]
        deployment = {'machines': machines, 'processes': rules}
        one.user.write('robot.yaml', json.dumps(deployment))
        words = (COLCON, 'launch', 'pkg0', 'pkg0.yaml')
        deploy = ('--deploy', 'robot.yaml')
        begin = time.monotonic()
        if (launch := one.user.start(*words, *deploy)).end():
            sys.exit(launch.output)
        first = time.monotonic() - begin
        one.user.start(*words).end()
        for _ in range(runs):
            for what, options in (
                ('there', deploy),
                ('here', ('--no-build',)),
            ):
                begin = time.monotonic()
                if (launch := one.user.start(*words, *options)).end():
                    sys.exit(launch.output)
                times[what].append(time.monotonic() - begin)
        ssh = one.slowest_ssh()
    there, here = (statistics.median(times[w]) for w in ('there', 'here'))
    return (
        f'{there:.2f} s (first time {first:.2f} s)',
        f'--no-build here {here:.2f} s, ssh {ssh:.2f} s',
    )


def grown(count: int) -> tuple[str, str]:
    """Launch over many machines, and see what the launcher needs."""
    names = [f'm{number}' for number in range(count)]
    with bench(names, direct=True) as one:
        total = count * PROCESSES_EACH
        one.deploy([SLEEP] * total)
        seconds_to_start(one, total, deployed=True)
        begin = time.monotonic()
        launch = one.launch()
        shows(launch, STARTED, total)
        seconds = time.monotonic() - begin
        time.sleep(3)
        before, quiet = _cpu_seconds(launch.process.pid), 10.0
        time.sleep(quiet)
        used = _cpu_seconds(launch.process.pid) - before
        memory = _megabytes(launch.process.pid)
        begin = time.monotonic()
        launch.process.send_signal(signal.SIGINT)
        launch.end()
        stopped = time.monotonic() - begin
        ssh = one.slowest_ssh()
    return (
        f'{seconds:.2f} s, Ctrl-C {stopped:.2f} s',
        f'ssh {ssh:.2f} s; launcher {memory:.0f} MiB, '
        f'{100 * used / quiet:.2f} % of a CPU',
    )


def rows(runs: int, lines: int) -> list[Row]:
    """Return the rows of the table."""
    return [
        Row(
            f'{PROCESSES} processes on 3 machines started',
            '<= ssh + 0.5 s',
            partial(started, runs, MACHINES, PROCESSES),
        ),
        Row(
            'relayed to the log folder',
            '>= 300,000 lines/s',
            partial(relayed, runs, 2 * lines),
        ),
        Row('link cut: noticed', f'<= 5 s, <= {GONE_AFTER:g} s', cut),
        Row(
            f'link held, {lines:,} lines',
            '0 lost, 0 twice',
            partial(counted, lines, True),
        ),
        Row(
            f'link broken, {lines:,} lines',
            '0 lost, 0 twice',
            partial(counted, lines, False),
        ),
        Row('second launch with sync', '', partial(synced, runs)),
        *(
            Row(
                f'{count} machines, {count * PROCESSES_EACH} processes',
                '',
                partial(grown, count),
            )
            for count in GROWTH
        ),
    ]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--runs', type=int, default=5)
    parser.add_argument('--lines', type=int, default=1_000_000)
    parser.add_argument('words', nargs='*', metavar='WORD')
    arguments = parser.parse_args()
    if why_not():
        sys.exit(why_not())
    print(f'load of the machine: {os.getloadavg()[0]:.1f}')
    print(_columns('what', 'colcon launch', 'beside', 'to reach'))
    for row in rows(arguments.runs, arguments.lines):
        words = arguments.words
        if not words or any(word in row.what for word in words):
            print(_columns(row.what, *row.measure(), row.target), flush=True)


def _columns(*texts: str) -> str:
    what, ours, beside, target = texts
    return f'{what:<36}{ours:<40}{beside:<46}{target}'


def _cpu_seconds(pid: int) -> float:
    return int(Path(f'/proc/{pid}/schedstat').read_text().split()[0]) / 1e9


def _megabytes(pid: int) -> float:
    text = Path(f'/proc/{pid}/smaps_rollup').read_bytes()
    return int(text.partition(b'Pss:')[2].split()[0]) / 1024


if __name__ == '__main__':
    main()
