# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Writing to a screen that may be slow, without waiting for it."""

from collections import deque
import errno
from itertools import islice
import os
import select
import stat
from typing import TextIO

from colcon_yamllaunch.engine import limits

# a full disk may have room again, and a file that is too large be truncated;
# anything else stays as it is
_PASSING = frozenset((errno.ENOSPC, errno.EDQUOT, errno.EFBIG))

# what a pipe that is ready takes for sure (POSIX, PIPE_BUF on Linux)
_SAFE_SIZE = 4096


class Writer:
    """
    Writes to a file descriptor what is to be shown.

    A key names the stream that something comes from. The descriptor itself
    stays as it is: its other users, such as the shell, would not bear
    O_NONBLOCK. A pipe and a terminal are opened once more.
    """

    def __init__(self, descriptor: int) -> None:
        #: What to wait for until it takes more, or -1 if there is no wait.
        self.descriptor = -1
        self._is_terminal = False
        if descriptor != -1:
            self._is_terminal = os.isatty(descriptor)
            self.descriptor, self._careful = _open_again(descriptor)
        #: Why output could not be shown although it has a reader.
        self.error: OSError | None = None
        #: Whether there is no reader any more; then everything is dropped.
        self.broken = False
        self._queue: deque[tuple[object, bytes | memoryview]] = deque()
        self._total = 0
        self._shares: dict[object, int] = {}

    def write(self, key: object, data: bytes) -> None:
        """Add data to what the next :meth:`flush` shows."""
        if not self.broken:
            self._add(key, data)

    def write_raw(self, key: object, data: bytes) -> None:
        """Add the unchanged output of the process that has the keyboard."""
        self.write(key, data)

    def steer(self, data: bytes) -> None:
        """Add control sequences, such as the title of a window."""
        self.write(None, data)

    def due(self) -> float | None:
        """Return the time when :meth:`flush` has more to do, or None."""
        return None

    def flush(self) -> None:
        """Show as much as can be shown without waiting."""
        try:
            while self._queue and self._write_some():
                continue
        except BlockingIOError:
            return
        except (BrokenPipeError, ConnectionError):
            self.give_up()
        except OSError as error:
            self._drop()
            self.broken = error.errno not in _PASSING
            # a terminal that was closed fails, too, but has no reader
            if not self._is_terminal:
                self.error = self.error or error

    def accepts(self, key: object) -> bool:
        """Return whether a stream may add to what is pending."""
        share = self._shares.get(key, 0)
        if self._total > limits.SCREEN_BACKLOG_BYTES:
            return share == 0 and self._total < limits.SCREEN_MAXIMUM_BYTES
        return share < limits.STREAM_BACKLOG_BYTES

    def waits(self) -> bool:
        """Return whether output is pending."""
        return bool(self._queue)

    def give_up(self) -> None:
        """Drop everything from now on, as there is no reader."""
        self._drop()
        self.broken = True

    def close(self) -> None:
        """Drop the rest, and free what is needed for writing."""
        self._drop()
        os.close(self.descriptor)

    def _add(self, key: object, data: bytes | memoryview) -> None:
        if data:
            self._queue.append((key, data))
            self._total += len(data)
            self._shares[key] = self._shares.get(key, 0) + len(data)

    def _write_some(self) -> bool:
        if self._careful:
            if not _is_ready(self.descriptor):
                return False
            written = os.write(self.descriptor, self._queue[0][1][:_SAFE_SIZE])
        else:
            written = os.writev(self.descriptor, self._batch())
        self._took(written)
        return True

    def _batch(self) -> list[bytes | memoryview]:
        """Return what may be taken at once; a terminal takes little."""
        pieces = []
        size = 0
        for _, data in islice(self._queue, limits.WRITE_BATCH_PIECES):
            pieces.append(data)
            size += len(data)
            if size >= limits.READ_BYTES:
                break
        return pieces

    def _took(self, size: int) -> None:
        self._total -= size
        while size:
            key, data = self._queue[0]
            if size < len(data):
                self._queue[0] = (key, memoryview(data)[size:])
                self._shares[key] -= size
                return
            self._queue.popleft()
            size -= len(data)
            self._shares[key] -= len(data)
            if not self._shares[key]:
                del self._shares[key]

    def _drop(self) -> None:
        self._queue.clear()
        self._shares.clear()
        self._total = 0


class TextWriter(Writer):
    """
    Writes to a text stream that is no file of the system.

    :param stream: The stream, which is not ours to close
    """

    def __init__(self, stream: TextIO) -> None:
        super().__init__(-1)
        self._stream = stream

    def write(self, key: object, data: bytes) -> None:  # noqa: ARG002, D102
        self._stream.write(data.decode(errors='replace'))

    def flush(self) -> None:  # noqa: D102
        self._stream.flush()

    def close(self) -> None:  # noqa: D102
        return


def _open_again(descriptor: int) -> tuple[int, bool]:
    """Return a descriptor of our own, and whether writing to it may wait."""
    mode = os.fstat(descriptor).st_mode
    if stat.S_ISFIFO(mode) or os.isatty(descriptor):
        flags = os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
        try:
            return os.open(f'/proc/self/fd/{descriptor}', flags), False
        except OSError:
            # a terminal of another user, or a pipe without a reader
            return os.dup(descriptor), True
    return os.dup(descriptor), stat.S_ISSOCK(mode)


def _is_ready(descriptor: int) -> bool:
    poll = select.poll()
    poll.register(descriptor, select.POLLOUT)
    return bool(poll.poll(0))
