# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the outcome of a build depends on beside the package's own source."""

from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from dataclasses import field
import os
from pathlib import Path
import platform
import shlex
import shutil
import sys

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.freshness.build_decision import BuildMode
from colcon_yamllaunch.workspace.freshness.build_decision import Reason

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


@dataclass(frozen=True, slots=True)
class BuildContext:
    """
    What a package's build depends on beside its own source.

    :param settings: The arguments of the build, by name
    :param environment: The variables that a build may read, and the programs
      that it calls
    :param dependencies: The last build of each needed package, as
      :func:`build_of` tells it, or None where that is not known
    :param variables: All variables, as some packages look for more of them
    """

    settings: Mapping[str, str]
    environment: Mapping[str, str]
    dependencies: Mapping[str, str | None]
    variables: Mapping[str, str] = field(default_factory=dict)


def build_of(clean_id: str, interface_id: str, build: str) -> str:
    """
    Name a build of a package.

    :param clean_id: The last build that was made from scratch
    :param interface_id: The last build of more than compiled code
    :param build: The last build
    """
    return f'{clean_id}\n{interface_id}\n{build}'


def context_changes(
    before: BuildContext, now: BuildContext
) -> Iterator[Reason]:
    """
    Iterate over what became different for a package.

    A build tool does not forget earlier arguments, compilers or packages that
    it found, so these take a build from scratch.
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


def mode_after(mode: BuildMode) -> BuildMode:
    """
    Tell how a package is built after one that it needs.

    :param mode: How that one was built
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
            relevant[name] = _without_own(value, install_base)
    for program, variable in _PROGRAMS:
        relevant[program] = _program(program, variable, environment)
    return {name: value for name, value in relevant.items() if value}


def own_variables(
    names: Iterable[str], environment: Mapping[str, str], install_base: Path
) -> dict[str, str]:
    """
    Return variables that a package looks for by itself.

    Those that any build reads are left out; one that is not set is empty.
    """
    return {
        name: _without_own(environment.get(name, ''), install_base)
        for name in sorted(names)
        if name not in _VARIABLES and not name.startswith('CMAKE_')
    }


def changed_variables(
    before: Mapping[str, str],
    environment: Mapping[str, str],
    install_base: Path,
) -> Iterator[Reason]:
    """
    Iterate over what became different of variables.

    :param before: As :func:`own_variables` returned them
    """
    for name, value in before.items():
        now = environment.get(name, '')
        if now != value and _without_own(now, install_base) != value:
            text = f'{name} changed in the environment'
            yield Reason(text, BuildMode.CLEAN)


def _without_own(value: str, install_base: Path) -> str:
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
        return mode_after(BuildMode.CLEAN)
    return mode_after(
        BuildMode.COMPILE
        if interface_id == before_interface_id
        else BuildMode.BUILD
    )
