# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
How the files of a package's source changed since it was built.

Links from the build and install space to the source show some edits without
another build (:func:`live_files`).
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from enum import IntEnum
import os
from pathlib import Path
import re
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.fingerprint import (
    content_digest,
    Fingerprint,
    fingerprint,
    has_same_content,
    with_content,
)
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.freshness.build_record import Record
from colcon_yamllaunch.workspace.packages.package import (
    entries_of,
    source_files,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.workspace.freshness.build_inputs import BuildInputs


#: That of a file that was written while it was built from: no file is so.
_UNKNOWN = Fingerprint(-1, 0, False)
#: That of one that was not there when the build began.
_ABSENT = Fingerprint(-2, 0, False)


#: What is compiled, configured or generated from, wherever it is linked to.
HEADER_SUFFIXES = ('.h', '.hh', '.hpp', '.hxx', '.inl', '.ipp', '.tpp', '.cuh')
#: What only compilers read.
SOURCE_SUFFIXES = frozenset(
    ('.c', '.cc', '.cpp', '.cxx', '.cu', '.s', '.f', '.f90', '.rs')
)
_TEMPLATES = ('.cmake', '.in', '.em', '.ui', '.qrc', '.proto', '.pyx', '.pxd')
#: Interfaces that code is generated from.
INTERFACE_SUFFIXES = ('.msg', '.srv', '.action', '.idl')
#: The metadata of a package in pyproject.toml (PEP 621); not compiled, as each
#: launch imports this module and few builds need it.
_PROJECT_TABLE = r'(?m)^\s*\[\s*project\s*\]'
_COMPILED_SUFFIXES = frozenset(
    (*HEADER_SUFFIXES, *SOURCE_SUFFIXES, *_TEMPLATES, *INTERFACE_SUFFIXES)
)
_COMPILED_NAMES = (
    *('CMakeLists.txt', 'CMakePresets.json', 'Makefile', 'package.xml'),
    *('setup.py', 'setup.cfg', 'pyproject.toml'),
)


class Kind(IntEnum):
    """What happened to a file, in the order of the reasons."""

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
class SourceChange:
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
    Return the fingerprints of the files that a build will read.

    They are the files of the package's source, and those elsewhere that its
    last build read.

    :param known: Earlier fingerprints; only files that were written since are
      read
    """
    now = _fingerprints(folder, filter(os.path.isabs, known))
    return {
        name: with_content(folder / name, found, known.get(name))
        for name, found in now.items()
    }


def with_sources(
    record: Record, folder: Path, read: Iterable[Path], started: int
) -> Record:
    """
    Return the record of a build with the fingerprints of its source.

    A file that was written during the build has no fingerprint: the build may
    have read it before or after that. But a file with the same content after
    two builds that both wrote it was written by these builds.

    :param record: As it was when the build started: its files are the
      :func:`snapshot` before it, the others those of the last build
    :param folder: The source of the package
    :param read: What was read from elsewhere, as it turned out
    :param started: When the build started (nanoseconds)
    """
    before = record.files
    outside = {str(path) for path in read}
    now = _fingerprints(folder, outside)
    files: dict[str, Fingerprint] = {}
    written, generated = set(), set(record.generated)
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
            if name in record.written and has_same_content(path, then, found):
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
    return replace(
        record,
        files=files,
        written=frozenset(written),
        generated=frozenset(generated.intersection(files)),
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
) -> tuple[SourceChange, ...]:
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
            found.append(SourceChange(Kind.NEW, relative, status.st_mtime_ns))
        elif relative not in ignored:
            now = Fingerprint.of(status)
            found += _change(folder, relative, before[relative], now)
    for relative in missing:
        outside = fingerprint(relative) if os.path.isabs(relative) else None
        if outside is None:
            found.append(SourceChange(Kind.DELETED, relative))
        else:
            found += _change(folder, relative, before[relative], outside)
    return tuple(sorted(found, key=lambda change: (change.kind, change.path)))


def with_changes(
    folder: Path,
    before: Mapping[str, Fingerprint],
    found: Iterable[SourceChange],
) -> dict[str, Fingerprint]:
    """Return fingerprints that include changes which do not matter."""
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
) -> list[SourceChange]:
    if before == _ABSENT:
        return [SourceChange(Kind.NEW, relative, now.mtime)]
    if not has_same_content(folder / relative, before, now):
        return [SourceChange(Kind.CHANGED, relative, now.mtime)]
    if before.executable != now.executable:
        return [SourceChange(Kind.MODE, relative, now.mtime)]
    return []


def live_files(
    source: Path,
    files: Iterable[str],
    build: Path,
    installed: Collection[Path],
    inputs: 'BuildInputs',
) -> frozenset[str]:
    """
    Return the source files whose edits show at once, without another build.

    A file is live when it is reached by a link from the install space, or by
    a linked folder in the build space (Python packages), and when no copy of
    it was installed and the build itself does not read it. In doubt it is not.

    :param files: Its files, relative to it
    :param build: The package's folder in the build space
    :param installed: The files of the package in the install space
    """
    real = Path(os.path.realpath(source))
    links = {path for path in installed if path.is_symlink()}
    copies = {path.name for path in installed if path not in links}
    if os.path.isdir(build):
        links |= {
            p for p in build.iterdir() if p.is_symlink() and os.path.isdir(p)
        }
    targets = [Path(os.path.realpath(path)) for path in links]
    linked = {t.relative_to(real) for t in targets if t.is_relative_to(real)}
    live = {
        str(path)
        for path in map(Path, files)
        if not linked.isdisjoint((path, *path.parents))
        and path.name not in copies
        and path.name not in _COMPILED_NAMES
        and path.suffix.lower() not in _COMPILED_SUFFIXES
    }
    read = {relative for relative in live if inputs.reads(relative)}
    # a program that the build runs may import what lies beside it
    folders = {os.path.dirname(r) for r in read if r.endswith('.py')}
    return frozenset(
        relative
        for relative in live - read
        if not relative.endswith('.py')
        or os.path.dirname(relative) not in folders
    )


def link_project(source: Path, build: Path) -> None:
    """
    Link the pyproject.toml of a Python package into its build folder.

    With `--symlink-install` colcon-core runs setuptools there, and links
    setup.py and setup.cfg only. Where setup.py is but a call of `setup()` and
    the metadata is in pyproject.toml, setuptools would not find it.

    :param build: The package's folder in the build space, which exists
    """
    project = source / 'pyproject.toml'
    if 'setup()' in text_of(source / 'setup.py') and re.search(
        _PROJECT_TABLE, text_of(project)
    ):
        # it may be there already
        with suppress(OSError):
            (build / project.name).symlink_to(project)


def remove_dangling_links(folder: Path, source: Path) -> None:
    """
    Remove links into a package's source whose files are gone.

    A build after a linked file was deleted may trip over them, or leaves them
    (colcon-core issue 692).

    :param folder: Where they may be, below the build or install space
    """
    own = f'{os.path.realpath(source)}{os.sep}'
    for path in list(_links(os.fspath(folder))):
        if not os.path.exists(path) and os.path.realpath(path).startswith(own):
            os.unlink(path)


def _links(folder: str) -> Iterator[str]:
    """Iterate over the links below a folder."""
    for entry in entries_of(folder):
        if entry.is_symlink():
            yield entry.path
        elif entry.is_dir(follow_symlinks=False):
            yield from _links(entry.path)


def tree(folder: Path) -> Iterator[Path]:
    """Iterate over the files and links below a folder."""
    for current, folders, files in os.walk(folder):
        for name in files:
            yield Path(current, name)
        for name in folders:
            if (path := Path(current, name)).is_symlink():
                yield path
