# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files that a package's source consists of, and what they are like."""

from collections.abc import Iterator
from collections.abc import Mapping
from dataclasses import dataclass
import fnmatch
import hashlib
import os
from pathlib import Path
import stat
import time

from colcon_yamllaunch.workspace.root import IGNORE_MARKERS

#: Larger files are told apart by size and time only (bytes).
HASHED_SIZE = 8 * 1024 * 1024
#: A file that was written so shortly before it was looked at may be written
#: again without another time stamp (nanoseconds).
RACY_AGE = 2_000_000_000

_SKIPPED_FOLDERS = frozenset(
    ('.git', '.hg', '.svn', '.bzr', 'CVS', '.cache', '.vscode', '.idea', '.vs')
) | frozenset(('__pycache__', '.pytest_cache', '.mypy_cache', '.ruff_cache'))
_SKIPPED_FILES = ('*~', '.#*', '#*#', '.*.sw?', '*.pyc', '4913', '.DS_Store')
_BUILD_FOLDERS = frozenset(('build', 'install', 'log'))


@dataclass(frozen=True, slots=True)
class FileState:
    """
    What a file was like.

    :param size: Bytes
    :param mtime: Nanoseconds, or 0 where the time proves nothing
    :param executable: Whether its owner may run it
    :param digest: BLAKE2b of the content, empty for a large or unreadable one
    """

    size: int
    mtime: int
    executable: bool
    digest: str = ''


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
    states = {}
    for relative, status in source_files(folder):
        state = _quick_state(status)
        before = known.get(relative)
        if before is not None and _is_same_file(before, state):
            digest = before.digest
        else:
            digest = _digest(folder / relative, status.st_size)
        # a time in the future is as good as one long ago
        racy = 0 <= now - state.mtime < RACY_AGE
        mtime = 0 if racy else state.mtime
        states[relative] = FileState(
            state.size, mtime, state.executable, digest
        )
    return states


def difference(
    folder: Path, before: Mapping[str, FileState], ignored: frozenset[str]
) -> str | None:
    """
    Get the first difference between a package's source then and now.

    :param folder: The package
    :param before: The state then
    :param ignored: Files whose content does not matter
    :returns: Such as `src/flow.cpp changed`, or None
    """
    missing = set(before)
    changed = []
    for relative, status in source_files(folder):
        state = before.get(relative)
        if state is None:
            changed.append((0, relative))
            continue
        missing.discard(relative)
        if relative not in ignored and not _unchanged(
            folder / relative, state, status
        ):
            changed.append((2, relative))
    changed += [(1, relative) for relative in missing]
    if not changed:
        return None
    kind, relative = min(changed)
    texts = ('new file {}', '{} was deleted', '{} changed')
    return texts[kind].format(relative)


def _unchanged(path: Path, before: FileState, status: os.stat_result) -> bool:
    state = _quick_state(status)
    if (before.size, before.executable) != (state.size, state.executable):
        return False
    if before.mtime == state.mtime:
        return True
    # a checkout there and back, or a copied workspace
    return bool(before.digest) and before.digest == _digest(path, state.size)


def _quick_state(status: os.stat_result) -> FileState:
    executable = bool(status.st_mode & stat.S_IXUSR)
    return FileState(status.st_size, status.st_mtime_ns, executable)


def _is_same_file(before: FileState, now: FileState) -> bool:
    return before.size == now.size and before.mtime == now.mtime


def _digest(path: Path, size: int) -> str:
    if size > HASHED_SIZE or not path.is_file():
        return ''
    try:
        return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()
    except OSError:
        return ''


def _entries(path: str) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(path) as entries:
            return list(entries)
    except OSError:
        return []


def _is_skipped_file(name: str) -> bool:
    return any(fnmatch.fnmatchcase(name, p) for p in _SKIPPED_FILES)


def _is_skipped_folder(entry: os.DirEntry[str]) -> bool:
    if entry.name in _SKIPPED_FOLDERS or entry.name.endswith('.egg-info'):
        return True
    if entry.name not in _BUILD_FOLDERS:
        return False
    return any(
        os.path.lexists(Path(entry.path, marker)) for marker in IGNORE_MARKERS
    )
