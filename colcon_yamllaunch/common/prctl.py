# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the kernel does when a process ends, see prctl(2)."""

import os

_PR_SET_PDEATHSIG = 1
_PR_SET_CHILD_SUBREAPER = 36


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
