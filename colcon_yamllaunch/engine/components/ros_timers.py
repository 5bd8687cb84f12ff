# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Timers on the time of the topic `/clock`."""

from collections.abc import Callable

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.components.requests import Requests
from colcon_yamllaunch.engine.components.requests import WaitWarnings
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.loop import Timers

_CLOCK = '/clock'


class RosTimers:
    """
    Timers on ROS time.

    Seconds count from the first time that arrives after a timer was set, if
    none arrived before. A clock that is set back, as when a simulation starts
    again, does not undo the time that has passed.
    """

    def __init__(
        self,
        requests: Requests,
        emit: events.Listener,
        loop: Loop,
    ) -> None:
        self._requests = requests
        self._emit = emit
        self._loop = loop
        self._timers = Timers()
        # the last time of /clock, and the seconds that have passed
        self._last: float | None = None
        self._passed = 0.0
        self._is_followed = False
        self._is_over = False
        self._since = 0.0
        self._warnings = WaitWarnings(loop)

    def add(self, seconds: float, action: Callable[[], None]) -> TimerHandle:
        """Call `action` in so many seconds."""
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
        """Handle a new time."""
        if self._last is not None:
            self._passed += max(0.0, seconds - self._last)
        self._last = seconds
        self._timers.run_due(self._passed)

    def client_is_ready(self) -> None:
        """Follow the clock if there is a timer."""
        self._follow()

    def client_died(self) -> None:
        """Note that no client follows the clock."""
        self._is_followed = False

    def cancel(self) -> None:
        """Cancel all timers, as no time arrives any more."""
        self._is_over = True
        for handle in self._timers.pending():
            handle.cancel()

    def end_turn(self) -> None:
        """Call due timers, and warn if no time arrives."""
        self._timers.run_due(self._passed)
        pending = self._timers.pending()
        if not pending:
            self._warnings.cancel(_CLOCK)
        elif self._last is None and self._warnings.is_due(_CLOCK, self._since):
            number = f'{len(pending)} timers wait'
            who = number if len(pending) > 1 else 'a timer waits'
            self._emit(
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
