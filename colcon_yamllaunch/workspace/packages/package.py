# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A package of the workspace: its manifest, its source files, its dependencies.

Where a `package.xml` is invalid, colcon takes the folder for whatever else is
there, such as plain CMake, and then knows no dependencies (colcon-core issue
597). :func:`invalid_manifest` and :func:`broken_manifests` find these.
"""

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
import os
from pathlib import Path
import re
import stat

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.packages.workspace_root import is_ignored

_SKIPPED_FOLDERS = {
    *('.git', '.hg', '.svn', '.bzr', 'CVS', '.vscode', '.idea', '.vs'),
    *('__pycache__', '.cache', '.pytest_cache', '.mypy_cache', '.ruff_cache'),
    *('.hypothesis', '.eggs', '.tox', '.nox'),
}
#: Left by editors and by others: *~ .#* #*# .*.sw? *.kate-swp 4913 *.pyc …
_SKIPPED_FILES = re.compile(
    r'.*~|\.#.*|#.*#|\..*\.sw.|.*\.kate-swp|4913'
    r'|.*___jb_(tmp|old)___|\.goutputstream-.*|\.~lock\..*#'
    r'|.*\.pyc|\.coverage|\.nfs.*|\.fuse_hidden.*|\.DS_Store',
    re.DOTALL,
)
_BUILD_FOLDERS = ('build', 'install', 'log')
_NAME = re.compile(r'<name>\s*([^<\s]+)\s*</name>')
_MANIFEST = 'package.xml'


@dataclass(frozen=True, slots=True)
class Package:
    """
    A package whose source is in the workspace.

    :param name: The name that other packages and launch files use
    :param path: The absolute path of the folder with the source
    :param type: How colcon builds it, such as `ros.ament_cmake` or `cmake`
    :param build_depends: Names of what it needs to be built
    :param run_depends: Names of what it, or who builds on it, needs later
    """

    name: str
    path: Path
    type: str
    build_depends: frozenset[str] = frozenset()
    run_depends: frozenset[str] = frozenset()


def prefix_of(name: str, install_base: Path, merge_install: bool) -> Path:
    """
    Return the folder that a package is installed into.

    :param merge_install: Whether all packages share one prefix
    """
    return install_base if merge_install else install_base / name


def is_merged(install_base: Path) -> bool:
    """Return whether an install folder has the merged layout already."""
    marker = install_base / '.colcon_install_layout'
    return text_of(marker).rstrip() == 'merged'


def source_files(folder: Path) -> Iterator[tuple[str, os.stat_result]]:
    """
    Iterate over the files of a package's source, by path and status.

    The paths are relative to the folder. They come in no particular order.
    """
    start = len(str(folder)) + 1
    for _, files in source_folders(str(folder)):
        for entry, status in files:
            yield entry.path[start:], status


def source_folders(
    folder: str,
) -> Iterator[tuple[str, list[tuple[os.DirEntry[str], os.stat_result]]]]:
    """
    Iterate over the folders of a package's source, each with its files.

    Left out is what version control, editors, caches and colcon itself put
    there. Symbolic links are followed; a dangling one is a file on its own.
    """
    pending = [folder]
    seen: set[tuple[int, int]] = set()
    while pending:
        path, files = pending.pop(), []
        for entry in entries_of(path):
            try:
                status = entry.stat()
            except OSError:
                status = entry.stat(follow_symlinks=False)
            if not stat.S_ISDIR(status.st_mode):
                if not is_skipped_file(entry.name):
                    files.append((entry, status))
                continue
            place = (status.st_dev, status.st_ino)
            if place not in seen and not is_skipped_folder(entry):
                seen.add(place)
                pending.append(entry.path)
        yield path, files


def is_skipped_file(name: str) -> bool:
    """Return whether a file belongs to an editor or a cache, by its name."""
    return _SKIPPED_FILES.fullmatch(name) is not None


def is_skipped_folder(entry: os.DirEntry[str]) -> bool:
    """Return whether nothing in a folder belongs to the source."""
    if entry.name in _SKIPPED_FOLDERS or entry.name.endswith('.egg-info'):
        return True
    return entry.name in _BUILD_FOLDERS and is_ignored(Path(entry.path))


def entries_of(path: str) -> list[os.DirEntry[str]]:
    """Return what is in a folder, nothing if it cannot be read."""
    try:
        with os.scandir(path) as entries:
            return list(entries)
    except OSError:
        return []


def closure(packages: Iterable[Package], wanted: Iterable[str]) -> list[str]:
    """
    Return the packages to be built, each after those that it needs.

    These are the wanted ones and what they need to be built and to run,
    transitively. Names that are not in the workspace are left out, as what
    they stand for comes from an underlay. What only tests need is not in it.

    :raises WorkspaceError: when needed packages depend on each other in a
      circle or when two have the same name
    """
    known = index(packages)
    # a dict, as it finds a name fast
    order: dict[str, None] = {}
    for name in sorted(set(wanted)):
        if name in known and name not in order:
            _visit(name, known, order)
    return list(order)


def index(packages: Iterable[Package]) -> dict[str, list[Package]]:
    """Return the packages by name; a name may be used more than once."""
    known: dict[str, list[Package]] = {}
    for package in packages:
        known.setdefault(package.name, []).append(package)
    return known


def build_closure(
    known: Mapping[str, Sequence[Package]], name: str
) -> tuple[frozenset[str], frozenset[str]]:
    """
    Return the packages whose builds a package's build depends on.

    These are its build dependencies with all that these need: a package
    that builds on another one gets to see what that one exports. First come
    those in the workspace, then the names of others.

    :param known: All packages of the workspace, by name
    """
    found: set[str] = set()
    others: set[str] = set()
    pending = [
        needed
        for package in known.get(name, ())
        for needed in package.build_depends
    ]
    while pending:
        current = pending.pop()
        if current in found or current == name:
            continue
        if current not in known:
            others.add(current)
            continue
        found.add(current)
        for package in known[current]:
            pending.extend(package.build_depends | package.run_depends)
    return frozenset(found), frozenset(others)


def needed_by(
    packages: Iterable[Package], wanted: Iterable[str]
) -> dict[str, tuple[str, ...]]:
    """
    Return why packages are in the closure of those that the launch uses.

    Return for each the shortest way to it: the names of a wanted package, of
    one that this needs and so on, up to itself.
    """
    known = index(packages)
    ways: dict[str, tuple[str, ...]] = {
        name: (name,) for name in sorted(set(wanted)) if name in known
    }
    pending = deque(ways)
    while pending:
        current = pending.popleft()
        for package in known[current]:
            for name in sorted(package.build_depends | package.run_depends):
                if name in known and name not in ways:
                    ways[name] = (*ways[current], name)
                    pending.append(name)
    return ways


def _visit(
    name: str, known: Mapping[str, list[Package]], order: dict[str, None]
) -> None:
    # depth first without recursion: a chain may be longer than Python's stack
    path = {name: _needs(known[name])}
    while path:
        current, pending = next(reversed(path.items()))
        for needed in pending:
            if needed in path:
                names = list(path)
                circle = [*names[names.index(needed) :], needed]
                raise WorkspaceError(
                    'packages depend on each other in a circle: '
                    + ' -> '.join(circle),
                    'remove one of these dependencies from its package.xml',
                )
            if needed in known and needed not in order:
                path[needed] = _needs(known[needed])
                break
        else:
            del path[current]
            order[current] = None


def _needs(named: list[Package]) -> Iterator[str]:
    """Return what the only package of a name needs."""
    package, paths = named[0], {package.path for package in named}
    if len(paths) > 1:
        listed = ''.join(f'\n  {path}' for path in sorted(paths))
        raise WorkspaceError(
            f"several packages are named '{package.name}':{listed}",
            'rename all but one, or put a file COLCON_IGNORE into the others',
        )
    needed = package.build_depends | package.run_depends
    return iter(sorted(needed - {package.name}))


@dataclass(frozen=True, slots=True)
class BrokenManifest:
    """
    A `package.xml` that cannot be used.

    :param name: The package's name as far as it can be told
    :param path: The folder that it is in
    :param reason: What catkin_pkg says about it
    """

    name: str | None
    path: Path
    reason: str


def invalid_manifest(package: Package) -> str | None:
    """Return what is wrong with a manifest that colcon did not use, if so."""
    if package.type.startswith('ros.'):
        return None
    error = manifest_error(package.path)
    if error is None:
        return None
    return (
        f'{package.path / _MANIFEST} is invalid, so colcon would build '
        f'{package.name} as a {package.type} package without its '
        f'dependencies: {error}'
    )


def broken_manifests(
    base_paths: Iterable[Path], packages: Iterable[Package]
) -> tuple[BrokenManifest, ...]:
    """
    Return the manifests in the workspace that make no package at all.

    This crawls the workspace: it is for messages about unknown packages.
    """
    known = {os.path.realpath(package.path) for package in packages}
    folders = [f for base in base_paths for f in _folders(base, known)]
    return tuple(
        BrokenManifest(manifest_name(folder), folder, reason)
        for folder in folders
        if (reason := manifest_error(folder)) is not None
    )


def manifest_error(folder: Path) -> str | None:
    """Return what is wrong with the manifest in a folder, if it has one."""
    if not os.path.isfile(folder / _MANIFEST):
        return None
    # takes long to import and is hardly ever needed
    from catkin_pkg.package import InvalidPackage, parse_package

    try:
        parse_package(str(folder)).get_build_type()
    except (InvalidPackage, AssertionError, OSError, ValueError) as e:
        return ' '.join(str(e).split())
    return None


def manifest_name(folder: Path) -> str | None:
    """Return the name in a folder's manifest as far as it can be told."""
    match = _NAME.search(text_of(folder / _MANIFEST))
    return match and match[1]


def _folders(base: Path, known: set[str]) -> Iterator[Path]:
    for current, folders, files in os.walk(base):
        folder = Path(current)
        if os.path.realpath(folder) in known or is_ignored(folder):
            folders.clear()
            continue
        folders[:] = sorted(f for f in folders if not f.startswith('.'))
        if _MANIFEST in files:
            yield folder
