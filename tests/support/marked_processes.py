# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Processes that are found by a variable of their environment."""

from collections.abc import Callable, Collection, Iterable
import contextlib
import os
from pathlib import Path
import signal
import time

from support.waiting import is_running

#: Seconds; a loaded machine needs some.
DEADLINE = 60


def marked(name: str, *values: str) -> list[int]:
    """Return the running processes that have one of the values."""
    marks = {f'{name}={value}'.encode() for value in values}
    found = []
    for path in Path('/proc').glob('[0-9]*'):
        with contextlib.suppress(OSError):
            environment = (path / 'environ').read_bytes().split(b'\0')
            pid = int(path.name)
            if not marks.isdisjoint(environment) and is_running(pid):
                found.append(pid)
    return found


def command_of(pid: int) -> str:
    """Return the command line of a process, or nothing."""
    with contextlib.suppress(OSError):
        words = Path(f'/proc/{pid}/cmdline').read_bytes().split(b'\0')
        return b' '.join(words).decode(errors='replace').strip()
    return ''


def descendants(pid: int) -> list[int]:
    """Return the children of a process, their children, and so on."""
    found = []
    for tasks in Path(f'/proc/{pid}/task').glob('*/children'):
        with contextlib.suppress(OSError):
            for child in map(int, tasks.read_text().split()):
                found += [child, *descendants(child)]
    return found


def kill(pids: Iterable[int]) -> None:
    """Send SIGKILL to those that still run."""
    for pid in pids:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def wait_until_none(
    left: Callable[[], Collection[object]], seconds: float = DEADLINE
) -> float:
    """
    Wait until nothing is left, and return how long it took.

    :raises AssertionError: if something still is after that
    """
    begin = time.monotonic()
    while found := left():
        assert time.monotonic() < begin + seconds, found
        time.sleep(0.05)
    return time.monotonic() - begin
