# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What became of the files of a package's source since it was built."""

from collections.abc import Iterable
from collections.abc import Mapping
from enum import IntEnum
import os
from pathlib import Path

from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.fingerprint import fingerprint
from colcon_yamllaunch.common.fingerprint import has_same_content
from colcon_yamllaunch.common.fingerprint import with_content
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.packages.source_files import source_files

#: That of a file that was written while it was built from.
_UNKNOWN = Fingerprint(-1, 0, False)


class Kind(IntEnum):
    """What happened to a file, in the order of telling it."""

    NEW = 0
    DELETED = 1
    CHANGED = 2
    MODE = 3


_TEXTS = {
    Kind.NEW: 'new file {}',
    Kind.DELETED: '{} was deleted',
    Kind.CHANGED: '{} changed',
    Kind.MODE: 'the mode of {} changed',
}


@dataclass(frozen=True, slots=True)
class Change:
    """
    A difference between a file then and now.

    :param path: The file, relative to the package
    :param mtime: Its time now (nanoseconds)
    """

    kind: Kind
    path: str
    mtime: int = 0

    def __str__(self) -> str:
        return _TEXTS[self.kind].format(self.path)


def snapshot(
    folder: Path, known: Mapping[str, Fingerprint]
) -> dict[str, Fingerprint]:
    """
    Return what all files of a package's source are like, with their content.

    :param known: What they were like before, so that only those that were
      written since are read
    """
    return {
        relative: with_content(
            folder / relative, Fingerprint.of(status), known.get(relative)
        )
        for relative, status in source_files(folder)
    }


def snapshot_of(paths: Iterable[Path], started: int) -> dict[str, Fingerprint]:
    """
    Return what files are like that turned out to matter after a build.

    :param started: When the build started (nanoseconds); what a file that was
      written since was built like is not known
    """
    found = {}
    for path in paths:
        now = fingerprint(str(path))
        if now is not None:
            is_older = now.mtime < started
            found[str(path)] = (
                with_content(path, now, None) if is_older else _UNKNOWN
            )
    return found


def changes(
    folder: Path, before: Mapping[str, Fingerprint], ignored: frozenset[str]
) -> tuple[Change, ...]:
    """
    Return the differences between a package's source then and now.

    New files come first, then deleted ones, then changed ones.

    :param before: What its files were like; one that is named by an absolute
      path does not belong to the source, but matters as well
    :param ignored: Files whose content does not matter
    """
    missing = set(before)
    found = []
    for relative, status in source_files(folder):
        missing.discard(relative)
        if relative not in before:
            found.append(Change(Kind.NEW, relative, status.st_mtime_ns))
        elif relative not in ignored:
            now = Fingerprint.of(status)
            found += _change(folder, relative, before[relative], now)
    for relative in missing:
        outside = fingerprint(relative) if os.path.isabs(relative) else None
        if outside is None:
            found.append(Change(Kind.DELETED, relative))
        else:
            found += _change(folder, relative, before[relative], outside)
    return tuple(sorted(found, key=lambda change: (change.kind, change.path)))


def _change(
    folder: Path, relative: str, before: Fingerprint, now: Fingerprint
) -> list[Change]:
    if not has_same_content(folder / relative, before, now):
        return [Change(Kind.CHANGED, relative, now.mtime)]
    if before.executable != now.executable:
        return [Change(Kind.MODE, relative, now.mtime)]
    return []
