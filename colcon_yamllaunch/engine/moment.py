# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The time of the current event: now, unless it arrives late."""

from collections.abc import Callable
import time


class Moment:
    """
    The time of the current event.

    An event that another machine kept while the connection was lost arrives
    late, and has the time at which it happened.

    :param now: Returns the time of day, in seconds
    """

    def __init__(self, now: Callable[[], float] = time.time) -> None:
        self._now = now
        #: When it was; None for now.
        self.past: float | None = None

    def __call__(self) -> float:
        """Return the time in seconds since 1970."""
        return self._now() if self.past is None else self.past
