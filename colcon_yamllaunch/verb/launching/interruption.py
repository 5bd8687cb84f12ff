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
import signal
import sys
import threading
import time
from types import FrameType

from colcon_yamllaunch.verb.cli.messages import INTERRUPTED
from colcon_yamllaunch.workspace.building.orphan_builds import (
    end_own_processes,
)
from colcon_yamllaunch.workspace.building.orphan_builds import own_processes
from colcon_yamllaunch.workspace.building.orphan_builds import send

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
            _interrupt()

    def end(self) -> None:
        """Leave nothing behind if it was interrupted."""
        self._has_ended.set()
        if self._number is not None:
            self._ender.join()
            end_own_processes()

    def _end(self) -> None:
        begin = time.monotonic()
        done: set[tuple[int, int]] = set()
        while not self._has_ended.wait(INTERVAL):
            number = _due(time.monotonic() - begin)
            if number is None:
                continue
            for pid in own_processes():
                if (pid, number) not in done:
                    done.add((pid, number))
                    send(pid, number)


@contextmanager
def interruption() -> Iterator[Interruption]:
    """
    End what is built when a signal asks for it, within some seconds.

    The first signal raises :class:`KeyboardInterrupt` inside.

    :raises SystemExit: with the exit code, if nothing took that
    """
    state = Interruption()
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


def _due(age: float) -> int | None:
    return next((number for start, number in STEPS if age >= start), None)
