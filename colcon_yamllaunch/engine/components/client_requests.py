# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Requests to the client program, and who waits for the answers."""

from collections.abc import Callable
from collections.abc import Mapping
from itertools import count
from typing import Any

#: Is called with an answer: `ok`, and `reason` where that is false.
Answered = Callable[[Mapping[str, Any]], None]


def has_ended(answer: Mapping[str, Any]) -> bool:
    """Tell whether there is no answer, as who was asked has ended."""
    return str(answer.get('reason')).endswith('has ended')


class Requests:
    """
    Requests that are under way.

    :param send: Hands a request to the client
    """

    def __init__(self, send: Callable[[Mapping[str, Any]], None]) -> None:
        self._send = send
        self._open: dict[int, Answered] = {}
        self._count = count(1)
        #: Whether there is a client that takes requests.
        self.is_ready = False

    def ask(self, do: str, answered: Answered, **fields: Any) -> int:
        """Send a request, and return its number."""
        number = next(self._count)
        self._open[number] = answered
        self._send({'id': number, 'do': do, **fields})
        return number

    def cancel(self, number: int | None) -> None:
        """Take a request back, if it is under way; nobody hears of it."""
        if number is not None and self._open.pop(number, None) is not None:
            self._send(
                {'id': next(self._count), 'do': 'cancel', 'request': number}
            )

    def take(self, answer: Mapping[str, Any]) -> None:
        """Pass an answer on to who waits for it, if anybody does."""
        answered = self._open.pop(answer['id'], None)
        if answered is not None:
            answered(answer)

    def gone(self, **who: str) -> None:
        """
        Tell that the process of a container or node has ended.

        One that crashed stays visible in ROS for a while.
        """
        if self.is_ready:
            self.ask('gone', lambda _: None, **who)

    def reset(self) -> None:
        """Forget what a client was asked that is gone."""
        self.is_ready = False
        self._open.clear()
