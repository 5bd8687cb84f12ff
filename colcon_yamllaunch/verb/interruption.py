# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Ending a build by Ctrl-C, SIGTERM or SIGHUP.

After Ctrl-C colcon waits for the jobs that run, as the terminal sends the
signal to these, too. One that does not heed it, or that begins just then,
would hold the user up for as long as it likes; and the other signals come to
colcon alone.
"""

from collections.abc import Iterator
from contextlib import contextmanager
import os
import signal
import threading
import time
from types import FrameType

#: What asks a build to end.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
#: Seconds after the first signal, and what everything that the build has
#: started gets from then on, each process once.
STEPS = (
    (6.0, signal.SIGKILL),
    (2.0, signal.SIGTERM),
    # those that have the signal from the terminal end by it
    (0.3, signal.SIGINT),
)
#: Seconds between two looks at what the build has started.
INTERVAL = 0.1


class Interruption:
    """What came of the signals during a build."""

    def __init__(self) -> None:
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
            raise KeyboardInterrupt

    def end(self) -> None:
        """Leave the processes alone from now on."""
        self._has_ended.set()
        if self._number is not None:
            self._ender.join()

    def _end(self) -> None:
        # imported by those who need it
        from colcon_yamllaunch.runtime.members import find_descendants

        begin = time.monotonic()
        done: set[tuple[int, int]] = set()
        while not self._has_ended.wait(INTERVAL):
            number = _due(time.monotonic() - begin)
            if number is None:
                continue
            for pid in find_descendants(os.getpid()):
                if (pid, number) not in done:
                    done.add((pid, number))
                    _send(pid, number)


@contextmanager
def interruption() -> Iterator[Interruption]:
    """
    End what is built when a signal asks for it, within some seconds.

    The first signal raises :class:`KeyboardInterrupt`.
    """
    state = Interruption()
    previous = {number: signal.getsignal(number) for number in SIGNALS}
    # what nohup or a background job has made ignored stays so
    taken = [n for n in SIGNALS if previous[n] is not signal.SIG_IGN]
    try:
        for number in taken:
            signal.signal(number, state.begin)
        yield state
    finally:
        state.end()
        for number in taken:
            signal.signal(number, previous[number])


def _due(age: float) -> int | None:
    return next((number for start, number in STEPS if age >= start), None)


def _send(pid: int, number: int) -> None:
    try:
        os.kill(pid, number)
    except (ProcessLookupError, PermissionError):
        # it has ended, or is not ours to end
        return
