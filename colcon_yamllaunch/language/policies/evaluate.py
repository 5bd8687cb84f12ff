# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
From a launch file and its arguments to a plan.

This is the policy of a launch, which is that of :class:`Walk` itself: all is
known, an error ends its action, and an action whose condition does not hold is
passed over.
"""

from collections.abc import Mapping
from dataclasses import field
from dataclasses import replace
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.evaluation.findings import Checked
from colcon_yamllaunch.language.evaluation.findings import ProgramUse
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.plan.plan import Plan

if TYPE_CHECKING:
    from colcon_yamllaunch.language.evaluation.launch_worker import Growing


@dataclass(frozen=True, slots=True)
class Evaluation(Checked):
    """
    What a launch file comes to.

    :param plan: What to run; not complete when there are errors
    :param inputs: The files that were read, or looked for in vain, besides
      launch files
    :param has_run_programs: Whether programs were run, or a launch file in
      Python, which may have read others
    :param growing: What makes more of it while it runs, if anything does
    :param programs: Where launch files in YAML and XML name the programs, by
      what ROS 2 calls the processes
    """

    plan: Plan
    inputs: tuple[str, ...] = ()
    has_run_programs: bool = False
    growing: 'Growing | None' = None
    programs: Mapping[str, ProgramUse] = field(default_factory=dict)


def evaluate(request: Request, *, runs: bool = True) -> Evaluation:
    """
    Evaluate a launch file with everything that it includes.

    Nothing is started but what `$(command …)` says.

    :param request: The launch file, and what to evaluate it with
    :param runs: Whether `$(command …)` is run, and what `$(eval …)` says
      whatever it is; else the plan has what is written instead
    """
    walk = Walk(request)
    walk.runs = runs
    walk.launch(request.name, request.path)
    if walk.dialogue is not None:
        # most launch files are not in Python
        from colcon_yamllaunch.language.python_files import python_visit

        python_visit.finish(walk, request.path)
    if request.arguments and not walk.has_opaque:
        _warn_of_unknown_arguments(walk, request.arguments)
        _warn_of_overwritten_arguments(walk)
    _warn_of_shell_variables(walk)
    _warn_of_nodes(walk)
    plan = replace(walk.draft.plan(), left_open=tuple(walk.left_open))
    growing = None
    if walk.dialogue is not None and not walk.error_count():
        from colcon_yamllaunch.language.python_files import growing_launch

        plan, growing = growing_launch.growing_launch(walk, plan)
    return Evaluation(
        tuple(walk.diagnostics),
        tuple(walk.sources),
        walk.packages_used,
        tuple(walk.executables),
        tuple(walk.plugins),
        plan,
        tuple(walk.inputs),
        walk.has_run_programs,
        growing,
        walk.programs,
    )


def _warn_of_overwritten_arguments(walk: Walk) -> None:
    for name, problem in walk.overwritten.items():
        if name not in walk.given_read:
            # the includes around are not those that led there
            walk.diagnostics.extend(problem.diagnostics)


def _warn_of_unknown_arguments(walk: Walk, given: Mapping[str, str]) -> None:
    """Warn of arguments that no launch file declares or reads."""
    # most launches are given none
    from colcon_yamllaunch.language.policies import cross_checks

    known = {*walk.read, *cross_checks.PROCESS_ARGUMENTS}
    files = [file for file in walk.files.values() if file is not None]
    declared = cross_checks.declared_arguments(files)
    if walk.dialogue is not None:
        declared |= walk.dialogue.declared.keys()
        declared |= cross_checks.written_in_python(walk.python_files)
        in_python = cross_checks.in_python(walk.python_files, given)
        known |= in_python
        # they may have been read before they were set
        walk.given_read |= in_python
    for name in given:
        if name not in declared | known:
            hint = cross_checks.undeclared_hint(name, declared)
            walk.report(cross_checks.undeclared_argument(name, hint))


def _warn_of_shell_variables(walk: Walk) -> None:
    """Warn of launch arguments that are written as in a shell."""
    if any('${' in source.text for source in walk.sources):
        # most launch files have none
        from colcon_yamllaunch.language.policies import cross_checks

        for problem in cross_checks.shell_variables(walk.files.values()):
            walk.report(problem)


def _warn_of_nodes(walk: Walk) -> None:
    """Warn of names that no node of the launch has."""
    if not (walk.targets or walk.section_uses):
        return
    # only launches with components or parameter files need it
    from colcon_yamllaunch.language.policies import cross_checks

    if not walk.error_count():
        # an action with an error is none of the launch's nodes
        cross_checks.warn_of_missing_containers(walk)
    cross_checks.warn_of_useless_sections(walk, in_full=False)
