# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One client of a running launch, as the launch sees it."""

from collections.abc import Callable
from collections.abc import Mapping
import select
import socket
from typing import Any

from colcon_yamllaunch.runtime.control import protocol
from colcon_yamllaunch.runtime.control.protocol import ProtocolError
from colcon_yamllaunch.runtime.control.service import Service
from colcon_yamllaunch.runtime.core.events import Stream
from colcon_yamllaunch.runtime.streams.watches import Watches

# so that a client with many requests does not keep others from their turn
_REQUESTS_PER_TURN = 8
_CHUNK = 64 * 1024
_GONE = select.EPOLLERR | select.EPOLLHUP


class Client:
    """
    A connection to a client.

    No client makes the launch wait or need more memory: as long as one does
    not take its answers, or waits for one, its requests are not read, and
    output that it is too slow for is skipped.

    :param connection: The connection, which does not block
    :param left: Is called when it is gone
    """

    def __init__(
        self,
        connection: socket.socket,
        watches: Watches,
        service: Service,
        left: Callable[['Client'], None],
    ) -> None:
        self._connection = connection
        self._watches = watches
        self._service = service
        self._left = left
        self._received = b''
        self._outgoing = bytearray()
        self._skipped = 0
        self._label: str | None = None
        # for the answer to a request that takes its time
        self._is_waiting = False
        self._is_last = False
        self._is_open = True
        watches.add(connection.fileno(), self._ready)

    @property
    def is_attached(self) -> bool:
        """Whether the client is attached to a process."""
        return self._label is not None

    def show(self, stream: Stream, data: bytes) -> None:  # noqa: ARG002
        """Send what the process wrote, unless too much waits already."""
        if self._skipped or len(self._outgoing) > protocol.MAXIMUM_BACKLOG:
            self._skipped += len(data)
        else:
            self.tell({'output': protocol.text_of(data)})

    def tell(self, message: Mapping[str, Any]) -> None:
        """Send a message."""
        self._outgoing += protocol.encode(message)
        self._send()

    def close(self) -> None:
        """End the connection."""
        if not self._is_open:
            return
        self._is_open = False
        if self._label is not None:
            self._service.detach(self._label, self)
        self._watches.remove(self._connection.fileno())
        self._connection.close()
        self._left(self)

    def _ready(self, mask: int) -> None:
        if self._is_waiting and mask & _GONE:
            self.close()
            return
        if mask & select.EPOLLOUT:
            self._send()
        if self._is_open and mask & ~select.EPOLLOUT and self._may_read():
            self._read()
        if self._is_open:
            self._serve()

    def _may_read(self) -> bool:
        if self._is_last or b'\n' in self._received:
            return False
        return self._label is not None or not self._outgoing

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

    def _serve(self) -> None:
        """Do what was asked for, as far as its answers find room."""
        for _ in range(_REQUESTS_PER_TURN):
            if self._is_waiting or (self._outgoing and self._label is None):
                break
            line, end, rest = self._received.partition(b'\n')
            if not end:
                if len(line) > protocol.MAXIMUM_REQUEST:
                    self._refuse('the request is too long')
                break
            self._received = rest
            self._take(line)
            if not self._is_open:
                return
        self._watch()

    def _take(self, line: bytes) -> None:
        try:
            message = protocol.decode(line)
            if self._label is not None:
                keys = protocol.bytes_of(message.get('keys', ''))
                self._service.type(self._label, keys)
                return
            self._is_waiting = True
            label = self._service.answer(message, self._answer)
        except ProtocolError as error:
            self._is_waiting = False
            self._refuse(str(error))
            return
        if label is not None and self._is_open:
            self._label = label
            self._service.attach(label, self)

    def _answer(self, answer: Mapping[str, Any]) -> None:
        """Send the answer to a request, which others may follow."""
        if self._is_open:
            self._is_waiting = False
            self.tell(answer)
            self._watch()

    def _refuse(self, reason: str) -> None:
        self._received = b''
        self._is_last = True
        self.tell(protocol.failure(reason))

    def _send(self) -> None:
        if not self._is_open:
            return
        try:
            while self._outgoing:
                sent = self._connection.send(self._outgoing)
                del self._outgoing[:sent]
                if self._skipped and not self._outgoing:
                    skipped = {'skipped': self._skipped}
                    self._skipped = 0
                    self._outgoing += protocol.encode(skipped)
        except BlockingIOError:
            self._watch()
        except OSError:
            self.close()

    def _watch(self) -> None:
        if not self._is_open:
            return
        if self._is_waiting:
            # it may go away meanwhile
            mask = select.EPOLLIN if self._may_read() else 0
            self._watches.change(self._connection.fileno(), mask)
            return
        has_request = b'\n' in self._received
        if self._is_last and not self._outgoing and not has_request:
            self.close()
            return
        waits = self._outgoing or has_request
        self._watches.change(
            self._connection.fileno(),
            (select.EPOLLOUT if waits else 0)
            | (select.EPOLLIN if self._may_read() else 0),
        )
