# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What to do about a file that a launch needs and that is not installed."""

from collections.abc import Iterable
import os
from pathlib import Path
import re
from typing import NamedTuple

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.suggestions import (
    did_you_mean,
    nearest_first,
    question,
)
from colcon_yamllaunch.workspace.packages.package import Package, source_files
from colcon_yamllaunch.workspace.packages.package_locator import (
    is_executable,
    PackageLocator,
)

#: How many names are listed at most.
LISTED = 10

_SCRIPTS = ('.py', '.sh')
_COMPILED = ('.c', '.cc', '.cpp', '.cxx')
_CODE = (*_COMPILED, '.h', '.hh', '.hpp', '.hxx', '.py')
_PROGRAM_SUFFIXES = (*_SCRIPTS, *_COMPILED)
# folders and files whose scripts a build installs as no programs
_NO_PROGRAMS = frozenset(('test', 'tests', 'launch', 'setup.py'))
# the ways to build whose programs the build files name
_KNOWN_TYPES = (
    *('cmake', 'ros.cmake', 'ros.ament_cmake', 'ros.catkin'),
    *('python', 'ros.ament_python'),
)
_BUILD_FILES = ('CMakeLists.txt', 'setup.py', 'setup.cfg', 'pyproject.toml')

#: What makes setuptools install programs elsewhere than in `bin/`.
_SCRIPT_FOLDER = 'script[-_]dir|install[-_]scripts'


def missing_executable(
    locator: PackageLocator, package: str, name: str
) -> WorkspaceError | None:
    """
    Explain why a package has no such program, with the cure; None if it has.

    :param locator: The packages as they are after the build
    """
    prefix = locator.prefix(package)
    if prefix is None:
        return locator.no_package(package)
    path = Path(prefix, 'lib', package, name)
    if is_executable(path):
        return None
    own = locator.package(package)
    known = locator.executables(package)
    if os.path.isfile(path):
        return _not_executable(_origin(path, own), own)
    spelling = _same_stem(name, known)
    if spelling:
        return _meant(package, name, spelling[0])
    if os.path.isfile(Path(prefix, 'bin', name)):
        return _in_bin(package, name, own)
    source = own and _source_file(own, name)
    if own is not None and source:
        return _not_installed_program(own, source, name)
    return _no_executable(package, name, _nearest(name, known))


def unknown_executable(
    locator: PackageLocator, package: str, name: str
) -> WorkspaceError | None:
    """
    Explain why not even a build would bring a program.

    Return None when the program is there, or the package's source has or
    mentions it.

    :param locator: The packages, built or not
    """
    own = locator.package(package)
    prefix = locator.prefix(package)
    if own is None or prefix is None:
        return missing_executable(locator, package, name)
    if is_executable(Path(prefix, 'lib', package, name)):
        return None
    # most launches name what is there
    from colcon_yamllaunch.workspace.packages.build_files import (
        names_all_programs,
        source_programs,
    )

    programs = source_programs(own.path)
    if own.type not in _KNOWN_TYPES:
        return None
    if name in programs.scripts:
        return _in_bin_by_default(package, name, own)
    source = _source_file(own, name)
    is_mentioned = _is_mentioned(own, name)
    is_script = source is not None and (
        Path(source).name == name or Path(source).suffix in _SCRIPTS
    )
    is_known = not is_mentioned and names_all_programs(own.path)
    if source is not None and is_script and is_known:
        same = _same_stem(name, programs.names)
        if not same:
            return _not_installed_program(own, source, name)
        return _meant(package, name, same[0])
    if source is not None and Path(source).name == name:
        files = (own.path / file for file, _ in source_files(own.path))
        # setuptools makes executable what it installs
        if own.type.endswith('python') or any(
            file.name == name and is_executable(file) for file in files
        ):
            return None
        return _not_executable(own.path / source, own)
    if is_mentioned:
        return _in_bin_by_default(package, name, own)
    if programs.may_have(name):
        return None
    if source is not None and Path(source).suffix in _SCRIPTS:
        return _meant(package, name, Path(source).name)
    scripts = programs.names or {
        Path(file).name
        for file, _ in source_files(own.path)
        if Path(file).suffix in _SCRIPTS
        and not file.endswith('.launch.py')
        and _NO_PROGRAMS.isdisjoint(Path(file).parts)
    }
    known = {*locator.executables(package), *scripts}
    listed = _nearest(name, known) if known else 'its build files name none'
    return _no_executable(package, name, listed)


def certainly_unknown_executable(
    locator: PackageLocator, package: str, name: str
) -> WorkspaceError | None:
    """
    Explain why a build would be in vain, as it brings no such program.

    Unlike :func:`unknown_executable`, which may miss a program that CMake
    makes of variables, this returns None where the source does not tell.

    :param locator: The packages, built or not
    """
    # only a launch that builds asks
    from colcon_yamllaunch.workspace.packages.build_files import (
        names_all_programs,
    )

    own = locator.package(package)
    # a program in a subfolder of lib/PACKAGE goes by its path from there
    if own is not None and ('/' in name or not names_all_programs(own.path)):
        return None
    return unknown_executable(locator, package, name)


def _meant(package: str, name: str, other: str) -> WorkspaceError:
    return WorkspaceError(f"{package} has no '{name}'", question(other))


def _no_executable(package: str, name: str, listed: str) -> WorkspaceError:
    return WorkspaceError(f"{package} has no executable '{name}'", listed)


def _in_bin_by_default(
    package: str, name: str, own: Package
) -> WorkspaceError | None:
    """Explain why setuptools installs a program where none is looked for."""
    is_elsewhere = re.search(_SCRIPT_FOLDER, text_of(own.path / 'setup.cfg'))
    if is_elsewhere or not own.type.endswith('python'):
        return None
    return _in_bin(package, name, own)


def _same_stem(name: str, known: Iterable[str]) -> list[str]:
    stem = Path(name).stem
    return sorted(other for other in known if Path(other).stem == stem)


def _is_mentioned(package: Package, name: str) -> bool:
    """Return whether the build files of a package have a name in them."""
    word = re.compile(rf'(?<![\w.-]){re.escape(name)}(?![\w.-])')
    return any(
        word.search(text_of(package.path / file))
        for file, _ in source_files(package.path)
        if Path(file).name in _BUILD_FILES or Path(file).suffix == '.cmake'
    )


class MissingPlugin(NamedTuple):
    """
    Why a component cannot be loaded.

    :param reason: Why, with the cure
    :param is_certain: Whether no container can load it
    """

    reason: str
    is_certain: bool


def missing_plugin(
    locator: PackageLocator, package: str, plugin: str
) -> MissingPlugin | None:
    """
    Explain why a package has no such component; None if it has.

    :param locator: The packages as they are after the build
    """
    known = locator.plugins(package)
    if known is None:
        # containers of other kinds may have lists of their own
        own = locator.package(package)
        reason = f'{package} has installed no components'
        if own is not None and not own.type.endswith('python'):
            reason += (
                ": add 'rclcpp_components_register_nodes(TARGET "
                f'"{plugin}")\' with its library as TARGET to '
                f'{own.path / "CMakeLists.txt"}'
            )
        return MissingPlugin(reason, own is not None)
    return None if plugin in known else _no_plugin(package, plugin, known)


def unknown_plugin(
    locator: PackageLocator, package: str, plugin: str
) -> MissingPlugin | None:
    """
    Explain why not even a build would bring a component.

    Return None when it is there, or the package's source mentions its class.

    :param locator: The packages, built or not
    """
    own = locator.package(package)
    known = set(locator.plugins(package) or ())
    if own is None or plugin in known:
        return missing_plugin(locator, package, plugin)
    # the namespace may be a variable of CMake's, or stand elsewhere
    name = plugin.rpartition('::')[2]
    if _is_mentioned(own, name) or _is_in_source(own, name):
        return None
    from colcon_yamllaunch.workspace.packages.build_files import source_plugins

    return _no_plugin(package, plugin, known | source_plugins(own.path))


def _no_plugin(
    package: str, plugin: str, known: Iterable[str]
) -> MissingPlugin:
    meant = did_you_mean(plugin, known)
    texts = filter(None, (meant, _nearest(plugin, known)))
    reason = f"{package} has no component '{plugin}': {' '.join(texts)}"
    return MissingPlugin(reason, is_certain=True)


def _is_in_source(package: Package, name: str) -> bool:
    """Return whether a class of that name may be in what is compiled."""
    word = re.compile(rf'\b{re.escape(name)}\b')
    return any(
        word.search(text_of(package.path / file))
        for file, _ in source_files(package.path)
        if Path(file).suffix in _CODE
    )


def not_installed(locator: PackageLocator, path: str) -> WorkspaceError | None:
    """
    Explain why a file is not there though the package's source has it.

    Return None when the file is there or no source of it is known.

    :param locator: The packages as they are after the build
    :param path: A path below the share folder of a package
    """
    found = locator.shared(path)
    source = locator.source_of(path)
    if found is None or source is None or os.path.exists(Path(path)):
        return None
    package, relative = found
    origin = os.path.relpath(source, package.path)
    if package.type.endswith('python'):
        folder = Path('share', package.name, relative.parent).as_posix()
        cure = f"add ('{folder}', ['{origin}']) to data_files in setup.py"
    else:
        what, into = f'FILES {origin}', Path('share/${PROJECT_NAME}')
        has_folder = os.path.isdir(os.path.dirname(path))
        if has_folder or origin != str(relative):
            into /= relative.parent
        elif len(relative.parts) > 1:
            what = f'DIRECTORY {relative.parts[0]}'
        cure = f"add 'install({what} DESTINATION {into})' to CMakeLists.txt"
    return WorkspaceError(f'{origin} of {package.name} is not installed', cure)


def _nearest(name: str, known: Iterable[str]) -> str:
    names = nearest_first(name, known)
    if not names:
        return 'it has installed none'
    more = ', …' if len(names) > LISTED else ''
    return f'it has {", ".join(names[:LISTED])}{more}'


def _origin(path: Path, own: Package | None) -> Path:
    """Return the source file that an installed one is a copy of, if known."""
    if own is None or path.is_symlink():
        return path
    source = _source_file(own, path.name)
    if source is None or Path(source).name != path.name:
        return path
    origin = own.path / source
    # with the mode of the source the next build would undo the cure
    return path if is_executable(origin) else origin


def _not_executable(path: Path, own: Package | None) -> WorkspaceError:
    real = Path(os.path.realpath(path))
    if own is not None and real.is_relative_to(os.path.realpath(own.path)):
        relative = os.path.relpath(real, os.path.realpath(own.path))
        return WorkspaceError(
            f'{relative} of {own.name} is not executable',
            f"run 'chmod +x {relative}' in {own.path}",
        )
    return WorkspaceError(
        f'{path} is not executable', f"run 'chmod +x {path}'"
    )


def _source_file(package: Package, name: str) -> str | None:
    """Find the file that the program would be made of."""
    files = sorted(name for name, _ in source_files(package.path))
    for candidates in (
        [f for f in files if Path(f).name == name],
        [f for f in files if Path(f).stem == Path(name).stem],
    ):
        for file in candidates:
            suffix = Path(file).suffix
            if suffix in _PROGRAM_SUFFIXES or (
                not suffix and is_executable(package.path / file)
            ):
                return file
    return None


def _not_installed_program(
    package: Package, source: str, name: str
) -> WorkspaceError:
    text = f'{source} of {package.name} is not installed'
    if package.type.endswith('python') and source.endswith('.py'):
        module = source.removesuffix('.py').replace(os.sep, '.')
        program = name.removesuffix('.py')
        return WorkspaceError(
            text,
            f"add '{program} = {module}:main' to the console_scripts in "
            f'entry_points of {package.path / "setup.py"}',
        )
    what, chmod = f'PROGRAMS {source}', ''
    file = package.path / 'CMakeLists.txt'
    if Path(source).suffix.startswith('.c'):
        targets = re.findall(r'add_executable\s*\(\s*([^\s)]+)', text_of(file))
        is_other = name not in targets and len(targets) == 1
        what = f'TARGETS {targets[0] if is_other else name}'
    elif not is_executable(package.path / source):
        chmod = f", and run 'chmod +x {source}' in {package.path}"
    return WorkspaceError(
        text,
        f"add 'install({what} DESTINATION lib/${{PROJECT_NAME}})' to "
        f'{file}{chmod}',
    )


def _in_bin(package: str, name: str, own: Package | None) -> WorkspaceError:
    text = f"'{name}' of {package} is installed in bin/, not in lib/{package}/"
    if own is None:
        return WorkspaceError(text)
    if own.type.endswith('python'):
        return WorkspaceError(
            text,
            "add the lines '[install]' and 'install_scripts=$base/lib/"
            f"{package}', and the lines '[develop]' and 'script_dir=$base/lib/"
            f"{package}', to {own.path / 'setup.cfg'}",
        )
    return WorkspaceError(
        text, 'install it with DESTINATION lib/${PROJECT_NAME}'
    )
