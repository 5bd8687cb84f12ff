# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The sources of packages, as a machine is to have them.

What belongs to a source is told as for builds here: without what version
control, editors, caches and colcon itself put there, and without virtual
environments, which work in one place only. A symbolic link stays one where
what it leads to comes along, or where it leads nowhere; else what it leads to
comes in its place.
"""

from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import stat
import threading

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.json_files import read_json
from colcon_yamllaunch.common.json_files import write_json
from colcon_yamllaunch.machines.sync.tree_entries import digest_of
from colcon_yamllaunch.machines.sync.tree_entries import Entries
from colcon_yamllaunch.machines.sync.tree_entries import file_entry
from colcon_yamllaunch.machines.sync.tree_entries import FOLDER
from colcon_yamllaunch.machines.sync.tree_entries import is_executable
from colcon_yamllaunch.machines.sync.tree_entries import link_entry
from colcon_yamllaunch.machines.sync.tree_entries import shown
from colcon_yamllaunch.machines.sync.tree_entries import tree_digest
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_file
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_folder
from colcon_yamllaunch.workspace.packages.workspace_root import (
    VIRTUAL_ENVIRONMENT,
)

#: The digests of the sources here, below the build folder.
DIGESTS_NAME = '.colcon_launch.digests.json'
#: To be raised when what is in that file changes.
_VERSION = 1


@dataclass(frozen=True, slots=True)
class SourceTree:
    """
    The source of one package.

    :param name: The package
    :param place: Its folder, relative to the workspace, here as there
    :param folder: Its folder here
    :param entries: What is in it, by paths relative to it
    :param digest: That of the entries
    """

    name: str
    place: str
    folder: str
    entries: Entries
    digest: str


class Digests:
    """
    The digests of files here, known from earlier launches.

    It may be used by several threads.

    :param path: The file that they are kept in
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._known: dict[str, list[object]] | None = None
        self._changed = False

    def of(self, path: str, status: os.stat_result) -> str:
        """
        Return the digest of a file.

        :raises UserError: when it cannot be read
        """
        now = Fingerprint.of(status)
        times = [now.size, now.mtime, now.ctime, now.inode]
        with self._lock:
            known = self._load().get(path)
        if known is not None and known[:4] == times:
            return str(known[4])
        is_settled = now.is_settled
        found = digest_of(path, status)
        if is_settled:
            with self._lock:
                self._load()[path] = [*times, found]
                self._changed = True
        return found

    def save(self) -> None:
        """Keep them for the next launch."""
        with self._lock:
            if self._changed:
                files = {
                    path: known
                    for path, known in self._load().items()
                    if os.path.lexists(path)
                }
                write_json(self._path, {'version': _VERSION, 'files': files})
                self._changed = False

    def _load(self) -> dict[str, list[object]]:
        if self._known is None:
            self._known = {}
            found = read_json(self._path)
            with suppress(KeyError, TypeError, AttributeError):
                if found['version'] == _VERSION:
                    self._known = {
                        path: known
                        for path, known in found['files'].items()
                        if isinstance(known, list) and len(known) == 5
                    }
        return self._known


def place_of(package: Package, root: Path) -> str:
    """
    Return the folder of a package there, relative to the workspace.

    It is that which it has here; that of one outside of the workspace is
    `src/` with its name.
    """
    if package.path.is_relative_to(root):
        place = package.path.relative_to(root).as_posix()
        return '' if place == '.' else place
    return f'src/{package.name}'


def source_trees(
    packages: Iterable[Package], root: Path, digests: Digests
) -> tuple[SourceTree, ...]:
    """
    Return the sources of packages, ordered by their places.

    :raises UserError: when a file cannot be read
    """
    packages = sorted(packages, key=lambda p: place_of(p, root))
    folders = {place_of(p, root): str(p.path) for p in packages}
    walk = _Walk(folders, digests)
    trees = []
    for package in packages:
        place = place_of(package, root)
        entries = walk.entries(place)
        folder = folders[place]
        trees.append(
            SourceTree(
                package.name, place, folder, entries, tree_digest(entries)
            )
        )
    digests.save()
    return tuple(trees)


class _Walk:
    """Walks through sources that lead to one another by links."""

    def __init__(self, folders: Mapping[str, str], digests: Digests) -> None:
        self._folders = folders
        self._digests = digests
        self._scanned: dict[str, Mapping[str, os.DirEntry[str]]] = {}

    def entries(self, place: str) -> Entries:
        """Return what is in a source, by paths relative to it."""
        folder = self._folders[place]
        found: Entries = {'': FOLDER}
        pending: list[tuple[str, str, tuple[tuple[int, int], ...]]] = [
            (folder, '', (_identity(os.stat(folder)),))
        ]
        while pending:
            path, below, parents = pending.pop()
            for entry in self._scan(path).values():
                inner = below + entry.name
                if entry.is_symlink() and self._stays(place, inner, entry):
                    found[inner] = link_entry(os.readlink(entry.path))
                    continue
                try:
                    status = entry.stat()
                except FileNotFoundError:
                    # gone meanwhile
                    continue
                except OSError as e:
                    raise _unreadable(entry.path, e) from e
                if stat.S_ISDIR(status.st_mode):
                    own = _identity(status)
                    if own not in parents and not _is_left_out(entry):
                        found[inner] = FOLDER
                        pending.append(
                            (entry.path, f'{inner}/', (*parents, own))
                        )
                elif stat.S_ISREG(status.st_mode) and not is_skipped_file(
                    entry.name
                ):
                    found |= self._file(inner, entry.path, status)
        return found

    def _file(self, inner: str, path: str, status: os.stat_result) -> Entries:
        try:
            found = self._digests.of(path, status)
        except UserError:
            if os.path.lexists(path):
                raise
            # gone meanwhile
            return {}
        return {inner: file_entry(is_executable(status), found)}

    def _stays(self, place: str, inner: str, entry: os.DirEntry[str]) -> bool:
        """Tell whether a link is to be one there, too."""
        if not os.path.exists(entry.path):
            return not is_skipped_file(entry.name)
        target = os.readlink(entry.path)
        if os.path.isabs(target):
            return False
        beside = os.path.dirname(f'{place}/{inner}' if place else inner)
        there = os.path.normpath(os.path.join(beside, target))
        here = self._here(there)
        return here is not None and (
            os.path.realpath(here) == os.path.realpath(entry.path)
        )

    def _here(self, path: str) -> str | None:
        """Return what comes to a path there, if anything does."""
        for place, folder in self._folders.items():
            prefix = f'{place}/' if place else ''
            if path == place:
                return folder
            if path.startswith(prefix) and not path.startswith('..'):
                inner = path[len(prefix) :]
                if self._comes_along(folder, inner):
                    return os.path.join(folder, inner)
        return None

    def _comes_along(self, folder: str, inner: str) -> bool:
        """Tell whether what is at a path in a source is brought."""
        *folders, name = inner.split('/')
        current = folder
        for part in folders:
            parent = self._scan(current).get(part)
            if parent is None or parent.is_symlink() or _is_left_out(parent):
                return False
            current = parent.path
        entry = self._scan(current).get(name)
        if entry is None:
            return False
        if entry.is_dir():
            return not _is_left_out(entry)
        return entry.is_file() and not is_skipped_file(name)

    def _scan(self, folder: str) -> Mapping[str, os.DirEntry[str]]:
        if folder not in self._scanned:
            try:
                with os.scandir(folder) as entries:
                    found = {entry.name: entry for entry in entries}
            except (FileNotFoundError, NotADirectoryError):
                found = {}
            except OSError as e:
                raise _unreadable(folder, e) from e
            self._scanned[folder] = found
        return self._scanned[folder]


def _is_left_out(entry: os.DirEntry[str]) -> bool:
    return is_skipped_folder(entry) or os.path.lexists(
        os.path.join(entry.path, VIRTUAL_ENVIRONMENT)
    )


def _identity(status: os.stat_result) -> tuple[int, int]:
    return status.st_dev, status.st_ino


def _unreadable(path: str, error: OSError) -> UserError:
    return UserError(
        f'{shown(path)} cannot be read: {error.strerror}. Make it readable, '
        'or take it out of the package'
    )
