# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""When a process that serves the launcher is started again."""

from collections.abc import Callable

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.loop import TimerHandle


class Restarts:
    """
    The starts of a process that is to run as long as the launch does.

    It is started again after pauses, each twice as long as the one before, up
    to some times in a row; one that has run for a while begins a new row.

    :param start: Starts it
    """

    def __init__(self, loop: Loop, start: Callable[[], None]) -> None:
        self._loop = loop
        self._start = start
        self._begun = 0.0
        self._next: TimerHandle | None = None
        #: How often it has ended in a row.
        self.ends = 0

    def begin(self) -> None:
        """Take note that it is being started."""
        self.cancel()
        self._begun = self._loop.time()

    def plan(self) -> bool:
        """Have it started again; return False if it has ended too often."""
        if self._loop.time() - self._begun > limits.CLIENT_STEADY:
            self.ends = 0
        self.ends += 1
        if self.ends > limits.CLIENT_RESTARTS:
            return False
        pause = limits.SHORTEST_PAUSE * 2.0 ** (self.ends - 1)
        self.cancel()
        self._next = self._loop.call_later(pause, self._start)
        return True

    def plan_at_once(self) -> None:
        """Have it started without a pause, as another one."""
        self._next = self._loop.call_soon(self._start)

    def cancel(self) -> None:
        """Have it not started any more."""
        if self._next is not None:
            self._next.cancel()
            self._next = None
