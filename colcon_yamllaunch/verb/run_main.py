# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon run`, from its options to the program."""

import ast
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import os
from pathlib import Path
import sys
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import say, say_line
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.engine.spawn import exec_program, StartError
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic, render
from colcon_yamllaunch.observers.failure_advice import Advisor
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.verb.options import RunOptions
from colcon_yamllaunch.verb.target import find_workspace, unknown_package
from colcon_yamllaunch.workspace.builds import Builds
from colcon_yamllaunch.workspace.packages import missing_files
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.packages.python_modules import certain_imports
from colcon_yamllaunch.workspace.workspace_session import WorkspaceSession


def main(
    options: RunOptions, _known: Any, environment: Mapping[str, str]
) -> int:
    """Build, source and become the program; return only when that fails."""
    package, executable = options.package, options.executable
    with _program_streams_replaced():
        workspace = WorkspaceSession(
            find_workspace(options.workspace, []),
            options.build_args,
            environment,
            say_line,
            ' '.join(filter(None, ['colcon run', package, executable])),
        )
        returncode = _prepare(workspace, options)
    if returncode:
        return returncode
    program = _find_program(workspace.locator, package, executable)
    if not options.prefix:
        _warn_of_missing_module(workspace, package, program)
    argv = [*options.prefix, program, *options.arguments]
    workspace.lock.hand_over()
    try:
        exec_program(argv, workspace.environment)
    except StartError as e:
        raise UserError(e.problem, e.hint) from e


def _find_program(
    locator: PackageLocator, package: str, name: str | None
) -> str:
    """
    Return the path of a program of a package, found as `ros2 run` does.

    :param name: The program: its name, also if it is in a subfolder of
      `lib/PACKAGE`, or its path from there; or None
    :raises UserError: when there is none, or more than one
    """
    names = locator.executables(package)
    if name is None and not names:
        raise UserError(f'{package} has installed no executables')
    fitting = [n for n in names if name in (n, None)]
    fitting = fitting or [n for n in names if Path(n).name == name]
    listed = ''.join(f'\n  {one_line(n)}' for n in fitting)
    if name is None:
        raise UserError(
            f'no executable of {package} is given', f'it has:{listed}'
        )
    if len(fitting) > 1:
        raise UserError(
            f"'{name}' may be one of several executables of {package}",
            f'name one by its path:{listed}',
        )
    if not fitting:
        raise missing_files.missing_executable(
            locator, package, name
        ) or UserError(f"{package} has no '{name}'")
    prefix = locator.prefix(package) or ''
    return str(Path(prefix, 'lib', package, fitting[0]))


def _warn_of_missing_module(
    workspace: WorkspaceSession, package: str, program: str
) -> None:
    """Warn of an import that will fail: nobody is there when it does."""
    path = os.path.realpath(program)
    imports: dict[str, ast.stmt] = {}
    for module, node in certain_imports(Path(path)):
        imports.setdefault(module, node)
    advisor = Advisor(
        workspace.environment, workspace.locator.undeclared_owner
    )
    lack = advisor.lacks(program, package, list(imports))
    if lack is None:
        return
    module, interpreter, cure = lack
    node = imports[module]
    warning = Diagnostic(
        'warning',
        f"it runs with {interpreter}, which has no module '{module}'",
        Position(path, node.lineno, node.col_offset + 1),
        cure,
        (node.end_col_offset or 0) - node.col_offset,
    )
    say(render([warning], str(Path.cwd())))


def _prepare(workspace: WorkspaceSession, options: RunOptions) -> int:
    """Build what is needed and not up to date; return the exit code."""
    package = options.package
    if workspace.locator.prefix(package) is None and not options.paths:
        broken = workspace.broken_manifests
        raise unknown_package(package, workspace.locator, broken)
    if not options.no_build and workspace.root is not None:
        wanted = workspace.package_names
        if not options.build_all:
            wanted &= {package}
        if options.paths:
            wanted = set(workspace.select(options.paths, Path.cwd()))
        builds = Builds(workspace, exactly=bool(options.paths))

        def look_first() -> None:
            # a program that the package will not have after a build either
            name, locator = options.executable, workspace.locator
            there = locator.executables(package)
            if name and not any(name in (n, Path(n).name) for n in there):
                problem = missing_files.certainly_unknown_executable(
                    locator, package, name
                )
                if problem is not None:
                    raise problem

        update = builds.update(wanted, package, look_first)
        if update.returncode:
            return update.returncode
    if workspace.locator.prefix(package) is None:
        raise unknown_package(package, workspace.locator, tuple)
    if package in workspace.package_names:
        workspace.check_sourced([package], may_build=not options.no_build)
    return 0


@contextmanager
def _program_streams_replaced() -> Iterator[None]:
    """
    Keep the input and output that are the program's out of a build.

    What is typed or piped in is for the program, and a pipe behind it gets
    nothing else than its output.
    """
    sys.stdout.flush()
    kept = [os.dup(0), os.dup(1)]
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        for number, descriptor in enumerate(kept):
            os.dup2(descriptor, number)
        for descriptor in (*kept, nothing):
            os.close(descriptor)
