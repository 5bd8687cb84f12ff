# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Find the workspace and the launch file."""

from collections.abc import Callable, Iterable
from contextlib import suppress
import os
from pathlib import Path
import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.suggestions import nearest, question
from colcon_yamllaunch.workspace.packages.package import BrokenManifest
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.packages.workspace_root import (
    find_root,
    Trust,
)

#: The variable that names a workspace to use outside of all.
WORKSPACE = 'ROS_WORKSPACE'

# what a launch file of any language has if it, or what it includes, names a
# package
_PACKAGE = re.compile('pkg|package|include', re.IGNORECASE)

#: What the path of a launch file ends in.
PATH_SUFFIXES = ('.yaml', '.yml', '.launch', '.xml', '.py')
#: How many launch files of a workspace are listed at most.
LISTED = 20


@dataclass(frozen=True, slots=True)
class Target:
    """
    A launch file.

    :param name: The path that it goes by: where it is, or will be, installed
    :param package: The package that was named, if one was
    """

    name: str
    path: str
    package: str | None = None


def find_workspace(
    given: str | Path | None,
    positionals: Iterable[str],
    *,
    builds: bool = False,
) -> Path | None:
    """
    Find the workspace that is given, or else the one around.

    Outside of all it is that of the variable `ROS_WORKSPACE`, if that names
    a folder.

    :param given: The value of `--workspace`, if given
    :param positionals: Words, the path of a launch file maybe among them
    :param builds: Whether the user asks for a build, whatever is launched
    :raises UserError: when the folder that is given does not exist, or what
      is found belongs to somebody else
    """
    if given is not None:
        folder = Path(given).expanduser().absolute()
        if not os.path.isdir(folder):
            raise UserError(f"there is no workspace folder '{given}'")
        return _trusted(folder)
    files = (Path(w) for w in positionals if w.endswith(PATH_SUFFIXES))
    file = next((f for f in files if os.path.isfile(f)), None)
    # the search takes long where there are many folders
    searches = builds or file is None or bool(_PACKAGE.search(text_of(file)))
    cwd = Path.cwd()
    root = find_root(cwd, searches=searches)
    folder = cwd if file is None else file.absolute().parent
    if root is None and folder != cwd:
        root = find_root(folder, searches=searches)
    if root is None and os.environ.get(WORKSPACE):
        folder = Path(os.environ[WORKSPACE]).expanduser()
        # what is relative would mean another one in each folder
        if folder.is_absolute() and os.path.isdir(folder):
            return _trusted(folder)
    return root


def _trusted(folder: Path) -> Path:
    Trust(os.environ).check(Path(os.path.realpath(folder)))
    return folder


def launch_commands(locator: PackageLocator) -> str:
    """Return a listing of the launch files that there are, '' for none."""
    # a launch file that is named by its path is not searched for
    from colcon_yamllaunch.workspace.packages.launch_files import (
        checkable_launch_files,
    )

    commands = [
        f'\n  colcon launch {package.name} {Path(file).name}'
        for package in sorted(locator.packages(), key=lambda p: p.name)
        for file in checkable_launch_files(package.path)
    ]
    if not commands:
        return ''
    more = '\n  …' if len(commands) > LISTED else ''
    return f'\nLaunch files here:{"".join(commands[:LISTED])}{more}'


def find_target(
    positionals: tuple[str, ...],
    cwd: Path,
    locator: PackageLocator,
    broken: Callable[[], Iterable[BrokenManifest]] = tuple,
) -> Target:
    """
    Return the launch file that words name.

    :param positionals: The path of a launch file, or a package and its file
    :param broken: Returns the manifests in the workspace that make no package
    :raises UserError: when there is no such launch file
    """
    target = _path_target(positionals, cwd, locator)
    return target or _package_target(positionals, locator, broken)


def _path_target(
    positionals: tuple[str, ...], cwd: Path, locator: PackageLocator
) -> Target | None:
    """Return the launch file that is given by its path; None for a package."""
    word = positionals[0]
    path = cwd / Path(word).expanduser()
    if os.path.isfile(path):
        _refuse_more(positionals[1:])
        return Target(str(path), str(path))
    if '/' in word or (len(positionals) == 1 and word.endswith(PATH_SUFFIXES)):
        hint = ''
        with suppress(OSError):
            others = {*os.listdir(path.parent)} - {path.name}
            if near := nearest(path.name, others):
                # as it works from here
                hint = question(str(Path(word).parent / near)) or ''
        if '/' not in word:
            hint += launch_commands(locator)
        hint = hint.strip()
        raise UserError(f"there is no launch file '{word}'", hint or None)
    return None


def _package_target(
    positionals: tuple[str, ...],
    locator: PackageLocator,
    broken: Callable[[], Iterable[BrokenManifest]],
) -> Target:
    """Return the launch file of a package."""
    from colcon_yamllaunch.workspace.packages import launch_files

    package, *rest = positionals
    _refuse_more(rest[1:])
    prefix = locator.prefix(package)
    if prefix is None:
        raise unknown_package(package, locator, broken)
    own = locator.package(package)
    folder = Path(locator.share(package) or '') if own is None else own.path
    files = launch_files.find_launch_files(folder)
    if not rest:
        likely = launch_files.likely_ones(files)
        if not likely:
            raise UserError(f'{package} has no launch files')
        listed = ''.join(f'\n  {one_line(file)}' for file in likely)
        raise UserError(
            f'no launch file of {package} is given', f'it has:{listed}'
        )
    chosen = launch_files.choose_launch_file(package, files, rest[0])
    path = str(folder / chosen)
    name = None if own is None else locator.installed_path(package, path)
    return Target(name or path, path, package)


def unknown_package(
    package: str,
    locator: PackageLocator,
    broken: Callable[[], Iterable[BrokenManifest]],
) -> UserError:
    """
    Return the error for a package that does not exist.

    :param broken: Returns the manifests in the workspace that make no package
    """
    for manifest in broken():
        if package in (manifest.name, manifest.path.name):
            return UserError(
                f'{package} is no package, as this file is invalid: '
                f'{manifest.reason}',
                place=str(manifest.path / 'package.xml'),
            )
    return locator.no_package(
        package,
        'run in the workspace that has it, or name that one with --workspace',
    )


def _refuse_more(positionals: list[str] | tuple[str, ...]) -> None:
    for word in positionals:
        name, is_given, value = word.partition('=')
        meant = f'{name}:={value}' if name and is_given else None
        hint = question(meant) or 'it is written name:=value'
        raise UserError(f"malformed launch argument '{word}'", hint)
