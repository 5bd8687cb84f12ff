# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure how fast the engine relays output, starts and stops processes.

usage: python benchmarks/relay.py [--lines N]

Prints a table. Each row is a launch in a process of its own, so the memory is
the launcher's alone. The producers `cat` a prepared file, so that they cost
little beside the launcher.
"""

import argparse
from collections.abc import Iterable
import os
from pathlib import Path
import signal
import subprocess
import sys
import tempfile
import time
from typing import IO

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from colcon_yamllaunch.language.plan import Plan  # noqa: E402
from colcon_yamllaunch.language.plan import Process  # noqa: E402
from colcon_yamllaunch.language.position import Position  # noqa: E402
from colcon_yamllaunch.runtime.launch import run  # noqa: E402

LINE = b'[INFO] [1732000000.123456789] [counter]: published number 42\n'
#: How often a producer writes its file.
ROUNDS = 20


def main() -> None:
    """Run the benchmarks, or one launch of them."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--lines', type=int, default=4_000_000)
    parser.add_argument('--launch', nargs='+', help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.launch:
        sys.exit(launch(*arguments.launch))
    for row in rows(arguments.lines):
        print(row, flush=True)


def rows(lines: int) -> Iterable[str]:
    """Measure, and return the lines of the table."""
    yield f'{"relay":<34}{"lines/s":>12}{"MiB/s":>8}{"peak MiB":>10}'
    for screen in ('file', 'pipe'):
        for logged in ('log', 'nolog'):
            for count in (1, 10):
                name = f'{count} to {screen}, {logged}'
                yield f'{name:<34}{relay(count, lines, screen, logged)}'
    title = 'quiet processes'
    yield f'{title:<34}{"start s":>12}{"stop s":>8}{"peak MiB":>10}'
    for count in (100, 500):
        yield f'{count:<34}{start_and_stop(count)}'


def relay(count: int, lines: int, screen: str, logged: str) -> str:
    """Relay lines of some processes, and return columns."""
    with tempfile.TemporaryDirectory() as folder:
        each = max(1, lines // count // ROUNDS)
        source = Path(folder, 'lines')
        source.write_bytes(LINE * each)
        command = [sys.executable, __file__, '--launch', 'relay']
        command += [folder, str(count), logged]
        started = time.monotonic()
        with Path(folder, 'screen').open('wb') as file:
            if screen == 'file':
                memory = _memory(_popen(command, file))
            else:
                first = _popen(command, subprocess.PIPE)
                subprocess.Popen(
                    ['cat'], stdin=first.stdout, stdout=subprocess.DEVNULL
                )
                memory = _memory(first)
        seconds = time.monotonic() - started
    total = each * ROUNDS * count
    size = total * len(LINE) / 2**20
    return f'{total / seconds:>12,.0f}{size / seconds:>8.0f}{memory:>10.1f}'


def start_and_stop(count: int) -> str:
    """Start and stop quiet processes, and return columns."""
    process = _popen(
        [sys.executable, __file__, '--launch', 'quiet', '/', str(count), '-'],
        subprocess.PIPE,
    )
    assert process.stdout is not None
    begun = started = 0.0
    left = count
    for line in process.stdout:
        if not begun:
            begun = time.monotonic()
        left -= b'started' in line
        if left == 0:
            started = time.monotonic()
            break
    time.sleep(0.5)
    stopping = time.monotonic()
    process.send_signal(signal.SIGINT)
    process.stdout.read()
    memory = _memory(process)
    stopped = time.monotonic() - stopping
    return f'{started - begun:>12.2f}{stopped:>8.2f}{memory:>10.1f}'


def launch(kind: str, folder: str, count: str, logged: str) -> int:
    """Run one launch; the parent measures it."""
    source = f'{folder}/lines'
    commands = {
        'relay': ('cat', *(source for _ in range(ROUNDS))),
        'quiet': ('sleep', '1000'),
    }
    position = Position('relay.yaml', 1, 1)
    plan = Plan(
        tuple(
            Process(f'{kind}-{n}', commands[kind], folder, position)
            for n in range(int(count))
        )
    )
    logs = Path(folder, 'log') if logged == 'log' else None
    exit_code = run(plan, environment=os.environ, log_folder=logs)
    status = Path('/proc/self/status').read_text(encoding='ascii')
    print(status.partition('VmHWM:')[2].split()[0], file=sys.stderr)
    return exit_code


def _popen(
    command: list[str], stdout: 'int | IO[bytes]'
) -> 'subprocess.Popen[bytes]':
    return subprocess.Popen(command, stdout=stdout, stderr=subprocess.PIPE)


def _memory(process: 'subprocess.Popen[bytes]') -> float:
    assert process.stderr is not None
    text = process.stderr.read()
    if process.wait() != 0:
        sys.exit(f'the launch failed: {text.decode()}')
    return int(text) / 1024


if __name__ == '__main__':
    main()
