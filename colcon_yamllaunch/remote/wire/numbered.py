# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Frames that arrive exactly once, however often the connection is another one.

The sender keeps what the other side has not acknowledged, and sends it again
after a loss from the number that the other side asks for. The receiver passes
over what it has already.
"""

from collections import deque
from contextlib import suppress
import os
from pathlib import Path
import tempfile

from colcon_yamllaunch.remote.wire import frames
from colcon_yamllaunch.remote.wire.frames import Frame
from colcon_yamllaunch.remote.wire.frames import FrameError

#: Bytes that are on their way and not acknowledged at most; what is added
#: then is to wait, or goes to the file.
WINDOW = 8 * 1024 * 1024
#: Bytes that the other side gets before it should acknowledge them.
ACKNOWLEDGED = 512 * 1024
# bytes for a frame that is read from the file
_SIZES = 8


class Outbox:
    """
    What is sent, until it has been acknowledged.

    :param spool: The folder for a file that takes what does not fit in
      memory, or None
    :param limit: Bytes that the file may have, or None; without the rest of
      them output is dropped, but no message
    """

    def __init__(
        self, spool: Path | None = None, limit: int | None = None
    ) -> None:
        self._folder = spool
        self._limit = limit
        self._last = 0
        # frames in memory: number, kind and body
        self._kept: deque[tuple[int, int, bytes]] = deque()
        self._size = 0
        # how many of them have been sent by this connection
        self._sent = 0
        # the last one that has been sent by any
        self._last_sent = 0
        self._file = -1
        self._read_at = self._write_at = 0
        #: Bytes of output that did not fit.
        self.dropped = 0
        #: Whether bodies are packed.
        self.packs = False

    @property
    def is_full(self) -> bool:
        """Whether what is added now goes to the file."""
        return self._size >= WINDOW or self._read_at < self._write_at

    @property
    def is_empty(self) -> bool:
        """Whether everything has been acknowledged."""
        return not self._kept and self._read_at == self._write_at

    @property
    def last(self) -> int:
        """The number of what was added last."""
        return self._last

    def add(self, kind: int, body: bytes) -> bool:
        """
        Have something sent; return False if it was dropped instead.

        It is dropped only if it is output, and neither memory nor file has
        room for it. A message that the disk has no room for goes to memory,
        with all that is before it.
        """
        if self.is_full and self._folder is not None:
            kept = self._spool(kind, body)
            if kept or kind != frames.MESSAGE:
                self.dropped += 0 if kept else len(body)
                return kept
            if self._read_at < self._write_at:
                # behind what the file has; it need not stay in order then
                self._load(limit=None)
        self._last += 1
        self._keep(self._last, kind, body)
        return True

    def take(self, size: int) -> bytes:
        """
        Return what is to be sent next.

        :param size: Bytes after which no further frame is begun
        """
        taken = []
        count = 0
        while count < size and self._sent < len(self._kept):
            number, kind, body = self._kept[self._sent]
            data = frames.encode(kind, body, number, packed=self.packs)
            taken.append(data)
            count += len(data)
            self._sent += 1
            self._last_sent = max(self._last_sent, number)
        return b''.join(taken)

    @property
    def has_more(self) -> bool:
        """Whether :meth:`take` has something."""
        return self._sent < len(self._kept)

    def acknowledged(self, number: int) -> None:
        """
        Forget what the other side has.

        :param number: The last one that it has
        :raises FrameError: when that has not been sent
        """
        if not 0 <= number <= self._last_sent:
            raise FrameError('it has received more than it was sent')
        while self._kept and self._kept[0][0] <= number:
            _, _, body = self._kept.popleft()
            self._size -= len(body)
            self._sent = max(0, self._sent - 1)
        self._load(limit=WINDOW)

    def resume(self, number: int) -> None:
        """
        Send again, through another connection.

        :param number: The last one that the other side has
        :raises FrameError: when that has not been sent
        """
        self.acknowledged(number)
        self._sent = 0

    def close(self) -> None:
        """Give the file up."""
        if self._file != -1:
            os.close(self._file)
            self._file = -1

    def _keep(self, number: int, kind: int, body: bytes) -> None:
        self._kept.append((number, kind, body))
        self._size += len(body)

    def _spool(self, kind: int, body: bytes) -> bool:
        """Write something to the file, if it has room."""
        data = len(body).to_bytes(_SIZES, 'big') + bytes([kind]) + body
        # what happened is told in any case, and is little
        if self._limit is not None and kind != frames.MESSAGE:
            used = self._write_at - self._read_at
            if used + len(data) > self._limit:
                return False
        if self._file == -1:
            try:
                self._file = _nameless_file(self._folder)
            except OSError:
                return False
        with suppress(OSError):
            if os.pwrite(self._file, data, self._write_at) == len(data):
                self._write_at += len(data)
                return True
        return False

    def _load(self, limit: int | None) -> None:
        """Take from the file what memory has room for."""
        while self._read_at < self._write_at and (
            limit is None or self._size < limit
        ):
            head = os.pread(self._file, _SIZES + 1, self._read_at)
            size = int.from_bytes(head[:_SIZES], 'big')
            start = self._read_at + len(head)
            body = os.pread(self._file, size, start)
            self._read_at = start + size
            self._last += 1
            self._keep(self._last, head[_SIZES], body)
        if self._file != -1 and self._read_at == self._write_at:
            self._read_at = self._write_at = 0
            with suppress(OSError):
                os.ftruncate(self._file, 0)


class Inbox:
    """What has come, and when it is to be acknowledged."""

    def __init__(self) -> None:
        #: The number of what has come last.
        self.last = 0
        self._size = 0

    def is_new(self, frame: Frame) -> bool:
        """
        Tell whether a numbered frame has not come before.

        :raises FrameError: when one before it is missing
        """
        if frame.number <= self.last:
            return False
        if frame.number != self.last + 1:
            raise FrameError('a frame is missing')
        self.last = frame.number
        self._size += len(frame.body)
        return True

    def is_due(self) -> bool:
        """Tell whether what has come should be acknowledged now."""
        if self._size < ACKNOWLEDGED:
            return False
        self._size = 0
        return True


def _nameless_file(folder: Path | None) -> int:
    """
    Open a file that goes with this process.

    :raises OSError: when there is none to be had
    """
    # removed at once, so it cannot be left behind
    descriptor, path = tempfile.mkstemp(prefix='.link-', dir=folder)
    os.unlink(path)
    return descriptor
