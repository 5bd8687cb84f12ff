# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The files that a machine needs.

The sources of a package are the same files as for builds here: none of version
control, editors, caches and colcon itself, and no virtual environments, which
work in one place only. A symbolic link stays a link if its target is sent too,
or if it is dangling; otherwise its target is sent in its place.
"""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from functools import cache
from itertools import pairwise
import json
import os
from pathlib import Path
import stat

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import digest
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.remote.sync.contents import content_at
from colcon_yamllaunch.remote.sync.contents import FOLDER
from colcon_yamllaunch.remote.sync.contents import LINK
from colcon_yamllaunch.remote.sync.contents import unreadable
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_file
from colcon_yamllaunch.workspace.packages.source_files import is_skipped_folder
from colcon_yamllaunch.workspace.packages.workspace_root import (
    VIRTUAL_ENVIRONMENT,
)

#: Settings for the build, beside the packages (colcon-metadata).
_SETTINGS = ('colcon.meta',)
#: The token of a file that may change without changing its times.
_UNSETTLED = 'f'

_Parents = tuple[tuple[int, int], ...]


class FileTree:
    """
    Files that are sent to one folder of the workspace there.

    :param place: That folder, relative to the workspace
    """

    def __init__(self, place: str) -> None:
        self.place = place
        #: What the contents depend on, by paths relative to the folder: size
        #: and times of a file, and the contents of links and folders.
        self.tokens: dict[str, str] = {}
        #: The paths of the files here.
        self.sources: dict[str, str] = {}

    @property
    def state(self) -> str:
        """
        A digest that changes with the files, which are not read for it.

        It is empty if a file may change without changing its times.
        """
        if _UNSETTLED in self.tokens.values():
            return ''
        return digest(json.dumps(sorted(self.tokens.items())).encode())

    def contents(self) -> dict[str, str]:
        """
        Return the contents of files, links and folders, by their paths.

        :raises UserError: when a file cannot be read
        """
        contents = dict(self.tokens)
        for inner, source in self.sources.items():
            contents[inner] = _content(source, self.tokens[inner])
            if not contents[inner]:
                # it is gone meanwhile
                del contents[inner]
        return contents

    def add_file(
        self, inner: str, source: str, status: os.stat_result
    ) -> None:
        """Add a file."""
        now = Fingerprint.of(status)
        times = f'f {now.size} {now.mtime} {now.ctime} {now.inode}'
        self.tokens[inner] = times if now.is_settled else _UNSETTLED
        self.sources[inner] = source


def _content(source: str, token: str) -> str:
    if token == _UNSETTLED:
        return content_at(source, follows_links=True)
    return _settled_content(source, token)


@cache
def _settled_content(source: str, _token: str) -> str:
    # several machines, and each change while watching, need the same contents
    return content_at(source, follows_links=True)


def place_of(package: Package, root: Path) -> str:
    """
    Return the folder of a package there, relative to the workspace.

    It is the same as here; for a package outside of the workspace, it is
    `src/` and its name.
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
    for one, other in pairwise(packages):
        place = place_of(one, root)
        if place == place_of(other, root):
            raise UserError(
                'two packages would be in one folder there: '
                f'{one.path} and {other.path} in {place}: rename one'
            )
    folders = {place_of(p, root): str(p.path) for p in packages}
    trees = listed(folders, _is_left_out)
    if '' not in folders:
        # colcon reads them in the root of a workspace
        settings = FileTree('')
        for path in (root / name for name in _SETTINGS):
            if path.is_file():
                settings.add_file(path.name, str(path), path.stat())
        trees += [settings] if settings.tokens else []
    return trees


def listed(
    folders: Mapping[str, str],
    leaves_out: Callable[[os.DirEntry[str]], bool],
) -> list[FileTree]:
    """
    Return the files in folders, whose links may lead to one another.

    :param folders: The paths of the folders by their places
    :param leaves_out: Returns whether a folder in them is not sent
    :raises UserError: when a folder or file cannot be read
    """
    trees = {place: FileTree(place) for place in folders}
    # the paths here of all that is sent, by the paths there
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
                tree.tokens[inner] = LINK + os.readlink(entry.path)
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
    """Return whether a link is sent as a link, to the path `path` there."""
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
