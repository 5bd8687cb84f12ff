# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Folders as colcon looks at them to find packages."""

from collections.abc import Collection
from collections.abc import Set
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.fingerprint import fingerprint
from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.packages.workspace_root import IGNORE_MARKERS
from colcon_yamllaunch.workspace.packages.workspace_root import is_folder

#: What a folder may be.
PACKAGE = 'package'
IGNORED = 'ignored'
PLAIN = 'plain'

MANIFEST = 'package.xml'
_CMAKE = 'CMakeLists.txt'
_PYTHON_FILES = ('setup.py', 'setup.cfg', 'pyproject.toml')
#: The types of packages with a manifest start with this.
_ROS = 'ros.'
#: Files that make colcon-ros ignore a folder, beside the ignore markers.
_FOREIGN = ('manifest.xml', '_order_isolated_packages.py', '_setup_util.py')
_IGNORING = frozenset((*IGNORE_MARKERS, *_FOREIGN))
_ROS_FILES = _IGNORING | {MANIFEST, 'colcon.pkg'}
#: A folder without any of these is no package on its own account.
MARKERS = _ROS_FILES | {_CMAKE, *_PYTHON_FILES}

#: A variable in a condition (REP 149, catkin_pkg).
_VARIABLE = re.compile(r'\$(\w+)')


def has_ignore_marker(path: str) -> bool:
    """Tell whether colcon ignores a folder whatever else is in it."""
    return os.path.lexists(f'{path}/COLCON_IGNORE')


def content(path: str) -> tuple[set[str], list[str]] | None:
    """Return the names of the files in a folder and of those crawled below."""
    files, folders = set(), []
    try:
        with os.scandir(path) as entries:
            for entry in entries:
                if not is_folder(entry):
                    files.add(entry.name)
                elif not entry.name.startswith('.'):
                    folders.append(entry.name)
    except OSError:
        return None
    return files, folders


def relevant(
    path: str, package_type: str, names: Collection[str]
) -> tuple[Set[str], list[str]]:
    """
    Return the files that colcon's answer about a folder depends on.

    With them come the folders where others may appear; all are relative.

    :param package_type: The type of the package, empty if it is none
    :param names: The files directly in the folder
    """
    if package_type.startswith(_ROS):
        return _ROS_FILES.intersection(names), ['.']
    if package_type == 'python':
        # setup.py and setup.cfg may read any of them
        return set(names), ['.']
    files = MARKERS.intersection(names)
    if package_type != 'cmake':
        return files, ['.']
    below, folders = cmake_files(path)
    return files | below, folders


def cmake_files(path: str) -> tuple[set[str], list[str]]:
    """
    Return the files in which colcon-cmake finds dependencies.

    With them come all folders that they may be in; all are relative.
    """
    files, folders = set(), []
    for current, below, names in os.walk(path):
        below[:] = [name for name in below if not name.startswith('.')]
        relative = os.path.relpath(current, path)
        folders.append(relative)
        for name in names:
            if name == _CMAKE or name.endswith('.cmake'):
                files.add(os.path.normpath(os.path.join(relative, name)))
    return files, folders


def candidates(
    path: str, names: Collection[str]
) -> dict[str, Fingerprint | None]:
    """Return what all is like that :func:`relevant` may turn out to return."""
    files, folders = set(names), ['.']
    if _CMAKE in files:
        below, folders = cmake_files(path)
        files |= below
    return settled(path, (*files, *folders))


def settled(
    path: str, names: Collection[str]
) -> dict[str, Fingerprint | None]:
    """Return the fingerprints of paths, None where a change may not show."""
    found = {}
    for name in names:
        now = fingerprint(f'{path}/{name}')
        found[name] = now if now is not None and now.is_settled else None
    return found


def is_certain(kind: str, package_type: str, names: Collection[str]) -> bool:
    """
    Tell whether colcon would say the same of a folder without a warning.

    :param kind: What it said: :data:`PACKAGE` or another
    :param package_type: The type of the package, empty if it is none
    :param names: The files directly in the folder
    """
    if kind == IGNORED:
        return not _IGNORING.isdisjoint(names)
    if MANIFEST in names:
        return package_type.startswith(_ROS)
    if kind == PLAIN:
        return _CMAKE not in names and 'setup.py' not in names
    return package_type in ('cmake', 'python')


def conditions(path: str) -> tuple[set[str], bool]:
    """
    Return what a manifest says that depends on more than the manifest.

    That is the variables that conditions may name, and whether it depends on
    the members of a group.
    """
    text = text_of(Path(path, MANIFEST))
    names = set(_VARIABLE.findall(text)) if 'condition' in text else set()
    return names, 'group_depend' in text
