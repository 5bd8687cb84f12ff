# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What can be seen of a launch without running it."""

from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import replace

from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.language.plan.plan_graph import plan_as_dot
from colcon_yamllaunch.language.plan.plan_graph import plan_as_mermaid
from colcon_yamllaunch.language.plan.plan_json import plan_to_json
from colcon_yamllaunch.language.plan.plan_text import plan_as_text
from colcon_yamllaunch.language.policies.check import check
from colcon_yamllaunch.language.policies.check import Checked
from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.language.policies.show_args import show_arguments
from colcon_yamllaunch.language.reports.reports import as_github
from colcon_yamllaunch.language.reports.reports import as_json
from colcon_yamllaunch.language.reports.reports import as_sarif
from colcon_yamllaunch.language.reports.reports import as_text
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.verb.cli.options import Options
from colcon_yamllaunch.verb.cli.options import TEXT
from colcon_yamllaunch.verb.launching.launch_flow import Launching
from colcon_yamllaunch.verb.launching.preflight import undeclared_packages
from colcon_yamllaunch.verb.launching.preflight import unknown_executables

_CHECK_FORMATS: Mapping[str, Callable[[Checked, str], str]] = {
    TEXT: as_text,
    'json': as_json,
    'github': as_github,
    'sarif': as_sarif,
}
_PLAN_FORMATS: Mapping[str, Callable[[Plan, str], str]] = {
    TEXT: plan_as_text,
    'json': lambda plan, _: plan_to_json(plan),
    'mermaid': plan_as_mermaid,
    'dot': plan_as_dot,
}


def look(launching: Launching, options: Options) -> int:
    """
    Show what the user asks to see.

    :param launching: The launch that is not run
    :param options: What the user asks for
    :returns: The exit code: 1 when there are errors
    :raises WorkspaceError: if there is no such launch file
    """
    looks = {'check': _check, 'plan': _plan, 'show_args': _show_args}
    return looks[options.look or ''](launching, options)


def _check(launching: Launching, options: Options) -> int:
    checked = check(launching.request(), portable=options.portable)
    found = (
        *checked.diagnostics,
        *unknown_executables(checked.executables, launching.locator),
        *undeclared_packages(checked.packages, launching.locator),
    )
    checked = replace(checked, diagnostics=found)
    show = _CHECK_FORMATS[options.look_format]
    print(show(checked, str(launching.cwd)), flush=True)
    return 1 if checked.errors else 0


def _show_args(launching: Launching, _options: Options) -> int:
    try:
        shown = show_arguments(launching.request())
    except LaunchError as e:
        launching.report(e.diagnostics)
        return 1
    print(shown, flush=True)
    return 0


def _plan(launching: Launching, options: Options) -> int:
    target = launching.target()
    evaluation = evaluate(launching.request(target))
    launching.report(evaluation.diagnostics)
    if evaluation.errors:
        return 1
    if options.why:
        launching.explain(target, evaluation)
    show = _PLAN_FORMATS[options.look_format]
    print(show(evaluation.plan, str(launching.cwd)), flush=True)
    return 0
