# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How far the clock of another machine is ahead of ours."""

from collections import deque
from collections.abc import Callable
import math
import time

#: Heartbeats that are looked back at; the fastest of them tells most.
_LOOKED_AT = 30
#: The seconds of a time that still has a date (year 9999).
_LAST = 253_402_300_799.0


class ClockDifference:
    """
    Estimated from heartbeats, as the Network Time Protocol does (RFC 5905, 8).

    :param ahead: Seconds, as far as is known before
    """

    def __init__(
        self, ahead: float = 0.0, now: Callable[[], float] = time.time
    ) -> None:
        self._now = now
        # the seconds that each took, and the difference that follows
        self._seen: deque[tuple[float, float]] = deque(maxlen=_LOOKED_AT)
        #: How many seconds it is ahead of ours.
        self.ahead = ahead

    def note(self, sent: float, theirs: float) -> None:
        """
        Take the answer to a heartbeat.

        :param sent: When that was sent, by our clock
        :param theirs: When it was answered, by the other clock
        """
        now = self._now()
        took = now - sent
        if not math.isfinite(took) or not math.isfinite(theirs):
            return
        if took < 0:
            # one of the clocks was set meanwhile
            self._seen.clear()
            return
        self._seen.append((took, theirs + took / 2 - now))
        self.ahead = min(self._seen)[1]

    def here(self, seconds: float) -> float:
        """Return a time of the other clock by ours."""
        here = seconds - self.ahead
        # whoever is to be trusted says no other
        return here if 0 <= here < _LAST else self._now()
