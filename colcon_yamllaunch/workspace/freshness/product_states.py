# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a build produced is like, and whether it still is so.

Products are those files of the build folder that later steps of a build, or
what is installed, are made of or linked to. Left out is what tests, programs
and colcon write there, such as `Testing`, `test_results` and logs.
"""

from collections.abc import Collection
from collections.abc import Iterator
from collections.abc import Mapping
import os
from pathlib import Path
import re
import stat
import sys

from colcon_yamllaunch.common.fingerprint import digest
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.fingerprint import with_content
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.freshness.source_links import HEADER_SUFFIXES
from colcon_yamllaunch.workspace.freshness.source_links import (
    INTERFACE_SUFFIXES,
)
from colcon_yamllaunch.workspace.freshness.source_links import SOURCE_SUFFIXES

CACHE = 'CMakeCache.txt'
#: What CMake writes for the build tool.
CONFIGURED = frozenset(
    (
        *(CACHE, 'cmake_install.cmake', 'Makefile', 'Makefile2'),
        *('build.make', 'flags.make', 'link.txt'),
        *('build.ninja', 'rules.ninja'),
    )
)
#: What compilers and linkers write, beside programs; not compiled, as each
#: launch imports this module and few need it.
_COMPILED = r'.+\.(?:o|obj|lo|a|so(?:\.[\d.]+)?|mod|gch|pch)'
_CODE = ('.py', *HEADER_SUFFIXES, *SOURCE_SUFFIXES, *INTERFACE_SUFFIXES)
#: Written by tests and programs, or by CMake while it tries things out.
_SKIPPED_FOLDERS = frozenset(
    (
        *('Testing', 'test_results', '__pycache__', '.pytest_cache', '.cmake'),
        *('CMakeTmp', 'CMakeScratch', 'CompilerIdC', 'CompilerIdCXX'),
    )
)
#: colcon writes these at each build.
_OF_COLCON = 'colcon_'
_METADATA = '.egg-info'
#: What a user or a CMakeLists.txt set; what CMake found out for itself may
#: differ between one run and the next.
_CACHE_ENTRY = rb'(?m)^(?!#|//)[^:\n]+:(?!INTERNAL|STATIC)[A-Z]+=.*$'


@dataclass(frozen=True, slots=True)
class Comparison:
    """
    What became of products.

    :param missing: Those that are gone
    :param changed: Those that are others now
    :param now: What all are like, if some only got other times; else None
    """

    missing: tuple[str, ...]
    changed: tuple[str, ...]
    now: dict[str, Fingerprint] | None

    @property
    def differing(self) -> tuple[str, ...]:
        """All that are not as they were."""
        return (*self.missing, *self.changed)


def state(path: Path, before: Fingerprint | None = None) -> Fingerprint | None:
    """
    Return what a file or link is like, with its content; None if it is gone.

    A link is told by its target.

    :param before: What it was like, so that it is read only if it was written
      since
    """
    try:
        status = path.lstat()
        now = Fingerprint.of(status)
        if stat.S_ISLNK(status.st_mode):
            content = f'link to {path.readlink()}'
        elif path.name == CACHE:
            entries = re.findall(_CACHE_ENTRY, path.read_bytes())
            content = digest(b'\n'.join(entries))
        else:
            return with_content(path, now, before, limit=sys.maxsize)
    except OSError:
        return None
    mtime = now.mtime if now.is_settled else 0
    return now._replace(mtime=mtime, digest=content, inode=0)


def compare(base: Path, before: Mapping[str, Fingerprint]) -> Comparison:
    """
    Compare products with what they were like.

    :param base: The folder that they are in
    :param before: By their paths below that
    """
    missing, changed = [], []
    touched: dict[str, Fingerprint] = {}
    for name, then in before.items():
        try:
            status = os.lstat(f'{base}/{name}')
        except OSError:
            missing.append(name)
            continue
        if (
            status.st_mtime_ns == then.mtime
            and status.st_ctime_ns == then.ctime
            and status.st_size == then.size
        ):
            continue
        now = state(base / name)
        if now is None or not is_same(then, now):
            changed.append(name)
        else:
            touched[name] = now
    now_all = {**before, **touched} if touched else None
    return Comparison(tuple(missing), tuple(changed), now_all)


def is_same(before: Fingerprint, now: Fingerprint) -> bool:
    """Tell whether two states have the same content."""
    return (before.digest, before.executable) == (now.digest, now.executable)


def built_files(
    build: Path,
    targets: Collection[str],
    before: Mapping[str, Fingerprint],
) -> dict[str, Fingerprint]:
    """
    Return what the products in a build folder are like, by their paths there.

    :param targets: Files in it that are linked to from the install space
    :param before: What they were like
    """
    found = {}
    for name in _products(str(build), '', targets):
        now = state(build / name, before.get(name))
        if now is not None:
            found[name] = now
    return found


def is_compiled(name: str, found: Fingerprint) -> bool:
    """Tell whether the build tool makes a product again once it is gone."""
    file = os.path.basename(name)
    if re.fullmatch(_COMPILED, file):
        return True
    return found.executable and '.' not in file


def _products(
    folder: str, below: str, targets: Collection[str]
) -> Iterator[str]:
    try:
        with os.scandir(folder) as scanned:
            entries = list(scanned)
    except OSError:
        return
    for entry in entries:
        name = below + entry.name
        if not entry.is_dir(follow_symlinks=False):
            if _is_product(entry, name, targets):
                yield name
        elif entry.name not in _SKIPPED_FOLDERS:
            yield from _products(entry.path, f'{name}/', targets)


def _is_product(
    entry: os.DirEntry[str], name: str, targets: Collection[str]
) -> bool:
    file = entry.name
    if file in CONFIGURED or name in targets or entry.is_symlink():
        return True
    if file.startswith(_OF_COLCON) or not entry.is_file():
        return False
    if file.endswith(_CODE) or re.fullmatch(_COMPILED, file):
        return True
    if f'{_METADATA}/' in name:
        return True
    return bool(entry.stat().st_mode & stat.S_IXUSR)
