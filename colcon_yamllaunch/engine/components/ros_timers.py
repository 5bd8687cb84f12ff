# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Timers on the time of the topic `/clock`."""

from collections.abc import Callable

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.components.client_requests import Requests
from colcon_yamllaunch.engine.components.patience import Patience
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.loop import Timers

_CLOCK = '/clock'


class RosTimers:
    """
    What is due at a ROS time.

    Seconds are counted from the first time that is told after a timer was
    set, if none was told before. Where the clock is set back, as when a
    simulation begins anew, what has passed has passed.
    """

    def __init__(
        self,
        requests: Requests,
        tell: events.Listener,
        loop: Loop,
    ) -> None:
        self._requests = requests
        self._tell = tell
        self._loop = loop
        self._timers = Timers()
        # what /clock told last, and how much of it has passed
        self._told: float | None = None
        self._passed = 0.0
        self._is_followed = False
        self._is_over = False
        self._since = 0.0
        self._patience = Patience(loop)

    def add(self, seconds: float, action: Callable[[], None]) -> TimerHandle:
        """Have something done in so many seconds."""
        if not self._timers.pending():
            self._since = self._loop.time()
        handle = self._timers.add(self._passed + seconds, action)
        if seconds <= 0.0:
            self._loop.wake()
        if self._is_over:
            handle.cancel()
        self._follow()
        return handle

    def clock(self, seconds: float) -> None:
        """Take into account which time it is."""
        if self._told is not None:
            self._passed += max(0.0, seconds - self._told)
        self._told = seconds
        self._timers.run_due(self._passed)

    def client_is_ready(self) -> None:
        """Follow the clock if there is need."""
        self._follow()

    def client_died(self) -> None:
        """Take into account that nobody follows the clock."""
        self._is_followed = False

    def cancel(self) -> None:
        """Give the timers up, as nobody tells the time any more."""
        self._is_over = True
        for handle in self._timers.pending():
            handle.cancel()

    def end_turn(self) -> None:
        """Call what is due, and warn when no time comes."""
        self._timers.run_due(self._passed)
        pending = self._timers.pending()
        if not pending:
            self._patience.forget(_CLOCK)
        elif self._told is None and self._patience.is_over(
            _CLOCK, self._since
        ):
            number = f'{len(pending)} timers wait'
            who = number if len(pending) > 1 else 'a timer waits'
            self._tell(
                events.Warned(
                    f'{who} for ROS time, but nothing comes on the topic '
                    f'{_CLOCK}: does the simulation, or ros2 bag play with '
                    '--clock, run?'
                )
            )

    def _follow(self) -> None:
        if (
            self._requests.is_ready
            and not self._is_followed
            and self._timers.pending()
        ):
            self._is_followed = True
            self._requests.ask('clock', lambda _: None)
