# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Requests to the ROS client, warnings of long waits, and ROS timers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import count
import math
from typing import Any

from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.loop import do_nothing, Loop, TimerHandle, Timers

#: Is called with an answer, and the reason of a refusal, else None.
Answered = Callable[[Mapping[str, Any], str | None], object]


def has_ended(refusal: str) -> bool:
    """Return whether a request was refused because the node has ended."""
    return refusal.endswith('has ended')


@dataclass(slots=True, eq=False)
class StandingRequest:
    """
    A request that a client gets again if one before it died.

    :param number: Its number, None while no client has it
    """

    do: str
    answered: Answered
    fields: Mapping[str, Any]
    number: int | None = None


class RosRequests:
    """
    The requests that have no answer yet.

    :param send: Sends a request to the client
    """

    def __init__(self, send: Callable[[Mapping[str, Any]], None]) -> None:
        self._send = send
        self._open: dict[int, Answered] = {}
        self._count = count(1)
        self._standing: list[StandingRequest] = []
        #: Whether there is a client that is ready.
        self.is_ready = False
        #: Why there will be no client any more.
        self.given_up: str | None = None

    def ask(self, do: str, answered: Answered, **fields: Any) -> int:
        """Send a request, and return its number."""
        number = next(self._count)
        self._open[number] = answered
        self._send({'id': number, 'do': do, **fields})
        return number

    def ask_any_client(
        self, do: str, answered: Answered, **fields: Any
    ) -> StandingRequest:
        """Send a request to the client, or as soon as there is one."""
        request = StandingRequest(do, answered, fields)
        self._standing.append(request)
        if self.is_ready:
            self._ask_again(request)
        return request

    def withdraw(self, request: StandingRequest) -> None:
        """Cancel a standing request, if it has no answer yet."""
        if request in self._standing:
            self._standing.remove(request)
            self.cancel(request.number)

    def client_is_ready(self) -> None:
        """Send standing requests to a client that is ready."""
        self.is_ready = True
        for request in tuple(self._standing):
            self._ask_again(request)

    def cancel(self, number: int | None) -> None:
        """Cancel a request if it has no answer yet."""
        if number is not None and self._open.pop(number, None) is not None:
            self._send(
                {'id': next(self._count), 'do': 'cancel', 'request': number}
            )

    def handle(self, answer: Mapping[str, Any]) -> None:
        """Pass an answer to the function that waits for it, if any."""
        answered = self._open.pop(answer['id'], None)
        if answered is not None:
            refusal = str(answer.get('reason') or 'no reason')
            answered(answer, None if answer.get('ok') else refusal)

    def gone(self, **who: str) -> None:
        """
        Report that the process of a container or node has ended.

        One that crashed stays visible in ROS for a while.
        """
        if self.is_ready:
            self.ask('gone', do_nothing, **who)

    def reset(self) -> None:
        """Forget the requests to a client that is gone."""
        self.is_ready = False
        self._open.clear()

    def _ask_again(self, request: StandingRequest) -> None:
        def answered(answer: Mapping[str, Any], refusal: str | None) -> None:
            if request in self._standing:
                self._standing.remove(request)
                request.answered(answer, refusal)

        request.number = self.ask(request.do, answered, **request.fields)


class WaitWarnings:
    """
    When to warn of waits: after a while, then ever less often.

    The loop begins a turn when :meth:`is_due` would return True.
    """

    def __init__(self, loop: Loop) -> None:
        self._loop = loop
        # the beginning of each wait, and when the next warning is due
        self._next: dict[str, tuple[float, float]] = {}

    def begin(self, key: str) -> None:
        """Begin a wait, or begin it again."""
        now = self._loop.time()
        self._set(key, now, now + limits.WAIT_WARNING_DELAY)

    def is_short(self, key: str) -> bool:
        """Return whether a wait is too short for a warning so far."""
        since, _ = self._next.get(key, (-math.inf, 0.0))
        return self._loop.time() < since + limits.WAIT_WARNING_DELAY

    def is_due(self, key: str) -> bool:
        """Return whether to warn now."""
        since, due = self._next.get(key, (0.0, math.inf))
        now = self._loop.time()
        if now < due:
            return False
        pause = min(2 * (due - since), limits.LONGEST_WARNING_DELAY)
        self._set(key, since, now + pause)
        return True

    def cancel(self, key: str) -> None:
        """End a wait."""
        self._next.pop(key, None)

    def _set(self, key: str, since: float, due: float) -> None:
        self._next[key] = since, due
        self._loop.wake_at(due)


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
        requests: RosRequests,
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
        self._warnings = WaitWarnings(loop)

    def add(self, seconds: float, action: Callable[[], None]) -> TimerHandle:
        """Call `action` in so many seconds."""
        if not self._timers.pending():
            self._warnings.begin(_CLOCK)
        handle = self._timers.add(self._passed + seconds, action)
        if seconds <= 0.0:
            self._loop.wake()
        if self._is_over:
            handle.cancel()
        self.follow_clock()
        return handle

    def clock(self, seconds: float) -> None:
        """Handle a new time."""
        if self._last is not None:
            self._passed += max(0.0, seconds - self._last)
        self._last = seconds
        self._timers.run_due(self._passed)

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
        elif self._last is None and self._warnings.is_due(_CLOCK):
            number = f'{len(pending)} timers wait'
            who = number if len(pending) > 1 else 'a timer waits'
            self._emit(
                events.Warned(
                    f'{who} for ROS time, but nothing comes on the topic '
                    f'{_CLOCK}: does the simulation, or ros2 bag play with '
                    '--clock, run?'
                )
            )

    def follow_clock(self) -> None:
        """Request the time of /clock if there is a timer."""
        if (
            self._requests.is_ready
            and not self._is_followed
            and self._timers.pending()
        ):
            self._is_followed = True
            self._requests.ask('clock', do_nothing)
