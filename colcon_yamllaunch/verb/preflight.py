# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Mistakes that show only once everything is built, and their cures."""

from collections.abc import Container
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
import os
from pathlib import Path
import shutil
from typing import Literal

from colcon_yamllaunch.common.suggestions import way_to_program
from colcon_yamllaunch.language.evaluation.findings import ExecutableUse
from colcon_yamllaunch.language.evaluation.findings import PluginUse
from colcon_yamllaunch.language.evaluation.findings import ProgramUse
from colcon_yamllaunch.language.evaluation.values import LeftOpen
from colcon_yamllaunch.language.evaluation.values import Place
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import Severity
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

# what explains mistakes is imported where it is needed


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
    from colcon_yamllaunch.workspace.packages import python_modules

    for user in filter(None, map(locator.package, uses)):
        for found in python_modules.undeclared_imports(
            user, locator.packages()
        ):
            yield Diagnostic(
                'warning',
                f"{user.name} imports '{found.module}' of the package "
                f'{found.owner} here, but its package.xml does not declare '
                'that',
                Position(str(found.path), found.line, found.column),
                f'add <exec_depend>{found.owner}</exec_depend>',
            )


def invalid_manifests(
    uses: Iterable[str], locator: PackageLocator
) -> Iterator[Diagnostic]:
    """
    Find packages whose manifests colcon passes over.

    :param uses: The packages that the launch uses
    """
    from colcon_yamllaunch.workspace.packages.package import invalid_manifest

    for package in filter(None, map(locator.package, uses)):
        reason = invalid_manifest(package)
        if reason:
            position = Position(str(package.path / 'package.xml'), 1, 1)
            yield Diagnostic('error', reason, position)


def missing_executables(
    uses: Iterable[ExecutableUse],
    locator: PackageLocator,
    when: Literal['now', 'built', 'certainly'],
) -> Iterator[Diagnostic]:
    """
    Find programs that packages do not have.

    :param when: `now`, after a build if that would not bring them either
      (`built`), or only those of which the source tells so (`certainly`)
    """
    for use in uses:
        from colcon_yamllaunch.workspace.packages import missing_files

        explain = {
            'now': missing_files.missing_executable,
            'built': missing_files.unknown_executable,
            'certainly': missing_files.certainly_unknown_executable,
        }[when]
        found = explain(locator, use.package, use.name)
        if found is not None:
            yield Diagnostic(
                'error',
                found.problem,
                use.position,
                found.hint,
                len(use.name),
            )


def missing_plugins(
    uses: Iterable[PluginUse],
    locator: PackageLocator,
    when: Literal['now', 'built'],
) -> Iterator[Diagnostic]:
    """
    Find components that packages do not have.

    :param when: `now`, or after a build if that would not bring them either
    """
    for use in uses:
        from colcon_yamllaunch.workspace.packages import missing_files

        explain = missing_files.missing_plugin
        if when == 'built':
            explain = missing_files.unknown_plugin
        if locator.prefix(use.package) is None:
            found = locator.no_package(use.package)
            yield Diagnostic(
                'error',
                found.problem,
                use.package_position,
                found.hint,
                len(use.package),
            )
        elif use.plugin is not None:
            missing = explain(locator, use.package, use.plugin)
            if missing is not None:
                yield Diagnostic(
                    'error' if missing.is_certain else 'warning',
                    missing.reason,
                    use.position,
                    length=len(use.plugin),
                )


def preflight(
    evaluation: Evaluation,
    missing: Iterable[str],
    locator: PackageLocator,
    only_there: Container[str] = (),
) -> Iterator[Diagnostic]:
    """
    Find what the launch needs and the packages have not installed.

    A program or component that is not there is an error; a file is a warning,
    as the launch may go on without it in ROS 2 too.

    :param only_there: Packages that other machines have, and not this one
    """
    executables = [
        use for use in evaluation.executables if use.package not in only_there
    ]
    plugins = [u for u in evaluation.plugins if u.package not in only_there]
    yield from missing_executables(executables, locator, 'now')
    yield from missing_plugins(plugins, locator, 'now')
    wanted = dict.fromkeys(missing) | _used_paths(evaluation)
    reported = {d.hint for d in evaluation.diagnostics}
    for path, position in wanted.items():
        owner = locator.owner(path)
        if owner is None or owner.name in only_there:
            continue
        from colcon_yamllaunch.workspace.packages import missing_files

        found = missing_files.not_installed(locator, path)
        if found is not None and found.hint not in reported:
            reported.add(found.hint)
            yield Diagnostic('warning', found.problem, position, found.hint)


def missing_programs(
    processes: Iterable[Process],
    uses: Mapping[str, ProgramUse],
    locator: PackageLocator,
    environment: Mapping[str, str],
    severity: Severity = 'warning',
) -> Iterator[Diagnostic]:
    """
    Find processes whose program this machine lacks, and not a package.

    The launch goes on without them, as in ROS 2.

    :param processes: Those that run on this machine
    :param uses: Where launch files name their programs, if that is known
    :param environment: The environment of the launch, for its `PATH`
    """
    for process in processes:
        name = process.argv[0]
        if not isinstance(name, str) or isinstance(name, LeftOpen):
            continue
        variables = {**environment, **dict(process.environment)}
        path = variables.get('PATH') or os.defpath
        file = os.path.join(process.cwd, name) if '/' in name else name
        if shutil.which(file, path=path) or locator.owner(file):
            continue
        use = uses.get(process.ros_name)
        place = use.place if use else Place(process.position, 1, ())
        where = '' if '/' in name else ' on the PATH'
        yield Diagnostic(
            severity,
            f"there is no executable '{name}'{where}, so {process.label} "
            'cannot be started',
            place.position,
            (use and use.hint) or way_to_program(name, process.cwd),
            place.length,
            place.includes,
        )


def _used_paths(evaluation: Evaluation) -> dict[str, Position | None]:
    """Return the absolute paths that command lines name, and where."""
    paths: dict[str, Position | None] = {}
    for process in evaluation.plan.processes():
        for argument in process.argv:
            if not isinstance(argument, str):
                continue
            path = argument[argument.find('/') :]
            if path.startswith('/') and not os.path.exists(Path(path)):
                paths.setdefault(path, process.position)
    return paths
