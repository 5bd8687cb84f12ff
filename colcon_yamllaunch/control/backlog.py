# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What happened last in a launch, for clients that subscribe.

It is kept once for all of them, and each has a cursor in it. So a client that
is slow costs no memory, and makes nobody wait: what is dropped before it has
come there, it has missed.
"""

from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Mapping
import time
from typing import Any
from typing import NamedTuple

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine import limits


class _Happened(NamedTuple):
    """
    An event, as a line for clients.

    :param order: How many events and pieces of output there were before
    """

    order: int
    line: bytes


class _Written(NamedTuple):
    """
    A piece of output.

    :param order: As that of an event
    :param start: How many bytes of output there were before
    :param time: In seconds since the epoch
    """

    order: int
    start: int
    time: float
    label: str
    stream: events.Stream
    data: bytes


class Cursor:
    """
    Where a client has come in the backlog.

    :param events: How many events there were before
    :param bytes: How many bytes of output there were before
    :param wants_events: Whether it is told events
    :param wants_output: Whether it is told output
    :param labels: The processes whose output that is; None for all
    """

    __slots__ = ('bytes', 'events', 'labels', 'wants_events', 'wants_output')

    def __init__(
        self,
        events: int,
        bytes: int,  # noqa: A002
        *,
        wants_events: bool,
        wants_output: bool,
        labels: Collection[str] | None = None,
    ) -> None:
        self.events = events
        self.bytes = bytes
        self.wants_events = wants_events
        self.wants_output = wants_output
        self.labels = labels


class Backlog:
    """
    The latest events and output, as much as finds room.

    Both have room of their own, so that output drives out no event.

    :param now: Returns the seconds since the epoch
    """

    def __init__(self, now: Callable[[], float] = time.time) -> None:
        self._now = now
        self._order = 0
        self._events: deque[_Happened] = deque()
        self._output: deque[_Written] = deque()
        # how many there were, and how many bytes of them are kept
        self._told = self._written = 0
        self._told_size = self._written_size = 0
        self._waiting: list[Callable[[], None]] = []

    @property
    def point(self) -> Mapping[str, int]:
        """How much there has been so far; see `protocol`."""
        return {'events': self._told, 'bytes': self._written}

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        if isinstance(event, events.Output):
            self._keep_output(event)
        else:
            record = event.record()
            if not record:
                return
            self._keep_event(record)
        self._order += 1
        if self._waiting:
            waiting, self._waiting = self._waiting, []
            for wake in waiting:
                wake()

    def cursor(
        self,
        since: object,
        *,
        wants_events: bool,
        wants_output: bool,
        labels: Collection[str] | None = None,
        before: Cursor | None = None,
    ) -> Cursor:
        """
        Return a cursor at a point.

        :param since: The point as a client has it, or None for now
        :param labels: The processes whose output it is told; None for all
        :param before: That which the client had so far: without `since`, the
          new one goes on from there
        :raises ProtocolError: when that is no point of this launch
        """
        point = self.point if since is None else since
        if since is None and before is not None:
            point = {'events': before.events, 'bytes': before.bytes}
        if not isinstance(point, Mapping):
            raise protocol.ProtocolError("'since' is a point, or null")
        return Cursor(
            _number(point, 'events', self._told),
            _number(point, 'bytes', self._written),
            wants_events=wants_events,
            wants_output=wants_output,
            labels=labels,
        )

    def has_more(self, cursor: Cursor) -> bool:
        """Tell whether there is more for a client than it has come to."""
        if cursor.wants_events and cursor.events < self._told:
            return True
        if cursor.wants_output and cursor.bytes < self._first_byte:
            return True
        return self._next_output(cursor) is not None

    def call(self, wake: Callable[[], None]) -> None:
        """Have a client called, once, when there is more."""
        self._waiting.append(wake)

    def forget(self, wake: Callable[[], None]) -> None:
        """Have it called no more."""
        if wake in self._waiting:
            self._waiting.remove(wake)

    def read(self, cursor: Cursor, room: int) -> bytes:
        """
        Return what follows, as lines, and move the cursor behind that.

        :param room: The bytes after which no line is added
        """
        lines: list[bytes] = []
        size = 0
        while size < room:
            line = self._next(cursor)
            if line is None:
                break
            lines.append(line)
            size += len(line)
        return b''.join(lines)

    def drop_output(self) -> None:
        """Keep no output, which who has not come to it has missed."""
        self._output.clear()
        self._written_size = 0

    def _next(self, cursor: Cursor) -> bytes | None:
        missed = self._missed(cursor)
        if missed is not None:
            return protocol.encode({'missed': missed})
        event = None
        if cursor.wants_events and cursor.events < self._told:
            event = self._events[cursor.events - self._told]
        output = self._next_output(cursor)
        if event is not None and (
            output is None or event.order < output.order
        ):
            cursor.events += 1
            return event.line
        if output is None:
            return None
        before = cursor.bytes
        data = _piece(output.data, before - output.start)
        cursor.bytes += len(data)
        return protocol.encode(
            {
                'output': {
                    'process': output.label,
                    'stream': output.stream,
                    'data': protocol.text_of(data),
                    'time': output.time,
                    'at': before,
                }
            }
        )

    @property
    def _first_byte(self) -> int:
        """How many bytes of output there were before those that are kept."""
        return self._written - self._written_size

    def _missed(self, cursor: Cursor) -> Mapping[str, int] | None:
        """Move a cursor to what there is, and tell what it missed by that."""
        first_event = self._told - len(self._events)
        missed = {
            'events': max(0, first_event - cursor.events),
            'bytes': max(0, self._first_byte - cursor.bytes),
        }
        cursor.events += missed['events']
        cursor.bytes += missed['bytes']
        if not cursor.wants_events:
            missed['events'] = 0
        if not cursor.wants_output:
            missed['bytes'] = 0
        return missed if any(missed.values()) else None

    def _next_output(self, cursor: Cursor) -> _Written | None:
        """Move a cursor to the next piece that its client wants, if any."""
        if not cursor.wants_output or cursor.bytes >= self._written:
            return None
        found = bisect_right(self._output, cursor.bytes, key=_start_of) - 1
        for number in range(found, len(self._output)):
            output = self._output[number]
            if cursor.labels is None or output.label in cursor.labels:
                return output
            cursor.bytes = output.start + len(output.data)
        return None

    def _keep_event(self, record: Mapping[str, Any]) -> None:
        fields = {'time': round(self._now(), 6), **record}
        line = protocol.encode({'event': fields})
        self._events.append(_Happened(self._order, line))
        self._told += 1
        self._told_size += len(line)
        while self._told_size > limits.EVENT_BACKLOG:
            self._told_size -= len(self._events.popleft().line)

    def _keep_output(self, event: events.Output) -> None:
        data = event.data
        self._output.append(
            _Written(
                self._order,
                self._written,
                round(self._now(), 6),
                event.process.label,
                event.stream,
                data,
            )
        )
        self._written += len(data)
        self._written_size += len(data)
        while (
            self._written_size > limits.OUTPUT_BACKLOG
            or len(self._output) > limits.OUTPUT_PIECES
        ):
            self._written_size -= len(self._output.popleft().data)


def _start_of(output: _Written) -> int:
    return output.start


def _piece(data: bytes, start: int) -> bytes:
    """Return as much of output as goes into a message, lines if possible."""
    end = start + protocol.MAXIMUM_OUTPUT
    if end < len(data):
        end = data.rfind(b'\n', start, end) + 1 or end
    return data[start:end]


def _number(point: Mapping[Any, Any], name: str, most: int) -> int:
    number = point.get(name)
    if type(number) is not int or not 0 <= number <= most:
        raise protocol.ProtocolError(
            "'since' is no point of this launch: how many 'events' and "
            "'bytes' there have been, or null for now"
        )
    return number
