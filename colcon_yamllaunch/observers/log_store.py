# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The log folders of all launches, which share limits.

The oldest folders are deleted, but never that of a running launch, which holds
a lock on it. The age of a folder is a number that it gets when it is first
seen, as its name and times are wrong after the clock was set back. An index
file beside the folders has these numbers, and the sizes of folders whose
launches have ended.
"""

from collections.abc import Iterator
from contextlib import suppress
import fcntl
import os
from pathlib import Path
import re
import shutil
import stat
import sys
from typing import Any

from colcon_yamllaunch.common.files import read_json, write_json
from colcon_yamllaunch.common.frozen import mutable
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.observers.log_files import (
    COMMON_LOG,
    EVENT_LOG,
    lock_folder,
)

#: The name of the file that has the ages and sizes of the folders.
INDEX_NAME = '.colcon_launch_logs.json'

# as colcon names them, and log_folder_of() where there is no workspace
_NAME = re.compile(r'launch_(\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d)(?:_(\d+))?')
# files that identify a folder as one of ours; the second is colcon's own log
# of a command that launched nothing
_OURS = (EVENT_LOG, 'logger_all.log')
_LINKS = ('latest', 'latest_launch')


@mutable
class _Folder:
    """
    The folder of another launch.

    :param number: Its age: the oldest has the lowest
    :param size: What its files take, in bytes, or None as long as its launch
      runs
    :param ran: Whether it launched anything
    """

    name: str
    number: int
    size: int | None
    ran: bool


class LogStore:
    """
    The log folders, as one launch sees them.

    :param folder: The folder of the launch, which stays
    :param kept: How many folders stay of launches that ran, and as many of
      those that launched nothing; None for all
    :param limit: What all folders may take together, in bytes; less if the
      disk gets full. None for no limit
    """

    def __init__(
        self, folder: Path, kept: int | None, limit: int | None
    ) -> None:
        self._base = folder.parent
        self._own = folder.name
        self._own_number = 0
        self.kept = kept
        self.limit = limit
        #: The others, the oldest first.
        self._folders: list[_Folder] = []
        self._protected: set[str] = set()
        self._work = self._tidy()
        self._spare: int | None = None

    def tidy(self) -> bool:
        """
        Do one step of the clean-up, such as deleting a folder.

        Return whether there are more steps.
        """
        return next(self._work, False)

    def allowed(self, used: int, wanted: int) -> int:
        """
        Make room for the files of this launch by deleting older folders.

        :param used: What they take, in bytes
        :param wanted: What they are to take
        :returns: What they may take
        """
        if self.limit is None:
            return sys.maxsize
        while self.tidy():
            continue
        # nodes may keep logs of their own in the folder of the launch
        beside = max(0, _size_of(self._base / self._own) - used)
        others = beside + self._others()
        self._delete_oldest(others + wanted - self.limit)
        others = beside + self._others()
        # delete no more than this launch writes: if other programs fill the
        # disk, old logs need not make room for them
        short = self._missing_space() + wanted - used
        self._delete_oldest(min(short, wanted - used))
        room = max(0, -self._missing_space())
        allowed = min(self.limit - others, used + room)
        return max(allowed, limits.MINIMUM_LOG_BYTES)

    def _tidy(self) -> Iterator[bool]:
        index = self._read()
        yield True
        for folder in self._excess_folders():
            if self._delete(folder):
                yield True
        for folder in self._folders:
            path = self._base / folder.name
            if folder.size is None:
                lock = lock_folder(path, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if lock is not None:
                    os.close(lock)
                    folder.size = _size_of(path)
                    folder.ran = (path / COMMON_LOG).exists()
                    yield True
        if self._index() != index:
            write_json(self._base / INDEX_NAME, self._index())

    def _read(self) -> dict[str, Any]:
        """Find the folders, and return what the file says of them."""
        index = read_json(self._base / INDEX_NAME)
        index = index if isinstance(index, dict) else {}
        found = []
        unknown = []
        for name, age in _folders(self._base):
            match index.get(name):
                case [int(number), (int() | None) as size, bool(ran)]:
                    found.append(_Folder(name, number, size, ran))
                case _:
                    unknown.append((age, name))
        last = max((f.number for f in found), default=0)
        # this launch is the latest, whatever the clock says
        unknown.sort(key=lambda one: (one[1] == self._own, *one))
        for number, (_, name) in enumerate(unknown, last + 1):
            ran = (self._base / name / COMMON_LOG).exists()
            found.append(_Folder(name, number, None, ran))
        found.sort(key=lambda f: f.number)
        for folder in found:
            if folder.name == self._own:
                self._own_number = folder.number
            else:
                self._folders.append(folder)
        base = self._base.resolve()
        for link in _LINKS:
            target = (self._base / link).resolve()
            if target.parent == base:
                self._protected.add(target.name)
        return index

    def _index(self) -> dict[str, Any]:
        index = {f.name: [f.number, f.size, f.ran] for f in self._folders}
        return {**index, self._own: [self._own_number, None, True]}

    def _excess_folders(self) -> list[_Folder]:
        """Return the folders that are too many, the oldest first."""
        if self.kept is None:
            return []
        found = []
        for ran in (True, False):
            alike = [
                f
                for f in self._folders
                if f.ran == ran and f.name not in self._protected
            ]
            found += alike[: max(0, len(alike) - self.kept)]
        return found

    def _delete_oldest(self, size: int) -> None:
        """Delete old folders until they took a size."""
        for folder in tuple(self._folders):
            if size <= 0:
                return
            if folder.name not in self._protected:
                taken = self._size(folder)
                if self._delete(folder):
                    size -= taken

    def _delete(self, folder: _Folder) -> bool:
        """Delete a folder if it is ours and its launch does not run."""
        path = self._base / folder.name
        descriptor = lock_folder(path, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if descriptor is None:
            return False
        try:
            if not _is_ours(path):
                return False
            shutil.rmtree(path, ignore_errors=True)
        finally:
            os.close(descriptor)
        if path.exists():
            return False
        self._folders.remove(folder)
        return True

    def _others(self) -> int:
        return sum(self._size(folder) for folder in self._folders)

    def _size(self, folder: _Folder) -> int:
        if folder.size is None:
            return _size_of(self._base / folder.name)
        return folder.size

    def _missing_space(self) -> int:
        """Return how many bytes too few are free; below 0 there are more."""
        try:
            disk = os.statvfs(self._base)
        except OSError:
            return -sys.maxsize
        free = disk.f_bavail * disk.f_frsize
        if self._spare is None:
            # on a disk that is almost full already, half of the rest
            spare = disk.f_blocks * disk.f_frsize // limits.FREE_DISK_DIVISOR
            self._spare = min(spare, free // 2)
        return self._spare - free


def _folders(base: Path) -> list[tuple[str, tuple[int, str, int]]]:
    """Return the folders of the user's launches, with their apparent age."""
    found = []
    with suppress(OSError), os.scandir(base) as entries:
        for entry in entries:
            match = _NAME.fullmatch(entry.name)
            if match and entry.is_dir(follow_symlinks=False):
                status = entry.stat(follow_symlinks=False)
                if status.st_uid == os.geteuid():
                    age = status.st_mtime_ns, match[1], int(match[2] or 0)
                    found.append((entry.name, age))
    return found


def _is_ours(folder: Path) -> bool:
    """Return whether a folder has a file that only a launch makes."""
    for name in _OURS:
        with suppress(OSError):
            if stat.S_ISREG((folder / name).lstat().st_mode):
                return True
    return False


def _size_of(folder: Path) -> int:
    """Return what the files in a folder take; no link is followed."""
    size = 0
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            with suppress(OSError):
                if entry.is_dir(follow_symlinks=False):
                    size += _size_of(Path(entry.path))
                else:
                    size += entry.stat(follow_symlinks=False).st_size
    return size
