# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What can be seen of a launch without running it."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from dataclasses import replace

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.language.evaluation.findings import Checked
from colcon_yamllaunch.language.evaluation.findings import together
from colcon_yamllaunch.language.policies.check import check
from colcon_yamllaunch.language.policies.check import find_declarations
from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.language.reports import as_github
from colcon_yamllaunch.language.reports import as_json
from colcon_yamllaunch.language.reports import as_sarif
from colcon_yamllaunch.language.reports import as_text
from colcon_yamllaunch.language.reports import show_arguments
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.vocabulary.parameter_sections import (
    parameters_of,
)
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan_graph import plan_to_dot
from colcon_yamllaunch.plan.plan_graph import plan_to_mermaid
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.plan.plan_script import plan_to_script
from colcon_yamllaunch.plan.plan_text import plan_to_text
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.position import shown_position
from colcon_yamllaunch.verb.context import GiveUpError
from colcon_yamllaunch.verb.messages import enumeration
from colcon_yamllaunch.verb.messages import show
from colcon_yamllaunch.verb.messages import show_json
from colcon_yamllaunch.verb.options import LaunchOptions
from colcon_yamllaunch.verb.options import TEXT
from colcon_yamllaunch.verb.preflight import invalid_manifests
from colcon_yamllaunch.verb.preflight import missing_programs
from colcon_yamllaunch.verb.preflight import undeclared_imports
from colcon_yamllaunch.verb.preflight import undeclared_packages
from colcon_yamllaunch.verb.preflight import unknown_executables
from colcon_yamllaunch.verb.preflight import unknown_plugins
from colcon_yamllaunch.verb.run_launch import LaunchFlow
from colcon_yamllaunch.verb.target import Target
from colcon_yamllaunch.workspace.packages.launch_files import (
    checkable_launch_files,
)

#: The format of a plan that can be run without colcon.
SCRIPT = 'sh'
_CHECK_FORMATS: Mapping[str, Callable[[Checked, str], str]] = {
    TEXT: as_text,
    'json': as_json,
    'github': as_github,
    'sarif': as_sarif,
}
#: By a plan, the current folder, and the setup script of the workspace.
_PLAN_FORMATS: Mapping[str, Callable[[Plan, str, str | None], str]] = {
    TEXT: lambda plan, cwd, setup: plan_to_text(
        plan, cwd, setup, parameters_of=parameters_of
    ),
    SCRIPT: plan_to_script,
    'json': lambda plan, *_: plan_to_json(plan),
    'mermaid': lambda plan, cwd, _: plan_to_mermaid(plan, cwd),
    'dot': lambda plan, cwd, _: plan_to_dot(plan, cwd),
}
#: The formats that are JSON.
_JSON = ('json', 'sarif')


def inspect(flow: LaunchFlow, options: LaunchOptions) -> int:
    """
    Show what the user asks to see; return 1 when there are errors.

    :raises UserError: when there is no such launch file
    """
    try:
        if options.check is not None:
            return _check(flow, options, options.check)
        if options.plan is not None:
            return _plan(flow, options, options.plan)
        return _show_args(flow)
    except GiveUpError as e:
        return e.returncode


def _check(flow: LaunchFlow, options: LaunchOptions, form: str) -> int:
    targets = _launch_files(flow) if options.checks_all else [flow.target()]
    checked = together(
        check(
            flow.request(target),
            portable=options.portable,
            checks_programs=flow.deployment is None,
        )
        for target in targets
    )
    placement = None
    if not options.checks_all and not checked.errors:
        placement = _placement_of_check(flow)
    owners = filter(None, (flow.locator.package_of(t.path) for t in targets))
    used = {*checked.packages, *(owner.name for owner in owners)}
    found = (
        *_guesses(flow),
        *checked.diagnostics,
        *unknown_executables(checked.executables, flow.locator),
        *unknown_plugins(checked.plugins, flow.locator),
        *invalid_manifests(sorted(used), flow.locator),
        *undeclared_packages(checked.packages, flow.locator),
        *undeclared_imports(checked.packages, flow.locator),
        *(() if placement is None else placement.problems),
    )
    checked = replace(checked, diagnostics=found)
    _show(form, _CHECK_FORMATS[form](checked, str(flow.cwd)))
    if placement is not None and form == TEXT:
        show(placement.text)
    return 1 if checked.errors else 0


def _placement_of_check(flow: LaunchFlow) -> '_Placement | None':
    """Return what runs where, as far as that is known without running."""
    if flow.deployment is None:
        return None
    request = flow.request()
    evaluation = evaluate(request, runs=False)
    # an argument that has no default is no error of a check
    if evaluation.errors:
        return None
    placement = _Placement(flow, evaluation.plan)
    local = placement.placed.local.processes()
    missing = missing_programs(
        local,
        evaluation.programs,
        flow.locator,
        request.environment,
        'error',
    )
    placement.problems += tuple(missing)
    return placement


class _Placement:
    """What runs where, and what is wrong with that."""

    def __init__(self, flow: LaunchFlow, plan: Plan) -> None:
        # most launches run here
        from colcon_yamllaunch.remote.deployment import placement

        assert flow.deployment is not None
        self.placed = placement.place(plan, flow.deployment)
        self.problems = tuple(placement.rules_in_vain(plan, flow.deployment))
        self.text = placement.placement_to_text(self.placed, flow.deployment)


def _launch_files(flow: LaunchFlow) -> list[Target]:
    """
    Return the launch files of the packages of the workspace.

    :raises UserError: when there are none
    """
    locator = flow.locator
    found = [
        Target(locator.installed_path(package.name, path) or path, path)
        for package in sorted(locator.packages(), key=lambda p: p.name)
        for file in checkable_launch_files(package.path)
        for path in (str(package.path / file),)
    ]
    if not found:
        raise UserError(
            'there are no launch files to check: run in a workspace whose '
            'packages have some, or name one: colcon launch PKG FILE --check'
        )
    return found


def _guesses(flow: LaunchFlow) -> Iterator[Diagnostic]:
    """Say what is left open, as nothing is run to find it out."""
    for name, setup in flow.guessed.items():
        yield Diagnostic(
            'warning',
            f"the name of this package is taken to be '{name}': what it is "
            'shows only when its setup.py runs',
            Position(str(setup), 1, 1),
            "write it there as a text, as in setup(name='…'), or into "
            'setup.cfg',
        )


def _show_args(flow: LaunchFlow) -> int:
    flow.report(_guesses(flow))
    try:
        declarations = find_declarations(flow.request())
    except LaunchError as e:
        flow.report(e.diagnostics)
        return 1
    # what is asked for is there; it is the launch that they are errors of
    flow.report(replace(d, severity='warning') for d in declarations.mistakes)
    show(show_arguments(declarations, str(flow.cwd)))
    return 0


def _plan(flow: LaunchFlow, options: LaunchOptions, form: str) -> int:
    target = flow.target()
    request = flow.request(target)
    evaluation = evaluate(request, runs=options.runs)
    # what cannot be loaded is shown all the same: the rest would go on
    plugins = [
        replace(d, severity='warning')
        for d in unknown_plugins(evaluation.plugins, flow.locator)
    ]
    flow.report((*_guesses(flow), *evaluation.diagnostics, *plugins))
    if evaluation.errors:
        return 1
    if options.why:
        flow.explain(target, evaluation)
    plan = evaluation.plan
    if form == SCRIPT and plan.left_open:
        raise UserError(
            f'there is no script for it, as {plan.left_open[0]} is left open: '
            'add --run-commands if you trust the launch file'
        )
    position = plan.host_position
    if form == SCRIPT and position is not None:
        place = shown_position(position, str(flow.cwd))
        raise UserError(
            'there is no script for it, as what happens while it runs is up '
            f'to Python ({place}): launch it'
        )
    setup = str(flow.cwd), flow.setup_script
    placement = None if flow.deployment is None else _Placement(flow, plan)
    local = plan if placement is None else placement.placed.local
    flow.report(
        missing_programs(
            local.processes(),
            evaluation.programs,
            flow.locator,
            request.environment,
        )
    )
    if placement is None:
        _show(form, _PLAN_FORMATS[form](plan, *setup))
        return 0
    flow.report(placement.problems)
    placed = placement.placed
    if form == SCRIPT and placed.parts:
        raise UserError(
            'there is no script for it, as parts of it run on '
            f'{enumeration(placed.parts)}: launch it'
        )
    if form == TEXT:
        text = plan_to_text(
            placed.whole, *setup, placed.machines, parameters_of
        )
        show(f'{placement.text}\n\n{text}')
    else:
        _show(form, _PLAN_FORMATS[form](placed.whole, *setup))
    return 0


def _show(form: str, text: str) -> None:
    if form in _JSON:
        show_json(text)
    else:
        show(text)
