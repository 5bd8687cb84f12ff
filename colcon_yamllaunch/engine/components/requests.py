# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Requests to the client program, and warnings of long waits."""

from collections.abc import Callable
from collections.abc import Mapping
from itertools import count
from typing import Any

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.loop import TimerHandle

#: Called with an answer: `ok`, and `reason` if that is false.
Answered = Callable[[Mapping[str, Any]], None]


def has_ended(answer: Mapping[str, Any]) -> bool:
    """Return whether there is no answer, as the node has ended."""
    return str(answer.get('reason')).endswith('has ended')


class Requests:
    """
    The requests that have no answer yet.

    :param send: Sends a request to the client
    """

    def __init__(self, send: Callable[[Mapping[str, Any]], None]) -> None:
        self._send = send
        self._open: dict[int, Answered] = {}
        self._count = count(1)
        #: Whether there is a client that is ready.
        self.is_ready = False

    def ask(self, do: str, answered: Answered, **fields: Any) -> int:
        """Send a request, and return its number."""
        number = next(self._count)
        self._open[number] = answered
        self._send({'id': number, 'do': do, **fields})
        return number

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
            answered(answer)

    def gone(self, **who: str) -> None:
        """
        Report that the process of a container or node has ended.

        One that crashed stays visible in ROS for a while.
        """
        if self.is_ready:
            self.ask('gone', lambda _: None, **who)

    def reset(self) -> None:
        """Forget the requests to a client that is gone."""
        self.is_ready = False
        self._open.clear()


class WaitWarnings:
    """
    When to warn of a wait: after a while, then rarely.

    The loop begins a turn when :meth:`is_due` would return True.
    """

    def __init__(self, loop: Loop) -> None:
        self._loop = loop
        self._alarms: dict[str, TimerHandle] = {}
        # the beginning of each wait, and the seconds until the next warning
        self._next: dict[str, tuple[float, float]] = {}

    def is_due(self, key: str, since: float) -> bool:
        """
        Return whether to warn now.

        :param since: The beginning of the wait; a later one is another wait
        """
        seconds = self._after(key, since)
        now = self._loop.time()
        if now < since + seconds:
            self._wake_at(key, since + seconds)
            return False
        pause = min(2 * seconds, limits.LONGEST_WARNING_PAUSE)
        after = max(seconds, now - since) + pause
        self._next[key] = since, after
        self._wake_at(key, since + after)
        return True

    def cancel(self, key: str) -> None:
        """End a wait."""
        self._next.pop(key, None)
        alarm = self._alarms.pop(key, None)
        if alarm is not None:
            alarm.cancel()

    def _wake_at(self, key: str, due: float) -> None:
        alarm = self._alarms.get(key)
        if alarm is None or alarm.when() != due:
            if alarm is not None:
                alarm.cancel()
            self._alarms[key] = self._loop.call_at(due, self._loop.wake)

    def _after(self, key: str, since: float) -> float:
        begun, seconds = self._next.get(
            key, (since, limits.WAIT_WARNING_DELAY)
        )
        return seconds if begun == since else limits.WAIT_WARNING_DELAY
