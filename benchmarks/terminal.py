# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure what the status block costs: output with it and without, by turns.

usage: python benchmarks/terminal.py [--pairs N] [--lines N]

A row is a number of processes that write as fast as they can, to a terminal
that is read as fast as it comes. `drawn` is how often the block was drawn;
the ratios are those of each pair, as the load of a machine changes between
pairs more than within one. Processor time is that of the launcher with all
that it started, which hardly depends on what else the machine does.
"""

import argparse
from dataclasses import dataclass
import fcntl
import json
import os
from pathlib import Path
import pty
import statistics
import struct
import sys
import tempfile
import termios
import time

LINE = b'[INFO] [1732000000.123456789] [counter]: published number 42\n'
OTHER_LINE = LINE.replace(b'42', b'43')
#: How often a producer writes its file.
ROUNDS = 20
#: What each drawing of a block contains, and nothing else does.
DRAWN = b'\x1b[?7l'


@dataclass(frozen=True)
class Run:
    """
    What a launch took.

    :param wall: Seconds until its end
    :param processor: Seconds of processors
    :param size: Bytes that were shown
    :param drawn: How often a block was drawn
    """

    wall: float
    processor: float
    size: int
    drawn: int


def run(folder: Path, *options: str) -> Run:
    """Launch the file in a folder in a terminal, and read that."""
    colcon = str(Path(sys.executable).with_name('colcon'))
    environment = {
        **os.environ,
        'COLCON_LOG_PATH': str(folder / 'log'),
        'TERM': 'xterm',
    }
    # which says that a terminal is none to look at
    environment.pop('CI', None)
    begin = time.monotonic()
    pid, terminal = pty.fork()
    if pid == 0:
        os.chdir(folder)
        arguments = ('colcon', 'launch', 'benchmark.yaml', *options)
        os.execve(colcon, arguments, environment)
    fcntl.ioctl(
        terminal, termios.TIOCSWINSZ, struct.pack('HHHH', 24, 80, 0, 0)
    )
    size = drawn = 0
    while data := _read(terminal):
        size += len(data)
        drawn += data.count(DRAWN)
    _, status, usage = os.wait4(pid, 0)
    os.close(terminal)
    if status:
        sys.exit('the launch failed')
    wall = time.monotonic() - begin
    return Run(wall, usage.ru_utime + usage.ru_stime, size, drawn)


def measure(pairs: int, lines: int, count: int) -> None:
    """Print a row for each way, and the ratios of the pairs."""
    without: list[Run] = []
    with_block: list[Run] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        each = lines // count // ROUNDS // 2
        # the same line over and over would be counted
        (folder / 'lines').write_bytes((LINE + OTHER_LINE) * each)
        command = f'cat {" ".join([str(folder / "lines")] * ROUNDS)}'
        actions = [
            {'executable': {'cmd': command, 'name': f'p{n}', 'output': 'both'}}
            for n in range(count)
        ]
        # JSON is YAML, too
        text = json.dumps({'launch': actions})
        (folder / 'benchmark.yaml').write_text(text, encoding='utf-8')
        for number in range(pairs):
            if number % 2:
                with_block.append(run(folder))
            without.append(run(folder, '--no-status'))
            if not number % 2:
                with_block.append(run(folder))
    for what, runs in (('--no-status', without), ('', with_block)):
        print(
            f'{count:>9}  {what:<12}'
            f'{statistics.median(r.wall for r in runs):>9.2f} s'
            f'{statistics.median(r.processor for r in runs):>9.2f} s'
            f'{statistics.median(r.size for r in runs) / 1e6:>9.2f} MB'
            f'{statistics.median(r.drawn for r in runs):>8.0f}'
        )
    both = list(zip(without, with_block, strict=True))
    wall = statistics.median(b.wall / a.wall for a, b in both)
    processor = statistics.median(b.processor / a.processor for a, b in both)
    print(f'{"":>11}{"ratio":<12}{wall:>9.2f}  {processor:>9.2f}', flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--pairs', type=int, default=7)
    parser.add_argument('--lines', type=int, default=1_000_000)
    arguments = parser.parse_args()
    print(f'load of the machine: {os.getloadavg()[0]:.1f}')
    print('processes  block         wall time  processor      shown   drawn')
    for count in (1, 10):
        measure(arguments.pairs, arguments.lines, count)


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 1 << 16)
    except OSError:
        # nobody has it open any more
        return b''


if __name__ == '__main__':
    main()
