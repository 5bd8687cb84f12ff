# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The journal of a launch: its events and output, for clients that subscribe.

All clients share it, and each has a cursor in it, so a slow client neither
blocks the launch nor uses its memory. The latest events and output stay in
memory. Older output goes to nameless files, but only while a client that has
subscribed has not read it and is not too far behind; else nothing is written.
"""

from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
import marshal
import math
from operator import attrgetter
import os
from pathlib import Path
import time
from typing import Any, NamedTuple

from colcon_yamllaunch.common.frozen import mutable
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.state import LaunchState, to_json


class _EventRecord(NamedTuple):
    """
    An event, as a line for clients.

    :param order: How many events and pieces of output there were before
    """

    order: int
    line: bytes


@mutable
class _OutputRecord:
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
    data: bytearray


class _Block(NamedTuple):
    """
    Output records in a file.

    :param start: How many bytes of output there were before
    :param end: How many there were up to its end
    :param descriptor: The file
    :param position: The place in the file
    """

    start: int
    end: int
    descriptor: int
    position: int
    size: int


@mutable
class Cursor:
    """
    The position of a client in the journal, and what that client wants.

    :param wants_events: Whether the client gets events
    :param wants_output: Whether the client gets output
    :param labels: The processes whose output it gets; None for all
    :param behind: Bytes of output that it may be behind before it misses some
    :param is_raw: Whether output follows a line about it as it is
    :param is_relayed: Whether its client is behind a relay; see `protocol`
    :param is_holder: Whether it misses no event, however far it is behind
    :param version: The version of the state that the client has; None if it
      does not want the state
    :param events: How many events there were before
    :param bytes: How many bytes of output there were before
    :param loaded: The end and the records of the block that is being read
    """

    wants_events: bool = True
    wants_output: bool = True
    labels: Collection[str] | None = None
    behind: int = limits.JOURNAL_BYTES
    is_raw: bool = False
    is_relayed: bool = False
    is_holder: bool = False
    version: int | None = None
    events: int = 0
    bytes: int = 0
    loaded: tuple[int, Sequence[_OutputRecord]] = (0, ())


class Journal:
    """
    The events and output of a launch, in their order.

    Both have room of their own, so that output drives out no event.

    :param folder: Where output goes that does not fit in memory
    :param limit: The bytes that it may take there, or None
    :param now: Returns the seconds since the epoch
    :param record: Returns what clients get of an event besides the time;
      empty for nothing
    """

    def __init__(
        self,
        folder: Path | None = None,
        limit: int | None = None,
        now: Callable[[], float] = time.time,
        record: Callable[[events.Event], Mapping[str, Any]] = (
            lambda event: event.record()
        ),
    ) -> None:
        #: The state of the launch, for clients that want its changes.
        self.state: LaunchState | None = None
        self._folder = folder
        self._limit = math.inf if limit is None else limit
        self._now = now
        self._record = record
        self._order = 0
        # those in memory, and the bytes that they take
        self._events: deque[_EventRecord] = deque()
        self._output: deque[_OutputRecord] = deque()
        self._events_size = self._output_size = 0
        # how many events, and how many bytes of output, there were
        self._event_count = self._byte_count = 0
        # output before that in memory, and the size of the last file
        self._blocks: deque[_Block] = deque()
        self._file_size = 0
        self._cursors: list[Cursor] = []
        self._waiting: set[Callable[[], None]] = set()

    @property
    def point(self) -> Mapping[str, int]:
        """How much there has been so far; see `protocol`."""
        return {'events': self._event_count, 'bytes': self._byte_count}

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        if isinstance(event, events.Output):
            self._add_output(event)
        else:
            record = self._record(event)
            if record:
                self._add_event(record)
        if self._waiting:
            waiting, self._waiting = self._waiting, set()
            for wake in waiting:
                wake()

    def subscribe(
        self, cursor: Cursor, since: object, before: Cursor | None = None
    ) -> Cursor:
        """
        Move a cursor to a point, and keep what follows that.

        :param since: The point from a client, or None for now
        :param before: The cursor which the client had so far: without
          `since`, the new one goes on from there
        :raises ProtocolError: when that is no point of this launch
        """
        point = self.point if since is None else since
        if since is None and before is not None:
            point = {'events': before.events, 'bytes': before.bytes}
        if not isinstance(point, Mapping):
            raise protocol.ProtocolError("'since' is a point, or null")
        cursor.events = _number(point, 'events', self._event_count)
        cursor.bytes = _number(point, 'bytes', self._byte_count)
        if before is not None:
            self.unsubscribe(before)
        self._cursors.append(cursor)
        return cursor

    def unsubscribe(self, cursor: Cursor) -> None:
        """Drop what only this cursor needs."""
        if cursor in self._cursors:
            self._cursors.remove(cursor)
            self._release()

    def has_more(self, cursor: Cursor) -> bool:
        """Return whether `cursor` has not come to the end."""
        if cursor.wants_events and cursor.events < self._event_count:
            return True
        if self._state_of(cursor) is not None:
            return True
        if cursor.wants_output and cursor.bytes < self._next_byte(cursor):
            return True
        return self._next_output(cursor) is not None

    def bytes_after(self, cursor: Cursor) -> int:
        """Return how many bytes of output there were after a cursor."""
        return self._byte_count - cursor.bytes

    def is_at_end(self, cursor: Cursor) -> bool:
        """Return whether nothing follows a cursor."""
        return (
            cursor.events == self._event_count
            and cursor.bytes == self._byte_count
        )

    def call(self, wake: Callable[[], None]) -> None:
        """Call `wake` once, when there is more."""
        self._waiting.add(wake)

    def forget(self, wake: Callable[[], None]) -> None:
        """Cancel :meth:`call`."""
        self._waiting.discard(wake)

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
        """Drop all output; clients that have not read it miss it."""
        self._output.clear()
        self._output_size = 0
        self.close()

    def close(self) -> None:
        """Close the files."""
        while self._blocks:
            self._drop_block()

    def _next(self, cursor: Cursor) -> bytes | None:
        missed = self._missed(cursor)
        if missed is not None:
            return protocol.encode({'missed': missed})
        event = None
        if cursor.wants_events and cursor.events < self._event_count:
            event = self._events[cursor.events - self._event_count]
        output = self._next_output(cursor)
        if event is not None and (
            output is None or event.order < output.order
        ):
            cursor.events += 1
            return event.line
        state = self._state_of(cursor)
        if state is not None:
            # the client has all events up to this state
            changes = to_json(state, cursor.version)
            cursor.version = state.version
            return protocol.encode({'state': changes})
        if output is None:
            return None
        before = cursor.bytes
        data = _piece(output.data, before - output.start)
        cursor.bytes += len(data)
        fields: dict[str, Any] = {
            'process': output.label,
            'stream': output.stream,
            'time': output.time,
            'at': before,
        }
        if cursor.is_raw:
            line = protocol.encode_raw('output', fields, data)
            is_inside = cursor.is_relayed and not data.endswith(b'\n')
            return line + b'\n' if is_inside else line
        fields['data'] = protocol.text_of(data)
        return protocol.encode({'output': fields})

    @property
    def _first_in_memory(self) -> int:
        """How many bytes of output there were before those in memory."""
        return self._byte_count - self._output_size

    def _next_byte(self, cursor: Cursor) -> int:
        """Return the position of the first output that `cursor` can read."""
        position = cursor.bytes
        if position >= self._first_in_memory or self._is_lost(cursor):
            return max(position, self._first_in_memory)
        found = bisect_right(self._blocks, position, key=_end_of)
        if found == len(self._blocks):
            return self._first_in_memory
        return max(position, self._blocks[found].start)

    def _is_lost(self, cursor: Cursor) -> bool:
        """
        Return whether a client is so far behind that it misses output.

        It goes on with what is in memory then, so that it is up to date. The
        holder goes on with the oldest that there is room for.
        """
        if cursor.is_holder:
            return False
        behind = self._first_in_memory - cursor.bytes
        return behind > cursor.behind or behind > self._limit

    def _missed(self, cursor: Cursor) -> Mapping[str, int] | None:
        """Move a cursor to what there is, and return what it missed."""
        first_event = self._event_count - len(self._events)
        missed = {
            'events': max(0, first_event - cursor.events),
            'bytes': self._next_byte(cursor) - cursor.bytes,
        }
        cursor.events += missed['events']
        cursor.bytes += missed['bytes']
        if not cursor.wants_events:
            missed['events'] = 0
        if not cursor.wants_output:
            missed['bytes'] = 0
        return missed if any(missed.values()) else None

    def _state_of(self, cursor: Cursor) -> LaunchState | None:
        """Return the state if the client of `cursor` has an older one."""
        if cursor.version is None or self.state is None:
            return None
        return None if cursor.version == self.state.version else self.state

    def _next_output(self, cursor: Cursor) -> _OutputRecord | None:
        """Move a cursor to the next piece that its client wants, if any."""
        if not cursor.wants_output:
            return None
        while cursor.bytes < self._byte_count:
            records = self._records_at(cursor)
            found = bisect_right(records, cursor.bytes, key=_start_of) - 1
            for number in range(found, len(records)):
                output = records[number]
                if cursor.labels is None or output.label in cursor.labels:
                    return output
                cursor.bytes = output.start + len(output.data)
        return None

    def _records_at(self, cursor: Cursor) -> Sequence[_OutputRecord]:
        """Return the records in memory, or of a block, at a cursor."""
        if cursor.bytes >= self._first_in_memory:
            cursor.loaded = 0, ()
            return self._output
        end, records = cursor.loaded
        if not records or not records[0].start <= cursor.bytes < end:
            found = bisect_right(self._blocks, cursor.bytes, key=_end_of)
            block = self._blocks[found]
            data = os.pread(block.descriptor, block.size, block.position)
            # with bytes as output, as none is added to these
            records = [_OutputRecord(*each) for each in marshal.loads(data)]
            end = block.end
            cursor.loaded = end, records
        return records

    def _add_event(self, record: Mapping[str, Any]) -> None:
        fields = {'time': round(self._now(), 6), **record}
        line = protocol.encode({'event': fields})
        self._events.append(_EventRecord(self._order, line))
        self._order += 1
        self._event_count += 1
        self._events_size += len(line)
        while self._events_size > limits.EVENT_BACKLOG_BYTES:
            first = self._event_count - len(self._events)
            may_wait = self._events_size <= limits.UNREAD_EVENT_BYTES
            if any(
                c.wants_events and c.events <= first
                for c in self._cursors
                if may_wait or c.is_holder
            ):
                break
            self._events_size -= len(self._events.popleft().line)

    def _add_output(self, event: events.Output) -> None:
        now = self._now()
        label, data = event.process.label, event.data
        size = len(data)
        last = self._output[-1] if self._output else None
        if (
            last is not None
            and last.order == self._order - 1
            and last.label == label
            and last.stream == event.stream
            and now - last.time < limits.JOURNAL_MERGE_SECONDS
            and len(last.data) + size <= protocol.MAXIMUM_OUTPUT
        ):
            last.data += data
        else:
            start, time = self._byte_count, round(now, 6)
            self._output.append(
                _OutputRecord(
                    self._order,
                    start,
                    time,
                    label,
                    event.stream,
                    bytearray(data),
                )
            )
            self._order += 1
        self._byte_count += size
        self._output_size += size
        # many at once, as they are one block
        room, pieces = (
            limits.OUTPUT_BACKLOG_BYTES,
            limits.OUTPUT_BACKLOG_PIECES,
        )
        if (
            self._output_size > room + room // 16
            or len(self._output) > pieces + pieces // 16
        ):
            self._move_out()

    def _move_out(self) -> None:
        """Move output from memory to a file if a client needs it."""
        records = []
        while (
            self._output_size > limits.OUTPUT_BACKLOG_BYTES
            or len(self._output) > limits.OUTPUT_BACKLOG_PIECES
        ):
            record = self._output.popleft()
            self._output_size -= len(record.data)
            records.append(record)
        if not self._release():
            self.close()
            return
        start = records[0].start
        while self._blocks and start - self._blocks[0].start > self._limit:
            self._drop_block()
        self._write(records)

    def _release(self) -> bool:
        """Drop what no client needs; return whether they need more."""
        positions = [
            c.bytes
            for c in self._cursors
            if c.wants_output and not self._is_lost(c)
        ]
        first = min(positions, default=self._byte_count)
        while self._blocks and (
            first >= self._first_in_memory
            if len(self._blocks) == 1
            else self._blocks[1].start <= first
        ):
            self._drop_block()
        return first < self._first_in_memory

    def _write(self, records: list[_OutputRecord]) -> None:
        """Write records to a file, if the disk has room for them."""
        data = marshal.dumps([_fields_of(record) for record in records])
        # without room on the disk, clients that are behind miss them
        with suppress(OSError):
            descriptor = self._file_with_room()
            position = self._file_size
            if os.pwrite(descriptor, data, position) == len(data):
                self._file_size += len(data)
                start, end = records[0].start, self._first_in_memory
                self._blocks.append(
                    _Block(start, end, descriptor, position, len(data))
                )
            elif not self._blocks or self._blocks[-1].descriptor != descriptor:
                os.close(descriptor)

    def _file_with_room(self) -> int:
        """
        Return the file for the next records.

        :raises OSError: when there can be no further file
        """
        if self._blocks and self._file_size < limits.JOURNAL_FILE_BYTES:
            return self._blocks[-1].descriptor
        descriptor = _nameless_file(self._folder)
        self._file_size = 0
        return descriptor

    def _drop_block(self) -> None:
        descriptor = self._blocks.popleft().descriptor
        if not self._blocks or self._blocks[0].descriptor != descriptor:
            os.close(descriptor)


_start_of: Callable[[_OutputRecord], int] = attrgetter('start')
_end_of: Callable[[_Block], int] = attrgetter('end')
_fields_of: Callable[[_OutputRecord], tuple[Any, ...]] = attrgetter(
    'order', 'start', 'time', 'label', 'stream', 'data'
)


def _nameless_file(folder: Path | None) -> int:
    """
    Open a file that vanishes with this process.

    :raises OSError: when that is not possible
    """
    # few launches have clients that are so slow
    import tempfile

    descriptor, path = tempfile.mkstemp(prefix='.journal-', dir=folder)
    os.unlink(path)
    return descriptor


def _piece(data: bytearray, start: int) -> bytes:
    """Return as much of output as goes into a message, lines if possible."""
    end = start + protocol.MAXIMUM_OUTPUT
    if end < len(data):
        end = data.rfind(b'\n', start, end) + 1 or end
    return bytes(memoryview(data)[start:end])


def _number(point: Mapping[Any, Any], name: str, most: int) -> int:
    number = point.get(name)
    if type(number) is not int or not 0 <= number <= most:
        raise protocol.ProtocolError(
            "'since' is no point of this launch: how many 'events' and "
            "'bytes' there have been, or null for now"
        )
    return number
