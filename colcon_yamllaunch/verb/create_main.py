# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon create`, from its options to its exit code."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
import getpass
from importlib.util import find_spec
import os
from pathlib import Path
from pkgutil import iter_modules
import re
import shlex
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.common.messages import say, show
from colcon_yamllaunch.common.suggestions import did_you_mean, enumeration
from colcon_yamllaunch.plan.position import shown_path
from colcon_yamllaunch.verb.git import git_output
from colcon_yamllaunch.verb.options import CreateOptions
from colcon_yamllaunch.verb.target import find_workspace
from colcon_yamllaunch.workspace.colcon.package_scan import scan_packages
from colcon_yamllaunch.workspace.create import added_node, new_package, sample
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.packages.workspace_root import (
    find_root,
    is_package,
    UntrustedError,
)

#: The address of a maintainer that git does not know.
TODO_EMAIL = 'TODO@example.com'

_BUILD_TYPE = re.compile(r'<build_type\b[^>]*>\s*(\w+)')
_DEPENDENCY = re.compile(r'[a-zA-Z0-9][a-zA-Z0-9_.+-]*')


def main(
    options: CreateOptions, _known: Any, environment: Mapping[str, str]
) -> int:
    """Make a package, and return the exit code."""
    cwd = Path.cwd()
    if options.example:
        show(_example(options.package, cwd))
        return 0
    if options.add_node is not None:
        show(_add_node(options.package, options.add_node, cwd, environment))
        return 0
    name, email, unknown = _maintainer(options, cwd, environment)
    package = _new_package(options, name, email)
    folder = _destination(options.destination, cwd) / package.name
    try:
        there = next(p for p in (folder, *folder.parents) if os.path.isdir(p))
        root = _root_of(there)
        _refuse_place(folder, root)
    except OSError as e:
        raise UserError(f'cannot read {e.filename}: {e.strerror}') from e
    # this runs nothing: a setup.py is read as a text
    locator = scan_packages(root, environment)
    known_package = locator.package(package.name)
    if known_package is not None:
        raise UserError(
            f'the workspace has a package {package.name} already, in '
            f'{known_package.path}: nothing was written',
            f'to add a node to it: colcon create {package.name} --add-node '
            'NODE',
        )
    new_package.make_package(package, folder)
    found = _warnings(package, options, locator, environment)
    for warning in (*unknown, *found):
        say(f'colcon create: warning: {warning}')
    show(_made(package, folder, cwd))
    return 0


def _example(given: str, cwd: Path) -> str:
    """
    Copy the sample workspace, and return the message for the user.

    :param given: The folder, '' if the user names none
    :raises UserError: when it is there already, or cannot be written
    """
    name = Path(given or sample.SAMPLE.name).expanduser()
    folder = Path(os.path.normpath(cwd / name))
    sample.copy_sample(folder)
    command = f'colcon launch {" ".join(sample.LAUNCH_FILE)}'
    shown = shown_path(str(folder), str(cwd))
    return (
        f'Created {shown}, a copy of the sample workspace: see README.md in '
        f'it\nTry it:  cd {shlex.quote(shown)} && {command}'
    )


def _add_node(
    name: str, node: str, cwd: Path, environment: Mapping[str, str]
) -> str:
    """
    Add a node to a package, and return the message for the user.

    :raises UserError: when there is no such package, or no place in it
    """
    root = _root_of(cwd) or _named_workspace(cwd)
    locator = scan_packages(root, environment)
    package = locator.package(name)
    if package is None:
        names = [package.name for package in locator.packages()]
        hint = did_you_mean(name, names) or 'make it without --add-node'
        raise UserError(f"the workspace has no package '{name}'", hint)
    build_type = _build_type(package)
    package = replace(package, type=build_type)
    which = f'{name}, of the build type {build_type},'
    node, is_cpp = _node(node, build_type, which, 'make a package for it')
    if build_type not in ('ament_cmake', 'ament_python', 'cmake', 'python'):
        raise UserError(
            f'a node cannot be added to {name}, as its build type is '
            f'{build_type}',
            'make a package for it',
        )
    added = added_node.AddedNode(package, node, is_cpp)
    made, *changed = added_node.add_node(added)
    missing = _missing_ros(is_cpp, locator, environment)
    if added.is_ros and missing is not None:
        say(f'colcon create: warning: {missing}')
    lines = [
        f'Added the node {node} to {shown_path(str(package.path), str(cwd))}',
        f'  {made} (new)',
        *(f'  {file} (changed)' for file in changed),
        f'Try it:  colcon run {name} {added.executable}',
        'To launch it, add to a launch file:',
    ]
    if added.is_ros:
        lines.append(
            f'  - node: {{pkg: {name}, exec: {added.executable}, '
            f'name: {node}, output: both}}'
        )
    else:
        program = f'$(find-pkg-prefix {name})/lib/{name}/{added.executable}'
        lines.append(f'  - executable: {{cmd: {program}, output: both}}')
    return '\n'.join(lines)


def _node(
    written: str, build_type: str, package: str, fix: str
) -> tuple[str, bool]:
    """
    Return the name of a node, and whether it is in C++.

    :param written: Its name as the user writes it
    :param package: The package, for the error if that cannot build it
    :raises UserError: when the package cannot build it, or by its name
    """
    is_cpp = written.endswith('.cpp')
    if is_cpp and build_type.endswith('python'):
        raise UserError(
            f"'{written}' is in C++, which {package} does not build", fix
        )
    node = written.removesuffix('.py').removesuffix('.cpp')
    new_package.check_node_name(node, build_type, is_cpp)
    return node, is_cpp


def _build_type(package: Package) -> str:
    """Return the build type of a package, read from its package.xml."""
    # a package scan reads it only of packages without ROS
    found = _BUILD_TYPE.search(text_of(package.path / 'package.xml'))
    return found[1] if found else package.type.removeprefix('ros.') or 'catkin'


def _root_of(folder: Path) -> Path | None:
    """Find the workspace of a folder, unless it is somebody else's."""
    try:
        return find_root(folder)
    except UntrustedError:
        return None


def _named_workspace(cwd: Path) -> Path | None:
    """Return the workspace of ROS_WORKSPACE if `cwd` is in none."""
    try:
        return None if find_root(cwd) else find_workspace(None, ())
    except UntrustedError:
        return None


def _new_package(
    options: CreateOptions, name: str, email: str
) -> new_package.NewPackage:
    """
    Return the new package, with defaults for options that are not given.

    :param name: The name of the maintainer
    :param email: The address of the maintainer
    :raises UserError: when something cannot be
    """
    new_package.check_package_name(options.package, options.build_type)
    node, is_cpp = _node(
        options.node or new_package.default_node_name(options.package),
        options.build_type,
        f'a package of the build type {options.build_type}',
        "leave out --build-type, or say '--build-type cmake' for one without "
        'ROS',
    )
    return new_package.NewPackage(
        name=options.package,
        build_type=options.build_type,
        node=node,
        is_cpp=is_cpp,
        maintainer_name=_one_line(name),
        maintainer_email=email,
        dependencies=tuple(_dependencies(options, is_cpp)),
        license=_one_line(options.license or new_package.NO_LICENSE),
        description=_one_line(
            options.description or f'The node {node} and its launch file.'
        ),
    )


def _maintainer(
    options: CreateOptions, cwd: Path, environment: Mapping[str, str]
) -> tuple[str, str, list[str]]:
    """Return the name and address of the maintainer, and a warning, if any."""
    name, email = (
        given or git_output(cwd, environment, 'config', '--get', key).strip()
        for given, key in (
            (options.maintainer_name, 'user.name'),
            (options.maintainer_email, 'user.email'),
        )
    )
    missing = [] if name else ['name']
    missing += [] if email else ['e-mail address']
    if not name:
        # a container may run as a user that has no name
        name = 'TODO'
        with suppress(KeyError, OSError):
            name = getpass.getuser()
    email = email or TODO_EMAIL
    if not missing:
        return name, email, []
    warning = (
        f'git knows no {" and ".join(missing)}, so package.xml names '
        f'{name} <{email}> as the maintainer: correct that there, and tell '
        "git once: git config --global user.name 'NAME' and "
        'git config --global user.email ADDRESS'
    )
    return name, email, [warning]


def _destination(given: Path | None, cwd: Path) -> Path:
    """
    Return the folder that the package's folder is made in.

    In the root of a workspace, and in a folder that is going to be one, this
    is `src`.
    """
    if given is not None:
        return Path(os.path.normpath(cwd / given))
    if not os.path.isdir(cwd / 'src'):
        cwd = _named_workspace(cwd) or cwd
    source = cwd / 'src'
    return source if os.path.isdir(source) and not is_package(cwd) else cwd


def _dependencies(options: CreateOptions, is_cpp: bool) -> Iterator[str]:
    names = dict.fromkeys(options.dependencies)
    if options.build_type != 'cmake':
        # the node is written with it
        names = dict.fromkeys((new_package.client_library(is_cpp), *names))
    for name in names:
        if name == options.package:
            raise UserError(f'{name} cannot depend on itself')
        if not _DEPENDENCY.fullmatch(name):
            raise UserError(
                f"--dependencies: '{name}' is no name of a package",
                'names of packages are separated by spaces',
            )
        yield name


def _one_line(text: str) -> str:
    return ' '.join(text.split())


def _refuse_place(folder: Path, root: Path | None) -> None:
    """Refuse a folder inside of a package, where colcon finds no packages."""
    parents = [folder.parent]
    if root is not None:
        parents = [p for p in folder.parents if p.is_relative_to(root)]
    for parent in parents:
        if is_package(parent):
            raise UserError(
                f'{parent} is a package, and colcon looks for none inside of '
                'it',
                'say by --destination where to make this one',
            )


def _warnings(
    package: new_package.NewPackage,
    options: CreateOptions,
    locator: PackageLocator,
    environment: Mapping[str, str],
) -> Iterator[str]:
    disliked = list(new_package.dislikes(package.name))
    if disliked:
        advised = new_package.advised_name(package.name)
        hint = f', such as {advised}' if advised != package.name else ''
        yield (
            f"the name '{package.name}' works, but REP 144 asks for "
            f'{enumeration(disliked)}{hint}'
        )
    if options.license is None:
        yield (
            'package.xml names no license yet: say which one there, or '
            'create the package with --license'
        )
    elif package.license not in new_package.LICENSES:
        others = f'those of {enumeration(new_package.LICENSES)} are'
        yield (
            f"the text of the license '{package.license}' is not known, so "
            'there is no file LICENSE: '
            f'{did_you_mean(package.license, new_package.LICENSES) or others}'
        )
    underlays = PackageLocator((), Path(os.devnull), False, environment)
    prefix = underlays.prefix(package.name)
    if prefix is not None:
        yield (
            f'there is a package {package.name} in {prefix} already: in this '
            'workspace, the new one takes its place'
        )
    missing = _missing_ros(package.is_cpp, underlays, environment)
    if package.is_ros and missing is not None:
        yield f'{missing}, or make one of --build-type cmake'
    modules = (module.name for module in iter_modules())
    known = {*locator.names(), *modules}
    for name in options.dependencies:
        meant = None if name in known else did_you_mean(name, known)
        if meant is not None:
            yield f"there is no package '{name}' here: {meant}"


def _missing_ros(
    is_cpp: bool, locator: PackageLocator, environment: Mapping[str, str]
) -> str | None:
    """Return a warning if ROS is missing that the node needs."""
    has_ros = environment.get('AMENT_PREFIX_PATH') or find_spec('rclpy')
    what = 'ROS 2'
    if is_cpp:
        has_ros, what = locator.prefix('rclcpp'), 'rclcpp of ROS 2'
    if has_ros:
        return None
    return (
        f'{what} is not to be found here, and the package needs it: source '
        'its setup.bash'
    )


def _made(package: new_package.NewPackage, folder: Path, cwd: Path) -> str:
    """Return the message about the new package, with the next command."""
    files = '\n'.join(f'  {path}' for path in package.files())
    command = f'colcon launch {package.name} {package.launch_file}'
    root = _root_of(folder) or _root_of(folder.parent) or folder.parent
    if not cwd.is_relative_to(root):
        command = (
            f'cd {shlex.quote(shown_path(str(root), str(cwd)))} && {command}'
        )
    shown = shown_path(str(folder), str(cwd))
    return (
        f'Created {shown} ({package.build_type})\n{files}\nTry it:  {command}'
    )
