# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `colcon launch` does, step by step."""

from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from copy import copy
from pathlib import Path
import signal
from typing import TYPE_CHECKING

from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.verb.cli.messages import say
from colcon_yamllaunch.verb.launching.log_folders import locked
from colcon_yamllaunch.verb.launching.log_folders import log_store_of
from colcon_yamllaunch.verb.launching.plan_run import PlanRun
from colcon_yamllaunch.verb.launching.steps.host_keeper import HostKeeper
from colcon_yamllaunch.verb.launching.steps.launch_basis import GiveUpError
from colcon_yamllaunch.verb.launching.steps.launch_preparation import (
    LaunchPreparation,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.participants import Participant

#: Makes what changes the plan while it runs, of the launch, its plan and the
#: environment of that.
MakeChanges = Callable[['LaunchFlow', Plan, Mapping[str, str]], 'Participant']


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

    def variant(
        self,
        arguments: Mapping[str, str],
        log_folder: Path,
        variables: Mapping[str, str],
        *,
        builds: bool = False,
    ) -> 'LaunchFlow':
        """
        Return the same launch with other arguments.

        It has the workspace as it is now, with what is known of it.

        :param log_folder: The folder for its logs
        :param variables: What its environment has, too
        :param builds: Whether it may build, as far as this one may
        """
        options = self._options.replaced(arguments=dict(arguments))
        if not builds:
            options = options.replaced(
                no_build=True,
                build_all=False,
                paths=(),
                force=False,
                why=False,
            )
        other = copy(self)
        other._options = options
        other._log_folder = log_folder
        other._log_dir = str(log_folder)
        other._variables = variables
        other._host = HostKeeper(self.cwd, self._environment, log_folder)
        other._growing = None
        # the runs of a sweep are all here
        other._deployed = None
        other._is_again = True
        other.evaluation, other.wanted = None, set()
        return other

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
            environment = self._process_environment()
            self._warn_of_missing_programs(plan, environment)
            return self._run(plan, environment, plan_run)

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
        whole = plan
        participants: list[Participant] = []
        if self._deployed is not None:
            plan, parts = self._deployed.start(
                plan, is_growing=self._growing is not None
            )
            participants.append(parts)
        # who types Ctrl-C once more just when the launch has ended gets its
        # exit code all the same: from here on only the launch takes SIGINT
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        identity, feeds = self.plan_feeds()
        if changes is not None:
            participants.insert(0, changes(self, whole, environment))
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
            identity,
            (*participants, *feeds),
        )

    def plan_feeds(self) -> tuple[str, 'Sequence[Participant]']:
        """
        Return the identity that the launch has already, '' for none.

        And the participant that extends its plan while it runs, if there is
        one. To be called once, when the plan is about to run.
        """
        identity = self._host.identity
        return identity, self._host.feeds(self._growing)
