# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A guard that is a fork of the process that it guards the launch of.

A new program has to import what the guard consists of, which takes longer
than all else that a short run costs. A fork has it already.
"""

from contextlib import suppress
import os
import signal
from typing import NoReturn

from colcon_yamllaunch.runtime.stopping.guard import guard

_BLOCKED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: What `ps` shows for it: no word of it names us, as `pkill -9 -f colcon`
#: ends launchers and leaves their guards to stop the processes.
_TITLE = b'guard of a launch'


def fork_guard(connection: int, identity: str) -> int:
    """
    Start a guard; see :data:`.guard_link.BeginGuard`.

    :raises OSError: when there can be no further process
    """
    session = os.getsid(0)
    pid = os.fork()
    if not pid:
        _be_guard(connection, identity, session)
    return pid


def _be_guard(connection: int, identity: str, session: int) -> NoReturn:
    code = 1
    try:
        signal.set_wakeup_fd(-1)
        signal.pthread_sigmask(signal.SIG_BLOCK, _BLOCKED)
        # its end is that of its work, not that of a parent or a terminal
        os.setsid()
        null = os.open(os.devnull, os.O_RDWR)
        for descriptor, target in ((connection, 0), (null, 1), (null, 2)):
            os.dup2(descriptor, target)
        # above all the other end of its own socket
        os.closerange(3, os.sysconf('SC_OPEN_MAX'))
        rename()
        guard(identity, session)
        code = 0
    finally:
        os._exit(code)
    raise AssertionError


def rename() -> None:
    """Have `ps` and `pkill -f` see a title in place of our arguments."""
    # fields 48 and 49 of /proc/PID/stat, see proc(5); the name, which may
    # have blanks, is before the last bracket
    with suppress(OSError, ValueError, IndexError):
        with open('/proc/self/stat', 'rb') as file:
            fields = file.read().rpartition(b')')[2].split()
        start, end = int(fields[45]), int(fields[46])
        if 0 < start < end:
            import ctypes

            room = end - start
            title = _TITLE[: room - 1].ljust(room, b'\0')
            ctypes.memmove(start, title, room)
