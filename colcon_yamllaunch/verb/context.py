# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The context of a launch, which all its steps share."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from functools import cached_property
import os
from pathlib import Path
import time
from typing import NoReturn, TYPE_CHECKING

from colcon_yamllaunch.common.messages import GiveUpError, say, say_line, show
from colcon_yamllaunch.engine.state import About
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    LaunchError,
    render,
)
from colcon_yamllaunch.language.syntax.launch_tree import LaunchFile
from colcon_yamllaunch.verb.log_folders import ros_log_folder
from colcon_yamllaunch.verb.options import LaunchOptions
from colcon_yamllaunch.verb.target import find_target, find_workspace, Target
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator
from colcon_yamllaunch.workspace.workspace_session import (
    LaunchPackages,
    WorkspaceSession,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.deployment.deployment import Deployment
    from colcon_yamllaunch.deployment.placement import PlacedPlan, Placer
    from colcon_yamllaunch.engine.participants import Participant
    from colcon_yamllaunch.language.policies.evaluate import Evaluation
    from colcon_yamllaunch.observers.junit import JUnitReport
    from colcon_yamllaunch.plan.plan import Entry, Plan
    from colcon_yamllaunch.python_launch.worker_process import WorkerProcess
    from colcon_yamllaunch.verb.background_launch import Background
    from colcon_yamllaunch.verb.machines import Machines
    from colcon_yamllaunch.workspace.builds import Builds

# what few launches need is imported where it is needed


class LaunchContext:
    """
    A launch: its options, its workspace, and the results of its steps.

    :param environment: The user's
    :param log_folder: The folder for the logs, or None to keep none
    :param announce: Is called with a line that the user should see at once;
      by default it is printed, unless the user wants it quiet
    :param is_again: Whether the launch runs already, or many alike do
    :raises UserError: when there is no such workspace
    """

    def __init__(
        self,
        options: LaunchOptions,
        cwd: Path,
        environment: Mapping[str, str],
        log_folder: Path | None,
        announce: Callable[[str], None] | None = None,
        *,
        is_again: bool = False,
    ) -> None:
        #: When it was begun, on the monotonic clock and since the epoch.
        self.begun = time.monotonic()
        self.begun_ns = time.time_ns()
        self.options = options
        self.cwd = cwd
        self.environment = environment
        self.log_folder = log_folder
        self.is_again = is_again
        if announce is None:
            announce = (lambda _: None) if options.quiet else say_line
        #: The workspace, as far as it has been built and sourced.
        self.workspace = WorkspaceSession(
            find_workspace(
                options.workspace,
                options.positionals,
                builds=options.build_all or bool(options.paths),
            ),
            options.build_args,
            environment,
            announce,
            f'colcon launch {options.title}',
            runs=options.runs,
        )
        #: The last evaluation, and the packages that it needs.
        self.evaluation: Evaluation | None = None
        self.wanted: set[str] = set()
        #: The packages, as the last request has them.
        self.packages = LaunchPackages(self.locator, built=False)
        #: The launch files that have been read.
        self.trees: dict[str, LaunchFile] = {}
        #: The launches that the user knows to run the same nodes.
        self.known_doubles: set[int] = set()
        #: Variables for the processes, beside those of the workspace.
        self.variables: Mapping[str, str] = {}
        #: Whether an argument that no launch file declares is an error.
        self.needs_declarations = False
        #: The command, for messages.
        self.command = 'colcon launch'
        #: The report that `--junit` asks for.
        self.junit: JUnitReport | None = None
        #: Where it goes when it begins to run, if another process shows it.
        self.background: Background | None = None
        self._worker: WorkerProcess | None = None
        # has placed the plan, if there is a deployment
        self._placer: Placer | None = None
        self._worker_environment: Mapping[str, str] = {}

    def again(
        self, options: LaunchOptions, announce: Callable[[str], None]
    ) -> 'LaunchContext':
        """Return the same launch, begun now; it reads only changed files."""
        other = LaunchContext(
            options,
            self.cwd,
            self.environment,
            self.log_folder,
            announce,
            is_again=True,
        )
        other.trees.update(self.trees)
        return other

    def variant(
        self,
        options: LaunchOptions,
        log_folder: Path,
        variables: Mapping[str, str],
    ) -> 'LaunchContext':
        """Return the same launch with other options, in this workspace."""
        other = copy(self)
        other.options = options
        other.log_folder = log_folder
        other.variables = variables
        other.is_again = True
        other.evaluation, other.wanted = None, set()
        other._worker = None
        return other

    @cached_property
    def deployment(self) -> 'Deployment | None':
        """
        The machines for parts of the launch, and settings of processes.

        None where all of it runs here, as the launch file says.

        :raises GiveUpError: when the deployment file is wrong
        :raises UserError: when there is no such machine
        """
        options, found = self.options, None
        if options.on is None and options.deploy is None:
            return None
        from colcon_yamllaunch.deployment import (
            deployment_file,
            machine_settings,
        )

        if options.deploy is not None:
            path = str(self.cwd / options.deploy)
            try:
                found = deployment_file.read_deployment(path, options.profile)
            except LaunchError as e:
                self.fail(e.diagnostics)
        if options.on is not None and options.install_service is None:
            found = machine_settings.deployed_on(options.on, found)
        return found

    @cached_property
    def machines(self) -> 'Machines | None':
        """The machines of parts of the launch, as far as connected."""
        if self.deployment is None or not self.deployment.machines:
            return None
        if self.options.install_service is not None:
            # a service is for one computer, see `services`
            return None
        from colcon_yamllaunch.verb.machines import Machines

        return Machines(self, self.deployment)

    def placed(self, plan: 'Plan') -> 'PlacedPlan | None':
        """
        Return a plan with what the deployment says; None without one.

        :raises GiveUpError: when the deployment does not fit the plan
        """
        if self.deployment is None:
            return None
        from colcon_yamllaunch.deployment.placement import Placer

        self._placer = Placer(self.deployment)
        try:
            return self._placer.place(plan)
        except LaunchError as e:
            self.fail(e.diagnostics)

    def _with_settings(
        self, entries: 'tuple[Entry, ...]'
    ) -> 'tuple[Entry, ...]':
        """
        Return entries that are added while the launch runs, with settings.

        :raises LaunchError: when the deployment does not fit them
        """
        if self.machines is not None:
            # what runs on machines gets its settings with its machine
            self.machines.check_more(entries)
        elif self._placer is not None:
            return self._placer.place_more(entries).whole.entries
        return entries

    @cached_property
    def builds(self) -> 'Builds':
        """The builds of this launch."""
        from colcon_yamllaunch.workspace.builds import Builds

        return Builds(
            self.workspace,
            exactly=bool(self.options.paths),
            force=self.options.force,
            why=self.options.why,
        )

    @property
    def locator(self) -> PackageLocator:
        """Where the packages are."""
        return self.workspace.locator

    def target(self) -> Target:
        """
        Find the launch file.

        :raises UserError: when there is none
        """
        return find_target(
            self.options.positionals,
            self.cwd,
            self.locator,
            self.workspace.broken_manifests,
        )

    def about(self) -> About:
        """
        Return what other terminals know the launch by.

        :raises UserError: when there is no such launch file
        """
        title, plan = self.options.title, self.options.from_plan
        if plan is not None:
            return About(title, None, str(self.cwd / plan), str(self.cwd))
        target = self.target()
        return About(title, target.package, target.path, str(self.cwd))

    @property
    def log_dir(self) -> str:
        """The folder that `$(log_dir)` names."""
        return str(self.log_folder or ros_log_folder(self.environment))

    def process_environment(self) -> Mapping[str, str]:
        """Return the environment for the processes."""
        environment = dict(self.workspace.environment)
        environment.setdefault('ROS_LOG_DIR', self.log_dir)
        environment.update(self.variables)
        return environment

    def request(
        self, target: Target | None = None, *, built: bool = False
    ) -> Request:
        """
        Return what is to be evaluated.

        :param target: The launch file; by default that which the user means
        :param built: Whether all that was to be built has been built
        :raises UserError: when there is no such launch file
        """
        target = target or self.target()
        self.packages = LaunchPackages(
            self.locator, built=built, remote_only=self.remote_only
        )
        locator = self.locator
        located = self.packages.locate(target.name)
        environment = self.process_environment()
        return Request(
            target.path if located is None else located[0],
            target.path,
            packages=self.packages,
            environment=environment,
            arguments=self._arguments(),
            cwd=str(self.cwd),
            log_folder=self.log_dir,
            exposed=lambda: locator.exposed,
            open_worker=lambda: self.worker(environment),
            trees=self.trees,
        )

    def _arguments(self) -> Mapping[str, str]:
        """Return the launch arguments; those of the command line win."""
        deployment = self.deployment
        if deployment is None:
            return self.options.arguments
        return {**deployment.arguments, **self.options.arguments}

    @property
    def remote_only(self) -> frozenset[str]:
        """The packages that other machines have, and this one need not."""
        machines = vars(self).get('machines')
        return frozenset() if machines is None else machines.remote_only

    def worker(self, environment: Mapping[str, str]) -> 'WorkerProcess':
        """
        Return the process that reads launch files in Python.

        It is the one that there is, unless it is in another environment.

        :raises UserError: when the user's time limit is no number
        """
        from colcon_yamllaunch.engine.launch_scan import new_identity
        from colcon_yamllaunch.python_launch import worker_process

        if self._worker is not None and (
            self._worker.is_spent or self._worker_environment != environment
        ):
            self.end_worker()
        if self._worker is None:
            log = None
            if self.log_folder is not None and not self.options.inspects:
                log = self.log_folder / worker_process.LOG_NAME
            self._worker = worker_process.WorkerProcess(
                environment,
                str(self.cwd),
                log,
                new_identity(),
                worker_process.timeout_of(self.environment),
            )
            self._worker_environment = environment
        return self._worker

    def release_worker(self) -> None:
        """Ask the worker to end, as it has nothing more to do."""
        if self._worker is not None:
            self._worker.release()

    def end_worker(self) -> None:
        """End the worker if it runs."""
        if self._worker is not None:
            self._worker.close()
            self._worker = None

    def plan_feeds(self) -> 'tuple[str, Sequence[Participant]]':
        """
        Return the identity that the launch has already, '' for none.

        And the participant that extends its plan while it runs, if there is
        one. To be called once, when the plan is about to run.
        """
        if self._worker is None:
            return '', ()
        identity = self._worker.identity
        growing = self.evaluation and self.evaluation.growing
        if not growing:
            self._worker.release()
            return identity, ()
        from colcon_yamllaunch.python_launch.plan_feed import PlanFeed

        self._worker.entrust()
        return identity, (
            PlanFeed(self._worker, growing, self._with_settings),
        )

    def close(self) -> None:
        """End the connections to machines and the worker."""
        if (machines := vars(self).get('machines')) is not None:
            machines.close()
        self.end_worker()

    def detach(self) -> None:
        """Detach a forked child from the connections and the worker."""
        if self._worker is not None:
            self._worker.detach()
            self._worker = None
        if (machines := vars(self).get('machines')) is not None:
            machines.detach()

    def report(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Show problems to the user."""
        text = render(diagnostics, str(self.cwd), self.command)
        if text:
            say(text)

    def report_or_fail(self, diagnostics: Iterable[Diagnostic]) -> None:
        """
        Show problems to the user, and end the launch if one is an error.

        :raises GiveUpError: when one is an error
        """
        found = list(diagnostics)
        if any(diagnostic.severity == 'error' for diagnostic in found):
            self.fail(found)
        self.report(found)

    def fail(self, diagnostics: Sequence[Diagnostic]) -> NoReturn:
        """
        Show problems to the user, and end the launch.

        :raises GiveUpError: always
        """
        self.report(diagnostics)
        self.annotate(diagnostics)
        raise GiveUpError(1)

    def annotate(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Print problems as annotations, in a workflow of GitHub."""
        if self.environment.get('GITHUB_ACTIONS') != 'true':
            return
        from dataclasses import replace

        from colcon_yamllaunch.language.reports import annotation

        root = self.environment.get('GITHUB_WORKSPACE') or os.getcwd()
        for diagnostic in diagnostics:
            if (position := diagnostic.position) is not None:
                # from an installed launch file to that in the repository
                path = os.path.realpath(position.path)
                position = replace(position, path=path)
            found = replace(diagnostic, position=position)
            show(annotation(found, os.path.realpath(root)))
