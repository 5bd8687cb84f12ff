# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Finding the packages of a workspace fast.

Folders are visited in the order and by the rules of colcon-recursive-crawl:
what colcon says is ignored or a package is not looked into, nor are folders
whose names start with a dot, and no folder is visited twice. What a folder is
says colcon itself; its answer is kept with what it came from, so that colcon
is asked about new and changed folders only.
"""

from collections.abc import (
    Callable,
    Collection,
    Iterable,
    Mapping,
    Sequence,
    Set,
)
import os
from pathlib import Path
import re
from typing import Any, Protocol

from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.fingerprint import Fingerprint, fingerprint
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.workspace_root import (
    IGNORE_MARKERS,
    is_folder,
)

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


#: What colcon said about a folder, and what that depends on; as in JSON.
Entry = dict[str, Any]
#: What an entry has besides if it is a package.
_OF_PACKAGES = {'name', 'path', 'type', 'build', 'run', 'metadata'}


def _content(path: str) -> tuple[set[str], list[str]] | None:
    """Return the files in a folder and the folders crawled below, or None."""
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


def _relevant(
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


def _settled(path: str, names: Iterable[str]) -> dict[str, Fingerprint | None]:
    """Return the fingerprints of paths, None where a change may not show."""
    found = {}
    for name in names:
        now = fingerprint(f'{path}/{name}')
        found[name] = now if now is not None and now.is_settled else None
    return found


def _is_certain(kind: str, package_type: str, names: Collection[str]) -> bool:
    """
    Return whether colcon would say the same of a folder without a warning.

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


class Identifier(Protocol):
    """What knows packages, as `colcon_adapter.Colcon`."""

    def identify(self, folder: str) -> tuple[str, str]:
        """Return what kind a folder is, and the type of a package."""

    def describe(self) -> Mapping[str, tuple[Package, str]]:
        """Return the identified packages with their own settings."""


class PackageIndex:
    """
    What the folders of a workspace are.

    :param base_paths: Where to look, relative to the workspace
    :param environment: The variables of conditions in manifests
    :param everywhere: Whether any folder may be a package, because files
      elsewhere may say so
    """

    def __init__(
        self,
        root: Path,
        base_paths: Sequence[str],
        environment: Mapping[str, str],
        everywhere: bool = False,
    ) -> None:
        self._root = str(root)
        self._base_paths = tuple(base_paths)
        self._environment = environment
        self._everywhere = everywhere
        self._entries: dict[str, Entry] = {}
        self._has_learned = False
        #: Whether anything is not as it was known before.
        self.changed = False

    def find(
        self, known: Mapping[str, Entry], ask: Callable[[], Identifier]
    ) -> None:
        """
        Visit all folders.

        :param known: The entries of an earlier time
        :param ask: Gets what is asked about all that is not known
        """
        self._crawl(known, ask)
        has_vanished = not known.keys() <= self._entries.keys()
        self.changed = self.changed or has_vanished
        if (self._has_learned or has_vanished) and any(
            entry.get('groups', True)
            for entry in (*known.values(), *self._entries.values())
        ):
            # members of a group may be anywhere
            self._crawl({}, ask)
        if self._has_learned:
            for folder, (package, metadata) in ask().describe().items():
                self._entries.get(folder, {}).update(
                    name=package.name,
                    path=str(package.path),
                    build=sorted(package.build_depends),
                    run=sorted(package.run_depends),
                    metadata=metadata,
                )

    def packages(self) -> dict[str, Package]:
        """Return the packages by the folder that colcon knows them by."""
        return {
            folder: Package(
                name=entry['name'],
                path=Path(entry['path']),
                type=entry['type'],
                build_depends=frozenset(entry['build']),
                run_depends=frozenset(entry['run']),
            )
            for folder, entry in self._entries.items()
            if entry['kind'] == PACKAGE
        }

    def metadata(self) -> dict[str, str]:
        """Return the packages' own settings, by name, where there are any."""
        return {
            entry['name']: entry['metadata']
            for entry in self._entries.values()
            if entry['kind'] == PACKAGE and entry['metadata']
        }

    def cacheable_entries(self) -> dict[str, Entry]:
        """Return the entries that may be relied on later."""
        return {
            folder: entry
            for folder, entry in self._entries.items()
            if entry['files'] is not None
        }

    def _crawl(
        self, known: Mapping[str, Entry], ask: Callable[[], Identifier]
    ) -> None:
        self._entries = {}
        seen: set[tuple[int, int]] = set()
        pending = list(reversed(self._base_paths))
        while pending:
            folder = pending.pop()
            path = os.path.join(self._root, folder)
            try:
                status = os.stat(path)
            except OSError:
                continue
            place = (status.st_dev, status.st_ino)
            if place in seen:
                continue
            seen.add(place)
            entry = self._if_valid(known.get(folder), path, status)
            below: list[str] = []
            if entry is None or entry['kind'] == PLAIN:
                # colcon ignores it whatever else is in it
                is_ignored = os.path.lexists(f'{path}/COLCON_IGNORE')
                found = None if is_ignored else _content(path)
                if found is None:
                    continue
                names, below = found
                if entry is None and (self._everywhere or names & MARKERS):
                    entry = self._learn(folder, path, names, ask())
            if entry is not None:
                self._entries[folder] = entry
            if entry is None or entry['kind'] == PLAIN:
                below.sort(reverse=True)
                pending += [os.path.join(folder, name) for name in below]

    def _if_valid(
        self, entry: Entry | None, path: str, status: os.stat_result
    ) -> Entry | None:
        """Return a known entry if all that it came from is as it was."""
        try:
            if entry is None or not self._holds(entry, path):
                return None
            folders = dict(entry['folders'])
            known = folders.pop('.', None)
            if (
                known is not None
                and Fingerprint.of(status) == tuple(known)
                and _are_same(path, folders)
            ):
                return entry
            # something was added or removed, which need not matter
            names, _ = _content(path) or (set(), [])
            files, below = _relevant(path, entry['type'], names)
            if files != entry['files'].keys():
                return None
        except (KeyError, TypeError, AttributeError):
            # damaged
            return None
        self.changed = True
        return entry | {'folders': _settled(path, below)}

    def _holds(self, entry: Entry, path: str) -> bool:
        variables = entry['variables'].items()
        return (
            entry['kind'] in (PACKAGE, IGNORED, PLAIN)
            and (entry['kind'] != PACKAGE or entry.keys() >= _OF_PACKAGES)
            and all(self._environment.get(n) == v for n, v in variables)
            and _are_same(path, entry['files'])
        )

    def _learn(
        self, folder: str, path: str, names: set[str], identifier: Identifier
    ) -> Entry:
        self.changed = self._has_learned = True
        # before colcon reads them, so that a change in between will show:
        # all that may turn out to be relevant
        below, folders = cmake_files(path) if _CMAKE in names else ((), ['.'])
        before = _settled(path, (*names, *below, *folders))
        kind, package_type = identifier.identify(folder)
        files, folders = _relevant(path, package_type, names)
        certain = _is_certain(kind, package_type, names)
        manifest = text_of(Path(path, MANIFEST))
        # those that conditions may name
        has_conditions = 'condition' in manifest
        variables = _VARIABLE.findall(manifest) if has_conditions else []
        return {
            'kind': kind,
            'type': package_type,
            'files': {name: before.get(name) for name in sorted(files)}
            if certain
            else None,
            'folders': {name: before.get(name) for name in folders},
            'variables': {
                name: self._environment.get(name) for name in sorted(variables)
            },
            'groups': 'group_depend' in manifest,
        }


def _are_same(path: str, known: Mapping[str, Any]) -> bool:
    """Return whether what is in a folder has its known fingerprints."""
    return all(
        then is not None and fingerprint(f'{path}/{name}') == tuple(then)
        for name, then in known.items()
    )
