# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Log files that rotate, and what all of them may take together.

A file that is full is renamed as logrotate does it: `stdout.log` becomes
`stdout.log.1`, `stdout.log.1` becomes `stdout.log.2`, and so on. It is full
when it reaches its share, which is so small that the files without a number
take no more than half of the limit; and not before it has an eighth of its
old parts, so that there are never many to rename. When the limit is reached,
the oldest of all files with a number is deleted.
"""

from collections import deque
from collections.abc import Callable
from contextlib import suppress
import os
from pathlib import Path
import sys

from colcon_yamllaunch.runtime.core import limits

_FLAGS = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW


class Quota:
    """
    What the log files of a launch may take together.

    :param limit: In bytes, or None for no limit
    :param files: How many log files there may be, old parts not counted
    :param complain: Is told once that something old is deleted
    """

    def __init__(
        self, limit: int | None, files: int, complain: Callable[[str], None]
    ) -> None:
        self._limit = sys.maxsize if limit is None else limit
        parts = 2 * max(files, limits.LOG_PARTS)
        #: Bytes at which a file is full unless it has large old parts.
        self.share = max(self._limit // parts, limits.LOG_PART)
        self._complain = complain
        self._complained = False
        #: Bytes that all files have now.
        self.used = 0
        self._rotated: deque[LogFile] = deque()

    def rotated(self, file: 'LogFile') -> None:
        """Take note that a file has one more old part."""
        self._rotated.append(file)

    def make_room(self, size: int) -> None:
        """Delete what is too old to stay when files grow by a size."""
        while self.used + size > self._limit and self._rotated:
            self.used -= self._rotated.popleft().forget_oldest()
            if not self._complained:
                self._complained = True
                self._complain(
                    'the log files have reached the limit of '
                    f'{size_text(self._limit)}: from now on the oldest parts '
                    'are deleted; --log-limit gives them more room'
                )


class LogFile:
    """
    A file that takes bytes as long as the disk does.

    :param path: The file, which is appended to
    :param quota: What it may take
    :raises OSError: when it cannot be opened
    """

    def __init__(self, path: Path, quota: Quota) -> None:
        self.path = path
        self._quota = quota
        self._share = quota.share
        self._descriptor = os.open(path, _FLAGS, 0o644)
        self._size = 0
        self._parts: deque[int] = deque()
        self._parts_size = 0

    def write(self, data: bytes) -> None:
        """
        Append to the file at once.

        :param data: What is not to be torn by a rotation
        :raises OSError: when the disk is full, for instance
        """
        full = max(self._share, self._parts_size // limits.LOG_PARTS)
        if self._size and self._size + len(data) > full:
            self._rotate()
        self._quota.make_room(len(data))
        view = memoryview(data)
        while view:
            written = os.write(self._descriptor, view)
            self._size += written
            self._quota.used += written
            view = view[written:]

    def forget_oldest(self) -> int:
        """Delete the oldest part, and return the size that it had."""
        with suppress(OSError):
            self._part(len(self._parts)).unlink()
        size = self._parts.pop()
        self._parts_size -= size
        return size

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)

    def _rotate(self) -> None:
        try:
            for number in range(len(self._parts), -1, -1):
                # somebody may have deleted it to have more room
                with suppress(FileNotFoundError):
                    os.rename(self._part(number), self._part(number + 1))
            descriptor = os.open(self.path, _FLAGS, 0o644)
        except OSError:
            # somebody else is at work in the folder: the file just grows
            self._share = sys.maxsize
            return
        os.close(self._descriptor)
        self._descriptor = descriptor
        self._parts.appendleft(self._size)
        self._parts_size += self._size
        self._size = 0
        self._quota.rotated(self)

    def _part(self, number: int) -> Path:
        if not number:
            return self.path
        return self.path.with_name(f'{self.path.name}.{number}')


def size_text(size: int) -> str:
    """Return a number of bytes in the largest unit that fits, as 2 GB."""
    for factor, unit in ((10**9, 'GB'), (10**6, 'MB'), (10**3, 'kB')):
        if size >= factor:
            return f'{size / factor:.4g} {unit}'
    return f'{size} bytes'
