# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What may stand at a place of the command line, for completion."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
import os
from pathlib import Path
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.target import find_workspace
from colcon_yamllaunch.workspace.colcon.package_scan import scan_packages
from colcon_yamllaunch.workspace.packages.build_files import source_programs
from colcon_yamllaunch.workspace.packages.launch_files import (
    find_launch_files,
    launch_file_names,
)
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

if TYPE_CHECKING:
    from colcon_yamllaunch.language.evaluation.findings import DeclaredArgument

#: The largest file of ssh that is read, in bytes.
MAXIMUM_SIZE = 1_000_000

#: Each candidate with its description, which zsh shows.
Candidates = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Cursor:
    """
    Where something is to be completed.

    :param prefix: The word up to the cursor
    :param known: What the parser has made of the words in front
    :param parser: The parser of the verb
    """

    prefix: str
    known: Any
    parser: Any
    environment: Mapping[str, str]

    def given(self, key: str) -> Any:
        """Return what was given for an option in front, or None."""
        return getattr(self.known, key, None)

    def locator(self, words: Sequence[str] = ()) -> PackageLocator:
        """Return the packages; words may have the path of a launch file."""
        root = find_workspace(self.given('workspace') or None, words)
        return scan_packages(root, self.environment)


def packages(cursor: Cursor, words: Sequence[str] = ()) -> Candidates:
    """Return the packages whose names start with the word."""
    names = cursor.locator(words).names()
    return {n: '' for n in names if n.startswith(cursor.prefix)}


def launch_files(cursor: Cursor, package: str) -> Candidates:
    """Return a package's launch files: names, or paths if one is begun."""
    locator = cursor.locator([package])
    own = locator.package(package)
    folder = locator.share(package) if own is None else own.path
    files = () if folder is None else find_launch_files(Path(folder))
    if '/' in cursor.prefix:
        return dict.fromkeys(files, '')
    return dict.fromkeys(launch_file_names(package, files), '')


def executables(cursor: Cursor, package: str) -> Candidates:
    """Return the programs that a package has installed, or will install."""
    locator = cursor.locator()
    names = set(locator.executables(package))
    own = locator.package(package)
    if own is not None:
        names |= source_programs(own.path).names
    return dict.fromkeys(sorted(names), '')


def paths(prefix: str, suffixes: Sequence[str]) -> Candidates:
    """
    Return folders, and files with given endings.

    :raises OSError: when the folder cannot be read
    """
    head = prefix[: prefix.rfind('/') + 1]
    begun = prefix[len(head) :]
    found = []
    with os.scandir(Path(head or '.').expanduser()) as entries:
        for entry in entries:
            name = entry.name
            if name.startswith('.') and not begun:
                continue
            if entry.is_dir():
                found.append(f'{head}{name}/')
            elif name.endswith(tuple(suffixes)):
                found.append(head + name)
    return dict.fromkeys(sorted(found), '')


def hosts(cursor: Cursor) -> Candidates:
    """Return the hosts that ssh knows, or the machines of `--deploy`."""
    deployment = cursor.given('deploy')
    if deployment:
        # it is read for this only
        from colcon_yamllaunch.remote.deployment.deployment_file import (
            read_deployment,
        )

        return dict.fromkeys(read_deployment(deployment).machines, '')
    # there may be a user in front of the host
    user, at, _ = cursor.prefix.rpartition('@')
    folder = Path.home() / '.ssh'
    names = {*_configured(folder / 'config'), *_known(folder / 'known_hosts')}
    return {f'{user}{at}{name}': '' for name in sorted(names)}


def _configured(path: Path) -> Iterator[str]:
    """Return the hosts that a configuration names (ssh_config(5))."""
    for line in _lines(path):
        key, *names = line.replace('=', ' ', 1).split() or ['']
        if key.lower() == 'host':
            yield from (n for n in names if not set(n) & set('*?!"'))


def _known(path: Path) -> Iterator[str]:
    """Return the hosts whose keys are known, unless they are hashed."""
    for line in _lines(path):
        names, *_ = line.split() or ['']
        if names.startswith(('#', '|', '@')):
            continue
        # what has a port of its own stands in brackets
        yield from (n for n in names.split(',') if n and n[0] not in '[!*')


def _lines(path: Path) -> list[str]:
    with suppress(OSError):
        if os.path.isfile(path) and path.stat().st_size <= MAXIMUM_SIZE:
            return path.read_text(errors='replace').splitlines()
    return []


def launch_arguments(
    cursor: Cursor, positionals: Sequence[str], given: Sequence[str]
) -> Candidates:
    """
    Return the launch arguments, or the values of the one that is begun.

    :param positionals: A package and a launch file, or the path of one
    :param given: The launch arguments in front
    :raises UserError: when there is no such launch file
    :raises LaunchError: when a launch file has mistakes
    """
    # reading launch files takes longer to import than all else
    from colcon_yamllaunch.language.evaluation.request import Request
    from colcon_yamllaunch.language.policies.check import find_declarations
    from colcon_yamllaunch.verb.target import package_target, path_target
    from colcon_yamllaunch.verb.workspace_session import (
        exposed_by_packages,
        LaunchPackages,
    )

    locator = cursor.locator(positionals)
    cwd = Path.cwd()
    target = path_target(tuple(positionals), cwd, locator) or package_target(
        tuple(positionals), locator, tuple
    )
    values = dict(word.split(':=', 1) for word in given)
    known = LaunchPackages(locator, built=False)
    located = known.locate(target.name)
    request = Request(
        target.path if located is None else located[0],
        target.path,
        packages=known,
        environment=cursor.environment,
        arguments=values,
        cwd=str(cwd),
        exposed=exposed_by_packages(locator, cursor.environment),
    )
    arguments = find_declarations(request).arguments
    name, found, _ = cursor.prefix.partition(':=')
    if found:
        choices = (_choices(a) for a in arguments if a.name == name)
        return {f'{name}:={c}': '' for c in next(choices, ())}
    return {
        f'{argument.name}:=': _described(argument)
        for argument in arguments
        # where the launch file sets it, the command line does not count
        if argument.name not in values and argument.set_at is None
    }


def _choices(argument: 'DeclaredArgument') -> tuple[str, ...]:
    from colcon_yamllaunch.language.actions.scope_actions import (
        BOOLEAN_CHOICES,
    )

    # of the ways to write a boolean, one will do
    is_boolean = argument.choices == BOOLEAN_CHOICES
    return ('true', 'false') if is_boolean else argument.choices


def _described(argument: 'DeclaredArgument') -> str:
    default = argument.default
    value = 'required' if default is None else f"default: '{default}'"
    text = f'{argument.description or ""} ({value})'
    return ' '.join(text.split())
