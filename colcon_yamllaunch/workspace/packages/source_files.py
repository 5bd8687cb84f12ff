# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files that a package's source consists of, and what they are like."""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from enum import IntEnum
import os
from pathlib import Path
import re
import stat
import time

from colcon_yamllaunch.common.digest import digest as content_digest
from colcon_yamllaunch.common.file_states import RACY_AGE
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.packages.workspace_root import IGNORE_MARKERS

#: Larger files are told apart by size and time only (bytes).
HASHED_SIZE = 8 * 1024 * 1024

_SKIPPED_FOLDERS = (
    frozenset(
        (
            '.git',
            '.hg',
            '.svn',
            '.bzr',
            'CVS',
            '.cache',
            '.vscode',
            '.idea',
            '.vs',
        )
    )
    | frozenset(('__pycache__', '.pytest_cache', '.mypy_cache', '.ruff_cache'))
    | frozenset(('.hypothesis', '.eggs', '.tox', '.nox'))
)
#: Left by editors and by others: *~ .#* #*# .*.sw? *.kate-swp 4913 *.pyc …
_SKIPPED_FILES = re.compile(
    r'.*~|\.#.*|#.*#|\..*\.sw.|.*\.kate-swp|4913'
    r'|.*\.pyc|\.coverage|\.nfs.*|\.fuse_hidden.*|\.DS_Store',
    re.DOTALL,
)
_BUILD_FOLDERS = frozenset(('build', 'install', 'log'))


@dataclass(frozen=True, slots=True)
class FileState:
    """
    What a file was like.

    :param size: Bytes
    :param mtime: Nanoseconds, or 0 where the time proves nothing
    :param executable: Whether its owner may run it
    :param digest: BLAKE2b of the content, empty for a large or unreadable one
    :param ctime: When it was last written or given another time, mode or name
      (nanoseconds); unlike the other time nobody can set it
    """

    size: int
    mtime: int
    executable: bool
    digest: str = ''
    ctime: int = 0


class Kind(IntEnum):
    """What happened to a file, in the order of telling it."""

    NEW = 0
    DELETED = 1
    CHANGED = 2
    MODE = 3


@dataclass(frozen=True, slots=True)
class Change:
    """
    A difference between a file then and now.

    :param kind: What happened
    :param path: The file, relative to the package
    :param mtime: Its time now (nanoseconds)
    """

    kind: Kind
    path: str
    mtime: int = 0

    def __str__(self) -> str:
        texts = {
            Kind.NEW: f'new file {self.path}',
            Kind.DELETED: f'{self.path} was deleted',
            Kind.CHANGED: f'{self.path} changed',
            Kind.MODE: f'the mode of {self.path} changed',
        }
        return texts[self.kind]


def source_files(folder: Path) -> Iterator[tuple[str, os.stat_result]]:
    """
    Iterate over the files of a package's source.

    Left out is what version control, editors, caches and colcon itself put
    there. Symbolic links are followed; a dangling one is a file on its own.

    :param folder: The package
    :returns: For each file its path relative to the folder and its status,
      in no particular order
    """
    pending = [(str(folder), '')]
    seen: set[tuple[int, int]] = set()
    while pending:
        path, below = pending.pop()
        for entry in _entries(path):
            try:
                status = entry.stat()
            except OSError:
                status = entry.stat(follow_symlinks=False)
            relative = below + entry.name
            if not stat.S_ISDIR(status.st_mode):
                if not _is_skipped_file(entry.name):
                    yield relative, status
                continue
            place = (status.st_dev, status.st_ino)
            if place not in seen and not _is_skipped_folder(entry):
                seen.add(place)
                pending.append((entry.path, relative + os.sep))


def snapshot(
    folder: Path, known: Mapping[str, FileState] | None = None
) -> dict[str, FileState]:
    """
    Get the state of all files of a package's source, with their content.

    :param folder: The package
    :param known: An earlier state, whose digests are used again for files
      that have the same size and time
    """
    now = time.time_ns()
    known = known or {}
    return {
        relative: _state(folder / relative, status, known.get(relative), now)
        for relative, status in source_files(folder)
    }


def states_of(paths: Iterable[Path], started: int) -> dict[str, FileState]:
    """
    Get the state of files that turned out to matter after a build.

    :param paths: The files
    :param started: When the build started (nanoseconds); the state of a file
      that was written since is not that which was built, so none is given
    """
    states = {}
    now = time.time_ns()
    for path in paths:
        status = _status(path)
        if status is None:
            continue
        if status.st_mtime_ns < started:
            states[str(path)] = _state(path, status, None, now)
        else:
            states[str(path)] = FileState(-1, 0, False)
    return states


def changes(
    folder: Path, before: Mapping[str, FileState], ignored: frozenset[str]
) -> tuple[Change, ...]:
    """
    Get the differences between a package's source then and now.

    :param folder: The package
    :param before: The state then; a file that is named by an absolute path
      does not belong to the source, but matters as well
    :param ignored: Files whose content does not matter
    :returns: New files first, then deleted ones, then changed ones
    """
    missing = set(before)
    found = []
    for relative, status in source_files(folder):
        state = before.get(relative)
        missing.discard(relative)
        if state is None:
            found.append(Change(Kind.NEW, relative, status.st_mtime_ns))
        elif relative not in ignored:
            found += _change(folder, relative, state, status)
    for relative in missing:
        path = folder / relative
        outside = _status(path) if os.path.isabs(relative) else None
        if outside is None:
            found.append(Change(Kind.DELETED, relative))
        else:
            found += _change(folder, relative, before[relative], outside)
    return tuple(sorted(found, key=lambda change: (change.kind, change.path)))


def _change(
    folder: Path, relative: str, before: FileState, status: os.stat_result
) -> list[Change]:
    if not _has_same_content(folder / relative, before, status):
        return [Change(Kind.CHANGED, relative, status.st_mtime_ns)]
    if before.executable != _quick_state(status).executable:
        return [Change(Kind.MODE, relative, status.st_mtime_ns)]
    return []


def _has_same_content(
    path: Path, before: FileState, status: os.stat_result
) -> bool:
    state = _quick_state(status)
    if before.size != state.size:
        return False
    if (before.mtime, before.ctime) == (state.mtime, state.ctime):
        return True
    if not before.digest and before.mtime == state.mtime:
        return True
    # a checkout there and back, or a copied workspace
    return bool(before.digest) and before.digest == digest(path, state.size)


def _status(path: Path) -> os.stat_result | None:
    try:
        return path.stat()
    except OSError:
        return None


def _state(
    path: Path, status: os.stat_result, before: FileState | None, now: int
) -> FileState:
    state = _quick_state(status)
    if before is not None and _is_same_file(before, state):
        content = before.digest
    else:
        content = digest(path, status.st_size)
    # a time in the future is as good as one long ago
    racy = 0 <= now - state.mtime < RACY_AGE
    mtime = 0 if racy else state.mtime
    return FileState(state.size, mtime, state.executable, content, state.ctime)


def _quick_state(status: os.stat_result) -> FileState:
    executable = bool(status.st_mode & stat.S_IXUSR)
    return FileState(
        status.st_size,
        status.st_mtime_ns,
        executable,
        ctime=status.st_ctime_ns,
    )


def _is_same_file(before: FileState, now: FileState) -> bool:
    return (before.size, before.mtime, before.ctime) == (
        now.size,
        now.mtime,
        now.ctime,
    )


def digest(path: Path, size: int) -> str:
    """Get the BLAKE2b of a file; nothing for a large or unreadable one."""
    if size > HASHED_SIZE or not path.is_file():
        return ''
    try:
        return content_digest(path.read_bytes())
    except OSError:
        return ''


def _entries(path: str) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(path) as entries:
            return list(entries)
    except OSError:
        return []


def _is_skipped_file(name: str) -> bool:
    return _SKIPPED_FILES.fullmatch(name) is not None


def _is_skipped_folder(entry: os.DirEntry[str]) -> bool:
    if entry.name in _SKIPPED_FOLDERS or entry.name.endswith('.egg-info'):
        return True
    if entry.name not in _BUILD_FOLDERS:
        return False
    return any(
        os.path.lexists(Path(entry.path, marker)) for marker in IGNORE_MARKERS
    )
