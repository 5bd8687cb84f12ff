# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
From a launch file and its arguments to a plan.

This is the policy of a launch, which is that of :class:`Walk` itself: all is
known, an error ends its action, and an action whose condition does not hold is
passed over.
"""

from collections.abc import Mapping
from dataclasses import field, replace
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.evaluation.findings import (
    CheckResult,
    ProgramUse,
)
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.plan.plan import Plan

if TYPE_CHECKING:
    from colcon_yamllaunch.language.python_files.growing_launch import (
        GrowingLaunch,
    )


@dataclass(frozen=True, slots=True)
class Evaluation(CheckResult):
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
    growing: 'GrowingLaunch | None' = None
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
    if (
        walk.given
        or walk.targets
        or walk.section_uses
        or any('${' in source.text for source in walk.files.sources)
    ):
        # most launches have none of these
        from colcon_yamllaunch.language.policies import cross_checks

        cross_checks.cross_check(walk)
    plan = replace(walk.draft.plan(), left_open=tuple(walk.left_open))
    growing = None
    dialogue = walk.dialogue
    if dialogue is not None and dialogue.goes_on and not walk.error_count():
        # most launch files are not in Python
        from colcon_yamllaunch.language.python_files import growing_launch

        growing = growing_launch.GrowingLaunch(walk, dialogue, plan)
        plan = replace(plan, handlers=dialogue.handlers)
    return Evaluation(
        tuple(walk.diagnostics),
        tuple(walk.files.sources),
        walk.packages_used,
        tuple(walk.executables),
        tuple(walk.plugins),
        plan,
        tuple(walk.inputs),
        walk.has_run_programs,
        growing,
        walk.programs,
    )
