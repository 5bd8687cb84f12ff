# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Processes that become children of ours as their own parents end.

A process whose parent ends becomes a child of the nearest ancestor that asked
for that, see PR_SET_CHILD_SUBREAPER in prctl(2), or else of process 1. So the
launcher finds all processes of a launch, whatever they do to their
environment, group and session. In a container the launcher may be process 1,
and nobody else would reap ended processes.
"""

from collections.abc import Collection
from contextlib import suppress
import os

_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36


class Adoption:
    """
    The adopted children of this process.

    Children from before this process became Python are not part of the launch;
    their descendants cannot be distinguished from those of the launch.

    :param helpers: Children that this process itself has started before
    :param guard: The process id of the guard if it runs already, else 0
    """

    def __init__(self, helpers: Collection[int] = (), guard: int = 0) -> None:
        before = _children().difference(helpers, (guard,))
        #: Whether helpers may have started something before.
        self.has_helpers = bool(helpers)
        #: Whether each child that is adopted comes from what we start.
        self.is_exact = not before
        # nobody else can wait for the children of process 1
        self._others = frozenset() if os.getpid() == 1 else frozenset(before)
        self._seen: set[int] = set()
        adopt_orphans(wanted=True)

    def check_children(
        self, ours: Collection[int]
    ) -> tuple[set[int], set[int]]:
        """
        Return the adopted children, and those of them that are new.

        They may have ended.

        :param ours: The children that this process itself has started
        """
        adopted = _children().difference(ours, self._others)
        new = adopted - self._seen
        self._seen = adopted
        return adopted, new

    def reaped(self, pid: int) -> None:
        """Forget a child; its process id may be given to another one."""
        self._seen.discard(pid)

    def end(self) -> None:
        """Stop adopting, and reap ended children."""
        adopt_orphans(wanted=False)
        for pid in self.check_children(())[0]:
            with suppress(ChildProcessError):
                os.waitpid(pid, os.WNOHANG)


def _children() -> set[int]:
    """Return the children of this process, ended ones included."""
    try:
        with open(f'/proc/self/task/{os.getpid()}/children', 'rb') as file:
            return set(map(int, file.read().split()))
    except OSError:
        # there is no /proc, or it does not have this
        return set()


def end_with_parent(number: int, parent: int | None = None) -> None:
    """
    Send this process a signal when its parent ends, for any reason.

    Other credentials, such as those in a new user namespace, undo this.

    :param parent: The process id of the parent, in case it has ended already
    """
    _prctl(_PR_SET_PDEATHSIG, number)
    if parent is not None and os.getppid() != parent:
        os.kill(os.getpid(), number)


def adopt_orphans(*, wanted: bool) -> None:
    """Become the parent of all descendants that lose theirs, or no more."""
    _prctl(_PR_SET_CHILD_SUBREAPER, int(wanted))


def _prctl(option: int, value: int) -> None:
    # late, as not every command comes here
    import ctypes

    arguments = [ctypes.c_ulong(n) for n in (value, 0, 0, 0)]
    ctypes.CDLL(None).prctl(option, *arguments)
