# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What became of the files of a package's source since it was built."""

from collections.abc import Iterable
from collections.abc import Mapping
from enum import IntEnum
import os
from pathlib import Path

from colcon_yamllaunch.common.fingerprint import content_digest
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.fingerprint import fingerprint
from colcon_yamllaunch.common.fingerprint import has_same_content
from colcon_yamllaunch.common.fingerprint import with_content
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.packages.source_files import source_files

#: That of a file that was written while it was built from: no file is so.
_UNKNOWN = Fingerprint(-1, 0, False)
#: That of one that was not there when the build began.
_ABSENT = Fingerprint(-2, 0, False)


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


@dataclass(frozen=True, slots=True)
class BuiltFrom:
    """
    What files were like that a build was made from.

    :param files: By their paths, as :func:`changes` takes them
    :param written: Those that were written during the build
    :param generated: Those of them that the build writes by itself, and those
      that earlier ones wrote
    """

    files: dict[str, Fingerprint]
    written: frozenset[str] = frozenset()
    generated: frozenset[str] = frozenset()


def snapshot(
    folder: Path, known: Mapping[str, Fingerprint]
) -> dict[str, Fingerprint]:
    """
    Return what the files are like that a build is to be made from.

    They are those of the package's source, and what its last build read from
    elsewhere, with their content.

    :param known: What they were like before, so that only those that were
      written since are read
    """
    now = _fingerprints(folder, filter(os.path.isabs, known))
    return {
        name: with_content(folder / name, found, known.get(name))
        for name, found in now.items()
    }


def built_from(
    folder: Path,
    last: BuiltFrom,
    before: Mapping[str, Fingerprint],
    read: Iterable[Path],
    started: int,
) -> BuiltFrom:
    """
    Return what the files were like that a build was made from.

    What was written during the build is not recorded: it may have been read
    before or after that, even if it is by now as it was. But what has the same
    content after two builds that both wrote it was written by these.

    :param last: As it was returned for the build before
    :param before: The :func:`snapshot` before the build
    :param read: What was read from elsewhere, as it turned out
    :param started: When the build started (nanoseconds)
    """
    outside = {str(path) for path in read}
    now = _fingerprints(folder, outside)
    files: dict[str, Fingerprint] = {}
    written, generated = set(), set(last.generated)
    for name in {*before, *now}:
        path = folder / name
        then, found = before.get(name), now.get(name)
        if os.path.isabs(name) and found is None and os.path.lexists(name):
            # it is not read any more
            continue
        if then is not None and found is not None:
            if _is_untouched(path, then, found):
                files[name] = then
                continue
            if name in last.written and has_same_content(path, then, found):
                generated.add(name)
        elif (
            found is not None
            and name in outside
            and max(found.mtime, found.ctime) < started
        ):
            files[name] = with_content(path, found, None)
            continue
        written.add(name)
        if found is not None and name in generated:
            files[name] = with_content(path, found, then)
        elif then is None and name not in outside:
            files[name] = _ABSENT
        else:
            files[name] = _UNKNOWN
    return BuiltFrom(
        files, frozenset(written), frozenset(generated.intersection(files))
    )


def _fingerprints(
    folder: Path, outside: Iterable[str]
) -> dict[str, Fingerprint]:
    found = {
        relative: Fingerprint.of(status)
        for relative, status in source_files(folder)
    }
    for path in outside:
        now = fingerprint(path)
        if now is not None:
            found[path] = now
    return found


def _is_untouched(path: Path, then: Fingerprint, now: Fingerprint) -> bool:
    if (then.size, then.ctime) != (now.size, now.ctime):
        return False
    if then.mtime:
        return then.mtime == now.mtime
    # it may have been written twice in one tick of the clock
    return then.digest == content_digest(path, now.size)


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


def with_changes(
    folder: Path, before: Mapping[str, Fingerprint], found: Iterable[Change]
) -> dict[str, Fingerprint]:
    """Return what files were like, with changes that do not matter."""
    files = dict(before)
    for change in found:
        path = folder / change.path
        now = fingerprint(str(path))
        files.pop(change.path, None)
        if now is not None:
            files[change.path] = with_content(path, now, None)
    return files


def _change(
    folder: Path, relative: str, before: Fingerprint, now: Fingerprint
) -> list[Change]:
    if before == _ABSENT:
        return [Change(Kind.NEW, relative, now.mtime)]
    if not has_same_content(folder / relative, before, now):
        return [Change(Kind.CHANGED, relative, now.mtime)]
    if before.executable != now.executable:
        return [Change(Kind.MODE, relative, now.mtime)]
    return []
