#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Measure `colcon sweep` beside the runs themselves, GNU parallel and Slurm.

usage: python benchmarks/sweep.py [--runs N] [--jobs N] [WORD ...]

It needs the extra `test`, and for two rows GNU parallel and Slurm. Prints a
table: what was measured, the figure, what it is to be seen beside, and the one
to reach. A row is measured if it contains one of the words; without words all
are.

A run is a launch of one process that takes 0.1 s. The sum over the jobs is
what runs of that length would take if nothing else did.
"""

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
import os
from pathlib import Path
import re
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

TESTS = Path(__file__).resolve().parents[1] / 'tests'
sys.path.insert(0, str(TESTS))

# ruff: noqa: E402
from support.slurm import Slurm, why_not
from support.user import User

#: Seconds that the process of a run takes.
LENGTH = 0.1
SIM = f"""\
launch:
  - arg: {{name: seed}}
  - executable: {{cmd: sleep {LENGTH}}}
"""
PATIENCE = 3600
#: Runs at a time beside GNU parallel, and how often both are measured.
AT_ONCE = 16
ROUNDS = 3


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


@dataclass(frozen=True)
class Cost:
    """
    What a command took.

    :param seconds: From its start to its end
    :param cpu: Seconds of processors, of it and all that it waited for
    """

    seconds: float
    cpu: float


def cost_of(user: User, *words: str) -> Cost:
    """Run a command to its end, which is to be a good one."""

    def used() -> float:
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime

    before = used()
    begin = time.monotonic()
    done = subprocess.run(
        words,
        cwd=user.root,
        env=user.environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    return Cost(time.monotonic() - begin, used() - before)


def locally(user: User, runs: int, jobs: int) -> tuple[str, str]:
    """Measure a sweep on this machine."""
    cost = cost_of(
        user,
        *('colcon', 'sweep', 'sim.yaml', f'seed:=1..{runs}'),
        *('--jobs', str(jobs), '--results', 'local'),
    )
    total = runs * LENGTH / jobs
    return (
        f'{cost.seconds:.1f} s, {cost.seconds / total:.2f} x',
        f'sum over {jobs} jobs: {total:.1f} s',
    )


def processors(user: User, runs: int, jobs: int) -> tuple[str, str]:
    """Measure the time of processors that a run costs."""
    words = ['colcon', 'sweep', 'sim.yaml', '--jobs', str(jobs)]
    one = cost_of(user, *words, 'seed:=1', '--results', 'one')
    all_ = cost_of(user, *words, f'seed:=1..{runs}', '--results', 'cpu')
    each = (all_.cpu - one.cpu) / (runs - 1)
    alone = cost_of(user, 'colcon', 'launch', 'sim.yaml', 'seed:=1')
    return (
        f'{1000 * each:.0f} ms a run',
        f'colcon launch: {1000 * alone.cpu:.0f} ms',
    )


def beside_parallel(user: User, runs: int) -> tuple[str, str]:
    """Measure a sweep and GNU parallel by turns."""
    ours, theirs = [], []
    jobs = ('--jobs', str(AT_ONCE))
    numbers = [str(number) for number in range(1, runs + 1)]
    for turn in range(ROUNDS):
        ours.append(
            cost_of(
                user,
                *('colcon', 'sweep', 'sim.yaml', f'seed:=1..{runs}'),
                *(*jobs, '--results', f'parallel-{turn}'),
            )
        )
        theirs.append(
            cost_of(
                user,
                # the number becomes a comment
                *('parallel', *jobs, f'sleep {LENGTH} #', ':::', *numbers),
            )
        )
    ratio = statistics.median(
        one.seconds / other.seconds
        for one, other in zip(ours, theirs, strict=True)
    )
    return (
        f'{ratio:.2f} x, {_each(ours, runs)}',
        f'GNU parallel: {_each(theirs, runs)}',
    )


def _each(costs: list[Cost], runs: int) -> str:
    cpu = statistics.median(cost.cpu for cost in costs) / runs
    return f'{1000 * cpu:.0f} ms a run'


def through_slurm(user: User, runs: int) -> tuple[str, str]:
    """Measure a sweep by Slurm, and an array of as many empty tasks."""
    with (
        tempfile.TemporaryDirectory() as folder,
        Slurm(Path(folder)) as slurm,
    ):
        user.environment = slurm.environment(user.environment)
        cost = cost_of(
            user,
            *('colcon', 'sweep', 'sim.yaml', f'seed:=1..{runs}'),
            *('--on', 'slurm:partition=cpu', '--results', 'slurm'),
        )
        script = user.write('empty.sh', '#!/bin/sh\n', 0o755)
        empty = cost_of(
            user,
            *('sbatch', '--wait', f'--array=0-{runs - 1}'),
            *('--output=/dev/null', str(script)),
        )
    return (
        f'{cost.seconds:.1f} s',
        f'sbatch of an empty array: {empty.seconds:.1f} s',
    )


def rows(user: User, runs: int, jobs: int) -> Iterator[Row]:
    """Iterate over the lines of the table."""
    yield Row(
        f'{runs:,} runs of {LENGTH:g} s',
        '1.3 x',
        lambda: locally(user, runs, jobs),
    )
    fewer = max(2, runs // 10)
    yield Row('processors', '', lambda: processors(user, fewer, jobs))
    if shutil.which('parallel'):
        yield Row(
            f'{runs:,} runs, {AT_ONCE} at a time',
            '1.5 x',
            lambda: beside_parallel(user, runs),
        )
    if not why_not():
        yield Row(
            f'{runs:,} runs by Slurm', '', lambda: through_slurm(user, runs)
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument('--runs', type=int, default=1000)
    parser.add_argument('--jobs', type=int, default=os.cpu_count() or 1)
    parser.add_argument('words', nargs='*', metavar='WORD')
    arguments = parser.parse_args()
    print(f'load of the machine: {os.getloadavg()[0]:.1f}')
    print(_columns('what', 'colcon sweep', 'beside', 'to reach'))
    with tempfile.TemporaryDirectory() as folder:
        user = User(Path(folder))
        user.write('sim.yaml', SIM)
        for row in rows(user, arguments.runs, arguments.jobs):
            words = arguments.words
            if not words or any(word in row.what for word in words):
                print(
                    _columns(row.what, *row.measure(), row.target), flush=True
                )


def _columns(*texts: str) -> str:
    what, ours, beside, target = (re.sub(r'\s+', ' ', t) for t in texts)
    return f'{what:<26}{ours:<22}{beside:<36}{target}'.rstrip()


if __name__ == '__main__':
    main()
