# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is to be done later."""

from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import field
import heapq
from itertools import count


@dataclass(slots=True, order=True)
class TimerHandle:
    """
    Something to be done at its time.

    :param due: When, in seconds of the clock of whoever keeps the schedule
    :param order: Those that are due at the same time keep their order
    :param action: What to do, or None once it is done or cancelled
    """

    due: float
    order: int
    action: Callable[[], None] | None = field(compare=False)

    def cancel(self) -> None:
        """Have it not done."""
        self.action = None


class Schedule:
    """What is to be done, in the order of the times."""

    def __init__(self) -> None:
        self._heap: list[TimerHandle] = []
        self._count = count()

    def add(self, due: float, action: Callable[[], None]) -> TimerHandle:
        """Have something done at a time."""
        handle = TimerHandle(due, next(self._count), action)
        heapq.heappush(self._heap, handle)
        return handle

    def run_due(self, now: float) -> None:
        """Do what is due."""
        while self._heap and self._heap[0].due <= now:
            handle = heapq.heappop(self._heap)
            action = handle.action
            if action is not None:
                handle.cancel()
                action()

    def next_due(self) -> float | None:
        """Return when the next thing is due, or None."""
        while self._heap and self._heap[0].action is None:
            heapq.heappop(self._heap)
        return self._heap[0].due if self._heap else None
