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
import fcntl
import os
from pathlib import Path
import sys

from colcon_yamllaunch.engine import limits

_FLAGS = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW


class Quota:
    """
    What the log files of a launch may take together.

    :param limit: In bytes, or None for no limit
    :param files: How many log files there may be, old parts not counted
    :param complain: Is told once that something old is deleted
    :param allowed: Given what the files take and what they are to take,
      returns what they may take on this disk; see
      :meth:`.log_store.LogStore.allowed`
    """

    def __init__(
        self,
        limit: int | None,
        files: int,
        complain: Callable[[str], None],
        allowed: Callable[[int, int], int] | None = None,
    ) -> None:
        self._limit = sys.maxsize if limit is None else limit
        self._files = files
        self._complain = complain
        self._complained = False
        self._allowed = allowed
        # bytes that may be written before the disk is looked at again
        self._left = limits.LOG_MINIMUM if allowed else sys.maxsize
        #: Bytes that all files have now.
        self.used = 0
        self._rotated: deque[LogFile] = deque()
        self._restrict(self._limit)

    def expect(self, files: int) -> None:
        """Take into account that there may be more files."""
        self._files += files
        self._restrict(self._bound)

    def rotated(self, file: 'LogFile') -> None:
        """Take note that a file has one more old part."""
        self._rotated.append(file)

    def make_room(self, size: int) -> None:
        """Delete what is too old to stay when files grow by a size."""
        self._left -= size
        if self._left < 0:
            self._look_at_disk(size)
        while self.used + size > self._bound and self._rotated:
            self.used -= self._rotated.popleft().forget_oldest()
            if not self._complained:
                self._complained = True
                self._complain(self._complaint())

    def _look_at_disk(self, size: int) -> None:
        if self._allowed is not None:
            step = size + min(limits.LOG_STEP, self._part)
            allowed = self._allowed(self.used, self.used + step)
            self._restrict(min(self._limit, allowed))
            self._left = step - size

    def _restrict(self, bound: int) -> None:
        self._bound = bound
        self._part = bound // (2 * max(self._files, limits.LOG_PARTS))
        #: Bytes at which a file is full unless it has large old parts.
        self.share = max(self._part, limits.LOG_PART)

    def _complaint(self) -> str:
        if self._bound == self._limit:
            return (
                'the log files have reached the limit of '
                f'{size_text(self._limit)}: from now on the oldest parts are '
                'deleted; --log-limit gives them more room'
            )
        return (
            'the logs of all launches have reached their limit, or the disk '
            f'is nearly full: with {size_text(self._bound)}, the oldest parts '
            'of the log files are deleted; COLCON_LAUNCH_LOG_TOTAL gives more '
            'room'
        )


class LogFile:
    """
    A file that takes bytes as long as the disk does.

    A file that somebody deleted is made anew, with its folder, so that what
    is written is found and counts.

    :param path: The file, which is appended to
    :param quota: What it may take
    :raises OSError: when it cannot be opened
    """

    def __init__(self, path: Path, quota: Quota) -> None:
        self.path = path
        self._quota = quota
        self._descriptor = _opened(path)
        self._size = os.fstat(self._descriptor).st_size
        quota.used += self._size
        self._parts: deque[int] = deque()
        self._parts_size = 0
        self._is_mid_line = False
        # a rotation that failed is tried again with this size
        self._postponed = 0
        # whether the file has become an old part, and no other could be made
        self._is_astray = False

    def write(self, data: bytes) -> None:
        """
        Append to the file at once.

        :param data: Whole lines, or any part of what comes; a line that is
          no longer than :data:`.limits.LOG_LINE` is not torn by a rotation
        :raises OSError: when the disk is full, for instance
        """
        # asked each time, as it takes a microsecond, and nothing is lost
        if self._is_astray or not os.fstat(self._descriptor).st_nlink:
            self._make_anew()
        excess = self._size + len(data) - self._full
        if self._size and excess > 0 and not self._is_astray:
            end = data.find(b'\n') + 1 if self._is_mid_line else 0
            if end:
                self._append(data[:end])
                data = data[end:]
            if not self._is_mid_line or excess > limits.LOG_LINE:
                self._rotate()
        if data:
            self._append(data)

    def forget_oldest(self) -> int:
        """Delete the oldest part, and return the size that it had."""
        if not self._parts:
            # somebody deleted them all
            return 0
        with suppress(OSError):
            self._part(len(self._parts)).unlink()
        size = self._parts.pop()
        self._parts_size -= size
        return size

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)

    @property
    def _full(self) -> int:
        return max(
            self._quota.share,
            self._parts_size // limits.LOG_PARTS,
            self._postponed,
        )

    def _append(self, data: bytes) -> None:
        self._quota.make_room(len(data))
        view = memoryview(data)
        while view:
            written = os.write(self._descriptor, view)
            self._size += written
            self._quota.used += written
            view = view[written:]
        self._is_mid_line = not data.endswith(b'\n')

    def _rotate(self) -> None:
        try:
            for number in range(len(self._parts), -1, -1):
                # somebody may have deleted it to have more room
                with suppress(FileNotFoundError):
                    os.rename(self._part(number), self._part(number + 1))
        except OSError:
            # somebody else is at work in the folder
            self._postponed = self._size + limits.LOG_PART
            return
        self._parts.appendleft(self._size)
        self._parts_size += self._size
        self._size = 0
        self._postponed = 0
        self._quota.rotated(self)
        self._is_astray = True
        self._make_anew()

    def _make_anew(self) -> None:
        """Open another file by the path, if that is possible now."""
        try:
            try:
                descriptor = _opened(self.path)
            except FileNotFoundError:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                descriptor = _opened(self.path)
        except OSError:
            return
        os.close(self._descriptor)
        self._descriptor = descriptor
        if self._is_astray and self._parts:
            # what came since then went into the part
            self._parts[0] += self._size
            self._parts_size += self._size
        else:
            self._quota.used -= self._size
            self._forget_deleted_parts()
        self._is_astray = False
        self._size = 0
        self._is_mid_line = False

    def _forget_deleted_parts(self) -> None:
        if self._parts and not self._part(1).exists():
            self._quota.used -= self._parts_size
            self._parts.clear()
            self._parts_size = 0

    def _part(self, number: int) -> Path:
        if not number:
            return self.path
        return self.path.with_name(f'{self.path.name}.{number}')


def _opened(path: Path) -> int:
    return os.open(path, _FLAGS, 0o644)


def lock_folder(folder: Path, operation: int = fcntl.LOCK_SH) -> int | None:
    """
    Return a descriptor that holds a lock on a folder, None for no lock.

    Each launch holds one on its own folder, so that no other deletes it.
    """
    flags = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
    try:
        descriptor = os.open(folder, flags)
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, operation)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor


def size_text(size: int) -> str:
    """Return a number of bytes in the largest unit that fits, as 2 GB."""
    for factor, unit in ((10**9, 'GB'), (10**6, 'MB'), (10**3, 'kB')):
        if size >= factor:
            return f'{size / factor:.4g} {unit}'
    return f'{size} bytes'
