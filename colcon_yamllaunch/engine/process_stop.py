# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Decides which signals processes get when they are stopped, and when.

Each process is stopped with all that it started.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import field, replace
import math
import signal
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.escalation import (
    Escalation,
    Orphan,
    Target,
    Targets,
    Timeouts,
    WHOLE,
)
from colcon_yamllaunch.common.frozen import mutable
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.loop import Loop, TimerHandle
from colcon_yamllaunch.plan.plan import Process, SignalProcess

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.engine import Engine

#: The label of what belongs to a launch, but to no process of it for sure.
UNATTRIBUTED = 'unknown process'


@mutable
class ProcessTask:
    """
    What the supervisor needs of a process besides its `ProcessState`.

    :param number: Its number in the plan
    :param respawns: How often it has been respawned since it was last
      started on request
    :param quick_ends: How often in a row it ended at once
    :param restarts: When its settings had it started again, by the clock
    :param doublings: How often the delay of such restarts was doubled
    :param started: When it was started last, by the clock of the loop
    :param group: Its process group, as long as its leader runs
    :param successor: The process that replaces it at its next start, if any
    :param once: The process that replaces it at its next start only, such as
      itself under a debugger
    :param early_signals: The signals of the plan that it gets once it runs
    :param is_restarting: Whether it starts again once it is stopped
    :param is_dropped: Whether it leaves the plan once it is stopped
    :param is_pause_reported: Whether the user knows that its respawns pause
    """

    number: int
    process: Process
    respawns: int = 0
    quick_ends: int = 0
    restarts: list[float] = field(default_factory=list)
    doublings: int = 0
    started: float = 0.0
    group: int | None = None
    successor: Process | None = None
    once: Process | None = None
    early_signals: list[SignalProcess] = field(default_factory=list)
    is_restarting: bool = False
    is_dropped: bool = False
    is_pause_reported: bool = False


class ProcessStop(Targets):
    """
    The end of some processes, with all that they started.

    :param engine: Finds processes, sends signals and emits events
    :param groups: The process groups of the launch, with their numbers
    :param tasks: The processes, all of the launch or some
    :param whole: Whether this is the end of the launch, and so of what is
      known to belong to it, but not to which process
    :param first: The signal to begin with
    """

    def __init__(
        self,
        engine: 'Engine',
        loop: Loop,
        groups: Mapping[int, int],
        tasks: Sequence[ProcessTask],
        *,
        whole: bool = False,
        first: signal.Signals = signal.SIGINT,
    ) -> None:
        self._tasks = {task.number: task for task in tasks}
        if whole and tasks:
            # lines and records of orphans of no known process need one
            unknown = replace(tasks[0].process, label=UNATTRIBUTED)
            self._tasks[WHOLE] = ProcessTask(WHOLE, unknown)
        self._engine = engine
        self._loop = loop
        self._groups = groups
        self._next: TimerHandle | None = None
        timeouts = {t.number: timeouts_of(t.process) for t in tasks}
        #: Their steps so far, and the next ones.
        self.escalation = Escalation(self, timeouts, loop.time(), first)
        self.advance()

    def advance(self) -> None:
        """Check what still runs, and send it the signals that are due."""
        self.escalation.advance(self._loop.time())
        self._note_next()

    def escalate(self) -> None:
        """Send the next signal at once."""
        self.escalation.escalate(self._loop.time())
        self._note_next()

    def cancel(self) -> None:
        """Send no further signals."""
        if self._next is not None:
            self._next.cancel()

    def alive(self) -> list[ProcessTask]:
        """Return what still runs, in the order of the plan."""
        return [self._tasks[n] for n in sorted(self.escalation.alive())]

    def abandon(self) -> None:
        """Report what still runs, as it cannot be ended."""
        left = dict(self.groups())
        left |= {o.pid: o.number for o in self.escalation.orphans}
        for pid, number in left.items():
            process = self._tasks[number].process
            self._engine.emit(events.LeftBehind(process, pid))

    def groups(self) -> dict[int, int]:
        """Return the groups whose leader runs; see `Targets`."""
        tasks = self._tasks.values()
        return {t.group: t.number for t in tasks if t.group is not None}

    def search(self, groups: Collection[int]) -> list[Orphan]:
        """Find what runs besides the groups; see `Targets`."""
        found = self._engine.orphans(self._groups, groups)
        return [o for o in found if o.number in self._tasks]

    def recheck(self, orphans: list[Orphan]) -> list[Orphan]:
        """Return those that still run; see `Targets`."""
        return [o for o in orphans if self._engine.is_alive(o)]

    def send(self, target: Target, step: signal.Signals) -> None:
        """Send a signal, and report it if it arrived; see `Targets`."""
        if self._engine.send(target, step):
            if isinstance(target, Orphan):
                pid, number, is_group = target.pid, target.number, False
            else:
                pid, number, is_group = target, self._groups[target], True
            process = self._tasks[number].process
            self._engine.emit(events.Signalled(process, pid, step, is_group))

    def kill(self, number: int) -> None:
        """Kill all of a process of the plan; see `Targets`."""
        self._engine.kill(number)

    def _note_next(self) -> None:
        self.cancel()
        due = self.escalation.due()
        if due != math.inf:
            self._next = self._loop.call_at(due, self.advance)


def timeouts_of(process: Process) -> Timeouts:
    """Return how long a process may take to stop."""
    return Timeouts(process.sigterm_timeout, process.sigkill_timeout)
