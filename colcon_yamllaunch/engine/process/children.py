# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The children of the launcher that ended or were suspended.

Only the given children are reaped: those of other code are left alone. If one
of these is reported first, ours are checked one by one.
"""

from collections.abc import Collection
from collections.abc import Iterator
import os

_PEEK = os.WNOHANG | os.WNOWAIT
_SUSPENDED = os.WSTOPPED | os.WCONTINUED


def ended_children(ours: Collection[int]) -> Iterator[tuple[int, int]]:
    """Return the children that ended, with what :func:`os.waitpid` says."""
    for result in _reported(ours, os.WEXITED):
        yield result.si_pid, os.waitpid(result.si_pid, 0)[1]


def suspended_children(
    ours: Collection[int],
) -> Iterator[tuple[int, int | None]]:
    """Return the children that a signal suspended, with it, or that go on."""
    for result in _reported(ours, _SUSPENDED):
        # taken note of, it is not reported again
        os.waitid(os.P_PID, result.si_pid, _SUSPENDED | os.WNOHANG)
        goes_on = result.si_code == os.CLD_CONTINUED
        yield result.si_pid, None if goes_on else result.si_status


def has_ended(pid: int) -> bool:
    """Return whether a child has ended; it is reaped if so."""
    try:
        return os.waitpid(pid, os.WNOHANG)[0] == pid
    except ChildProcessError:
        return True


def _reported(ours: Collection[int], what: int) -> Iterator[os.waitid_result]:
    while True:
        result = _look(os.P_ALL, 0, what)
        if result is None:
            return
        if result.si_pid not in ours:
            break
        yield result
    for pid in ours:
        result = _look(os.P_PID, pid, what)
        if result is not None:
            yield result


def _look(kind: int, pid: int, what: int) -> os.waitid_result | None:
    try:
        return os.waitid(kind, pid, what | _PEEK)
    except ChildProcessError:
        return None
