# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `colcon launch` does, step by step."""

from collections.abc import Callable
from collections.abc import Mapping
from pathlib import Path
import signal
from typing import TYPE_CHECKING

from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.verb.cli.messages import say
from colcon_yamllaunch.verb.launching.log_folders import locked
from colcon_yamllaunch.verb.launching.log_folders import log_store_of
from colcon_yamllaunch.verb.launching.plan_run import PlanRun
from colcon_yamllaunch.verb.launching.steps.launch_basis import GiveUpError
from colcon_yamllaunch.verb.launching.steps.launch_preparation import (
    LaunchPreparation,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.runtime.course.plan_changes import PlanChanges

#: Makes what changes the plan while it runs, of the launch, its plan and the
#: environment of that.
MakeChanges = Callable[['LaunchFlow', Plan, Mapping[str, str]], 'PlanChanges']


class LaunchFlow(LaunchPreparation):
    """One launch, from its evaluation to its end."""

    def run(
        self, plan_run: PlanRun, changes: MakeChanges | None = None
    ) -> int:
        """
        Do it, and return the exit code.

        :param changes: Makes what changes the plan while it runs
        """
        with locked(self._log_folder), self._workspace.lock:
            try:
                plan, environment = self.prepare()
            except GiveUpError as e:
                return e.returncode
            return self._run(plan, environment, plan_run, changes)

    def run_saved(self, path: Path, plan_run: PlanRun) -> int:
        """
        Run a saved plan in the environment of the workspace.

        :raises UserError: when the file has no plan
        """
        # few plans are saved
        from colcon_yamllaunch.verb.launching.steps import saved_plan

        plan = saved_plan.read_saved_plan(path, self.cwd)
        with locked(self._log_folder):
            if self._deployed is not None:
                try:
                    self._deployed.bring_code_of(plan)
                    plan = self._deployed.settled(plan)
                except GiveUpError as e:
                    return e.returncode
            return self._run(plan, self._process_environment(), plan_run)

    def _run(
        self,
        plan: Plan,
        environment: Mapping[str, str],
        plan_run: PlanRun,
        changes: MakeChanges | None = None,
    ) -> int:
        # one that this waited for may have started them meanwhile
        self._tell_of_doubled_nodes(plan, environment)
        label = None
        if self._options.attach is not None:
            from colcon_yamllaunch.verb.sessions.attaching import with_terminal

            plan, label = with_terminal(plan, self._options.attach)
        whole, elsewhere = plan, None
        if self._deployed is not None:
            plan, elsewhere = self._deployed.start(
                plan, is_growing=self._growing is not None
            )
        # who types Ctrl-C once more just when the launch has ended gets its
        # exit code all the same: from here on only the launch takes SIGINT
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        source = self._host.source(self._growing)
        store = None
        if self._log_folder is not None:
            store = log_store_of(self._log_folder, self._environment, say)
        return plan_run.run(
            plan,
            environment,
            self._log_folder,
            store,
            self._about(),
            label,
            lambda module, user: self.locator.undeclared_owner(module, user),
            self._workspace.lock.release,
            self._host.identity,
            None if changes is None else changes(self, whole, environment),
            source,
            elsewhere,
        )
