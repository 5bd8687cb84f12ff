# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Symbolic links from where a package is built and installed to its source."""

from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Iterator
from contextlib import suppress
import os
from pathlib import Path
import re
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.packages.source_files import entries_of

if TYPE_CHECKING:
    from colcon_yamllaunch.workspace.freshness.build_inputs import BuildInputs

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
        relative
        for relative in files
        if not linked.isdisjoint((Path(relative), *Path(relative).parents))
        and not _is_compiled(Path(relative))
        and Path(relative).name not in copies
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


def remove_dangling(folder: Path, source: Path) -> None:
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
    """Iterate over the links below a folder, without a look at the rest."""
    for entry in entries_of(folder):
        if entry.is_symlink():
            yield entry.path
        elif entry.is_dir(follow_symlinks=False):
            yield from _links(entry.path)


def tree(folder: Path) -> Iterator[Path]:
    """Iterate over what is below a folder and is not a real folder."""
    for current, folders, files in os.walk(folder):
        for name in files:
            yield Path(current, name)
        for name in folders:
            if (path := Path(current, name)).is_symlink():
                yield path


def _is_compiled(path: Path) -> bool:
    return (
        path.name in _COMPILED_NAMES
        or path.suffix.lower() in _COMPILED_SUFFIXES
    )
