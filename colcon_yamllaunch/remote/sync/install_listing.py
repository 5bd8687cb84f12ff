# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The installed files, for a machine of the same kind.

Links that lead out of the install space, as `--symlink-install` makes them,
are resolved. A Python package that is used from its build folder, through an
`.egg-link`, is sent to the folder where it would be installed. Texts with the
path of this workspace, such as colcon's setup scripts, get the path there. A
Python program whose interpreter is missing there gets `python3`.
"""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.remote.sync.contents import FOLDER
from colcon_yamllaunch.remote.sync.listing import FileTree
from colcon_yamllaunch.remote.sync.listing import listed

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
        trees = listed({base: str(install_base)}, _is_left_out)
    else:
        # what lies beside the prefixes of packages
        top = FileTree(base)
        top.tokens[''] = FOLDER
        for path in install_base.iterdir():
            if path.is_file():
                top.add_file(path.name, str(path), path.stat())
        trees = listed(
            {f'{base}/{name}': str(path) for name, path in prefixes.items()},
            _is_left_out,
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
    root_there: str,
    missing_of: Callable[[list[str]], Collection[str]],
) -> Texts:
    """
    Return the contents of the text files that differ there.

    :param root: The workspace
    :param root_there: The workspace there
    :param missing_of: Returns the paths among some that are missing there
    """
    here, there = os.fsencode(root), os.fsencode(root_there)
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
        (below,) = listed({'': str(path)}, _is_left_out)
        for inner, token in below.tokens.items():
            tree.tokens[f'{target}/{inner}'.rstrip('/')] = token
        for inner, source in below.sources.items():
            tree.sources[f'{target}/{inner}'] = source


def _is_left_out(entry: os.DirEntry[str]) -> bool:
    # Python creates it again
    return entry.name == '__pycache__'
