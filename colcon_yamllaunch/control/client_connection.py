# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One client of a running launch, as the launch sees it."""

from collections.abc import Callable, Mapping
from contextlib import suppress
import select
import socket
import time
from typing import Any

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.journal import Cursor
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.control.service import Service
from colcon_yamllaunch.engine.events import Stream
from colcon_yamllaunch.engine.loop import Loop

# so that a client with many requests does not keep others from their turn
_REQUESTS_PER_TURN = 8
# bytes that a client that has subscribed gets at once, and those that may wait
# to be sent to it before its requests are not read
_SHARE = 64 * 1024
_TOO_MUCH = 4 * _SHARE
# bytes that the system is to take from us at the end; it takes what it allows
_LAST_ROOM = 1024 * 1024
_CHUNK = 64 * 1024
# a connection is slow that has something to send all the time, and takes fewer
# bytes a second; how long it is looked at, in seconds
_SLOW = 8 * 1024 * 1024
_LOOK = 0.2
_GONE = select.EPOLLERR | select.EPOLLHUP


class Client:
    """
    A connection to a client.

    No client makes the launch wait or need more memory: as long as one does
    not take its answers, or waits for one, its requests are not read, and
    what it is too slow for is skipped.

    :param connection: The connection, which does not block
    :param left: Is called when it is gone
    """

    def __init__(
        self,
        connection: socket.socket,
        loop: Loop,
        service: Service,
        left: Callable[['Client'], None],
    ) -> None:
        self._connection = connection
        self._loop = loop
        self._service = service
        self._journal = service.journal
        self._left = left
        self._received = b''
        self._outgoing = bytearray()
        self._skipped = 0
        #: The process that the client is attached to.
        self.label: str | None = None
        #: The position of a client that has subscribed.
        self.cursor: Cursor | None = None
        # for the answer to a request that takes its time
        self._is_waiting = False
        self._unanswered = 0
        self._is_last = False
        #: Whether it has not been closed.
        self.is_open = True
        self._speed = _Speed()
        loop.add_hangup_handler(connection.fileno(), self._hung_up)
        loop.add_reader(connection.fileno(), self._readable)

    def show(self, stream: Stream, data: bytes) -> None:  # noqa: ARG002
        """Send what the process wrote, unless too much waits already."""
        if self._skipped or len(self._outgoing) > protocol.MAXIMUM_BACKLOG:
            self._skipped += len(data)
        else:
            self.send_message({'output': protocol.text_of(data)})

    def send_message(self, message: Mapping[str, Any]) -> None:
        """Send a message."""
        self.send(protocol.encode(message))

    def send(self, data: bytes) -> None:
        """Send messages."""
        self._outgoing += data
        self._send()

    def close(self) -> None:
        """End the connection."""
        if not self.is_open:
            return
        self.is_open = False
        if self.label is not None:
            self._service.detach(self.label, self)
        self._journal.forget(self._watch)
        if self.cursor is not None:
            self._journal.unsubscribe(self.cursor)
        self._loop.remove(self._connection.fileno())
        self._connection.close()
        self._service.subscribers.left(self)
        self._left(self)

    def drain(self) -> None:
        """Send all that is left, as far as that needs no waiting."""
        self._send()
        while self.is_open and self._has_more() and not self._outgoing:
            self._send()

    def end(self) -> None:
        """Send the rest where the system still has room for it, and close."""
        if self._outgoing or self._has_more():
            with suppress(OSError):
                self._connection.setsockopt(
                    socket.SOL_SOCKET, socket.SO_SNDBUF, _LAST_ROOM
                )
            self.drain()
        self.close()

    def _hung_up(self) -> None:
        is_stuck = self._is_waiting or not self._may_ask_more()
        is_done = self._is_last and b'\n' not in self._received
        if is_stuck or is_done:
            self.close()
        elif self._may_read():
            self._readable()

    def _writable(self) -> None:
        self._send()
        self._serve()

    def _readable(self) -> None:
        if self.is_open and self._may_read():
            self._read()
        self._serve()

    def _may_read(self) -> bool:
        if self._is_last or b'\n' in self._received:
            return False
        return self.label is not None or self._has_room()

    def _has_room(self) -> bool:
        """Return whether there is room for the answer to a request."""
        most = 1 if self.cursor is None else _TOO_MUCH
        has_room = len(self._outgoing) < most and self._may_ask_more()
        # the holder may have to stop what floods it
        return has_room or self._is_holder

    @property
    def _is_holder(self) -> bool:
        return self._service.subscribers.connection is self

    def _may_ask_more(self) -> bool:
        # the holder may have to stop what takes its time
        is_below = self._unanswered < protocol.MAXIMUM_UNANSWERED
        return is_below or self._is_holder

    def _has_more(self) -> bool:
        """Return whether a subscribed client has not received everything."""
        cursor = self.cursor
        return cursor is not None and self._journal.has_more(cursor)

    def _read(self) -> None:
        try:
            data = self._connection.recv(_CHUNK)
        except BlockingIOError:
            return
        except OSError:
            self.close()
            return
        self._received += data
        if not data:
            self._is_last = True
        elif self.cursor is not None:
            self._service.subscribers.heard(self.cursor)

    def _serve(self) -> None:
        """Answer requests as long as there is room for their answers."""
        for _ in range(_REQUESTS_PER_TURN):
            has_room = self.label is not None or self._has_room()
            if not self.is_open or self._is_waiting or not has_room:
                break
            line, end, rest = self._received.partition(b'\n')
            if not end:
                longest = protocol.MAXIMUM_REQUEST
                if self._is_holder:
                    longest = protocol.MAXIMUM_HOLDER_REQUEST
                if len(line) > longest:
                    self._refuse('the request is too long')
                break
            self._received = rest
            self._handle(line)
        self._watch()

    def _handle(self, line: bytes) -> None:
        try:
            message = protocol.decode(line)
            if self.label is not None:
                keys = protocol.bytes_of(message.get('keys', ''))
                self._service.type(self.label, keys)
                return
            self._ask(message)
        except ProtocolError as error:
            self._refuse(str(error))

    def _ask(self, message: Mapping[str, Any]) -> None:
        """
        Execute a request.

        :raises ProtocolError: when it has a wrong form
        """
        number = message.get('id')
        if not isinstance(number, str | int | None):
            raise ProtocolError("an 'id' is a text or a whole number")
        same = {} if number is None else {'id': number}
        # only with an id does the client know which request an answer is for
        self._is_waiting = number is None
        self._unanswered += 1
        if message.get('request') == 'ping':
            has_rest = bool(self._outgoing) or self._has_more()
            self._speed.update(time.monotonic(), has_rest=has_rest)
        self._service.answer(
            message, lambda answer: self._answer({**answer, **same}), self
        )

    def _answer(self, answer: Mapping[str, Any]) -> None:
        """Send the answer to a request, which others may follow."""
        if self.is_open and self._unanswered:
            self._unanswered -= 1
            if 'id' not in answer:
                self._is_waiting = False
            self.send_message(answer)
            self._watch()

    def _refuse(self, reason: str) -> None:
        self._received = b''
        self._is_last = True
        self._is_waiting = False
        self._unanswered = 0
        if self.cursor is not None:
            self._journal.unsubscribe(self.cursor)
            self.cursor = None
        self.send_message(protocol.failure(reason))

    def _send(self) -> None:
        if not self.is_open:
            return
        if self.cursor is not None and len(self._outgoing) < _SHARE:
            # no more at once, as others have their turn
            data = self._journal.read(self.cursor, _SHARE)
            if data and self.cursor.is_relayed and self._speed.is_slow:
                data = _packed(data)
            self._outgoing += data
        try:
            while self._outgoing:
                sent = self._connection.send(self._outgoing)
                self._speed.bytes += sent
                del self._outgoing[:sent]
                if self._skipped and not self._outgoing:
                    skipped = {'skipped': self._skipped}
                    self._skipped = 0
                    self._outgoing += protocol.encode(skipped)
        except BlockingIOError:
            self._watch()
        except OSError:
            if self._is_holder:
                # its last requests are still to be read
                self._outgoing.clear()
            else:
                self.close()

    def _watch(self) -> None:
        if not self.is_open:
            return
        has_request = b'\n' in self._received
        is_idle = not (self._outgoing or has_request or self._unanswered)
        if self._is_last and is_idle and self.cursor is None:
            self.close()
            return
        has_more = self._has_more()
        if self.cursor is not None and not has_more:
            self._journal.call(self._watch)
        may_serve = not self._is_waiting and self._may_ask_more()
        waits = self._outgoing or has_more or (has_request and may_serve)
        descriptor = self._connection.fileno()
        if waits:
            self._loop.add_writer(descriptor, self._writable)
        else:
            self._loop.remove_writer(descriptor)
        if self._may_read():
            self._loop.add_reader(descriptor, self._readable)
        else:
            self._loop.remove_reader(descriptor)


class _Speed:
    """How fast a connection is."""

    def __init__(self) -> None:
        #: Whether it is slow.
        self.is_slow = False
        #: The bytes that it has taken since the last look.
        self.bytes = 0
        self._since = time.monotonic()
        self._had_rest = False

    def update(self, now: float, *, has_rest: bool) -> None:
        """
        Find out whether it is slow.

        :param has_rest: Whether there is something that it has not taken
        """
        seconds = now - self._since
        if seconds >= _LOOK:
            is_busy = self._had_rest and has_rest
            self.is_slow = is_busy and self.bytes < _SLOW * seconds
            self.bytes, self._since, self._had_rest = 0, now, has_rest


def _packed(data: bytes) -> bytes:
    """Return messages as one that has them compressed."""
    # most connections are fast
    import zlib

    return protocol.encode_raw('packed', {}, zlib.compress(data, 1)) + b'\n'
