# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`--show-args`, `--check` and `--plan`: show a launch without running it."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import show, show_json
from colcon_yamllaunch.common.suggestions import enumeration
from colcon_yamllaunch.language import reports
from colcon_yamllaunch.language.actions.parameter_files import parameters_of
from colcon_yamllaunch.language.evaluation.findings import (
    CheckResult,
    together,
)
from colcon_yamllaunch.language.policies.check import check, find_declarations
from colcon_yamllaunch.language.policies.evaluate import evaluate, Evaluation
from colcon_yamllaunch.language.reports import show_arguments
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    LaunchError,
    Severity,
)
from colcon_yamllaunch.plan import plan_graph
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.plan.plan_script import plan_to_script
from colcon_yamllaunch.plan.plan_text import plan_to_text
from colcon_yamllaunch.plan.position import Position, shown_position
from colcon_yamllaunch.verb.context import LaunchContext
from colcon_yamllaunch.verb.options import TEXT
from colcon_yamllaunch.verb.prepare import (
    explain,
    missing_executables,
    missing_plugins,
    missing_programs,
    undeclared_packages,
)
from colcon_yamllaunch.verb.target import Target
from colcon_yamllaunch.workspace.packages.launch_files import (
    checkable_launch_files,
)
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

if TYPE_CHECKING:
    from colcon_yamllaunch.deployment.placement import PlacedPlan

#: The format of a plan that can be run without colcon.
SCRIPT = 'sh'
_CHECK_FORMATS: Mapping[str, Callable[[CheckResult, str], str]] = {
    TEXT: reports.as_text,
    'json': reports.as_json,
    'github': reports.as_github,
    'sarif': reports.as_sarif,
}
#: By a plan, the current folder, and the setup script of the workspace.
_PLAN_FORMATS: Mapping[str, Callable[[Plan, str, str | None], str]] = {
    SCRIPT: plan_to_script,
    'json': lambda plan, *_: plan_to_json(plan),
    'mermaid': lambda plan, cwd, _: plan_graph.plan_to_mermaid(plan, cwd),
    'dot': lambda plan, cwd, _: plan_graph.plan_to_dot(plan, cwd),
}
#: The formats that are JSON.
_JSON = ('json', 'sarif')


def inspect(context: LaunchContext) -> int:
    """
    Show what the user asks to see; return 1 when there are errors.

    :raises UserError: when there is no such launch file
    """
    if context.options.check is not None:
        return _check(context, context.options.check)
    if context.options.plan is not None:
        return _plan(context, context.options.plan)
    return _show_args(context)


def _check(context: LaunchContext, form: str) -> int:
    options, locator = context.options, context.locator
    targets = [] if options.checks_all else [context.target()]
    if options.checks_all:
        targets = _launch_files(locator)
    checked = together(
        check(
            context.request(target),
            portable=options.portable,
            checks_programs=context.deployment is None,
        )
        for target in targets
    )
    placement = ''
    problems: list[Diagnostic] = []
    if not (options.checks_all or checked.errors or not context.deployment):
        evaluation = evaluate(context.request(), runs=False)
        # an argument that has no default is no error of a check
        if not evaluation.errors:
            _, placement, problems = _place(context, evaluation, 'error')
    owners = filter(None, (locator.package_of(t.path) for t in targets))
    used = {*checked.packages, *(owner.name for owner in owners)}
    found = (
        *_guesses(context),
        *checked.diagnostics,
        *missing_executables(checked.executables, locator, 'built'),
        *missing_plugins(checked.plugins, locator, 'built'),
        *_invalid_manifests(sorted(used), locator),
        *undeclared_packages(checked.packages, locator),
        *_undeclared_imports(checked.packages, locator),
        *problems,
    )
    checked = replace(checked, diagnostics=found)
    _show(form, _CHECK_FORMATS[form](checked, str(context.cwd)))
    if placement and form == TEXT:
        show(placement)
    return 1 if checked.errors else 0


def _place(
    context: LaunchContext, evaluation: Evaluation, severity: Severity
) -> 'tuple[PlacedPlan | None, str, list[Diagnostic]]':
    """
    Assign the processes to machines, and find problems.

    Return the placement and its text, if there are other machines, and the
    problems.

    :param severity: How bad it is when this machine lacks a program
    """
    placed, text = None, ''
    problems: list[Diagnostic] = []
    local = evaluation.plan
    deployment = context.deployment
    if deployment is not None:
        # most launches run here
        from colcon_yamllaunch.deployment import placement

        placed = context.placed(evaluation.plan)
        assert placed is not None
        if deployment.machines:
            text = placement.placement_to_text(placed, deployment)
        problems += placement.rules_in_vain(placed.whole, deployment)
        local = placed.local
    problems += missing_programs(
        local.processes(),
        evaluation.programs,
        context.locator,
        context.process_environment(),
        severity,
    )
    return placed, text, problems


def _launch_files(locator: PackageLocator) -> list[Target]:
    """
    Return the launch files of the packages of the workspace.

    :raises UserError: when there are none
    """
    found = []
    for package in sorted(locator.packages(), key=lambda p: p.name):
        for file in checkable_launch_files(package.path):
            path = str(package.path / file)
            name = locator.installed_path(package.name, path) or path
            found.append(Target(name, path))
    if not found:
        raise UserError(
            'there are no launch files to check: run in a workspace whose '
            'packages have some, or name one: colcon launch PKG FILE --check'
        )
    return found


def _undeclared_imports(
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


def _invalid_manifests(
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


def _guesses(context: LaunchContext) -> Iterator[Diagnostic]:
    """Return warnings about package names that are guesses."""
    for name, setup in context.workspace.guessed.items():
        yield Diagnostic(
            'warning',
            f"the name of this package is taken to be '{name}': what it is "
            'shows only when its setup.py runs',
            Position(str(setup), 1, 1),
            "write it there as a text, as in setup(name='…'), or into "
            'setup.cfg',
        )


def _show_args(context: LaunchContext) -> int:
    context.report(_guesses(context))
    try:
        declarations = find_declarations(context.request())
    except LaunchError as e:
        context.report(e.diagnostics)
        return 1
    # the arguments can be shown; it is the launch that these are errors of
    context.report(
        replace(d, severity='warning') for d in declarations.mistakes
    )
    show(show_arguments(declarations, str(context.cwd)))
    return 0


def _plan(context: LaunchContext, form: str) -> int:
    options, locator = context.options, context.locator
    target = context.target()
    request = context.request(target)
    evaluation = evaluate(request, runs=options.runs)
    # a component that cannot be loaded is no error: the launch goes on
    plugins = [
        replace(d, severity='warning')
        for d in missing_plugins(evaluation.plugins, locator, 'built')
    ]
    context.report((*_guesses(context), *evaluation.diagnostics, *plugins))
    if evaluation.errors:
        return 1
    if options.why:
        explain(context, target, evaluation)
    placed, placement, problems = _place(context, evaluation, 'warning')
    if form == SCRIPT:
        _refuse_script(evaluation.plan, placed, context.cwd)
    context.report(problems)
    plan = evaluation.plan if placed is None else placed.whole
    cwd, setup = str(context.cwd), context.workspace.setup_script
    if form == TEXT:
        machines = {} if placed is None else placed.machines
        text = plan_to_text(plan, cwd, setup, machines, parameters_of)
        text = f'{placement}\n\n{text}' if placement else text
    else:
        text = _PLAN_FORMATS[form](plan, cwd, setup)
    _show(form, text)
    return 0


def _refuse_script(plan: Plan, placed: 'PlacedPlan | None', cwd: Path) -> None:
    """
    Refuse a plan that no script can run.

    :raises UserError: when it is such a plan
    """
    reason = None
    if plan.left_open:
        reason = (
            f'{plan.left_open[0]} is left open: add --run-commands if you '
            'trust the launch file'
        )
    elif plan.worker_position is not None:
        place = shown_position(plan.worker_position, str(cwd))
        reason = (
            f'what happens while it runs is up to Python ({place}): launch it'
        )
    elif placed is not None and placed.parts:
        machines = enumeration(placed.parts)
        reason = f'parts of it run on {machines}: launch it'
    if reason is not None:
        raise UserError(f'there is no script for it, as {reason}')


def _show(form: str, text: str) -> None:
    if form in _JSON:
        show_json(text)
    else:
        show(text)
