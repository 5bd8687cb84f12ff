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

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import field
from itertools import pairwise
import os
from pathlib import Path
import stat
import threading

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.json_files import read_json
from colcon_yamllaunch.common.json_files import write_json
from colcon_yamllaunch.remote.sync.tree_entries import digest_of
from colcon_yamllaunch.remote.sync.tree_entries import Entries
from colcon_yamllaunch.remote.sync.tree_entries import file_entry
from colcon_yamllaunch.remote.sync.tree_entries import FOLDER
from colcon_yamllaunch.remote.sync.tree_entries import is_executable
from colcon_yamllaunch.remote.sync.tree_entries import link_entry
from colcon_yamllaunch.remote.sync.tree_entries import shown
from colcon_yamllaunch.remote.sync.tree_entries import tree_digest
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_file
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_folder
from colcon_yamllaunch.workspace.packages.workspace_root import (
    VIRTUAL_ENVIRONMENT,
)

#: The digests of the sources here, below the build folder.
DIGESTS_NAME = '.colcon_launch.digests.json'
#: Beside the packages: how they are built (colcon-metadata).
_SETTINGS = ('colcon.meta',)
#: Larger files name no path that matters (bytes).
_TEXT_SIZE = 1024 * 1024
_SHEBANG = b'python'
#: To be raised when what is in that file changes.
_VERSION = 1


@dataclass(frozen=True, slots=True)
class FileTree:
    """
    Files that are brought to one folder of the workspace there.

    :param place: That folder, relative to the workspace
    :param folder: Where they are here
    :param entries: What is to be in it, by paths relative to it
    :param digest: That of the entries
    :param elsewhere: The paths of files that are elsewhere here
    :param contents: Of files that are to have another content than here
    """

    place: str
    folder: str
    entries: Entries
    digest: str
    elsewhere: Mapping[str, str] = field(default_factory=dict)
    contents: Mapping[str, bytes] = field(default_factory=dict)


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

    def is_text(self, path: str, root: Path) -> bool:
        """
        Tell whether a file may have to change to be used elsewhere.

        It is a text that names the workspace, or a program in Python.

        :param root: The workspace
        """
        now = Fingerprint.of(os.stat(path))
        key = f'{path}\0{root}'
        times = [now.size, now.mtime, now.ctime, now.inode]
        with self._lock:
            known = self._load().get(key)
        if known is not None and known[:4] == times:
            return bool(known[4])
        is_settled = now.is_settled
        found = False
        if now.size <= _TEXT_SIZE:
            content = Path(path).read_bytes()
            found = b'\0' not in content and (
                os.fsencode(root) in content or _SHEBANG in content[:256]
            )
        if is_settled:
            with self._lock:
                self._load()[key] = [*times, found]
                self._changed = True
        return found

    def save(self) -> None:
        """Keep them for the next launch."""
        with self._lock:
            if self._changed:
                files = {
                    path: known
                    for path, known in self._load().items()
                    if os.path.lexists(path.partition('\0')[0])
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
) -> tuple[FileTree, ...]:
    """
    Return the sources of packages, ordered by their places.

    :raises UserError: when a file cannot be read
    """
    packages = sorted(packages, key=lambda p: place_of(p, root))
    folders = {place_of(p, root): str(p.path) for p in packages}
    if len(folders) < len(packages):
        raise UserError(
            'two packages would be in one folder there: '
            + _doubled(packages, root)
        )
    walk = Walk(folders, digests, _is_left_out)
    trees = []
    for place, folder in folders.items():
        entries = walk.entries(place)
        trees.append(FileTree(place, folder, entries, tree_digest(entries)))
    if '' not in folders:
        trees += _settings(root, digests)
    digests.save()
    return tuple(trees)


def _doubled(packages: Sequence[Package], root: Path) -> str:
    """Tell of two packages that come to one folder."""
    for one, other in pairwise(packages):
        place = place_of(one, root)
        if place == place_of(other, root):
            return f'{one.path} and {other.path} in {place}: rename one'
    return ''


def _settings(root: Path, digests: Digests) -> list[FileTree]:
    """Return what colcon reads in the root of a workspace, if anything."""
    walk = Walk({}, digests, _is_left_out)
    entries: Entries = {}
    for name in _SETTINGS:
        path = root / name
        if path.is_file():
            entries |= walk.file(name, str(path), path.stat())
    if not entries:
        return []
    return [FileTree('', str(root), entries, tree_digest(entries))]


class Walk:
    """
    Walks through folders that lead to one another by links.

    :param folders: They by their places
    :param leaves_out: Whether what is in a folder does not belong to it
    """

    def __init__(
        self,
        folders: Mapping[str, str],
        digests: Digests,
        leaves_out: Callable[[os.DirEntry[str]], bool],
    ) -> None:
        self._folders = folders
        self._digests = digests
        self._leaves_out = leaves_out
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
                    if own not in parents and not self._leaves_out(entry):
                        found[inner] = FOLDER
                        pending.append(
                            (entry.path, f'{inner}/', (*parents, own))
                        )
                elif stat.S_ISREG(status.st_mode) and not is_skipped_file(
                    entry.name
                ):
                    found |= self.file(inner, entry.path, status)
        return found

    def file(self, inner: str, path: str, status: os.stat_result) -> Entries:
        """Return the entry of a file, unless it is gone."""
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
            if (
                parent is None
                or parent.is_symlink()
                or self._leaves_out(parent)
            ):
                return False
            current = parent.path
        entry = self._scan(current).get(name)
        if entry is None:
            return False
        if entry.is_dir():
            return not self._leaves_out(entry)
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
