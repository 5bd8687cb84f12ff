# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch is about: its launch file, workspace and machines."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import NoReturn
from typing import TYPE_CHECKING

from colcon_yamllaunch.control.socket_folder import has_sockets
from colcon_yamllaunch.engine.state import About
from colcon_yamllaunch.language.evaluation.request import FindExposed
from colcon_yamllaunch.language.evaluation.request import NothingExposed
from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.language.syntax.diagnostics import render
from colcon_yamllaunch.language.syntax.launch_tree import LaunchFile
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.verb.log_folders import ros_log_folder
from colcon_yamllaunch.verb.messages import say
from colcon_yamllaunch.verb.messages import say_line
from colcon_yamllaunch.verb.options import LaunchOptions
from colcon_yamllaunch.verb.target import package_target
from colcon_yamllaunch.verb.target import path_target
from colcon_yamllaunch.verb.target import Target
from colcon_yamllaunch.verb.target import workspace_root
from colcon_yamllaunch.verb.workspace_session import exposed_by_packages
from colcon_yamllaunch.verb.workspace_session import LaunchPackages
from colcon_yamllaunch.verb.workspace_session import WorkspaceSession
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.participants import Participant
    from colcon_yamllaunch.language.evaluation.launch_worker import Growing
    from colcon_yamllaunch.python_launch.worker_process import WorkerProcess
    from colcon_yamllaunch.remote.deployment.deployment import Deployment
    from colcon_yamllaunch.verb.machines import DeployedLaunch


#: What is imported where it is needed, as that is behind the evaluation.
_BEHIND = (
    'colcon_yamllaunch.verb.builds',
    'colcon_yamllaunch.verb.preflight',
    'colcon_yamllaunch.run',
)


class GiveUpError(Exception):
    """
    The launch ends here; the user was told why.

    :param is_build: Whether that is a build
    """

    def __init__(self, returncode: int, *, is_build: bool = False) -> None:
        super().__init__()
        self.returncode = returncode
        self.is_build = is_build


class LaunchBasis:
    """
    What a launch is about, before anything is done.

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
            from colcon_yamllaunch.verb.attaching import need_terminal

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
            workspace_root(
                options.workspace,
                options.positionals,
                builds=options.build_all or bool(options.paths),
            ),
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
        # what is added to the environment of the processes
        self._variables: Mapping[str, str] = {}
        #: Whether an argument that no launch file declares is an error.
        self.needs_declarations = False
        #: What is typed, for messages.
        self.command = 'colcon launch'
        #: The launch files that have been read.
        self.trees: dict[str, LaunchFile] = {}
        #: What was evaluated last, and what is needed for it.
        self.evaluation: Evaluation | None = None
        self.wanted: set[str] = set()

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

    def target(self) -> Target:
        """
        Find the launch file.

        :raises UserError: when there is none
        """
        positionals = self._options.positionals
        return path_target(
            positionals, self.cwd, self.locator
        ) or package_target(
            positionals, self.locator, self._workspace.broken_manifests
        )

    def _about(self) -> About:
        plan = self._options.from_plan
        if plan is not None:
            return About(str(plan), None, str(self.cwd / plan), str(self.cwd))
        target = self.target()
        title = ' '.join(self._options.positionals)
        return About(title, target.package, target.path, str(self.cwd))

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

    @property
    def guessed(self) -> Mapping[str, Path]:
        """The packages whose names are guessed, with their `setup.py`."""
        return self._workspace.guessed

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

    def _tell_of_doubled_nodes(
        self, plan: Plan, environment: Mapping[str, str]
    ) -> None:
        """Warn of nodes that another launch of the user runs already."""
        if self._is_again or not has_sockets(self._environment):
            return
        from colcon_yamllaunch.verb import doubled_nodes

        file = self._about().file
        for other in doubled_nodes.running(self._environment):
            nodes = doubled_nodes.doubled_nodes(plan, environment, file, other)
            if nodes and other.pid not in self._told:
                self._told.add(other.pid)
                text = doubled_nodes.warning(nodes, other)
                say(f'colcon launch: warning: {text}')

    @property
    def _only_there(self) -> frozenset[str]:
        """The packages that other machines have, and this one need not."""
        if self._deployed is None:
            return frozenset()
        return self._deployed.only_there

    def _make_deployed(self) -> 'DeployedLaunch':
        # most launches run here
        from colcon_yamllaunch.verb.machines import DeployedLaunch

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

    def _fail(self, diagnostics: Sequence[Diagnostic]) -> NoReturn:
        from colcon_yamllaunch.verb.run_launch import annotate

        self.report(diagnostics)
        annotate(diagnostics, self._environment)
        raise GiveUpError(1)

    def report(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Show problems to the user."""
        text = render(diagnostics, str(self.cwd), self.command)
        if text:
            say(text)


def _say_nothing(line: str) -> None:
    """Leave it at that."""


class HostKeeper:
    """
    The process that reads launch files in Python, if there is one.

    :param environment: The user's environment
    :param log_folder: Where it keeps a log, or None to keep none
    """

    def __init__(
        self,
        cwd: Path,
        environment: Mapping[str, str],
        log_folder: Path | None,
    ) -> None:
        self._cwd = cwd
        self._environment = environment
        self._log_folder = log_folder
        self._host: WorkerProcess | None = None
        # what it runs in
        self._variables: Mapping[str, str] = {}

    @property
    def identity(self) -> str:
        """The identity that the launch has by it, or an empty text."""
        return '' if self._host is None else self._host.identity

    def open(self, variables: Mapping[str, str]) -> 'WorkerProcess':
        """
        Return the process that reads launch files in Python.

        It is the one that there is, unless it is in another environment.

        :param variables: What it is to run in
        :raises UserError: when the user's time limit is no number
        """
        # most launch files are not in Python
        from colcon_yamllaunch.engine.launch_scan import new_identity
        from colcon_yamllaunch.python_launch import worker_process

        if self._host is not None and (
            self._host.is_spent or self._variables != variables
        ):
            self.close()
        if self._host is None:
            log = None
            if self._log_folder is not None:
                log = self._log_folder / worker_process.LOG_NAME
            self._host = worker_process.WorkerProcess(
                variables,
                str(self._cwd),
                log,
                new_identity(),
                worker_process.timeout_of(self._environment),
            )
            self._variables = variables
        return self._host

    def feeds(self, growing: 'Growing | None') -> 'Sequence[Participant]':
        """
        Return what extends the plan while it runs, if there is anything.

        :param growing: What turns its answers into plan, if it is asked more
        """
        if self._host is None:
            return ()
        if growing is None:
            self._host.release()
            return ()
        from colcon_yamllaunch.python_launch.plan_feed import PlanFeed

        self._host.entrust()
        return (PlanFeed(self._host, growing),)

    def release(self) -> None:
        """End it in order, as nothing more is asked of it."""
        if self._host is not None:
            self._host.release()

    def close(self) -> None:
        """End it if it runs."""
        if self._host is not None:
            self._host.close()
            self._host = None

    def disown(self) -> None:
        """Have nothing to do with it, in a fork of this process."""
        if self._host is not None:
            self._host.disown()
            self._host = None
