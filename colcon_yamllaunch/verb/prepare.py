# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch needs before it runs: a plan, and all that it names."""

from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import nullcontext
from contextlib import redirect_stdout
from functools import cached_property
import io
import os
from pathlib import Path
import sys
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.verb.context import GiveUpError
from colcon_yamllaunch.verb.context import LaunchBasis
from colcon_yamllaunch.verb.messages import say
from colcon_yamllaunch.verb.target import Target

if TYPE_CHECKING:
    from colcon_yamllaunch.verb.builds import Builds
    from colcon_yamllaunch.watch.consequences import Products
    from colcon_yamllaunch.watch.dependencies import RemoteDependencies


#: How often what a build brought may make more packages necessary.
MAXIMUM_ROUNDS = 5
_NONE = frozenset[str]()


class LaunchPreparation(LaunchBasis):
    """A launch that is evaluated and built, here and on other machines."""

    @cached_property
    def builds(self) -> 'Builds':
        """The builds of this launch."""
        from colcon_yamllaunch.verb.builds import Builds

        return Builds(
            self._workspace,
            exactly=bool(self._options.paths),
            force=self._options.force,
            why=self._options.why,
        )

    def prepare(self) -> tuple[Plan, Mapping[str, str]]:
        """
        Evaluate and build until nothing more is needed.

        Return the plan, and the environment for its processes.

        :raises GiveUpError: when there can be no launch
        :raises UserError: when there can be none either
        """
        built: set[str] = set()
        self._warned: list[Diagnostic] = []
        may_build = not self._options.no_build and bool(self._workspace.root)
        # what need not be here is known once it is known what runs here
        is_final = not may_build and self.deployment is None
        if self._deployed is not None:
            self._deployed.expect_machines()
        for _ in range(MAXIMUM_ROUNDS):
            target = self.target()
            request = self.request(target, built=is_final)
            evaluation = evaluate(request)
            errors = evaluation.errors
            if not errors:
                # before a build, which may take long
                if self.needs_declarations:
                    self._refuse_undeclared(evaluation)
                plan, environment = evaluation.plan, request.environment
                self._tell_of_doubled_nodes(plan, environment)
                if self._deployed is not None:
                    named = self._named(target, evaluation)
                    if self._options.build_all:
                        named = self._workspace.package_names
                    self._deployed.bring_code(evaluation, named)
            if is_final or any(not e.may_pass_after_build for e in errors):
                break
            self._stop_at_foreign_plugins(evaluation)
            wanted = self._wanted(target, evaluation)
            is_final = (
                not may_build
                or wanted <= built
                or not self._update(wanted, target, evaluation)
            )
            built |= wanted
            expected = self._packages.expected
            if is_final and all(map(self._is_there, expected)):
                # nothing was built since, so all of it still holds
                break
        self.wanted = self._wanted(target, evaluation)
        self._tell_of_build(target, evaluation)
        self._stop_at_errors(target, evaluation)
        self.evaluation = evaluation
        self._warn(evaluation.diagnostics)
        self._check_before_start(evaluation)
        self._growing = evaluation.growing
        plan = evaluation.plan
        if self._deployed is not None:
            plan = self._deployed.settled(plan)
        self._warn_of_missing_programs(plan, request.environment)
        return plan, request.environment

    def explain(self, target: Target, evaluation: Evaluation) -> None:
        """Say what would be built for the launch, and why."""
        wanted = self._wanted(target, evaluation)
        self.builds.explain(wanted, Path(target.name).name)

    @property
    def deployment_digest(self) -> str:
        """What tells which machines there are, and what is on them."""
        return '' if self._deployed is None else self._deployed.digest

    @property
    def machine_names(self) -> frozenset[str]:
        """The machines that parts of it run on."""
        return _NONE if self._deployed is None else self._deployed.used

    @property
    def runs_there(self) -> 'RemoteDependencies | None':
        """What runs on these, with `--watch`."""
        return None if self._deployed is None else self._deployed.there

    @property
    def built_there(self) -> frozenset[str]:
        """The packages that were built there."""
        return _NONE if self._deployed is None else self._deployed.built

    @property
    def records_there(self) -> 'Products':
        """What these builds, and earlier ones, have made."""
        return {} if self._deployed is None else self._deployed.records

    def _stop_at_errors(self, target: Target, evaluation: Evaluation) -> None:
        errors = evaluation.errors
        if all(error.may_pass_after_build for error in errors):
            # what is missing may be missing for this reason
            needed = sorted(self._needed(target, evaluation))
            may_build = not self._options.no_build
            self._workspace.check_sourced(needed, may_build=may_build)
        if errors:
            self._fail(evaluation.diagnostics)

    def _warn(self, warnings: Iterable[Diagnostic]) -> None:
        """Report those warnings that were not reported before a build."""
        new = [w for w in warnings if w not in self._warned]
        self._warned += new
        self.report(new)

    def _refuse_undeclared(self, evaluation: Evaluation) -> None:
        """Refuse arguments that the launch would warn of."""
        from colcon_yamllaunch.language.policies import cross_checks

        told = {d.message: d.hint for d in evaluation.diagnostics}
        for name in self._options.arguments:
            problem = cross_checks.undeclared_argument(name, '')
            message = problem.diagnostics[0].message
            if message in told:
                raise UserError(message, told[message])

    def _stop_at_foreign_plugins(self, evaluation: Evaluation) -> None:
        """Stop at components that no build of the workspace brings."""
        own = self._workspace.package_names
        uses = [use for use in evaluation.plugins if use.package not in own]
        if not uses:
            return
        from colcon_yamllaunch.verb.preflight import unknown_plugins

        found = unknown_plugins(uses, self._workspace.locator)
        errors = [d for d in found if d.severity == 'error']
        if errors:
            self._fail([*evaluation.diagnostics, *errors])

    def _wanted(self, target: Target, evaluation: Evaluation) -> set[str]:
        """Return the packages of the workspace to bring up to date."""
        workspace = self._workspace
        if self._options.build_all:
            return set(workspace.package_names) - self._only_there
        if self._options.paths:
            return set(workspace.select(self._options.paths, self.cwd))
        return self._needed(target, evaluation)

    def _needed(self, target: Target, evaluation: Evaluation) -> set[str]:
        """Return the packages of the workspace that it needs here."""
        return self._named(target, evaluation) - self._only_there

    def _named(self, target: Target, evaluation: Evaluation) -> set[str]:
        """Return the packages of the workspace that the launch names."""
        names = {target.package, *evaluation.packages}
        return self._workspace.package_names & names

    def _is_there(self, path: str) -> bool:
        """Say whether a path exists, or need not exist here."""
        if os.path.exists(Path(path)):
            return True
        owner = self.locator.owner(path)
        return owner is not None and owner.name in self._only_there

    def _update(
        self, wanted: set[str], target: Target, evaluation: Evaluation
    ) -> bool:
        """Build what is stale, and return whether that changed anything."""
        from colcon_yamllaunch.verb.builds import failure
        from colcon_yamllaunch.verb.preflight import executables_in_vain

        def look_first() -> None:
            found = executables_in_vain(evaluation.executables, self.locator)
            if found:
                self._fail(found)
            if not evaluation.errors:
                # what a build brings is missing in vain only after it
                self._warn(
                    d
                    for d in evaluation.diagnostics
                    if not d.may_pass_after_build
                )

        if evaluation.growing is None:
            # what builds leave running is told apart by what was there before
            self._host.release()
        output = io.StringIO()
        with redirect_stdout(output) if self._options.quiet else nullcontext():
            update = self.builds.update(
                wanted, Path(target.name).name, look_first
            )
        if update.returncode:
            say(failure(update))
            if self._options.quiet:
                # as without --quiet, with the colours of the compiler
                print(output.getvalue().rstrip(), file=sys.stderr, flush=True)
            raise GiveUpError(update.returncode, is_build=True)
        if update.changed:
            # it may have imported what is another now
            self._host.close()
        return update.changed

    def _tell_of_build(self, target: Target, evaluation: Evaluation) -> None:
        if self._workspace.root is None:
            return
        if not self._options.no_build:
            if not self._options.quiet:
                self.builds.tell()
        elif self._options.why:
            self.explain(target, evaluation)

    def _warn_of_missing_programs(
        self, plan: Plan, environment: Mapping[str, str]
    ) -> None:
        from colcon_yamllaunch.verb.preflight import missing_programs

        uses = {} if self.evaluation is None else self.evaluation.programs
        here = plan if self._deployed is None else self._deployed.local(plan)
        found = missing_programs(
            here.processes(), uses, self.locator, environment
        )
        self.report(found)

    def _check_before_start(self, evaluation: Evaluation) -> None:
        from colcon_yamllaunch.verb.preflight import preflight
        from colcon_yamllaunch.verb.preflight import undeclared_packages

        locator = self._workspace.locator
        found = [
            *undeclared_packages(evaluation.packages, locator),
            *preflight(
                evaluation,
                self._packages.not_installed,
                locator,
                self._only_there,
            ),
        ]
        if any(d.severity == 'error' for d in found):
            self._fail(found)
        self.report(found)
