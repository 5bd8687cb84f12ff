# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `colcon launch` does, step by step."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import nullcontext
from contextlib import redirect_stdout
from functools import cached_property
from importlib import import_module
import io
from pathlib import Path
import signal
import sys
from typing import NoReturn
from typing import TYPE_CHECKING

from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.language.policies.evaluate import evaluate
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import render
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile
from colcon_yamllaunch.language.vocabulary.package_lookup import FindExposed
from colcon_yamllaunch.language.vocabulary.package_lookup import NothingExposed
from colcon_yamllaunch.runtime.control.launch_states import About
from colcon_yamllaunch.runtime.control.socket_folder import has_sockets
from colcon_yamllaunch.verb.cli.launch_options import LaunchOptions
from colcon_yamllaunch.verb.cli.log_base import workspace_root
from colcon_yamllaunch.verb.cli.messages import say
from colcon_yamllaunch.verb.cli.messages import say_line
from colcon_yamllaunch.verb.cli.target import package_target
from colcon_yamllaunch.verb.cli.target import path_target
from colcon_yamllaunch.verb.cli.target import Target
from colcon_yamllaunch.verb.launching.launch_packages import (
    exposed_by_packages,
)
from colcon_yamllaunch.verb.launching.launch_packages import LaunchPackages
from colcon_yamllaunch.verb.launching.log_folders import locked
from colcon_yamllaunch.verb.launching.log_folders import log_store_of
from colcon_yamllaunch.verb.launching.log_folders import ros_log_folder
from colcon_yamllaunch.verb.launching.plan_run import PlanRun
from colcon_yamllaunch.verb.launching.steps.host_keeper import HostKeeper
from colcon_yamllaunch.verb.launching.workspace_session import WorkspaceSession
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

if TYPE_CHECKING:
    from colcon_yamllaunch.language.evaluation.launch_host import Growing
    from colcon_yamllaunch.machines.deployment.deployment import Deployment
    from colcon_yamllaunch.runtime.course.plan_changes import PlanChanges
    from colcon_yamllaunch.verb.launching.builds import Builds
    from colcon_yamllaunch.verb.launching.steps.deployed_launch import (
        DeployedLaunch,
    )
    from colcon_yamllaunch.watch.knowledge.build_effects import Built

#: How often what a build brought may make more packages necessary.
MAXIMUM_ROUNDS = 5
_NONE = frozenset[str]()
#: What is imported where it is needed, as that is behind the evaluation.
_BEHIND = (
    'colcon_yamllaunch.verb.launching.builds',
    'colcon_yamllaunch.verb.launching.preflight',
    'colcon_yamllaunch.runtime.run_plan',
)

#: Makes what changes the plan while it runs, of the launch, its plan and the
#: environment of that.
MakeChanges = Callable[['LaunchFlow', Plan, Mapping[str, str]], 'PlanChanges']


class GiveUpError(Exception):
    """
    The launch ends here; the user was told why.

    :param is_build: Whether that is a build
    """

    def __init__(self, returncode: int, *, is_build: bool = False) -> None:
        super().__init__()
        self.returncode = returncode
        self.is_build = is_build


class LaunchFlow:
    """
    One launch.

    :param log_folder: The folder for the logs, or None to keep none
    :param announce: Is called with a line that the user should see at once;
      by default it is said, unless the user wants it quiet
    :param is_again: Whether the launch runs already
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
        if options.attach is not None:
            # what few launches need is imported where it is needed
            from colcon_yamllaunch.verb.sessions.attaching import need_terminal

            need_terminal()
        self._options = options
        self.cwd = cwd
        self._environment = environment
        self._log_folder = log_folder
        # the launches that were told to run the same nodes
        self._told: set[int] = set()
        # for which packages it was, and what gives what they bring
        self._exposed: tuple[PackageLocator | None, FindExposed] = (
            None,
            NothingExposed,
        )
        self._log_dir = str(log_folder or ros_log_folder(environment))
        self._workspace = WorkspaceSession(
            workspace_root(options.workspace, options.positionals),
            options.build_args,
            environment,
            announce or (_say_nothing if options.quiet else say_line),
            ' '.join(['colcon launch', *options.positionals]),
            runs=options.runs,
        )
        self._packages = LaunchPackages(self._workspace.locator, built=False)
        keeps_log = not options.inspects
        self._host = HostKeeper(
            cwd, environment, log_folder if keeps_log else None
        )
        # what makes more of the plan while it runs
        self._growing: Growing | None = None
        self._is_again = is_again
        # what is done about other machines, if parts of it run there
        self._deployed: DeployedLaunch | None = None
        if options.is_deployed:
            self._deployed = self._make_deployed()
        #: The launch files that have been read.
        self.trees: dict[str, LaunchFile] = {}
        #: What was evaluated last, and what is needed for it.
        self.evaluation: Evaluation | None = None
        self.wanted: set[str] = set()

    @cached_property
    def builds(self) -> 'Builds':
        """The builds of this launch."""
        from colcon_yamllaunch.verb.launching.builds import Builds

        return Builds(
            self._workspace,
            exactly=self._options.paths is not None,
            force=self._options.force,
            why=self._options.why,
        )

    @property
    def deployment(self) -> 'Deployment | None':
        """
        Which machines parts of it run on; None where all of it runs here.

        :raises GiveUpError: when the deployment file is wrong
        :raises UserError: when there is no such machine
        """
        return None if self._deployed is None else self._deployed.deployment

    def start_host(self) -> None:
        """
        Start the host of a launch file in Python before it is asked.

        It imports `launch` while this process imports what it needs behind
        the evaluation.

        :raises UserError: when the user's time limit is no number
        """
        if ''.join(self._options.positionals[-1:]).endswith('.py'):
            self._host.open(self._process_environment()).start()
            for name in _BEHIND:
                import_module(name)

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

    def close(self) -> None:
        """End what has been started and the launch does not need."""
        if self._deployed is not None:
            self._deployed.close()
        self._host.close()

    def disown(self) -> None:
        """Have nothing to do with all of that, in a fork of this process."""
        self._host.disown()
        if self._deployed is not None:
            self._deployed.disown()

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

    # what is known of other machines, for who watches files

    @property
    def deployment_digest(self) -> str:
        """What tells which machines there are, and what is on them."""
        return '' if self._deployed is None else self._deployed.digest

    @property
    def machine_names(self) -> frozenset[str]:
        """The machines that parts of it run on."""
        return _NONE if self._deployed is None else self._deployed.used

    @property
    def needed_there(self) -> frozenset[str]:
        """The packages of the workspace that these need."""
        return _NONE if self._deployed is None else self._deployed.needed

    @property
    def built_there(self) -> frozenset[str]:
        """The packages that were built there."""
        return _NONE if self._deployed is None else self._deployed.built

    @property
    def records_there(self) -> 'Built':
        """What these builds, and earlier ones, have made."""
        return {} if self._deployed is None else self._deployed.records

    def _make_deployed(self) -> 'DeployedLaunch':
        # most launches run here
        from colcon_yamllaunch.verb.launching.steps.deployed_launch import (
            DeployedLaunch,
        )

        return DeployedLaunch(
            self._options,
            self.cwd,
            self._environment,
            self._workspace,
            self._log_folder,
            self.report,
            self._fail,
            # who typed at a launch that runs would be heard by its processes
            may_ask=not self._is_again,
        )

    def _tell_of_doubled_nodes(
        self, plan: Plan, environment: Mapping[str, str]
    ) -> None:
        """Warn of nodes that another launch of the user runs already."""
        if self._is_again or not has_sockets(self._environment):
            return
        from colcon_yamllaunch.verb.sessions import doubled_nodes

        file = self._about().file
        for other in doubled_nodes.running(self._environment):
            nodes = doubled_nodes.doubled_nodes(plan, environment, file, other)
            if nodes and other.pid not in self._told:
                self._told.add(other.pid)
                text = doubled_nodes.warning(nodes, other)
                say(f'colcon launch: warning: {text}')

    def _about(self) -> About:
        plan = self._options.from_plan
        if plan is not None:
            return About(str(plan), None, str(self.cwd / plan), str(self.cwd))
        target = self.target()
        title = ' '.join(self._options.positionals)
        return About(title, target.package, target.path, str(self.cwd))

    def prepare(self) -> tuple[Plan, Mapping[str, str]]:
        """
        Evaluate and build until nothing more is needed.

        Return the plan, and the environment for its processes.

        :raises GiveUpError: when there can be no launch
        :raises UserError: when there can be none either
        """
        built: set[str] = set()
        may_build = not self._options.no_build and bool(self._workspace.root)
        # what need not be here is known once it is known what runs here
        is_final = not may_build and self.deployment is None
        for _ in range(MAXIMUM_ROUNDS):
            target = self.target()
            request = self.request(target, built=is_final)
            evaluation = evaluate(request)
            errors = evaluation.errors
            if not errors:
                # before a build, which may take long
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
        self._tell_of_build(target, evaluation)
        self._stop_at_errors(target, evaluation)
        self.evaluation = evaluation
        self.wanted = self._wanted(target, evaluation)
        self.report(evaluation.diagnostics)
        self._check_before_start(evaluation)
        self._growing = evaluation.growing
        plan = evaluation.plan
        if self._deployed is not None:
            plan = self._deployed.settled(plan)
        return plan, request.environment

    def target(self) -> Target:
        """
        Find the launch file.

        :raises UserError: when there is none
        """
        positionals = self._options.positionals
        return path_target(positionals, self.cwd) or package_target(
            positionals, self.locator, self._workspace.broken_manifests
        )

    @property
    def workspace(self) -> WorkspaceSession:
        """The workspace, as far as it has been built and sourced."""
        return self._workspace

    @property
    def locator(self) -> PackageLocator:
        """Where the packages are."""
        return self._workspace.locator

    @property
    def setup_script(self) -> str | None:
        """What a shell sources to have the workspace, None without one."""
        setup = self._workspace.setup_script
        return None if setup is None else str(setup)

    def _process_environment(self) -> Mapping[str, str]:
        """Return the environment for the processes."""
        environment = dict(self._workspace.environment)
        environment.setdefault('ROS_LOG_DIR', self._log_dir)
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
        self._packages = LaunchPackages(
            self.locator, built=built, only_there=self._only_there
        )
        located = self._packages.locate(target.name)
        environment = self._process_environment()
        return Request(
            target.path if located is None else located[0],
            target.path,
            packages=self._packages,
            environment=environment,
            arguments=self._options.arguments,
            cwd=str(self.cwd),
            log_folder=self._log_dir,
            exposed=self._find_exposed(),
            host=lambda: self._host.open(environment),
            trees=self.trees,
        )

    def _find_exposed(self) -> FindExposed:
        """Return what gives what packages bring, as long as they are so."""
        known, find = self._exposed
        if known is not self.locator:
            environment = self._workspace.environment
            find = exposed_by_packages(self.locator, environment)
            self._exposed = self.locator, find
        return find

    def _stop_at_errors(self, target: Target, evaluation: Evaluation) -> None:
        errors = evaluation.errors
        if all(error.may_pass_after_build for error in errors):
            # what is missing may be missing for this reason
            needed = sorted(self._needed(target, evaluation))
            may_build = not self._options.no_build
            self._workspace.check_sourced(needed, may_build=may_build)
        if errors:
            self._fail(evaluation.diagnostics)

    def _stop_at_foreign_plugins(self, evaluation: Evaluation) -> None:
        """Stop at components that no build of the workspace brings."""
        own = self._workspace.package_names
        uses = [use for use in evaluation.plugins if use.package not in own]
        if not uses:
            return
        from colcon_yamllaunch.verb.launching.preflight import unknown_plugins

        found = unknown_plugins(uses, self._workspace.locator)
        errors = [d for d in found if d.severity == 'error']
        if errors:
            self._fail([*evaluation.diagnostics, *errors])

    def _wanted(self, target: Target, evaluation: Evaluation) -> set[str]:
        """Return the packages of the workspace to bring up to date."""
        workspace = self._workspace
        if self._options.build_all:
            return set(workspace.package_names) - self._only_there
        if self._options.paths is not None:
            return set(workspace.select(self._options.paths, self.cwd))
        return self._needed(target, evaluation)

    def _update(
        self, wanted: set[str], target: Target, evaluation: Evaluation
    ) -> bool:
        """Build what is stale, and return whether that changed anything."""
        from colcon_yamllaunch.verb.launching.builds import failure
        from colcon_yamllaunch.verb.launching.preflight import (
            executables_in_vain,
        )

        def look_first() -> None:
            found = executables_in_vain(evaluation.executables, self.locator)
            if found:
                self._fail(found)

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

    @property
    def guessed(self) -> Mapping[str, Path]:
        """The packages whose names are guessed, with their `setup.py`."""
        return self._workspace.guessed

    def explain(self, target: Target, evaluation: Evaluation) -> None:
        """Say what would be built for the launch, and why."""
        wanted = self._wanted(target, evaluation)
        self.builds.explain(wanted, Path(target.name).name)

    def _needed(self, target: Target, evaluation: Evaluation) -> set[str]:
        """Return the packages of the workspace that it needs here."""
        return self._named(target, evaluation) - self._only_there

    @property
    def _only_there(self) -> frozenset[str]:
        """The packages that other machines have, and this one need not."""
        if self._deployed is None:
            return frozenset()
        return self._deployed.only_there

    def _is_there(self, path: str) -> bool:
        """Say whether a path exists, or need not exist here."""
        if Path(path).exists():
            return True
        owner = self.locator.owner(path)
        return owner is not None and owner.name in self._only_there

    def _named(self, target: Target, evaluation: Evaluation) -> set[str]:
        """Return the packages of the workspace that the launch names."""
        names = {target.package, *evaluation.packages}
        return self._workspace.package_names & names

    def _check_before_start(self, evaluation: Evaluation) -> None:
        from colcon_yamllaunch.verb.launching.preflight import preflight
        from colcon_yamllaunch.verb.launching.preflight import (
            undeclared_packages,
        )

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

    def _fail(self, diagnostics: Sequence[Diagnostic]) -> NoReturn:
        from colcon_yamllaunch.verb.launching.annotations import annotate

        self.report(diagnostics)
        annotate(diagnostics, self._environment)
        raise GiveUpError(1)

    def report(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Show problems to the user."""
        text = render(diagnostics, str(self.cwd))
        if text:
            say(text)


def _say_nothing(line: str) -> None:
    """Leave it at that."""
