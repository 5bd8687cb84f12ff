# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure how launches start, relay output, idle and stop.

usage: python benchmarks/runtime.py [--runs N] [--lines N] [WORD ...]

Prints a table: what was measured, the figure of `colcon launch`, that of
`ros2 launch` when it is on PATH, and the one to reach. Times are medians of
several runs. A row is measured if it contains one of the words; without
words all are.

`engine` means `run()` alone, in a process that has imported everything;
beside it stands how long the same number of bare calls of posix_spawn() took
in the same process, as what a machine can do changes with its load. All else
is measured from outside, with whole commands. Producers of output `cat` a
prepared file, so that they cost little beside the launcher.
"""

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
import json
import os
from pathlib import Path
import pty
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from typing import TypeAlias

from colcon_yamllaunch.plan.plan import Plan, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.run import run, RunContext

LINE = b'[INFO] [1732000000.123456789] [counter]: published number 42\n'
OTHER_LINE = LINE.replace(b'42', b'43')
#: How often a producer writes its file.
ROUNDS = 20
#: Expressions that no line matches: one that is searched for in many lines at
#: once, and one that each line is searched for.
UNTIL = {
    'many lines at once': 'received .* double',
    'each line': r'received\s.* double',
}
#: How many times fewer lines `ros2 launch` gets, as it takes so long.
LESS_LINES = 40
#: Lines after which the memory is measured again.
MANY_LINES = 10_000_000
#: Seconds that a quiet launch is watched.
QUIET_SECONDS = 10.0
#: Seconds until a killed launcher's processes have to be gone.
KILLED_SECONDS = 12.0
#: Seconds after which something is given up.
PATIENCE = 120.0
#: Seconds that processes get to be really up after they were started.
SETTLING = 1.0
MARK = 'RUNTIME_BENCHMARK'
#: The command lines of processes.
Commands: TypeAlias = list[tuple[str, ...]]
#: The word of a command that stands for the launch file.
FILE = '{file}'

SLEEP = ('sleep', '1000')
IGNORING = ('sh', '-c', 'trap "" INT; exec sleep 1000')
DAEMON = ('sh', '-c', 'setsid sleep 1000 & exec sleep 1000')


def launch_file(commands: Commands) -> str:
    """Return a launch file that starts `commands`."""
    actions = []
    for number, command in enumerate(commands):
        words = ' '.join(f"'{w}'" if ' ' in w else w for w in command)
        actions.append(
            {
                'executable': {
                    'cmd': words,
                    'name': f'p{number}',
                    'output': 'both',
                }
            }
        )
    # JSON is YAML, too
    return json.dumps({'launch': actions})


@dataclass(frozen=True)
class Launcher:
    """
    A command that runs a launch file.

    :param command: The command, with FILE for the launch file
    :param started: What its line about a process that was started contains
    :param finished: The same for one that ended well
    :param less: How many times fewer lines it is given
    :param engine: Whether its engine can be measured alone
    :param file: The name of the launch file
    :param write: Returns the text of the launch file, from the command lines
    """

    command: tuple[str, ...]
    started: bytes
    finished: bytes
    less: int = 1
    engine: bool = False
    file: str = 'benchmark.yaml'
    write: Callable[[Commands], str] = launch_file


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
    measure: Callable[[Launcher], str]


class Running:
    """
    A launch in a process of its own.

    :param launcher: Runs it
    :param folder: A folder for its files
    :param commands: The command lines of its processes
    :param screen: Where output goes: a `file`, a `pipe` or a `terminal`
    """

    def __init__(
        self,
        launcher: Launcher,
        folder: Path,
        commands: Commands,
        screen: str = 'terminal',
    ) -> None:
        self._launcher = launcher
        self._mark = f'{MARK}={folder}'.encode()
        file = folder / launcher.file
        file.write_text(launcher.write(commands), encoding='utf-8')
        arguments = [
            str(file) if word == FILE else word for word in launcher.command
        ]
        environment = {
            **os.environ,
            MARK: str(folder),
            'COLCON_LOG_PATH': str(folder / 'log'),
            'ROS_LOG_DIR': str(folder / 'log'),
            'TERM': 'xterm',
        }
        # which says that a terminal is none to look at
        environment.pop('CI', None)
        self.pid, self.terminal = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            if screen != 'terminal':
                _redirect(screen, folder)
            os.execvpe(arguments[0], arguments, environment)
        self._shown = b''

    def shows(self, text: bytes, times: int) -> None:
        """Wait until a text was shown so many times."""
        deadline = time.monotonic() + PATIENCE
        while self._shown.count(text) < times:
            if not self._read() or time.monotonic() > deadline:
                sys.exit(f'{text!r} is missing in {self._shown[-2000:]!r}')

    def shows_started(self, count: int) -> None:
        """Wait until so many processes have been started."""
        self.shows(self._launcher.started, count)

    def shows_finished(self) -> None:
        """Wait until one process has ended."""
        self.shows(self._launcher.finished, 1)

    def ends(self) -> None:
        """Wait for the end."""
        while self._read():
            self._shown = b''
        os.waitpid(self.pid, 0)
        self.pid = 0

    def left(self) -> list[int]:
        """Return what still runs, the launcher included but not its guard."""
        return [p for p in processes() if self._mark in _environment(p)]

    def guards(self, launcher: int = 0) -> list[int]:
        """
        Return the guard, if there is one.

        :param launcher: The launcher, if it is not the process itself
        """
        return [
            p
            for p in processes()
            if b'engine.guard' in read_proc(p, 'environ')
            and parent(p) == (launcher or self.pid)
        ]

    def memory(self) -> tuple[float, float]:
        """Return the MiB of the launcher, and those of its guard."""
        own = proportional_size(self.pid)
        return own, sum(map(proportional_size, self.guards()))

    def clean_up(self) -> None:
        """Leave nothing running."""
        for pid in {*self.left(), self.pid} - {0}:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
        if self.pid:
            os.waitpid(self.pid, 0)
        os.close(self.terminal)

    def _read(self) -> bytes:
        try:
            data = os.read(self.terminal, 1 << 16)
        except OSError:
            # a terminal that nobody has open any more
            return b''
        self._shown += data
        return data


@contextmanager
def running(
    launcher: Launcher,
    commands: Commands,
    screen: str = 'terminal',
) -> Iterator[Running]:
    """Have a launch run."""
    with tempfile.TemporaryDirectory() as name:
        one = Running(launcher, Path(name), commands, screen)
        try:
            yield one
        finally:
            one.clean_up()


def started(launcher: Launcher, runs: int, count: int) -> str:
    """Take the time until the last process is started."""
    if launcher.engine:
        return started_by_engine(runs, count)
    return started_by_command(launcher, count)


def started_by_engine(runs: int, count: int) -> str:
    """Start quiet processes by the engine alone."""
    command = [sys.executable, __file__, '--start', str(count)]
    results = [
        json.loads(subprocess.check_output(command)) for _ in range(runs)
    ]
    engine = statistics.median(r['engine'] for r in results)
    bare = statistics.median(r['bare'] for r in results)
    return f'{engine:.3f} s (posix_spawn {bare:.3f} s)'


def started_by_command(launcher: Launcher, count: int) -> str:
    """Take the time from the first start to the last, as it is shown."""
    with running(launcher, [SLEEP] * count) as one:
        one.shows_started(1)
        begin = time.monotonic()
        one.shows_started(count)
        return f'{time.monotonic() - begin:.3f} s'


def relayed(
    launcher: Launcher, runs: int, lines: int, count: int, screen: str
) -> str:
    """Return how many lines a second go through a launcher."""
    each = max(1, lines // launcher.less // count // ROUNDS)
    with tempfile.TemporaryDirectory() as name:
        source = Path(name, 'lines')
        seconds = []
        for size in (0, each):
            # the same line over and over would be counted on a terminal
            source.write_bytes((LINE + OTHER_LINE) * (size // 2))
            producer = ('cat', *[str(source)] * ROUNDS)
            times = []
            for _ in range(runs):
                begin = time.monotonic()
                with running(launcher, [producer] * count, screen) as one:
                    one.ends()
                times.append(time.monotonic() - begin)
            seconds.append(statistics.median(times))
    # the command itself takes its time without a line, too
    rate = each * ROUNDS * count / (seconds[1] - seconds[0])
    return f'{rate:,.0f} lines/s'


def searched(
    expression: str, launcher: Launcher, runs: int, lines: int
) -> str:
    """Relay lines that are searched for an expression, which is in none."""
    if not launcher.engine:
        return '-'
    return relayed(_colcon('--until', expression), runs, lines, 1, 'file')


def memory(launcher: Launcher, count: int) -> str:
    """Measure the memory of a launch with quiet processes."""
    with running(launcher, [SLEEP] * count) as one:
        one.shows_started(count)
        time.sleep(SETTLING)
        return _megabytes(one)


def memory_after_lines(launcher: Launcher) -> str:
    """Measure the memory after much output."""
    with tempfile.TemporaryDirectory() as name:
        source = Path(name, 'lines')
        source.write_bytes(LINE * (MANY_LINES // launcher.less // ROUNDS))
        producer = ('cat', *[str(source)] * ROUNDS)
        with running(launcher, [*[SLEEP] * 100, producer], 'error') as one:
            one.shows_finished()
            return _megabytes(one)


def cpu(launcher: Launcher) -> str:
    """Measure what a launch with quiet processes does."""
    with running(launcher, [SLEEP] * 100) as one:
        one.shows_started(100)
        time.sleep(2 * SETTLING)
        before = _cpu_seconds(one.pid)
        time.sleep(QUIET_SECONDS)
        used = _cpu_seconds(one.pid) - before
    return f'{100 * used / QUIET_SECONDS:.3f} %'


def interrupted(launcher: Launcher, runs: int, count: int) -> str:
    """Take the time from Ctrl-C to the prompt."""
    times = []
    for _ in range(runs):
        with running(launcher, [SLEEP] * count) as one:
            one.shows_started(count)
            time.sleep(SETTLING)
            begin = time.monotonic()
            os.write(one.terminal, b'\x03')
            one.ends()
            times.append(time.monotonic() - begin)
    return f'{statistics.median(times):.3f} s'


def left_by_killed(launcher: Launcher) -> str:
    """Kill the launcher, and count what is left."""
    commands = [*[SLEEP] * 40, *[IGNORING] * 50, *[DAEMON] * 10]
    with running(launcher, commands) as one:
        one.shows_started(len(commands))
        time.sleep(SETTLING)
        guards = one.guards()
        before = one.left() + guards
        os.kill(one.pid, signal.SIGKILL)
        time.sleep(KILLED_SECONDS)
        left = one.left() + [p for p in guards if read_proc(p, 'cmdline')]
        return f'{len(left)} of {len(before) - 1}'


def start(count: int) -> None:
    """Start processes by the engine, and print how long it took."""
    position = Position('benchmark.yaml', 1, 1)
    plan = Plan(
        tuple(Process(f'p{n}', SLEEP, '/', position) for n in range(count))
    )
    bare = _bare_start(count)
    ends: list[float] = []

    def spawn(*arguments: object, **options: object) -> int:
        pid = os.posix_spawn(*arguments, **options)  # type: ignore[arg-type]
        ends.append(time.perf_counter())
        if len(ends) == count:
            os.kill(os.getpid(), signal.SIGINT)
        return pid

    with (
        tempfile.TemporaryDirectory() as name,
        Path(name, 'screen').open('w', encoding='utf-8') as stream,
    ):
        begin = time.perf_counter()
        run(
            plan,
            RunContext(
                environment=os.environ,
                log_folder=Path(name, 'log'),
                stream=stream,
                spawn=spawn,
            ),
        )
    print(json.dumps({'engine': ends[-1] - begin, 'bare': bare}))


def rows(runs: int, lines: int) -> list[Row]:
    """Return the rows of the table."""
    table = [
        Row(
            f'{count} processes started (engine)',
            f'<= {0.0016 * count:.2f} s',
            partial(started, runs=runs, count=count),
        )
        for count in (100, 1000)
    ]
    table += [
        Row(
            f'relayed to a {screen}, {count} process{"es" * (count > 1)}',
            '>= 1,500,000 lines/s',
            partial(
                relayed, runs=runs, lines=lines, count=count, screen=screen
            ),
        )
        for screen in ('file', 'pipe')
        for count in (1, 10)
    ]
    table += [
        Row(
            f'searched, {kind} (--until)',
            '',
            partial(searched, expression, runs=runs, lines=lines),
        )
        for kind, expression in UNTIL.items()
    ]
    table += [
        Row(
            f'memory (PSS), {count} quiet processes',
            target,
            partial(memory, count=count),
        )
        for count, target in ((100, '<= 45 MiB'), (1000, ''))
    ]
    table += [
        Row(
            f'memory (PSS), after {MANY_LINES:,} lines',
            '<= 45 MiB',
            memory_after_lines,
        ),
        Row('CPU, 100 quiet processes', '< 0.2 %', cpu),
    ]
    table += [
        Row(
            f'Ctrl-C to prompt, {count} processes',
            target,
            partial(interrupted, runs=runs, count=count),
        )
        for count, target in ((100, '<= 0.3 s'), (500, '<= 1 s'))
    ]
    title = f'SIGKILL of the launcher, left after {KILLED_SECONDS:g} s'
    return [*table, Row(title, '0', left_by_killed)]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--runs', type=int, default=5)
    parser.add_argument('--lines', type=int, default=4_000_000)
    parser.add_argument('--start', type=int, help=argparse.SUPPRESS)
    parser.add_argument('words', nargs='*', metavar='WORD')
    arguments = parser.parse_args()
    if arguments.start:
        start(arguments.start)
        return
    launchers = (_colcon(), _ros2())
    if launchers[1] is None:
        print('ros2 is not on PATH, so there is nothing to compare with')
    print(f'load of the machine: {os.getloadavg()[0]:.1f}')
    print(_columns('what', 'colcon launch', 'ros2 launch', 'to reach'))
    for row in rows(arguments.runs, arguments.lines):
        words = arguments.words
        if not words or any(word in row.what for word in words):
            figures = [row.measure(one) if one else '-' for one in launchers]
            print(_columns(row.what, *figures, row.target), flush=True)


def _colcon(*options: str) -> Launcher:
    return Launcher(
        (
            str(Path(sys.executable).with_name('colcon')),
            'launch',
            # a line for each start instead of a table
            '--verbose',
            *options,
            FILE,
        ),
        b': started, pid',
        b': finished after',
        engine=True,
    )


def _ros2() -> Launcher | None:
    if shutil.which('ros2') is None:
        return None
    return Launcher(
        ('ros2', 'launch', FILE),
        b'process started with pid',
        b'process has finished cleanly',
        less=LESS_LINES,
    )


def _columns(*texts: str) -> str:
    what, ours, theirs, target = texts
    return f'{what:<42}{ours:<32}{theirs:<32}{target}'


def _redirect(screen: str, folder: Path) -> None:
    """Lead standard output elsewhere, in the process that becomes one."""
    if screen == 'file':
        target = os.open(folder / 'screen', os.O_WRONLY | os.O_CREAT)
    else:
        # a reader that keeps what was asked for, and drops the rest
        command = ['cat']
        stdout: int | None = subprocess.DEVNULL
        if screen == 'error':
            command = ['grep', '-a', 'launch.*finished\\|cleanly']
            stdout = None
        reader = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=stdout
        )
        assert reader.stdin is not None
        target = reader.stdin.fileno()
    os.dup2(target, 1)


def _bare_start(count: int) -> float:
    program = shutil.which(SLEEP[0]) or SLEEP[0]
    begin = time.perf_counter()
    pids = [
        os.posix_spawn(program, SLEEP, os.environ, setpgroup=0)
        for _ in range(count)
    ]
    seconds = time.perf_counter() - begin
    for pid in pids:
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
    return seconds


def processes() -> list[int]:
    """Return the ids of all processes."""
    return [int(n) for n in os.listdir('/proc') if n.isdigit()]


def read_proc(pid: int, name: str) -> bytes:
    """Return a file of `/proc/PID`; nothing if the process has ended."""
    try:
        return Path(f'/proc/{pid}/{name}').read_bytes()
    except OSError:
        return b''


def _environment(pid: int) -> list[bytes]:
    return read_proc(pid, 'environ').split(b'\0')


def parent(pid: int) -> int:
    """Return the parent of a process; 0 if the process has ended."""
    fields = read_proc(pid, 'stat').rpartition(b') ')[2].split()
    return int(fields[1]) if fields else 0


def _cpu_seconds(pid: int) -> float:
    return int(read_proc(pid, 'schedstat').split()[0]) / 1e9


def proportional_size(pid: int) -> float:
    """Return the MiB of memory of a process (PSS)."""
    return (
        int(read_proc(pid, 'smaps_rollup').partition(b'Pss:')[2].split()[0])
        / 1024
    )


def _megabytes(one: Running) -> str:
    launcher, guard = one.memory()
    both = f', {launcher + guard:.0f} MiB with guard' if guard else ''
    return f'{launcher:.0f} MiB{both}'


if __name__ == '__main__':
    main()
