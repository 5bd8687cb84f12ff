# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a launch uses of a package, as of its last successful build.

The record of that build tells which files stand for what is installed. It is
read once, and again when there is another.
"""

from collections.abc import Iterable
from collections.abc import Iterator
from functools import lru_cache
import os
from pathlib import Path
import re
from typing import Protocol

from colcon_yamllaunch.watch.knowledge import PackageUse
from colcon_yamllaunch.workspace.colcon.colcon_cache import CachedColcon
from colcon_yamllaunch.workspace.freshness.build_record import (
    DamagedRecordError,
)
from colcon_yamllaunch.workspace.freshness.build_record import read_record
from colcon_yamllaunch.workspace.freshness.build_record import Record
from colcon_yamllaunch.workspace.freshness.build_record import RECORD_NAME
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

_PYTHON_SUFFIX = '.py'
_LINK = 'link to '
#: As many as a workspace may have packages.
_RECORDS = 10_000


class Workspace(Protocol):
    """The workspace of a launch."""

    @property
    def colcon(self) -> CachedColcon:
        """What knows the packages; there must be a workspace."""

    locator: PackageLocator
    root: Path | None


def record_of(workspace: Workspace, name: str) -> Record | None:
    """Return what is known about the last build of a package."""
    stamp = _stamp(workspace, name)
    return None if stamp is None else _record(*stamp)


def package_use(package: Package, workspace: Workspace) -> PackageUse:
    """Return what is used of a package, as of its last build."""
    stamp = _stamp(workspace, package.name)
    if stamp is None:
        return PackageUse(package.name, str(package.path))
    return _package_use(package.name, str(package.path), stamp)


def _stamp(workspace: Workspace, name: str) -> tuple[str, int, int] | None:
    path = f'{workspace.colcon.build_base}{os.sep}{name}{os.sep}{RECORD_NAME}'
    try:
        status = os.stat(path)
    except OSError:
        return None
    return path, status.st_mtime_ns, status.st_ino


@lru_cache(_RECORDS)
def _record(path: str, _time: int, _inode: int) -> Record | None:
    try:
        return read_record(Path(path))
    except DamagedRecordError:
        return None


@lru_cache(_RECORDS)
def _package_use(
    name: str, path: str, stamp: tuple[str, int, int]
) -> PackageUse:
    record = _record(*stamp)
    if record is None:
        return PackageUse(name, path)
    build = os.path.dirname(stamp[0])
    modules = frozenset(_modules(name, Path(path), record, build))
    return PackageUse(
        name,
        path,
        record.live,
        modules,
        frozenset(map(os.path.dirname, modules)),
        frozenset(filter(os.path.isabs, record.files)),
    )


def _modules(
    name: str, folder: Path, record: Record, build: str
) -> Iterator[str]:
    """
    Iterate over the files that programs in Python import.

    :param build: The package's folder in the build space, where those of
      packages in Python are linked, too
    """
    candidates = [r for r in record.live if r.endswith(_PYTHON_SUFFIX)]
    if not candidates:
        return
    folders = {str(folder), os.path.realpath(folder), build}
    starts = [f'{_LINK}{start}{os.sep}' for start in sorted(folders)]
    data, programs = set(), set()
    for installed, found in record.installed.items():
        for start in starts:
            if not found.digest.startswith(start):
                continue
            parts = installed.split(os.sep)
            target = found.digest[len(start) :].rstrip(os.sep)
            if 'share' in parts:
                data.add(target)
            elif parts[-3:-1] == ['lib', name]:
                programs.add(target)
    imported = _imported(folder, programs)
    for relative in candidates:
        above = {relative, *map(str, Path(relative).parents)}
        if data.isdisjoint(above) and (
            relative not in programs
            or Path(relative).stem in imported
            or not os.access(folder / relative, os.X_OK)
        ):
            yield relative


def _imported(folder: Path, programs: Iterable[str]) -> set[str]:
    """Return the modules that programs import, up to the first dot."""
    found: set[str] = set()
    for program in programs:
        try:
            text = (folder / program).read_text('utf-8')
        except (OSError, UnicodeDecodeError):
            continue
        found.update(re.findall(r'(?m)^\s*(?:from|import)\s+(\w+)', text))
    return found
