# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The files that a machine is to have, and their tokens.

What belongs to a source is found out as for builds here: without what version
control, editors, caches and colcon itself put there, and without virtual
environments, which work in one place only. A symbolic link stays one where
what it leads to comes along, or where it leads nowhere; else what it leads to
comes in its place.
"""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from itertools import pairwise
import os
from pathlib import Path
import stat

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.remote.sync.contents import file_token
from colcon_yamllaunch.remote.sync.contents import FOLDER
from colcon_yamllaunch.remote.sync.contents import tree_state
from colcon_yamllaunch.remote.sync.contents import unreadable
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_file
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_folder
from colcon_yamllaunch.workspace.packages.workspace_root import (
    VIRTUAL_ENVIRONMENT,
)

#: Beside the packages: how they are built (colcon-metadata).
_SETTINGS = ('colcon.meta',)

_Parents = tuple[tuple[int, int], ...]


class FileTree:
    """
    Files that are sent to one folder of the workspace there.

    :param place: That folder, relative to the workspace
    """

    def __init__(self, place: str) -> None:
        self.place = place
        #: The tokens of all that is to be in it, by paths relative to it.
        self.tokens: dict[str, str] = {}
        #: Where the files are here.
        self.sources: dict[str, str] = {}

    @property
    def state(self) -> str:
        """What tells whether something in it has changed."""
        return tree_state(self.tokens)

    def add_file(
        self, inner: str, source: str, status: os.stat_result
    ) -> None:
        """Add a file."""
        self.tokens[inner] = file_token(status)
        self.sources[inner] = source

    def drop(self, inner: str) -> None:
        """Leave a file out, which is gone meanwhile."""
        del self.tokens[inner], self.sources[inner]


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


def source_trees(packages: Iterable[Package], root: Path) -> list[FileTree]:
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
    trees = listed(folders, _is_left_out)
    if '' not in folders:
        # what colcon reads in the root of a workspace
        settings = FileTree('')
        for path in (root / name for name in _SETTINGS):
            if path.is_file():
                settings.add_file(path.name, str(path), path.stat())
        trees += [settings] if settings.tokens else []
    return trees


def _doubled(packages: Sequence[Package], root: Path) -> str:
    """Return two packages that come to one folder."""
    for one, other in pairwise(packages):
        place = place_of(one, root)
        if place == place_of(other, root):
            return f'{one.path} and {other.path} in {place}: rename one'
    return ''


def listed(
    folders: Mapping[str, str],
    leaves_out: Callable[[os.DirEntry[str]], bool],
) -> list[FileTree]:
    """
    Return what is in folders, which may lead to one another by links.

    :param folders: They by their places
    :param leaves_out: Whether a folder in them does not belong to them
    :raises UserError: when one cannot be read
    """
    trees = {place: FileTree(place) for place in folders}
    # what comes along, by its path there: where it is here
    known: dict[str, str] = {}
    pending: list[tuple[FileTree, str, str, _Parents]] = []
    links: list[tuple[FileTree, str, os.DirEntry[str], _Parents]] = []

    def add(
        tree: FileTree, inner: str, entry: os.DirEntry[str], parents: _Parents
    ) -> None:
        try:
            status = entry.stat()
        except FileNotFoundError:
            # gone meanwhile
            return
        except OSError as e:
            raise unreadable(entry.path, e.strerror) from e
        identity = (status.st_dev, status.st_ino)
        if stat.S_ISDIR(status.st_mode):
            if identity not in parents and not leaves_out(entry):
                pending.append((tree, entry.path, inner, (*parents, identity)))
        elif stat.S_ISREG(status.st_mode) and not is_skipped_file(entry.name):
            tree.add_file(inner, entry.path, status)
            known[os.path.join(tree.place, inner)] = entry.path

    for place, folder in folders.items():
        status = os.stat(folder)
        identity = (status.st_dev, status.st_ino)
        pending.append((trees[place], folder, '', (identity,)))
    while pending or links:
        if not pending:
            tree, inner, entry, parents = links.pop()
            if _stays(os.path.join(tree.place, inner), entry, known):
                tree.tokens[inner] = f'l {os.readlink(entry.path)}'
            else:
                add(tree, inner, entry, parents)
            continue
        tree, path, below, parents = pending.pop()
        tree.tokens[below] = FOLDER
        known[os.path.join(tree.place, below).rstrip('/')] = path
        for entry in _entries(path):
            inner = os.path.join(below, entry.name)
            if not entry.is_symlink():
                add(tree, inner, entry, parents)
            elif os.path.exists(entry.path) or not is_skipped_file(entry.name):
                links.append((tree, inner, entry, parents))
                known[os.path.join(tree.place, inner)] = entry.path
    return list(trees.values())


def _stays(
    path: str, entry: os.DirEntry[str], known: Mapping[str, str]
) -> bool:
    """Return whether a link at a path there is to be one there, too."""
    if not os.path.exists(entry.path):
        return True
    target = os.readlink(entry.path)
    there = os.path.normpath(os.path.join(os.path.dirname(path), target))
    here = known.get('' if there == '.' else there)
    return (
        not os.path.isabs(target)
        and here is not None
        and os.path.realpath(here) == os.path.realpath(entry.path)
    )


def _entries(folder: str) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as entries:
            return list(entries)
    except (FileNotFoundError, NotADirectoryError):
        return []
    except OSError as e:
        raise unreadable(folder, e.strerror) from e


def _is_left_out(entry: os.DirEntry[str]) -> bool:
    return is_skipped_folder(entry) or os.path.lexists(
        os.path.join(entry.path, VIRTUAL_ENVIRONMENT)
    )
