# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The clients that subscribe to a launch, and the one of them that holds it.

The holder acknowledges what it has, and the journal keeps the rest for it, so
that it gets everything exactly once, however often it has to connect again.
It may also hold a lease: the launch is stopped once the holder is silent for
so many seconds.
"""

from collections.abc import Callable
from collections.abc import Mapping
import math
import time
from typing import Any
from typing import Protocol

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.control.journal import Cursor
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.engine import limits

#: Renews the lease of a launch by some seconds; without them, it has none.
Lease = Callable[[float | None], object]
#: How often a lease is renewed, at most, while it lasts.
_RENEWALS = 8
# a day, as no client can be away for longer by mistake
_LONGEST_LEASE = 86_400.0


class Holder(Protocol):
    """The connection of the client that holds a launch."""

    def send(self, data: bytes) -> None:
        """Send messages."""

    def close(self) -> None:
        """End the connection."""


class Subscribers:
    """
    Opens subscriptions, and keeps what the holder has not acknowledged.

    :param lease: Stops the launch when it is not renewed
    """

    #: Is called when the holder has another connection, and with None when it
    #: has lost that.
    when_held: Callable[[Holder | None], object] = bool

    def __init__(
        self,
        journal: Journal,
        lease: Lease = bool,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._journal = journal
        self._lease = lease
        self._clock = clock
        self._holder: str | None = None
        #: The connection of the holder, None while it has none.
        self.connection: Holder | None = None
        #: When something came from the holder last, by the clock.
        self.heard_at = -math.inf
        #: Whether the holder said that it goes on by another connection.
        self.is_reconnecting = False
        # the id of its last request
        self._asked = 0
        # how the holder reads now, and what it has acknowledged
        self._reads: Cursor | None = None
        self._acknowledged: Cursor | None = None
        self._seconds: float | None = None
        self._renewed = -math.inf

    def subscribe(
        self,
        message: Mapping[str, Any],
        before: Cursor | None,
    ) -> Cursor:
        """
        Return the cursor of a client that subscribes.

        :param before: The cursor that it had so far
        :raises ProtocolError: when the request has a wrong form
        :raises RefusedError: when another client is the holder
        """
        holder = message.get('holder')
        if not isinstance(holder, str | None):
            raise ProtocolError("the 'holder' is a text, or null")
        seconds = _seconds(message)
        behind = message.get('behind')
        if not (behind is None or (type(behind) is int and behind >= 0)):
            raise ProtocolError("'behind' is a number of bytes, or null")
        if holder is not None and self._holder not in (None, holder):
            raise RefusedError('another client holds this launch')
        if seconds is not None and holder is None:
            raise ProtocolError("a 'lease' is for a 'holder' only")
        cursor = Cursor(
            wants_events=_flag(message, 'events'),
            wants_output=_flag(message, 'output'),
            labels=_labels(message),
            behind=limits.JOURNAL if behind is None else behind,
            is_raw=_flag(message, 'raw', default=False),
            is_relayed=_flag(message, 'relayed', default=False),
        )
        if _flag(message, 'states', default=False):
            # what the client has not read of the state comes after all
            cursor.version = None if before is None else before.version
            if cursor.version is None:
                state = self._journal.state
                cursor.version = 0 if state is None else state.version
        self._journal.subscribe(cursor, message.get('since'), before)
        if holder is not None:
            self._holder, self._reads = holder, cursor
            self._acknowledge({'events': cursor.events, 'bytes': cursor.bytes})
            self._seconds, self._renewed = seconds, -math.inf
            if seconds is None:
                self._lease(None)
            self.heard(cursor)
        return cursor

    def hold(self, connection: Holder) -> dict[str, Any]:
        """
        Note the connection of the holder, which has subscribed.

        :return: Fields of the answer
        """
        self.is_reconnecting = False
        self.connection = connection
        self.when_held(connection)
        return {'asked': self._asked}

    def left(self, connection: Holder) -> None:
        """Note that a connection has ended."""
        if connection is self.connection:
            self.connection = None
            self.when_held(None)

    def is_repeated(self, number: object) -> bool:
        """
        Return whether the holder has sent a request before.

        :param number: The `id` of the request
        """
        if not isinstance(number, int):
            return False
        if number <= self._asked:
            return True
        self._asked = number
        return False

    @property
    def unacknowledged(self) -> int:
        """How many bytes of output the holder has not acknowledged."""
        if self._acknowledged is None:
            return 0
        return self._journal.bytes_after(self._acknowledged)

    @property
    def has_all(self) -> bool:
        """Whether the holder has acknowledged everything."""
        cursor = self._acknowledged
        return cursor is not None and self._journal.is_at_end(cursor)

    def ping(
        self, message: Mapping[str, Any], cursor: Cursor | None
    ) -> dict[str, float]:
        """
        Return the fields of the answer to a `ping`.

        :param cursor: That of the client
        :raises ProtocolError: when the request has a wrong form
        :raises RefusedError: when the client acknowledges, but is not the
          holder
        """
        acknowledged = message.get('ack')
        if acknowledged is not None:
            if not self.is_holder(cursor):
                raise RefusedError('another client holds this launch')
            self._acknowledge(acknowledged)
        if self.is_holder(cursor):
            self.is_reconnecting = _flag(
                message, 'reconnecting', default=False
            )
        return {'clock': time.time()}

    def is_holder(self, cursor: Cursor | None) -> bool:
        """Return whether a cursor is that of the holder."""
        return cursor is not None and cursor is self._reads

    def heard(self, cursor: Cursor) -> None:
        """Renew the lease if something came from the holder."""
        if cursor is not self._reads:
            return
        self.heard_at = now = self._clock()
        if self._seconds is None:
            return
        if now >= self._renewed + self._seconds / _RENEWALS:
            self._renewed = now
            self._lease(self._seconds)

    def _acknowledge(self, point: object) -> None:
        """
        Keep what follows a point for the holder.

        :raises ProtocolError: when that is no point of this launch
        """
        self._acknowledged = self._journal.subscribe(
            Cursor(is_holder=True), point, self._acknowledged
        )


def _seconds(message: Mapping[str, Any]) -> float | None:
    seconds = message.get('lease')
    if seconds is None:
        return None
    if type(seconds) in (int, float) and 0 < seconds <= _LONGEST_LEASE:
        return float(seconds)
    raise ProtocolError("a 'lease' is a number of seconds, or null")


def _flag(
    message: Mapping[str, Any], name: str, *, default: bool = True
) -> bool:
    flag = message.get(name, default)
    if not isinstance(flag, bool):
        raise ProtocolError(f"'{name}' is true or false")
    return flag


def _labels(message: Mapping[str, Any]) -> frozenset[str] | None:
    labels = message.get('processes')
    if labels is None:
        return None
    if not isinstance(labels, list) or not all(
        isinstance(label, str) for label in labels
    ):
        raise ProtocolError("'processes' is a list of labels, or null")
    return frozenset(labels)
