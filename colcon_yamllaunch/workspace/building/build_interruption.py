# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Ending a build by Ctrl-C, SIGTERM, SIGHUP or SIGQUIT.

After Ctrl-C colcon waits for the jobs that run, as the terminal sends the
signal to these, too. One that does not heed it, or that begins just then,
would hold the user up for as long as it likes; and the other signals come to
colcon alone.
"""

from collections.abc import Iterator
from contextlib import contextmanager
import signal
import sys
import threading
import time
from types import FrameType

from colcon_yamllaunch.common.adoption import Adoption
from colcon_yamllaunch.common.escalation import Escalation
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.workspace.building.orphan_builds import BuildProcesses
from colcon_yamllaunch.workspace.colcon.build_result import INTERRUPTED

#: What asks a build to end.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: Seconds after the first signal until all that the build has started gets
#: one; those that have it from the terminal end by it.
GRACE = 0.3
#: How long it has then.
TIMEOUTS = Timeouts(sigterm=1.7, sigkill=4.0)
#: Seconds between two looks at what the build has started.
INTERVAL = 0.1


class Interruption:
    """
    What came of the signals during a build.

    :param adoption: Keeps what the build has started in sight
    """

    def __init__(self, adoption: Adoption) -> None:
        self._processes = BuildProcesses(adoption=adoption)
        self._number: int | None = None
        self._has_ended = threading.Event()
        self._ender = threading.Thread(target=self._end, daemon=True)

    @property
    def returncode(self) -> int | None:
        """The exit code of what was ended by a signal, as shells have it."""
        return None if self._number is None else 128 + self._number

    def begin(self, number: int, _frame: FrameType | None) -> None:
        """Handle a signal."""
        if self._number is None:
            self._number = number
            self._ender.start()
            _interrupt()

    def end(self) -> None:
        """Leave nothing behind if it was interrupted."""
        self._has_ended.set()
        if self._number is not None:
            self._ender.join()
            self._processes.end()

    def _end(self) -> None:
        if self._has_ended.wait(GRACE):
            return
        timeouts = {0: TIMEOUTS}
        escalation = Escalation(self._processes, timeouts, time.monotonic())
        while not self._has_ended.is_set():
            escalation.advance(time.monotonic())
            self._has_ended.wait(INTERVAL)


@contextmanager
def interruption() -> Iterator[Interruption]:
    """
    End what is built when a signal asks for it, within some seconds.

    The first signal raises :class:`KeyboardInterrupt` inside.

    :raises SystemExit: with the exit code, if nothing took that
    """
    adoption = Adoption()
    state = Interruption(adoption)
    previous = {number: signal.getsignal(number) for number in SIGNALS}
    # what nohup or a background job has made ignored stays so
    taken = [n for n in SIGNALS if previous[n] is not signal.SIG_IGN]
    try:
        for number in taken:
            signal.signal(number, state.begin)
        yield state
    except KeyboardInterrupt:
        raise SystemExit(state.returncode or INTERRUPTED) from None
    finally:
        state.end()
        adoption.end()
        for number in taken:
            signal.signal(number, previous[number])


def _interrupt() -> None:
    """Raise KeyboardInterrupt, in a running event loop between two steps."""
    # within a step it would leave pipes and processes behind half made
    asyncio = sys.modules.get('asyncio')
    try:
        if asyncio is None:
            raise KeyboardInterrupt
        asyncio.get_running_loop().call_soon_threadsafe(_raise)
    except RuntimeError:
        # there is none, or it is closed
        raise KeyboardInterrupt from None


def _raise() -> None:
    raise KeyboardInterrupt
