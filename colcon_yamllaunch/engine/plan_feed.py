# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a source of more plan is told in a running launch, and its answers."""

from collections.abc import Callable
from collections.abc import Iterable
from itertools import chain
import os

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.plan_source import PlanSource
from colcon_yamllaunch.plan.plan import Block
from colcon_yamllaunch.plan.plan import Entry
from colcon_yamllaunch.plan.plan import Growth
from colcon_yamllaunch.plan.plan import Shutdown

#: Why a launch ends in which nothing is left to do, as ROS 2 calls it.
IDLE = 'idle'
_FAILED = 'a launch file in Python failed'


class PlanFeed:
    """
    Has a plan grow as a source says.

    :param extend: Takes more into the plan
    :param tell: Is told what happens
    """

    def __init__(
        self,
        source: PlanSource,
        loop: Loop,
        extend: Callable[[Iterable[Entry]], None],
        tell: events.Listener,
    ) -> None:
        self._source = source
        self._loop = loop
        self._extend = extend
        self._tell = tell
        #: The launch files, groups and timers of the plan, once it has grown.
        self.blocks: tuple[Block, ...] = ()
        # one of our own: the source closes its when it likes
        self._watched = -1
        # whether the source knows that the launch ends
        self._knows_end = False
        self._patient_until: float | None = None
        self._retry: TimerHandle | None = None
        # bytes of output since it last had nothing to do, and whose
        self._output = 0
        self._labels: set[str] = set()
        # whether nothing is asked of the source any more
        self._is_over = False

    @property
    def pid(self) -> int:
        """The process of the source, or 0 while there is none."""
        return self._source.pid

    @property
    def number(self) -> int:
        """Its number in the launch; see `PlanSource`."""
        return self._source.number

    def begin(self) -> None:
        """Listen to the source from now on."""
        if self._source.descriptor != -1:
            self._watched = os.dup(self._source.descriptor)
            self._loop.add_reader(self._watched, self._take)

    def handle(self, event: events.Event) -> None:
        """Pass an event on."""
        if self._is_over:
            return
        if isinstance(event, events.Output):
            name = event.process.ros_name
            if name in self._source.wants_output:
                self._output += len(event.data)
                self._labels.add(event.process.label)
                self._source.output(name, event.stream, event.data)
            return
        if isinstance(event, events.ShuttingDown):
            self._knows_end = True
        self._source.handle(event)

    def accepts(self, label: str) -> bool:
        """
        Tell whether a process may write more.

        Who writes faster than a handler of its output works is held up by
        its own pipe, as by a slow screen.
        """
        if not self._source.is_busy:
            self._output = 0
        return (
            self._is_over
            or self._output < limits.STREAM_BACKLOG
            or label not in self._labels
        )

    def flush(self) -> None:
        """Send what is not sent yet; soon again if the source is slow."""
        if self._is_over or self._source.flush():
            return
        if self._retry is None or self._retry.cancelled():
            pause = limits.SOURCE_PAUSE
            self._retry = self._loop.call_later(pause, self._loop.wake)

    def call(self, number: int) -> None:
        """Ask for what a `HostCall` stands for."""
        if not self._is_over:
            self._source.call(number)

    def is_waiting(self) -> bool:
        """
        Tell whether something may still come, though nothing runs.

        If not, the source is told that the launch ends. What it has to say
        to that is waited for, but not for long.
        """
        if self._is_over:
            return False
        if self._source.is_busy:
            if self._knows_end and self._patient_until is None:
                self._patient_until = (
                    self._loop.time() + limits.SOURCE_PATIENCE
                )
                self._loop.call_at(self._patient_until, self._loop.wake)
            return not self._is_overdue()
        if not self._knows_end:
            self._knows_end = True
            self._source.handle(events.ShuttingDown(IDLE))
        return False

    def hurry(self) -> None:
        """Wait for nothing any more."""
        self._knows_end = True
        self._patient_until = self._loop.time()

    def ended(self, status: int) -> None:
        """
        Take into account that the process of the source ended.

        :param status: What `os.waitpid` says of it
        """
        growths = list(self._source.ended(status))
        self._is_over = True
        self._unwatch()
        self._grow(growths)
        self._tell(events.HostLost(str(Outcome.from_status(status))))

    def close(self) -> None:
        """End the source."""
        self._is_over = True
        self._unwatch()
        self._source.close()

    def _is_overdue(self) -> bool:
        until = self._patient_until
        return until is not None and self._loop.time() >= until

    def _take(self) -> None:
        self._grow(self._source.take())
        if self._source.descriptor == -1:
            # its end is told with that of its process
            self._unwatch()

    def _grow(self, growths: Iterable[Growth]) -> None:
        for growth in growths:
            problems = [p.split('\n') for p in growth.problems]
            if problems:
                self._tell(events.PlanFailed(tuple(chain(*problems))))
            self.blocks = growth.blocks or self.blocks
            # unless what came with it gives a better reason
            end = (Shutdown(_FAILED),) if problems else ()
            if growth.entries or end:
                self._extend((*growth.entries, *end))

    def _unwatch(self) -> None:
        if self._watched != -1:
            self._loop.remove_reader(self._watched)
            os.close(self._watched)
            self._watched = -1
