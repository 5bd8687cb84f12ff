# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a launch does besides if parts of it run on other machines.

In this order: it reads the deployment file, cuts the plan by it once there is
one, connects, has the code brought while this computer builds what it needs
itself, looks whether all is there, and starts the parts.
"""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import NoReturn
from typing import TYPE_CHECKING

from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.remote.deployment import deployment_file
from colcon_yamllaunch.remote.deployment.deployment import Deployment
from colcon_yamllaunch.remote.deployment.placement import rules_in_vain
from colcon_yamllaunch.verb.cli.options import LaunchOptions
from colcon_yamllaunch.verb.launching.log_folders import log_store_of
from colcon_yamllaunch.verb.launching.workspace_session import WorkspaceSession

if TYPE_CHECKING:
    from colcon_yamllaunch.remote.link.remote_parts import RemoteParts
    from colcon_yamllaunch.remote.part_settings import PartSettings
    from colcon_yamllaunch.verb.launching.steps.machines_there import (
        MachinesThere,
    )
    from colcon_yamllaunch.watch.consequences import Products
    from colcon_yamllaunch.watch.dependencies import RemoteDependencies


class DeployedLaunch:
    """
    What a launch does about other machines.

    :param environment: The user's
    :param log_folder: The folder for the logs, or None to keep none
    :param report: Shows problems to the user
    :param fail: Shows them, and ends the launch by an exception
    :param may_ask: Whether ssh may ask for a password at the terminal
    """

    def __init__(
        self,
        options: LaunchOptions,
        cwd: Path,
        environment: Mapping[str, str],
        session: WorkspaceSession,
        log_folder: Path | None,
        report: Callable[[Iterable[Diagnostic]], None],
        fail: Callable[[Sequence[Diagnostic]], NoReturn],
        *,
        may_ask: bool,
    ) -> None:
        self._options = options
        self._cwd = cwd
        self._environment = environment
        self._session = session
        self._log_folder = log_folder
        self._report = report
        self._fail = fail
        self._may_ask = may_ask
        self._parts: RemoteParts | None = None
        #: The packages that are not built here, as nothing here needs them.
        self.only_there: frozenset[str] = frozenset()
        #: The machines that parts of it run on.
        self.used: frozenset[str] = frozenset()
        # the packages that each machine needs
        self._needed: Mapping[str, frozenset[str]] = {}
        #: What runs there, and the code that is there, with `--watch`.
        self.there: RemoteDependencies | None = None
        self.records: Products = {}

    @cached_property
    def deployment(self) -> Deployment:
        """
        Which machines there are, and what runs on them.

        :raises GiveUpError: when the deployment file is wrong
        :raises UserError: when there is no such machine
        """
        found = None
        if self._options.deploy is not None:
            path = str(self._cwd / self._options.deploy)
            try:
                found = deployment_file.read_deployment(path)
            except LaunchError as e:
                self._fail(e.diagnostics)
        if self._options.on is not None:
            return deployment_file.deployed_on(self._options.on, found)
        assert found is not None
        return found

    @cached_property
    def machines(self) -> 'MachinesThere':
        """The machines, as far as they have been connected with."""
        # who only looks at a launch connects nowhere
        from colcon_yamllaunch.verb.launching.steps import machines_there

        return machines_there.MachinesThere(
            self.deployment,
            self._session,
            self._environment,
            self._cwd,
            self._log_folder,
            None if self._options.quiet else self._session.announce,
            ' '.join(['colcon launch', *self._options.positionals]),
            mode='none' if self._options.no_build else None,
            may_ask=self._may_ask,
        )

    def expect_machines(self) -> None:
        """
        Begin to connect while the launch file is evaluated.

        :raises GiveUpError: when the deployment file is wrong
        :raises UserError: when there is no such machine
        """
        self.machines.expect()

    def bring_code(
        self, evaluation: Evaluation, named: Collection[str]
    ) -> None:
        """
        Connect with the machines of a launch, and begin to bring the code.

        :param named: The packages of the workspace that the launch names
        :raises GiveUpError: when no build brings a program of it
        :raises UserError: when a machine cannot be reached
        """
        from colcon_yamllaunch.verb.launching.preflight import (
            executables_in_vain,
        )

        locator = self._session.locator
        found = executables_in_vain(evaluation.executables, locator)
        if found:
            self._fail(found)
        placed = self.machines.place(evaluation.plan)
        self._needed = needed = self.machines.needed(
            placed,
            frozenset(named),
            is_growing=evaluation.growing is not None,
        )
        self.machines.begin(needed)
        # what was run here may need any of them
        if not evaluation.has_run_programs:
            self.only_there = self.machines.only_there(placed, needed)

    def bring_code_of(self, plan: Plan) -> None:
        """
        Do so for a saved plan.

        :raises UserError: when a machine cannot be reached
        """
        self.machines.begin_with(plan)

    def settled(self, plan: Plan) -> Plan:
        """
        Return a plan as it is known by its users, with names of machines.

        All that its parts need is there then.

        :raises GiveUpError: when something that they need is not
        :raises UserError: when the code could not be brought
        """
        self._report(rules_in_vain(plan, self.deployment))
        placed = self.machines.place(plan)
        self.machines.wait()
        found = list(self.machines.check(placed))
        if any(d.severity == 'error' for d in found):
            self._fail(found)
        self._report(found)
        self.used = frozenset(placed.parts)
        if self._options.watch is not None:
            self.there = self.machines.runs_there(placed, self._needed)
            self.records = self.machines.records(self.there)
        return placed.whole

    def local(self, plan: Plan) -> Plan:
        """Return what of a plan runs here."""
        return self.machines.place(plan).local

    @property
    def digest(self) -> str:
        """What tells the deployment from others."""
        # only who watches files asks
        import hashlib

        known = self.deployment
        # where it is written does not matter
        machines = [replace(m, position=None) for m in known.machines.values()]
        rules = [(str(rule), rule.machine) for rule in known.rules]
        text = repr((machines, rules, known.everything_on))
        return hashlib.sha256(text.encode()).hexdigest()

    @property
    def built(self) -> frozenset[str]:
        """The packages that were built on machines."""
        return frozenset[str]().union(*self.machines.built.values())

    def disown(self) -> None:
        """Have nothing to do with the parts, in a fork of this process."""
        if self._parts is not None:
            self._parts.disown()

    def start(
        self, plan: Plan, *, is_growing: bool
    ) -> 'tuple[Plan, RemoteParts]':
        """
        Start the parts, and return what of the plan runs here besides.

        :param plan: As :meth:`settled` has returned it
        :param is_growing: Whether more may come while it runs
        :raises UserError: when one cannot be started
        """
        placed = self.machines.place(plan)
        self._parts = self.machines.start(
            placed, self._settings(), is_growing=is_growing
        )
        return placed.local, self._parts

    def close(self) -> None:
        """End what is connected, and what runs there."""
        if self._parts is not None:
            self._parts.close()
        if 'machines' in vars(self):
            self.machines.close()

    def _settings(self) -> 'PartSettings':
        """Return what is the same for the parts on all machines."""
        from colcon_yamllaunch.remote.part_settings import PartSettings

        settings = PartSettings(
            '', log_limit=self._options.log_limit, tty=self._options.tty
        )
        folder = self._log_folder
        if folder is None:
            return settings
        settings = replace(settings, log_name=folder.name)
        # that the user's wish is no number is said by who tidies up here
        store = log_store_of(folder, self._environment, lambda _: None)
        if store is None:
            return settings
        return replace(settings, kept_logs=store.kept, logs_limit=store.limit)
