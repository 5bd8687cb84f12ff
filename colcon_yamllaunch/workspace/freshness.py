# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Whether what was built last still is what a build would give now.

For each package that was built successfully, a record is kept in its folder
below `build/`. It is removed before a build starts and written after it
succeeded, so an interrupted or failed build leaves none. A record that cannot
be read counts as none, and in doubt a package is built.
"""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from dataclasses import dataclass
from dataclasses import field
import json
import os
from pathlib import Path
import sys
from typing import Any
import uuid

from colcon_yamllaunch.workspace.links import live_files
from colcon_yamllaunch.workspace.links import remove_dangling
from colcon_yamllaunch.workspace.links import tree
from colcon_yamllaunch.workspace.package import Package
from colcon_yamllaunch.workspace.package import prefix_of
from colcon_yamllaunch.workspace.source import difference
from colcon_yamllaunch.workspace.source import FileState
from colcon_yamllaunch.workspace.source import snapshot

#: The name of a record, below `build/<package>/`.
RECORD_NAME = 'colcon_launch.json'
#: To be raised when what is in a record changes.
RECORD_VERSION = 1

_PREFIX_PATHS = (
    'COLCON_PREFIX_PATH',
    'AMENT_PREFIX_PATH',
    'CMAKE_PREFIX_PATH',
)
_VARIABLES = frozenset(
    ('CC', 'CXX', 'FC', 'CUDACXX', 'CUDAHOSTCXX', 'CPATH', 'LIBRARY_PATH')
) | frozenset(
    ('CFLAGS', 'CXXFLAGS', 'CPPFLAGS', 'FFLAGS', 'LDFLAGS', 'PKG_CONFIG_PATH')
)
#: Where each package of a merged install space has files of its own.
_OWN_FOLDERS = ('share/{}', 'lib/{}', 'include/{}')
#: What colcon writes for all packages together (colcon-core).
_PREFIX_SCRIPTS = ('setup.sh', 'local_setup.sh', '_local_setup_util_sh.py')
#: colcon writes these whenever it builds a package (colcon-core,
#: colcon-cmake, colcon-package-selection).
_TRACES = (
    'colcon_command_prefix_build.sh',
    'colcon_command_prefix_setup_py.sh',
    'cmake_args.last',
    'colcon_build.rc',
)


@dataclass(frozen=True, slots=True)
class Conditions:
    """
    What a package's build depends on beside its own source.

    :param settings: The arguments of the build, by name
    :param environment: The variables that a build may read
    :param dependencies: The id of each needed package's last build, or None
      where that is not known
    """

    settings: Mapping[str, str]
    environment: Mapping[str, str]
    dependencies: Mapping[str, str | None]


@dataclass(frozen=True, slots=True)
class Record:
    """
    A successful build.

    :param id: Another one for each build
    :param source: The folder that was built
    :param files: The files of the source before the build
    :param live: Those whose edits show without a build
    :param installed: What was installed, relative to the install space
    :param traces: When the files that colcon leaves were written
    :param settings: As in :class:`Conditions`, and so are the next two
    """

    id: str
    source: str
    files: dict[str, FileState]
    live: frozenset[str]
    installed: list[str]
    traces: dict[str, int]
    settings: dict[str, str]
    environment: dict[str, str]
    dependencies: dict[str, str | None] = field(default_factory=dict)


class Freshness:
    """
    The records of a workspace.

    :param build_base: The build folder of the workspace
    :param install_base: The install folder of the workspace
    :param merge_install: Whether all packages are installed into one prefix
    """

    def __init__(
        self, build_base: Path, install_base: Path, merge_install: bool
    ) -> None:
        self._build_base = build_base
        self._install_base = install_base
        self._merge_install = merge_install

    def stale(self, package: Package, conditions: Conditions) -> str | None:
        """
        Tell why a package has to be built.

        :param package: The package
        :param conditions: Those that hold now
        :returns: Such as `src/flow.cpp changed`, or None if it is up to date
        """
        record = self.record(package.name)
        if record is None:
            return self._unknown(package.name)
        if record.source != str(package.path):
            return f'it was built from {record.source}'
        return (
            self._changed_conditions(record, conditions)
            or self._changed_install(package.name, record)
            or difference(package.path, record.files, record.live)
        )

    def prepare(self, package: Package) -> dict[str, FileState]:
        """
        Get ready for a build: forget the last one, look at the source.

        Links to source files that are gone are removed, as builds trip over
        them.

        :returns: The state of the source, for :meth:`remember`
        """
        record = self.record(package.name)
        self._path(package.name).unlink(missing_ok=True)
        for folder in self._own_folders(package.name):
            remove_dangling(folder, package.path)
        remove_dangling(self._build_base / package.name, package.path)
        return snapshot(package.path, record.files if record else None)

    def remember(
        self,
        package: Package,
        files: Mapping[str, FileState],
        conditions: Conditions,
    ) -> None:
        """
        Write down that a package was built successfully.

        :param package: The package
        :param files: What :meth:`prepare` returned before the build
        :param conditions: Those that the build took place under
        """
        installed = sorted(self._installed(package.name))
        build = self._build_base / package.name
        record = Record(
            id=uuid.uuid4().hex,
            source=str(package.path),
            files=dict(files),
            live=live_files(package.path, files, build, installed),
            installed=[
                os.path.relpath(path, self._install_base)
                for path in installed
                if path.exists()
            ],
            traces=self._traces(package.name),
            settings=dict(conditions.settings),
            environment=dict(conditions.environment),
            dependencies=dict(conditions.dependencies),
        )
        # without a record it is built again, which is no harm
        with suppress(OSError):
            _write(self._path(package.name), _encode(record))

    def record(self, name: str) -> Record | None:
        """Read a package's record; None if there is none that can be used."""
        try:
            return _decode(json.loads(self._path(name).read_bytes()))
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            return None

    def _path(self, name: str) -> Path:
        return self._build_base / name / RECORD_NAME

    def _unknown(self, name: str) -> str:
        if (self._build_base / name).is_dir():
            return 'no successful build of it by colcon launch is known'
        return 'never built'

    def _changed_conditions(
        self, record: Record, conditions: Conditions
    ) -> str | None:
        name = _first_change(record.settings, conditions.settings)
        if name is not None:
            return f'build arguments changed ({name})'
        name = _first_change(record.environment, conditions.environment)
        if name is not None:
            return f'{name} changed in the environment'
        name = _first_change(record.dependencies, conditions.dependencies)
        if name is not None:
            return f'{name} was rebuilt'
        return None

    def _changed_install(self, name: str, record: Record) -> str | None:
        if record.traces != self._traces(name):
            return 'something else built it since'
        for relative in (*_PREFIX_SCRIPTS, *record.installed):
            if not (self._install_base / relative).exists():
                return self._missing(relative, record)
        return None

    def _missing(self, relative: str, record: Record) -> str:
        # a link in the install space may be gone because its target is
        source = Path(record.source)
        reason = difference(source, record.files, record.live)
        return reason or f'{relative} is missing in {self._install_base}'

    def _traces(self, name: str) -> dict[str, int]:
        prefix = prefix_of(name, self._install_base, self._merge_install)
        paths = [self._build_base / name / trace for trace in _TRACES]
        paths.append(prefix / 'share' / name / 'package.sh')
        traces = {}
        for path in paths:
            with suppress(OSError):
                traces[str(path)] = path.stat().st_mtime_ns
        return traces

    def _own_folders(self, name: str) -> list[Path]:
        if not self._merge_install:
            return [self._install_base / name]
        return [
            self._install_base / folder.format(name) for folder in _OWN_FOLDERS
        ]

    def _installed(self, name: str) -> Iterator[Path]:
        for folder in self._own_folders(name):
            yield from tree(folder)


def relevant_environment(
    environment: Mapping[str, str], install_base: Path
) -> dict[str, str]:
    """
    Get the part of an environment that the outcome of a build depends on.

    The workspace's own install space is left out: whether the user sourced it
    makes no difference.

    :param environment: The environment of the build
    :param install_base: The install folder of the workspace
    """
    relevant = {'python': sys.executable}
    for name, value in environment.items():
        if name in _PREFIX_PATHS:
            relevant[name] = _underlays(value, install_base)
        elif name in _VARIABLES or name.startswith('CMAKE_'):
            relevant[name] = value
    return {name: value for name, value in relevant.items() if value}


def _underlays(value: str, install_base: Path) -> str:
    return os.pathsep.join(
        prefix
        for prefix in value.split(os.pathsep)
        if prefix and not Path(prefix).is_relative_to(install_base)
    )


def _first_change(
    before: Mapping[str, str | None], now: Mapping[str, str | None]
) -> str | None:
    for name in sorted({*before, *now}):
        # an unknown id is not even equal to itself
        if name not in before or name not in now or now[name] is None:
            return name
        if before[name] != now[name]:
            return name
    return None


def _encode(record: Record) -> dict[str, Any]:
    values = {key: getattr(record, key) for key in Record.__dataclass_fields__}
    values['files'] = {
        name: list(asdict(state).values())
        for name, state in sorted(record.files.items())
    }
    values['live'] = sorted(record.live)
    return {'version': RECORD_VERSION, **values}


def _decode(values: Any) -> Record | None:
    if values.pop('version') != RECORD_VERSION:
        return None
    values['files'] = {
        name: FileState(*state) for name, state in values['files'].items()
    }
    values['live'] = frozenset(values['live'])
    record = Record(**values)
    return record if _is_sound(record) else None


def _is_sound(record: Record) -> bool:
    texts: Iterable[object] = [record.id, record.source, *record.installed]
    mappings = (
        record.traces,
        record.settings,
        record.environment,
        record.dependencies,
    )
    return all(isinstance(text, str) for text in texts) and all(
        isinstance(mapping, dict) for mapping in mappings
    )


def _write(path: Path, values: Mapping[str, Any]) -> None:
    # the record appears complete or not at all
    temporary = path.with_name(f'{path.name}.{os.getpid()}')
    temporary.write_text(json.dumps(values), encoding='utf-8')
    temporary.replace(path)
