# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The processes of a build: how signals end them, and what is left of them.

After Ctrl-C colcon waits for the jobs that run, as the terminal sends the
signal to these, too. One that does not heed it, or that begins just then,
would hold the user up for as long as it likes; and the other signals come to
colcon alone.

When a launch is killed while it builds, its make and its compilers go on, and
would write into the folders of the next build. They are found by a variable
that they inherit.
"""

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
import os
from pathlib import Path
import signal
import sys
import threading
import time
from types import FrameType

from colcon_yamllaunch.common.adoption import Adoption
from colcon_yamllaunch.common.escalation import (
    Escalation,
    Orphan,
    Targets,
    Timeouts,
)
from colcon_yamllaunch.common.process_scan import (
    running_processes,
    RunningProcess,
    variable_of,
)

#: The variable that the processes of a build have; its value is the process
#: id of the launch, a colon, and the build folder.
BUILD_ID_VARIABLE = 'COLCON_LAUNCH_BUILD'
#: How long they have after SIGTERM, with which their end begins (seconds).
TERMINATE_TIMEOUT = 2.0


#: The exit code of a build that the user stopped (128 + SIGINT).
INTERRUPTED = 130
#: What asks a build to end.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: Seconds after the first signal until all that the build has started gets
#: one; those that have it from the terminal end by it.
GRACE = 0.3
#: How long it has then.
TIMEOUTS = Timeouts(sigterm=1.7, sigkill=4.0)
#: Seconds between two looks at what the build has started.
INTERVAL = 0.1


class BuildProcesses(Targets):
    """
    The running processes of builds.

    They have the variable, or their parent is one of them. Who has neither
    any more is a child of this process, where that adopts orphans.

    :param build_base: The build folder whose builds are meant; without it,
      those that this process has started
    :param adoption: What knows the children of this process
    :param builder: The process whose builds are meant, if it is another
    """

    def __init__(
        self,
        build_base: Path | None = None,
        adoption: Adoption | None = None,
        builder: int | None = None,
    ) -> None:
        self._adoption = adoption
        self._start, self._end = f'{builder or os.getpid()}:', ''
        if build_base is not None:
            self._start, self._end = '', f':{build_base}'

    def search(self, groups: Collection[int] = ()) -> list[Orphan]:  # noqa: ARG002
        """Find all of them."""
        found = []
        others: dict[int, list[RunningProcess]] = {}
        children: Collection[int] = ()
        if self._adoption is not None and self._adoption.is_exact:
            children, _ = self._adoption.check_children(())
        for process in running_processes():
            value = variable_of(process.pid, BUILD_ID_VARIABLE) or ''
            if process.pid in children or (
                value.startswith(self._start) and value.endswith(self._end)
            ):
                found.append(process)
            else:
                others.setdefault(process.parent, []).append(process)
        # the list grows by the children of those that it has
        for parent in found:
            found.extend(others.pop(parent.pid, ()))
        return [Orphan(p.pid, p.birth, p.group, 0) for p in found]

    def recheck(self, orphans: list[Orphan]) -> list[Orphan]:
        """Find all of them, as a build goes on to start some."""
        if not orphans:
            return []
        found = dict.fromkeys([*super().recheck(orphans), *self.search()])
        return list(found)

    def end(self) -> None:
        """End all of them, and wait for that."""
        timeouts = {0: Timeouts(0.0, TERMINATE_TIMEOUT)}
        now = time.monotonic()
        Escalation(self, timeouts, now, first=signal.SIGTERM).run()


def mark(build_base: Path) -> dict[str, str]:
    """Return the variable for what this process builds."""
    return {BUILD_ID_VARIABLE: f'{os.getpid()}:{build_base}'}


def end_orphans(build_base: Path, announce: Callable[[str], None]) -> None:
    """
    End the processes of earlier builds in a workspace, and wait for that.

    To be called while no other launch builds there.

    :param announce: Is called with one line if there are some
    """
    processes = BuildProcesses(build_base)
    if found := processes.search():
        pids = sorted(process.pid for process in found)
        announce(
            'ending what is left of a build that was killed: process '
            + ', '.join(map(str, pids))
        )
        processes.end()


class Interruption:
    """
    Handles signals during a build.

    :param adoption: Knows the processes that the build has started
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
        """End all processes of the build if it was interrupted."""
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
    End a build within some seconds after a signal.

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
