# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A process that spares short runs the time that a control group takes.

The first move of a process into a group makes the kernel wait for some 10 ms,
those soon after it do not; see :func:`.cgroup.expect_moves`. With runs that
take a tenth of a second, that is a tenth of all.
"""

from contextlib import suppress
import os
import signal
import time

from colcon_yamllaunch.engine.process.cgroup import expect_moves
from colcon_yamllaunch.sweep.isolation import end_with

#: Seconds that a run takes on average for this to be worth its while.
SHORT = 1.0
#: Runs that have to be done before that is known.
_KNOWN_FROM = 4
#: Seconds within which moves end that could not be made.
_AT_ONCE = 0.1


class MoveKeeper:
    """Has that process as long as runs are short."""

    def __init__(self) -> None:
        self._pid = 0
        self._is_known = False
        self._count = 0
        self._seconds = 0.0

    def note(self, seconds: float) -> None:
        """Take note of how long a run took."""
        if self._is_known:
            return
        self._count += 1
        self._seconds += seconds
        if self._count < _KNOWN_FROM:
            return
        self._is_known = True
        if self._seconds / self._count < SHORT:
            with suppress(OSError):
                self._begin()

    def end(self) -> None:
        """Have it no more."""
        if self._pid:
            # it is not reaped yet, so the id is still its own
            os.kill(self._pid, signal.SIGKILL)
            os.waitpid(self._pid, 0)
            self._pid = 0

    def _begin(self) -> None:
        parent = os.getpid()
        self._pid = os.fork()
        if self._pid:
            return
        try:
            signal.set_wakeup_fd(-1)
            for number in (signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, signal.SIG_DFL)
            # the keys of the terminal are for the sweep
            os.setsid()
            os.closerange(0, os.sysconf('SC_OPEN_MAX'))
            end_with(parent)
            while True:
                begin = time.monotonic()
                expect_moves()
                if time.monotonic() - begin < _AT_ONCE:
                    # there are no control groups here
                    break
        finally:
            os._exit(0)
