# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launches that the runs of a sweep are."""

from collections.abc import Mapping
from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.language.actions.process_actions import OUTPUT_OVERRIDE
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.sweep.local_runner import NotBuiltError
from colcon_yamllaunch.sweep.local_runner import PlanError
from colcon_yamllaunch.sweep.run import PlannedRun
from colcon_yamllaunch.sweep.table import Run
from colcon_yamllaunch.verb.launching.launch_flow import LaunchFlow
from colcon_yamllaunch.verb.launching.steps.launch_basis import GiveUpError
from colcon_yamllaunch.verb.sweeping.code_state import CodeState
from colcon_yamllaunch.verb.sweeping.code_state import files_of


class LaunchVariants:
    """
    Plans runs; all that they have in common is done once.

    :param flow: The launch
    :param fixed: Launch arguments that all runs have beside their own
    :param code: Is told which files the runs use
    :param folder: Where logs go that belong to no run
    :param may_build: Whether more packages may be built as runs need them
    """

    def __init__(
        self,
        flow: LaunchFlow,
        fixed: Mapping[str, str],
        folder: Path,
        code: CodeState,
        *,
        may_build: bool,
    ) -> None:
        self._flow = flow
        self._fixed = fixed
        self._folder = folder
        self._code = code
        self._may_build = may_build
        self._built: set[str] = set()
        # nobody sees a screen, so all output goes to the logs, unless the user
        # has said what is to become of it
        self._variables: Mapping[str, str] = {}
        if not flow.workspace.environment.get(OUTPUT_OVERRIDE):
            self._variables = {OUTPUT_OVERRIDE: 'both'}
        # who knows more of a launch that is planned, until it runs
        self._planned: LaunchFlow | None = None

    def prepare(self, run: Run) -> None:
        """
        Build what a run needs, and plan it to see that this can be done.

        :raises GiveUpError: when it cannot
        :raises UserError: when it cannot either
        """
        flow = self._flow.variant(
            {**run.arguments, **self._fixed}, self._folder, {}, builds=True
        )
        flow.needs_declarations = True
        try:
            with flow.workspace.lock:
                plan, _ = flow.prepare()
        finally:
            flow.close()
        self._code.add(self._uses(flow, plan))
        target = flow.target()
        if target.package is None:
            # what its programs import or read is in no package
            self._code.add_tracked(Path(target.path).parent)
        self._built |= flow.wanted

    def build(self, run: Run) -> None:
        """Build what a run needs; see :class:`.local_runner.Work`."""
        self.prepare(run)

    def _uses(self, flow: LaunchFlow, plan: Plan) -> set[str]:
        """Return the files, and the folders of packages, that a run uses."""
        if flow.evaluation is None:
            return set()
        files = files_of(plan, flow.evaluation)
        if not flow.wanted <= self._built:
            needed = flow.workspace.needed_by(flow.wanted)
            packages = flow.workspace.packages
            files |= {str(p.path) for p in packages if p.name in needed}
        return files

    def leave(self) -> None:
        """Have nothing to do any more with what was planned last."""
        if self._planned is not None:
            self._planned.close()
            self._planned = None

    def plan(
        self, run: Run, folder: Path, variables: Mapping[str, str]
    ) -> PlannedRun:
        """
        Plan a run; see :class:`.local_runner.Work`.

        :raises NotBuiltError: when it needs what is not built
        :raises PlanError: when it cannot be planned
        """
        flow = self._flow.variant(
            {**run.arguments, **self._fixed},
            folder,
            {**self._variables, **variables},
        )
        try:
            try:
                plan, environment = flow.prepare()
            finally:
                if self._may_build and not flow.wanted <= self._built:
                    raise NotBuiltError
        except GiveUpError as e:
            flow.close()
            raise PlanError from e
        except UserError:
            flow.close()
            raise
        identity, source = flow.plan_source()
        uses = self._code.missing(self._uses(flow, plan))
        self._code.add(uses)
        # what it holds ends with it
        self._planned = flow
        locator = flow.locator
        return PlannedRun(
            plan,
            environment,
            identity,
            source,
            lambda module, user: locator.undeclared_owner(module, user),
            tuple(uses),
        )
