# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Mistakes that show only once everything is built, and their cures."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from pathlib import Path

from colcon_yamllaunch.language.evaluation.findings import ExecutableUse
from colcon_yamllaunch.language.evaluation.findings import PluginUse
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.workspace.packages.missing_files import (
    missing_executable,
)
from colcon_yamllaunch.workspace.packages.missing_files import missing_plugin
from colcon_yamllaunch.workspace.packages.missing_files import not_installed
from colcon_yamllaunch.workspace.packages.missing_files import (
    unknown_executable,
)
from colcon_yamllaunch.workspace.packages.missing_files import unknown_plugin
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator


def undeclared_packages(
    packages: Mapping[str, Position], locator: PackageLocator
) -> Iterator[Diagnostic]:
    """
    Find packages that a launch file uses, but its package does not declare.

    They are built all the same; but other tools would not know of them.

    :param packages: The packages that are used, and where first
    """
    for name, position in packages.items():
        owner = locator.package_of(position.path)
        if owner is None or owner.name == name:
            continue
        # only these have a manifest to declare anything in
        is_ros = owner.type.startswith('ros.')
        if is_ros and name not in owner.build_depends | owner.run_depends:
            yield Diagnostic(
                'warning',
                f"{owner.name} uses the package '{name}' here, but its "
                'package.xml does not declare it',
                position,
                f'add <exec_depend>{name}</exec_depend>',
                len(name),
            )


def undeclared_imports(
    uses: Iterable[str], locator: PackageLocator
) -> Iterator[Diagnostic]:
    """
    Find imports of packages that are not declared, so that none builds them.

    :param uses: The packages that the launch uses
    """
    # only --check looks
    from colcon_yamllaunch.workspace.packages import python_modules

    for name in uses:
        user = locator.package(name)
        if user is None:
            continue
        for found in python_modules.undeclared_imports(
            user, locator.packages()
        ):
            yield Diagnostic(
                'warning',
                f"{name} imports '{found.module}' of the package "
                f'{found.owner} here, but its package.xml does not declare '
                'that',
                Position(str(found.path), found.line, found.column),
                f'add <exec_depend>{found.owner}</exec_depend>',
            )


def unknown_executables(
    uses: Iterable[ExecutableUse], locator: PackageLocator
) -> Iterator[Diagnostic]:
    """Find programs that not even a build would bring."""
    return _lacking(_programs(uses), locator, unknown_executable)


def unknown_plugins(
    uses: Iterable[PluginUse], locator: PackageLocator
) -> Iterator[Diagnostic]:
    """Find components that not even a build would bring."""
    return _lacking(_plugins(uses), locator, unknown_plugin)


#: A package, what it is to have, and where the launch file says so.
_Use = tuple[str, str, Position]


def _programs(uses: Iterable[ExecutableUse]) -> Iterator[_Use]:
    return ((use.package, use.name, use.position) for use in uses)


def _plugins(uses: Iterable[PluginUse]) -> Iterator[_Use]:
    return ((use.package, use.plugin, use.position) for use in uses)


def _lacking(
    uses: Iterable[_Use],
    locator: PackageLocator,
    reason_of: Callable[[PackageLocator, str, str], str | None],
) -> Iterator[Diagnostic]:
    for package, name, position in uses:
        reason = reason_of(locator, package, name)
        if reason is not None:
            yield Diagnostic('error', reason, position, length=len(name))


def preflight(
    evaluation: Evaluation, missing: Iterable[str], locator: PackageLocator
) -> Iterator[Diagnostic]:
    """
    Find what the launch needs and the packages have not installed.

    A program that is not there is an error; a file is a warning, as the
    launch may go on without it in ROS 2 too.
    """
    programs = _programs(evaluation.executables)
    yield from _lacking(programs, locator, missing_executable)
    plugins = _plugins(evaluation.plugins)
    yield from _lacking(plugins, locator, missing_plugin)
    wanted = dict.fromkeys(missing) | _used_paths(evaluation)
    reported: set[str] = set()
    for path, position in wanted.items():
        reason = not_installed(locator, path)
        if reason is not None and reason not in reported:
            reported.add(reason)
            yield Diagnostic('warning', reason, position)


def _used_paths(evaluation: Evaluation) -> dict[str, Position | None]:
    """Return the absolute paths that command lines name, and where."""
    paths: dict[str, Position | None] = {}
    for process in evaluation.plan.processes():
        for argument in process.argv:
            if not isinstance(argument, str):
                continue
            path = argument[argument.find('/') :]
            if path.startswith('/') and not Path(path).exists():
                paths.setdefault(path, process.position)
    return paths
