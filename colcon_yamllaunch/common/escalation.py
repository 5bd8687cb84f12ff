# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The steps by which processes are stopped: SIGINT, SIGTERM, SIGKILL.

These steps stop a whole launch, one process that is stopped or restarted, the
processes of a launch that was killed, and a build. Each has its own way to
find the processes, see :class:`Targets`.

This module is part of the guard and imports little.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
import math
import os
import signal
import time

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.process_scan import is_alive

#: The signals in the order in which they are sent.
STEPS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
#: Seconds that a killed process gets to vanish, as it may hang in the kernel.
KILL_TIMEOUT = 5.0
#: Seconds between two looks at processes whose end nobody reports.
CHECK_INTERVAL = 0.05

#: The number of processes of the launch whose origin or time-outs are unknown.
WHOLE = -1

_GIVEN_UP = len(STEPS)


@dataclass(frozen=True, slots=True)
class Timeouts:
    """
    How long a process may take to stop.

    :param sigterm: Seconds from SIGINT to SIGTERM
    :param sigkill: Seconds from SIGTERM to SIGKILL
    """

    sigterm: float
    sigkill: float


@dataclass(frozen=True, slots=True)
class Orphan:
    """
    A process whose group has no leader that runs, or is not ours.

    No signal to a group of the launch is sure to reach it.

    :param birth: When it started; with the process id it names one process
      for good
    :param number: The number of what it comes from
    """

    pid: int
    birth: int
    group: int
    number: int


#: Whom a signal is sent to: a process group, or one process.
Target = int | Orphan


class Targets(ABC):
    """The processes to be stopped, and how they are found and signalled."""

    def groups(self) -> Mapping[int, int]:
        """Return the process groups that run now, with their numbers."""
        return {}

    @abstractmethod
    def search(self, groups: Collection[int]) -> list[Orphan]:
        """Find running processes outside the groups; this is slow."""

    def recheck(self, orphans: list[Orphan]) -> list[Orphan]:
        """Return the orphans that still run."""
        return [o for o in orphans if is_alive(o.pid, o.birth)]

    def send(self, target: Target, step: signal.Signals) -> None:
        """Send a signal."""
        send(target, step)

    def kill(self, number: int) -> None:  # noqa: B027
        """Kill all processes with a number, even unseen ones, if possible."""


class Escalation:
    """
    Which process gets which signal, and when.

    :param targets: The processes; each belongs to what has a number, such as
      a process of the plan, and takes the steps with that
    :param timeouts: For each number its time-outs; others have the longest
    :param now: When stopping begins, in seconds of any clock
    :param first: The first step
    """

    def __init__(
        self,
        targets: Targets,
        timeouts: Mapping[int, Timeouts],
        now: float,
        first: signal.Signals = signal.SIGINT,
    ) -> None:
        self._targets = targets
        self._timeouts = dict(timeouts)
        self._timeouts.setdefault(
            WHOLE,
            Timeouts(
                max((t.sigterm for t in timeouts.values()), default=0.0),
                max((t.sigkill for t in timeouts.values()), default=0.0),
            ),
        )
        self._steps: dict[int, int] = {}
        self._deadlines: dict[int, float] = {}
        for number in self._timeouts:
            self._enter(number, STEPS.index(first), now)
        self._sent: dict[Target, int] = {}
        self._checked = -math.inf
        self._groups: Mapping[int, int] = {}
        #: The processes outside the groups that ran at the last check.
        self.orphans: list[Orphan] = []
        #: Whether nothing runs any more, or only what cannot be ended.
        self.is_over = False

    def advance(self, now: float) -> None:
        """Find out what still runs, and send the signals that are due."""
        is_first = self._checked == -math.inf
        # the first signal is sent even if there is no time until the second
        due = [n for n, t in self._deadlines.items() if t <= now]
        for number in () if is_first else due:
            self._enter(number, self._steps[number] + 1, now)
        self._groups = self._targets.groups()
        if is_first:
            # before any signal: what loses its parent by one may have nothing
            # else that tells whose it is
            self._search()
        # else groups at once, as looking for others takes some milliseconds
        for group, number in self._groups.items():
            self._send(group, number, self._sent.get(group, -1))
        if not is_first:
            self.orphans = self._targets.recheck(self.orphans)
            if due or not (self._groups or self.orphans):
                self._search()
        for orphan in self.orphans:
            # what its group was sent reached it, too
            sent = max(
                self._sent.get(orphan, -1), self._sent.get(orphan.group, -1)
            )
            self._send(orphan, orphan.number, sent)
        self._checked = now
        self.is_over = all(
            self._steps[self._known(n)] == _GIVEN_UP for n in self.alive()
        )

    def escalate(self, now: float) -> None:
        """Send the next signal at once to all that still runs."""
        for number in map(self._known, self.alive()):
            if self._steps[number] < len(STEPS) - 1:
                self._deadlines[number] = now
        self.advance(now)

    def due(self) -> float:
        """Return the moment to call :meth:`advance` next, or infinity."""
        deadlines = [self._deadlines[self._known(n)] for n in self.alive()]
        check = self._checked + CHECK_INTERVAL if self.orphans else math.inf
        return min((*deadlines, check))

    def alive(self) -> set[int]:
        """Return the numbers of all that still ran at the last look."""
        return {
            *self._groups.values(),
            *(orphan.number for orphan in self.orphans),
        }

    def next_signal(self) -> tuple[signal.Signals, float] | None:
        """Return the signal that is sent next, and when, if one is."""
        coming = [
            (self._deadlines[number], self._steps[number] + 1)
            for number in map(self._known, self.alive())
            if self._steps[number] + 1 < len(STEPS)
        ]
        if not coming:
            return None
        due, step = min(coming)
        return STEPS[step], due

    def latest_signal(self) -> signal.Signals:
        """Return the furthest step that anything which still runs came to."""
        return STEPS[max((self._step(n) for n in self.alive()), default=0)]

    def run(
        self,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Send all signals, and wait until nothing is left to do."""
        while True:
            self.advance(clock())
            if self.is_over:
                return
            sleep(max(0.0, min(self.due() - clock(), CHECK_INTERVAL)))

    def _search(self) -> None:
        """Search for more targets, and keep those found before."""
        known = {(o.pid, o.birth) for o in self.orphans}
        found = self._targets.search(self._groups)
        self.orphans += [o for o in found if (o.pid, o.birth) not in known]

    def _known(self, number: int) -> int:
        return number if number in self._steps else WHOLE

    def _step(self, number: int) -> int:
        return min(self._steps[self._known(number)], len(STEPS) - 1)

    def _enter(self, number: int, step: int, now: float) -> None:
        timeouts = self._timeouts[number]
        waits = (timeouts.sigterm, timeouts.sigkill, KILL_TIMEOUT, math.inf)
        self._steps[number] = step
        self._deadlines[number] = now + waits[step]

    def _send(self, target: Target, number: int, sent: int) -> None:
        step = self._step(number)
        if sent < step:
            self._sent[target] = step
            self._targets.send(target, STEPS[step])
            if STEPS[step] == signal.SIGKILL:
                # what was started since, or may be sent nothing
                self._targets.kill(number)


def send(target: Target, step: signal.Signals) -> bool:
    """
    Send a signal, and return whether there was somebody to get it.

    :param target: A process group, or one process
    """
    kill = os.kill if isinstance(target, Orphan) else os.killpg
    number = target.pid if isinstance(target, Orphan) else target
    try:
        kill(number, step)
        # a stopped process takes a signal only when it is continued
        if step != signal.SIGKILL:
            kill(number, signal.SIGCONT)
    except (ProcessLookupError, PermissionError):
        return False
    return True
