# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `colcon launch` does, step by step."""

from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import nullcontext
from contextlib import redirect_stdout
from copy import copy
from dataclasses import replace
from functools import cached_property
from importlib import import_module
import io
from pathlib import Path
import signal
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.language.evaluation.request import Request
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
        # the process that reads launch files in Python, and its environment
        self._host: HostLink | None = None
        self._host_environment: Mapping[str, str] = {}
        # what makes more of the plan while it runs
        self._growing: Growing | None = None
        self._is_again = is_again
        # what is added to the environment of the processes
        self._variables: Mapping[str, str] = {}
        #: Whether an argument that no launch file declares is an error.
        self.needs_declarations = False
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

    def start_host(self) -> None:
        """
        Start the host of a launch file in Python before it is asked.

        It imports `launch` while this process imports what it needs behind
        the evaluation.

        :raises UserError: when the user's time limit is no number
        """
        if ''.join(self._options.positionals[-1:]).endswith('.py'):
            self._open_host(self._process_environment()).start()
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
        options = replace(self._options, arguments=dict(arguments))
        if not builds:
            options = replace(
                options,
                no_build=True,
                build_all=False,
                paths=None,
                force=False,
                why=False,
            )
        other = copy(self)
        other._options = options
        other._log_folder = log_folder
        other._log_dir = str(log_folder)
        other._variables = variables
        other._host, other._growing = None, None
        other._is_again = True
        other.evaluation, other.wanted = None, set()
        return other

    def close(self) -> None:
        """End the process that reads launch files in Python, if it runs."""
        if self._host is not None:
            self._host.close()
            self._host = None

    def disown_host(self) -> None:
        """Have nothing to do with that process, in a fork of this one."""
        if self._host is not None:
            self._host.disown()
            self._host = None

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
        identity, source = self.plan_source()
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

    def plan_source(self) -> tuple[str, 'PlanSource | None']:
        """
        Return the identity that the launch has already, '' for none.

        And what makes more of the plan while it runs, if anything does. To be
        called once, when the plan is about to run.
        """
        host = self._host
        if host is None:
            return '', None
        if self._growing is None:
            host.release()
            return host.identity, None
        from colcon_yamllaunch.ros.host_link import NUMBER
        from colcon_yamllaunch.ros.host_plan_source import HostPlanSource

        host.entrust()
        source = HostPlanSource(host, self._growing, NUMBER)
        return host.identity, source

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
        is_final = self._options.no_build or self._workspace.root is None
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
            if is_final or any(not e.may_pass_after_build for e in errors):
                break
            self._stop_at_foreign_plugins(evaluation)
            wanted = self._wanted(target, evaluation)
            is_final = wanted <= built or not self._update(
                wanted, target, evaluation
            )
            built |= wanted
            expected = self._packages.expected
            if is_final and all(Path(path).exists() for path in expected):
                # nothing was built since, so all of it still holds
                break
        self.wanted = self._wanted(target, evaluation)
        self._tell_of_build(target, evaluation)
        self._stop_at_errors(target, evaluation)
        self.evaluation = evaluation
        self.report(evaluation.diagnostics)
        self._check_before_start(evaluation)
        self._growing = evaluation.growing
        return evaluation.plan, request.environment

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
        environment.update(self._variables)
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
        self._packages = LaunchPackages(self._workspace.locator, built=built)
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
            host=lambda: self._open_host(environment),
            trees=self.trees,
        )

    def _open_host(self, environment: Mapping[str, str]) -> 'HostLink':
        """
        Return the process that reads launch files in Python.

        It is the one that there is, unless it is in another environment.

        :raises UserError: when the user's time limit is no number
        """
        # most launch files are not in Python
        from colcon_yamllaunch.ros import host_link
        from colcon_yamllaunch.runtime.stopping.launch_scan import new_identity

        if self._host is not None and (
            self._host.is_spent or self._host_environment != environment
        ):
            self.close()
        if self._host is None:
            log = None
            if self._log_folder is not None and not self._options.inspects:
                log = self._log_folder / host_link.LOG_NAME
            self._host = host_link.HostLink(
                environment,
                str(self.cwd),
                log,
                new_identity(),
                host_link.timeout_of(self._environment),
            )
            self._host_environment = environment
        return self._host

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

    def _refuse_undeclared(self, evaluation: Evaluation) -> None:
        """Refuse arguments that the launch would warn of."""
        from colcon_yamllaunch.language.policies import launch_arguments

        told = {d.message: d.hint for d in evaluation.diagnostics}
        for name in self._options.arguments:
            problem = launch_arguments.undeclared_argument(name, '')
            message = problem.diagnostics[0].message
            if message in told:
                raise UserError(f'{message}: {told[message]}')

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
            return set(workspace.package_names)
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

        if self._host is not None and evaluation.growing is None:
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
            self.close()
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
            *preflight(evaluation, self._packages.not_installed, locator),
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
