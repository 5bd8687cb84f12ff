# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""When a process that serves the launcher is started again."""

from collections.abc import Callable

from colcon_yamllaunch.engine import limits


class Restarts:
    """
    The starts of a process that is to run as long as the launch does.

    It is started again after pauses, each twice as long as the one before, up
    to some times in a row; one that has run for a while begins a new row.

    :param clock: Returns seconds that never go back
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._begun = 0.0
        self._due: float | None = None
        #: How often it has ended in a row.
        self.ends = 0

    @property
    def is_due(self) -> bool:
        """Whether it is to be started now."""
        return self._due is not None and self._due <= self._clock()

    def begin(self) -> None:
        """Take note that it is being started."""
        self._due = None
        self._begun = self._clock()

    def plan(self) -> bool:
        """Have it started again; return False if it has ended too often."""
        if self._clock() - self._begun > limits.CLIENT_STEADY:
            self.ends = 0
        self.ends += 1
        if self.ends > limits.CLIENT_RESTARTS:
            return False
        pause = limits.SHORTEST_PAUSE * 2.0 ** (self.ends - 1)
        self._due = self._clock() + pause
        return True

    def plan_at_once(self) -> None:
        """Have it started without a pause, as another one."""
        self._due = self._clock()

    def cancel(self) -> None:
        """Have it not started any more."""
        self._due = None

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until it is due, None if it is not to be."""
        if self._due is None:
            return None
        return max(0.0, self._due - self._clock())
