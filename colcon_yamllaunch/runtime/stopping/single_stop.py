# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Stopping one process of a launch that goes on."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
import math
from typing import Protocol

from colcon_yamllaunch.common.process_scan import Member
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.runtime.core import limits
from colcon_yamllaunch.runtime.core.events import Event
from colcon_yamllaunch.runtime.core.events import LeftBehind
from colcon_yamllaunch.runtime.core.events import Signalled
from colcon_yamllaunch.runtime.core.schedule import Appointment
from colcon_yamllaunch.runtime.core.schedule import Schedule
from colcon_yamllaunch.runtime.core.tasks import Task
from colcon_yamllaunch.runtime.stopping.escalation import Order
from colcon_yamllaunch.runtime.stopping.escalation import Stopping
from colcon_yamllaunch.runtime.stopping.escalation import Timeouts


class StopHost(Protocol):
    """What stopping needs of the system; see `supervisor.Host`."""

    def send(self, order: Order) -> bool:
        """Send a signal, and return whether anybody got it."""

    def members(self, groups: Mapping[int, int]) -> list[Member]:
        """Find the running processes of the launch."""

    def is_alive(self, member: Member) -> bool:
        """Tell whether a process still runs."""

    def tell(self, event: Event) -> None:
        """Take note of what happened."""


def carry_out(
    host: StopHost,
    orders: Iterable[Order],
    process_of: Callable[[int], Process],
) -> None:
    """
    Send signals, and tell of those that somebody got.

    :param process_of: Returns the process of a number in the plan
    """
    for order in orders:
        if host.send(order):
            target = order.target
            whole = isinstance(target, int)
            pid = target if isinstance(target, int) else target.pid
            process = process_of(order.number)
            host.tell(Signalled(process, pid, order.signal, group=whole))


class SingleStop:
    """
    The steps by which one process is stopped, with all that it started.

    They are those of a whole launch, with the process's own time-outs.

    :param task: The process
    :param host: Sends signals
    :param schedule: Where the next step is noted
    :param clock: Returns the time in seconds
    :param groups: The process groups of the launch, with their numbers
    :param finished: Is called when nothing of the process runs any more
    """

    def __init__(
        self,
        task: Task,
        host: StopHost,
        schedule: Schedule,
        clock: Callable[[], float],
        groups: Mapping[int, int],
        finished: Callable[[], None],
    ) -> None:
        self._task = task
        self._host = host
        self._schedule = schedule
        self._clock = clock
        self._groups = groups
        self._finished = finished
        process = task.process
        timeouts = Timeouts(process.sigterm_timeout, process.sigkill_timeout)
        self._stopping = Stopping({task.number: timeouts}, clock())
        self._strays: list[Member] = []
        self._killed = math.inf
        self._next: Appointment | None = None

    def begin(self) -> None:
        """Take the first step."""
        # the group at once, as looking for others takes some milliseconds
        self._send()
        self.look()

    def hurry(self) -> None:
        """Take the next step at once."""
        self._stopping.hurry((self._task.number,), self._clock())
        self.look()

    def cancel(self) -> None:
        """Leave the rest to somebody else."""
        if self._next is not None:
            self._next.cancel()

    def look(self) -> None:
        """Find what still runs, and send it what is due."""
        now = self._clock()
        self._stopping.advance(now)
        self._strays = [
            m
            for m in self._host.members(self._groups)
            if m.number == self._task.number and m.group != self._task.group
        ]
        self._send()
        if self._killed == math.inf and self._is_final():
            self._killed = now
        if self._task.group is None and not self._strays:
            self._end()
        else:
            self._wait()

    def _send(self) -> None:
        number = self._task.number
        group = self._task.group
        running = {} if group is None else {group: number}
        orders = self._stopping.orders(running, self._strays)
        carry_out(self._host, orders, lambda _: self._task.process)

    def _wait(self) -> None:
        self.cancel()
        due = self._stopping.next_deadline((self._task.number,))
        action = self.look
        if self._task.group is None:
            check = self._clock() + limits.STRAY_CHECK_INTERVAL
            if check < due:
                due, action = check, self._check
        if due != math.inf:
            self._next = self._schedule.add(due, action)

    def _check(self) -> None:
        alive = [m for m in self._strays if self._host.is_alive(m)]
        if not alive:
            self.look()
        elif self._clock() >= self._killed + limits.KILL_PATIENCE:
            label = self._task.process.label
            for member in alive:
                self._host.tell(LeftBehind(label, member.pid))
            self._end()
        else:
            self._strays = alive
            self._wait()

    def _is_final(self) -> bool:
        return self._stopping.is_final((self._task.number,))

    def _end(self) -> None:
        self.cancel()
        self._finished()


class SingleStops:
    """
    All processes that are being stopped while the launch goes on.

    :param host: Sends signals
    :param schedule: Where the next steps are noted
    :param clock: Returns the time in seconds
    :param groups: The process groups of the launch, with their numbers
    :param start: Starts a process anew that was stopped for it
    """

    def __init__(
        self,
        host: StopHost,
        schedule: Schedule,
        clock: Callable[[], float],
        groups: Mapping[int, int],
        start: Callable[[Task], None],
    ) -> None:
        self._host = host
        self._schedule = schedule
        self._clock = clock
        self._groups = groups
        self._start = start
        self._stops: dict[int, SingleStop] = {}
        self._restarting: set[int] = set()

    def __contains__(self, task: Task) -> bool:
        return task.number in self._stops

    def __bool__(self) -> bool:
        return bool(self._stops)

    def stop(self, task: Task) -> None:
        """Stop a process for good; once more takes the next step."""
        self._restarting.discard(task.number)
        if task in self:
            self._stops[task.number].hurry()
        else:
            self._begin(task)

    def restart(self, task: Task) -> None:
        """Stop a process, then start it anew."""
        self._restarting.add(task.number)
        if task not in self:
            self._begin(task)

    def ended(self, task: Task) -> None:
        """Take into account that a process ended."""
        if task in self:
            self._stops[task.number].look()

    def cancel(self) -> None:
        """Leave all of them to somebody else."""
        for stop in self._stops.values():
            stop.cancel()
        self._stops.clear()
        self._restarting.clear()

    def _begin(self, task: Task) -> None:
        self._stops[task.number] = stop = SingleStop(
            task,
            self._host,
            self._schedule,
            self._clock,
            self._groups,
            lambda: self._finished(task),
        )
        stop.begin()

    def _finished(self, task: Task) -> None:
        del self._stops[task.number]
        if task.number in self._restarting:
            self._restarting.remove(task.number)
            task.respawns = 0
            task.restarts += 1
            self._start(task)
