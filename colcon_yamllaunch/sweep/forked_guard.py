# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A guard that is a fork of the process that it guards the launches of.

A new program has to import what the guard consists of, which takes longer
than all else that a short run costs. A fork has it already, and guards one
launch after the other, as each fork makes both processes copy their memory.
"""

from contextlib import suppress
import json
import os
import signal
import socket
from typing import NoReturn

from colcon_yamllaunch.engine.stopping.guard import DISMISSED
from colcon_yamllaunch.engine.stopping.guard import guard
from colcon_yamllaunch.engine.stopping.guard_link import Guards

_BLOCKED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: What `ps` shows for it: no word of it names us, as `pkill -9 -f colcon`
#: ends launchers and leaves their guards to stop the processes.
_TITLE = b'guard of a launch'
#: Bytes that the identity of a launch has at most.
_IDENTITY = 1024


class ForkedGuards(Guards):
    """Has one guard, which it forks when there is none."""

    def __init__(self) -> None:
        # over this it gets the sockets of the launches
        self._link: socket.socket | None = None

    def begin(self, connection: int, identity: str) -> int:
        """Have the guard take a launch, and return its process id."""
        words = [identity.encode()]
        if self._link is not None:
            with suppress(OSError):
                socket.send_fds(self._link, words, [connection])
                return self.pid
            # it was killed; if that was between two launches, it is ours
            self._link.close()
            with suppress(ChildProcessError):
                os.waitpid(self.pid, os.WNOHANG)
        self._link, its = socket.socketpair(
            socket.AF_UNIX, socket.SOCK_SEQPACKET
        )
        session = os.getsid(0)
        with its:
            self.pid = os.fork()
            if not self.pid:
                _be_guard(its.fileno(), session)
        socket.send_fds(self._link, words, [connection])
        return self.pid

    def close(self) -> None:
        """Let the guard end."""
        if self._link is not None:
            self._link.close()
            self._link = None

    def end(self, pid: int, connection: socket.socket) -> None:
        """Have the guard leave a launch alone that has ended."""
        try:
            connection.send(json.dumps([DISMISSED]).encode())
        except OSError:
            super().end(pid, connection)


def _be_guard(link: int, session: int) -> NoReturn:
    code = 1
    try:
        signal.set_wakeup_fd(-1)
        signal.pthread_sigmask(signal.SIG_BLOCK, _BLOCKED)
        # its end is that of its work, not that of a parent or a terminal
        os.setsid()
        null = os.open(os.devnull, os.O_RDWR)
        for descriptor, target in ((link, 0), (null, 1), (null, 2)):
            os.dup2(descriptor, target)
        # above all the other end of its own socket
        os.closerange(3, os.sysconf('SC_OPEN_MAX'))
        rename()
        with socket.socket(fileno=0) as launches:
            while True:
                name, descriptors, _, _ = socket.recv_fds(
                    launches, _IDENTITY, 1
                )
                if not descriptors:
                    break
                with socket.socket(fileno=descriptors[0]) as connection:
                    guard(name.decode(), session, connection)
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
