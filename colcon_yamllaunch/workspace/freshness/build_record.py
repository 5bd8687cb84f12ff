# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The record of a package's last build: its inputs, mode and result.

It is in the package's folder below `build/`. It is written before a build
starts and again when the build has ended, so that an interrupted build shows.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from enum import IntEnum
import json
import os
from pathlib import Path
import platform
import shlex
import shutil
import sys
from typing import Any

from colcon_yamllaunch.common.codec import Codec, only
from colcon_yamllaunch.common.files import content_of, write_json
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.frozen import dataclass

#: What a build may read, beside all that begins with CMAKE_.
_VARIABLES = (
    *('CC', 'CXX', 'FC', 'CUDACXX', 'CUDAHOSTCXX', 'HIPCXX', 'HIPHOSTCXX'),
    *('OBJC', 'OBJCXX', 'ISPC', 'ASM', 'RC', 'SWIFTC'),
    *('CFLAGS', 'CXXFLAGS', 'CPPFLAGS', 'FFLAGS', 'LDFLAGS', 'ASMFLAGS'),
    *('CUDAFLAGS', 'CUDAARCHS', 'HIPFLAGS', 'OBJCFLAGS', 'OBJCXXFLAGS'),
    # of GCC and Clang
    *('CPATH', 'C_INCLUDE_PATH', 'CPLUS_INCLUDE_PATH', 'OBJC_INCLUDE_PATH'),
    *('OBJCPLUS_INCLUDE_PATH', 'LIBRARY_PATH', 'COMPILER_PATH'),
    *('GCC_EXEC_PREFIX', 'LD_RUN_PATH', 'SOURCE_DATE_EPOCH'),
    *('DESTDIR', 'PKG_CONFIG', 'PKG_CONFIG_PATH', 'PKG_CONFIG_LIBDIR'),
    *('PKG_CONFIG_SYSROOT_DIR', 'COLCON_PREFIX_PATH', 'AMENT_PREFIX_PATH'),
    'CMAKE_PREFIX_PATH',
)
#: What builds call, with the variable that may name another one.
_PROGRAMS = (('cc', 'CC'), ('c++', 'CXX'), ('cmake', ''), ('python3', ''))
#: The name of a record, below `build/<package>/`.
RECORD_NAME = 'colcon_launch.json'
#: To be raised when what is in a record changes.
RECORD_VERSION = 4


class BuildMode(IntEnum):
    """
    How a package is built; each mode includes those before it.

    Build tools compare times and cache answers of earlier runs. Where this
    could give another result than a build from scratch, less is reused.
    """

    #: The build tool decides; only compiled code changed.
    COMPILE = 0
    #: The build tool decides.
    BUILD = 1
    #: CMake configures again; compiled code stays.
    CONFIGURE = 2
    #: Installed files are removed first.
    REINSTALL = 3
    #: The build folder is removed, too.
    CLEAN = 4


@dataclass(frozen=True, slots=True)
class Reason:
    """
    A reason to build.

    :param text: Such as `src/flow.cpp changed`
    :param mode: How to build
    :param is_damage: Whether a product was changed after the build
    """

    text: str
    mode: BuildMode = BuildMode.BUILD
    is_damage: bool = False


@dataclass(frozen=True, slots=True)
class Decision:
    """
    Whether and why a package is built.

    :param reasons: Why it is built, the most important one first; none if it
      is up to date
    :param built_at: When it was last built successfully, as far as is known
      (nanoseconds since the epoch)
    """

    name: str
    reasons: tuple[Reason, ...] = ()
    built_at: int | None = None

    @property
    def is_stale(self) -> bool:
        """Whether the package is built."""
        return bool(self.reasons)

    @property
    def reason(self) -> str:
        """The first reason."""
        return self.reasons[0].text if self.reasons else ''

    @property
    def mode(self) -> BuildMode:
        """How it is built."""
        return max((r.mode for r in self.reasons), default=BuildMode.COMPILE)


@dataclass(frozen=True, slots=True)
class BuildContext:
    """
    What a package's build depends on beside its own source.

    :param settings: The arguments of the build, by name
    :param environment: The variables that a build may read, and the programs
      that it calls
    :param dependencies: The last build of each needed package, as
      :func:`build_identifier` tells it, or None where that is not known
    """

    settings: Mapping[str, str]
    environment: Mapping[str, str]
    dependencies: Mapping[str, str | None]


def build_identifier(clean_id: str, interface_id: str, build: str) -> str:
    """
    Return the name of a build of a package.

    :param clean_id: The last build that was made from scratch
    :param interface_id: The last build of more than compiled code
    :param build: The last build
    """
    return f'{clean_id}\n{interface_id}\n{build}'


def context_changes(
    before: BuildContext, now: BuildContext
) -> Iterator[Reason]:
    """
    Iterate over the changes of a build's context.

    Build tools keep earlier arguments, compilers and packages, so that changes
    of these need a build from scratch.
    """
    for name in _changes(before.settings, now.settings):
        text = f'build arguments changed ({name})'
        yield Reason(text, BuildMode.CLEAN)
    for name in _changes(before.environment, now.environment):
        yield Reason(f'{name} changed in the environment', BuildMode.CLEAN)
    for name in _changes(before.dependencies, now.dependencies):
        mode = _mode(before.dependencies.get(name), now.dependencies.get(name))
        if name not in now.dependencies:
            text = f'{name} is no longer among what it is built on'
        elif name not in before.dependencies:
            text = f'{name} is new among what it is built on'
        else:
            text = f'{name} was rebuilt'
        yield Reason(text, mode)


def mode_for_dependents(mode: BuildMode) -> BuildMode:
    """
    Return how the packages are built that need another one.

    :param mode: How the other one was built
    """
    # after a build from scratch its files may be older than what was compiled
    # with those before
    if mode in (BuildMode.COMPILE, BuildMode.CLEAN):
        return mode
    # CMake does not know all files that it was made to read
    return BuildMode.CONFIGURE


def relevant_environment(
    environment: Mapping[str, str], install_base: Path
) -> dict[str, str]:
    """
    Return the part of an environment that the outcome of a build depends on.

    The workspace's own install space is left out: whether the user sourced it
    makes no difference. Programs are told apart by place, size and time.
    """
    relevant = {'python': f'{sys.executable} {platform.python_version()}'}
    for name, value in environment.items():
        if name in _VARIABLES or name.startswith('CMAKE_'):
            relevant[name] = _without_workspace(value, install_base)
    for program, variable in _PROGRAMS:
        relevant[program] = _program(program, variable, environment)
    return {name: value for name, value in relevant.items() if value}


def searched_variables(
    names: Iterable[str], environment: Mapping[str, str], install_base: Path
) -> dict[str, str]:
    """
    Return variables that a package looks for by itself.

    Those that any build reads are left out; one that is not set is empty.
    """
    return {
        name: _without_workspace(environment.get(name, ''), install_base)
        for name in sorted(names)
        if name not in _VARIABLES and not name.startswith('CMAKE_')
    }


def changed_variables(
    before: Mapping[str, str],
    environment: Mapping[str, str],
    install_base: Path,
) -> Iterator[Reason]:
    """
    Iterate over the changes of variables.

    :param before: As :func:`searched_variables` returned them
    """
    for name, value in before.items():
        now = environment.get(name, '')
        if now != value and _without_workspace(now, install_base) != value:
            text = f'{name} changed in the environment'
            yield Reason(text, BuildMode.CLEAN)


def _without_workspace(value: str, install_base: Path) -> str:
    return os.pathsep.join(
        entry
        for entry in value.split(os.pathsep)
        if entry and not Path(entry).is_relative_to(install_base)
    )


def _program(name: str, variable: str, environment: Mapping[str, str]) -> str:
    try:
        words = shlex.split(environment.get(variable, '')) or [name]
    except ValueError:
        words = [name]
    path = shutil.which(words[0], path=environment.get('PATH', os.defpath))
    if path is None:
        return ''
    real = os.path.realpath(path)
    try:
        status = os.stat(real)
    except OSError:
        return real
    return f'{real} {status.st_size} {status.st_mtime_ns}'


def _changes(
    before: Mapping[str, str | None], now: Mapping[str, str | None]
) -> Iterator[str]:
    for name in sorted({*before, *now}):
        value = now.get(name)
        # what is not known is not even equal to itself
        if value is None or before.get(name) != value:
            yield name


def _mode(before: str | None, now: str | None) -> BuildMode:
    if before is None or now is None:
        return BuildMode.CONFIGURE
    clean_id, interface_id, _ = now.split('\n')
    before_clean_id, before_interface_id, _ = before.split('\n')
    if clean_id != before_clean_id:
        return mode_for_dependents(BuildMode.CLEAN)
    return mode_for_dependents(
        BuildMode.COMPILE
        if interface_id == before_interface_id
        else BuildMode.BUILD
    )


class DamagedRecordError(Exception):
    """There is a record, but it cannot be read."""


@dataclass(frozen=True, slots=True)
class Record:
    """
    A build.

    :param files: The files of the source before the build; one that is read
      from elsewhere goes by its absolute path
    :param written: Those that were written during the build
    :param generated: Those that builds write by themselves
    :param mode: How it was built, as a number
    :param id: Another one for each build
    :param clean_id: The id of the last build from scratch
    :param interface_id: The id of the last build of more than compiled code
    :param succeeded: Whether it ended well; all below is as it was after the
      last build that did
    :param finished: When it ended (nanoseconds since the epoch), or 0
    :param built_at: When a build ended well, or 0
    :param live: The files whose edits show without a build
    :param installed: What was installed, relative to the install space, and
      what it was like
    :param products: What was built, relative to the build folder, likewise
    :param traces: When the files that colcon leaves were written
    :param arguments: Those that CMake was called with, as colcon keeps them
    :param variables: Variables that the package looked for by itself
    """

    source: str
    files: dict[str, Fingerprint]
    written: frozenset[str] = frozenset()
    generated: frozenset[str] = frozenset()
    mode: int = BuildMode.COMPILE
    id: str = ''
    clean_id: str = ''
    interface_id: str = ''
    succeeded: bool = False
    finished: int = 0
    built_at: int = 0
    live: frozenset[str] = frozenset()
    installed: dict[str, Fingerprint] = field(default_factory=dict)
    products: dict[str, Fingerprint] = field(default_factory=dict)
    traces: dict[str, int] = field(default_factory=dict)
    arguments: str = ''
    variables: dict[str, str] = field(default_factory=dict)
    context: BuildContext = BuildContext({}, {}, {})


def read_record(path: Path) -> Record | None:
    """
    Read a record; None if there is none, or one of another version.

    :raises DamagedRecordError: when there is one that makes no sense
    """
    try:
        data = content_of(path)
    except OSError:
        return None
    try:
        values = json.loads(data)
        version = values.pop('version')
        if isinstance(version, int) and version != RECORD_VERSION:
            return None
        return _CODEC.from_json(Record, values)
    except (ValueError, TypeError, KeyError, AttributeError) as e:
        raise DamagedRecordError from e


def write_record(path: Path, record: Record) -> None:
    """Write a record; without one it is built again, which is no harm."""
    values = _CODEC.to_json(record)
    write_json(path, {'version': RECORD_VERSION, **values})


def _read_files(data: Any) -> dict[str, Fingerprint]:
    # each launch reads thousands of them, of its own making
    return {path: Fingerprint(*one) for path, one in only(dict, data).items()}


# which file it is does not matter
_CODEC = Codec(
    special={
        dict[str, Fingerprint]: (
            lambda files: {path: files[path][:-1] for path in sorted(files)},
            _read_files,
        )
    }
)
