# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The files that a machine needs.

The sources of a package are the same files as for builds here: none of version
control, editors, caches and colcon itself, and no virtual environments, which
work in one place only. A symbolic link stays a link if its target is sent too,
or if it is dangling; otherwise its target is sent in its place.

The installed files are for a machine of the same kind. A Python package that
is used from its build folder, through an `.egg-link`, is sent to the folder
where it would be installed. Texts with the path of this workspace, such as
colcon's setup scripts, get the path there. A Python program whose interpreter
is missing there gets `python3`.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cache
from itertools import pairwise
import json
import os
from pathlib import Path
import re
import stat

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import digest, Fingerprint
from colcon_yamllaunch.remote.sync import manifest
from colcon_yamllaunch.workspace.packages.package import (
    is_skipped_file,
    is_skipped_folder,
    Package,
)
from colcon_yamllaunch.workspace.packages.workspace_root import (
    VIRTUAL_ENVIRONMENT,
)

#: Settings for the build, beside the packages (colcon-metadata).
_SETTINGS = ('colcon.meta',)
#: The token of a file that may change without changing its times.
_UNSETTLED = 'f'

_Parents = tuple[tuple[int, int], ...]
#: The suffix of files that name the build folder of a Python package.
_EGG_LINK = '.egg-link'
#: Part of the lines of colcon's scripts that add that folder to the path.
_DEVELOP = b'pythonpath_develop'
_SCRIPT = re.compile(r'(^|/)package\.(sh|bash|zsh|ps1|dsv)$')
#: Replaces interpreters that are missing there.
_ANY_PYTHON = b'/usr/bin/env python3'
_SHEBANG = re.compile(rb'#!\s*(/\S*python[\d.]*)')
#: Larger files are sent as they are (bytes).
_TEXT_SIZE = 1024 * 1024
#: The contents of texts by their paths here.
Texts = Mapping[str, bytes]


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
        return manifest.content_at(source, follows_links=True)
    return _settled_content(source, token)


@cache
def _settled_content(source: str, _token: str) -> str:
    # several machines, and each change while watching, need the same contents
    return manifest.content_at(source, follows_links=True)


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
            raise manifest.unreadable(entry.path, e.strerror) from e
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
                tree.tokens[inner] = manifest.LINK + os.readlink(entry.path)
            else:
                add(tree, inner, entry, parents)
            continue
        tree, path, below, parents = pending.pop()
        tree.tokens[below] = manifest.FOLDER
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
        raise manifest.unreadable(folder, e.strerror) from e


def _is_left_out(entry: os.DirEntry[str]) -> bool:
    return is_skipped_folder(entry) or os.path.lexists(
        os.path.join(entry.path, VIRTUAL_ENVIRONMENT)
    )


def install_trees(
    root: Path, install_base: Path, names: Collection[str], *, merged: bool
) -> list[FileTree]:
    """
    Return the installed files of packages.

    :param root: The workspace
    :param install_base: Where packages are installed
    :param merged: Whether all packages share one prefix
    :raises UserError: when they are not installed, or cannot be read
    """
    base = os.path.relpath(install_base, root)
    prefixes = {
        name: install_base if merged else install_base / name
        for name in sorted(names)
    }
    missing = [name for name, path in prefixes.items() if not path.is_dir()]
    if missing:
        raise UserError(
            'not built here, which `sync: install` needs: '
            + ', '.join(missing)
        )
    if merged:
        trees = listed({base: str(install_base)}, _is_cache)
    else:
        # what lies beside the prefixes of packages
        top = FileTree(base)
        top.tokens[''] = manifest.FOLDER
        for path in install_base.iterdir():
            if path.is_file():
                top.add_file(path.name, str(path), path.stat())
        trees = listed(
            {f'{base}/{name}': str(path) for name, path in prefixes.items()},
            _is_cache,
        )
        trees.append(top)
    for tree in trees:
        for inner in [i for i in tree.sources if i.endswith(_EGG_LINK)]:
            del tree.tokens[inner]
            link = Path(tree.sources.pop(inner))
            _add_developed(tree, os.path.dirname(inner), link)
    return trees


def pythons_of(trees: Iterable[FileTree]) -> list[str]:
    """Return the versions of Python that modules are installed for."""
    found = {
        part.removeprefix('python')
        for tree in trees
        for inner in tree.tokens
        for part in inner.split('/')[1:2]
        if re.fullmatch(r'python3\.\d+', part)
    }
    return sorted(found)


def changed_texts(
    paths: Iterable[str],
    root: Path,
    remote_root: str,
    missing_of: Callable[[list[str]], Collection[str]],
) -> Texts:
    """
    Return the contents of the text files that differ there.

    :param root: The workspace
    :param remote_root: The workspace there
    :param missing_of: Returns the paths among some that are missing there
    """
    here, there = os.fsencode(root), os.fsencode(remote_root)
    # but no folder beside it with a longer name
    names_here = re.compile(re.escape(here) + rb'(?![\w.-])')
    texts = dict(_texts(paths, here))
    interpreters = {
        os.fsdecode(match[1])
        for text in texts.values()
        if (match := _SHEBANG.match(text))
    }
    missing = missing_of(sorted(interpreters)) if interpreters else ()
    changed = {}
    for path, text in texts.items():
        new = text
        match = _SHEBANG.match(new)
        if match and os.fsdecode(match[1]) in missing:
            new = b'#!' + _ANY_PYTHON + new[match.end() :]
        if _SCRIPT.search(path) and _DEVELOP in new:
            lines = new.splitlines(keepends=True)
            new = b''.join(line for line in lines if _DEVELOP not in line)
        new = names_here.sub(lambda _: there, new)
        if new != text:
            changed[path] = new
    return changed


def _texts(paths: Iterable[str], root: bytes) -> Iterable[tuple[str, bytes]]:
    """Iterate over the texts that may differ there."""
    for path in paths:
        try:
            if os.stat(path).st_size <= _TEXT_SIZE:
                text = Path(path).read_bytes()
                if b'\0' not in text and (
                    root in text or b'python' in text[:256]
                ):
                    yield path, text
        except OSError:
            # it is gone, or cannot be read, which sending it reports
            continue


def _add_developed(tree: FileTree, site: str, link: Path) -> None:
    """Add the Python package whose build folder a file names."""
    lines = link.read_text(errors='replace').splitlines()
    folder = Path(lines[0]) if lines else Path()
    eggs = sorted(folder.glob('*.egg-info'))
    if not lines or not eggs:
        raise UserError(
            f'{link} leads to no Python package: build it here again'
        )
    names = [egg.name for egg in eggs]
    for egg in eggs:
        top = egg / 'top_level.txt'
        if top.is_file():
            for name in top.read_text().split():
                names += [
                    path.name
                    for path in (folder / name, *folder.glob(f'{name}.*'))
                    if path.exists() and path.suffix != '.egg-info'
                ]
    for name in dict.fromkeys(names):
        path, target = folder / name, f'{site}/{name}'
        if path.is_file():
            tree.add_file(target, str(path), path.stat())
            continue
        (below,) = listed({'': str(path)}, _is_cache)
        for inner, token in below.tokens.items():
            tree.tokens[f'{target}/{inner}'.rstrip('/')] = token
        for inner, source in below.sources.items():
            tree.sources[f'{target}/{inner}'] = source


def _is_cache(entry: os.DirEntry[str]) -> bool:
    # Python creates it again
    return entry.name == '__pycache__'
