# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The packages and files that a plan names, by paths in its texts."""

from collections.abc import Callable, Iterator
import os.path
from pathlib import Path
import re

from colcon_yamllaunch.common.files import is_user_file
from colcon_yamllaunch.plan.plan import (
    Component,
    Member,
    ParameterFile,
    Plan,
    Process,
)
from colcon_yamllaunch.remote.remote_paths import is_of_system, paths_in
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

#: What no path of a package has, and what stands around paths has.
_BETWEEN = r'[^\s:,;\'"<>|&()\[\]{}]*'
_WORD = re.compile(r'[^\s:=,;\'"<>|&()\[\]{}]+')


def packages_of(
    plan: Plan, locator: PackageLocator, root: Path, install_base: Path
) -> frozenset[str]:
    """
    Return the packages of the workspace that a part of a plan names.

    It names them as the package of a program or component, or by a path, in
    whatever it gives a process.

    :param root: The root of the workspace
    :param install_base: Where its packages are installed
    """
    own = {package.name for package in locator.packages()}
    members = tuple(plan.members())
    found = {member.package for member in members}
    bases = dict.fromkeys(
        str(path)
        for base in (install_base, root)
        for path in (base, os.path.realpath(base))
    )
    pattern = re.compile(f'(?:{"|".join(map(re.escape, bases))})/{_BETWEEN}')
    paths = {
        path
        for member in members
        for text in _texts(member)
        for path in pattern.findall(text)
    }
    for path in paths:
        package = locator.owner(path) or locator.package_of(path)
        if package is not None:
            found.add(package.name)
    return frozenset(name for name in found if name in own)


def named_paths(
    part: Plan, covers: Callable[[str], bool]
) -> Iterator[tuple[str, Process]]:
    """
    Iterate over the paths of a part that its machine may lack.

    Each is with the process that is given it. The last one of each path
    counts, so this begins with the last process.

    :param covers: Whether a path is one of the workspace
    """
    for process in reversed(list(part.processes())):
        texts = [a for a in process.argv if isinstance(a, str)]
        for text in reversed(texts):
            for path in paths_in(text):
                if covers(path) or (
                    not is_of_system(path) and os.path.exists(path)
                ):
                    yield path, process
        program = process.argv[0]
        if isinstance(program, str) and program.startswith('/'):
            yield program, process


def files_of(member: Member, covers: Callable[[str], bool]) -> frozenset[str]:
    """
    Return the files that a process or component names, as absolute paths.

    :param covers: Whether a file counts that does not exist here
    """
    folder = member.cwd if isinstance(member, Process) else os.sep
    found = set()
    for text in _texts(member):
        words = (text, text.rpartition('=')[2], *_WORD.findall(text))
        for word in words:
            path = os.path.normpath(os.path.join(folder, word.strip('"\'')))
            if os.sep in word and '\0' not in path:
                found.add(path)
    return frozenset(
        path
        for path in found
        if covers(path) or (is_user_file(path) and os.path.isfile(path))
    )


def _texts(member: Member) -> Iterator[str]:
    parameters = list(member.parameters)
    if isinstance(member, Component):
        parameters += member.extra_arguments
    else:
        yield member.cwd
        for argument in member.argv:
            if isinstance(argument, ParameterFile):
                yield argument.content
                parameters += argument.parameters
            else:
                yield argument
        for _, value in member.environment:
            yield value or ''
    for parameter in parameters:
        yield parameter.value
