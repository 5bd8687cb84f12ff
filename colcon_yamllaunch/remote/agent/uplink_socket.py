# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One connection of the engine of a part, by which it speaks with us."""

from collections.abc import Iterator
from contextlib import suppress
import os
import select
import socket
import time

from colcon_yamllaunch.remote.wire.frames import Frame
from colcon_yamllaunch.remote.wire.frames import FrameReader
from colcon_yamllaunch.remote.wire.numbered import Outbox

_READ = 256 * 1024
_BATCH = 256 * 1024
#: Of a second: how long a link must have been busy to be slow.
_BUSY = 0.5


class UplinkSocket:
    """A connection that is never waited for."""

    def __init__(self, connection: socket.socket) -> None:
        connection.setblocking(False)
        self._connection = connection
        self._reader = FrameReader()
        self._unsent = bytearray()
        self._blocked_since: float | None = None
        self._blocked = 0.0
        self._bytes = 0
        self._since = time.monotonic()
        #: The descriptor to wait for.
        self.descriptor = connection.fileno()
        #: Whether the other end is gone, or has sent something else.
        self.is_broken = False

    @property
    def mask(self) -> int:
        """What it is waited for."""
        return select.EPOLLIN | (select.EPOLLOUT if self._unsent else 0)

    def read(self) -> Iterator[Frame]:
        """
        Iterate over the frames that have come.

        :raises FrameError: when it is something else
        """
        while not self.is_broken:
            try:
                data = os.read(self.descriptor, _READ)
            except BlockingIOError:
                return
            except OSError:
                data = b''
            if not data:
                self.is_broken = True
                return
            yield from self._reader.feed(data)

    def send(self, data: bytes) -> None:
        """Send something before all that waits in the outbox."""
        self._unsent += data
        self._write()

    def flush(self, outbox: Outbox) -> None:
        """Send what the connection takes."""
        while not self.is_broken:
            if not self._unsent:
                if not outbox.has_more:
                    return
                self._unsent += outbox.take(_BATCH)
            if not self._write():
                return

    def is_slow(self, now: float, rate: float) -> bool:
        """
        Tell whether it was busy since the last call, and yet slow.

        :param now: A time of :func:`time.monotonic`
        :param rate: The bytes a second that are not slow
        """
        if self._blocked_since is not None:
            self._blocked += now - self._blocked_since
            self._blocked_since = now
        seconds = max(now - self._since, 1e-3)
        slow = self._blocked > _BUSY * seconds and self._bytes < rate * seconds
        self._blocked, self._bytes, self._since = 0.0, 0, now
        return slow

    def close(self) -> None:
        """Close it."""
        with suppress(OSError):
            self._connection.close()
        self.is_broken = True

    def _write(self) -> bool:
        """Write what waits, and return whether nothing does any more."""
        try:
            while self._unsent:
                count = os.write(self.descriptor, self._unsent)
                self._bytes += count
                del self._unsent[:count]
        except BlockingIOError:
            if self._blocked_since is None:
                self._blocked_since = time.monotonic()
            return False
        except OSError:
            # its end shows when we read, behind what it said last
            self._unsent.clear()
            return False
        if self._blocked_since is not None:
            self._blocked += time.monotonic() - self._blocked_since
            self._blocked_since = None
        return True
