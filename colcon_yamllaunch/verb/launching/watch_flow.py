# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `colcon launch --watch` adds to a launch, and what its worker does."""

from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import closing
from contextlib import redirect_stdout
from contextlib import suppress
from dataclasses import replace
import gc
from importlib import import_module
import io
import logging
import os
from pathlib import Path
import signal
import sys
import threading
import time
from typing import NoReturn

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.engine.process.cgroup import CGROUP_VARIABLE
from colcon_yamllaunch.engine.process.cgroup import expect_moves
from colcon_yamllaunch.language.syntax.diagnostics import render
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile
from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.verb.cli.launch_options import LaunchOptions
from colcon_yamllaunch.verb.cli.messages import say
from colcon_yamllaunch.verb.launching.launch_flow import LaunchFlow
from colcon_yamllaunch.verb.launching.steps.launch_basis import GiveUpError
from colcon_yamllaunch.watch.build_effects import Built
from colcon_yamllaunch.watch.build_effects import changed_by_build
from colcon_yamllaunch.watch.build_effects import records
from colcon_yamllaunch.watch.jobs import Announced
from colcon_yamllaunch.watch.jobs import Failed
from colcon_yamllaunch.watch.jobs import Job
from colcon_yamllaunch.watch.jobs import Prepared
from colcon_yamllaunch.watch.knowledge import Knowledge
from colcon_yamllaunch.watch.learning import knowledge_of
from colcon_yamllaunch.watch.python_sources import source_error
from colcon_yamllaunch.watch.watcher_link import is_installed
from colcon_yamllaunch.watch.watcher_link import MISSING
from colcon_yamllaunch.watch.watching import Watching
from colcon_yamllaunch.watch.worker import Tell
from colcon_yamllaunch.watch.worker_link import WorkerLink
from colcon_yamllaunch.workspace.building.orphan_builds import BuildProcesses

logger = logging.getLogger('colcon.colcon_yamllaunch')

#: The log of what watches files, in the folder with the logs of the launch.
WATCHER_LOG = 'watcher.log'
#: What a build takes, and few launches have loaded when they begin.
_FOR_BUILDS = (
    'colcon_yamllaunch.verb.launching.builds',
    'colcon_yamllaunch.verb.launching.preflight',
    'colcon_yamllaunch.workspace.colcon.colcon_adapter',
    'colcon_yamllaunch.workspace.freshness.build_inputs',
    'colcon_yamllaunch.workspace.packages.install_rules',
    'ctypes',
)


class WatchFlow:
    """
    A launch that goes on with its files.

    :raises UserError: when what watches files is not installed
    """

    def __init__(
        self,
        options: LaunchOptions,
        cwd: Path,
        environment: Mapping[str, str],
        log_folder: Path | None,
    ) -> None:
        if not is_installed():
            raise UserError(MISSING)
        # of each job only that which went wrong is shown
        self._options = replace(options, quiet=True, force=False, why=False)
        self._why = options.why
        self._cwd = cwd
        self._environment = environment
        self._log_folder = log_folder
        self._since_ns = time.time_ns()
        self._trees: dict[str, LaunchFile] = {}
        self._watching: Watching | None = None
        self._sigint = signal.getsignal(signal.SIGINT)

    def begin(
        self, flow: LaunchFlow, plan: Plan, environment: Mapping[str, str]
    ) -> Watching:
        """Return what changes the plan of a launch that is about to run."""
        # the worker does not read again what has not changed
        self._trees = flow.trees
        knowledge = self._knowledge_of(flow, plan, environment, {})
        names = [package.name for package in knowledge.packages]
        log = self._log_folder and self._log_folder / WATCHER_LOG

        def warm_up() -> None:
            flow.disown()
            _warm_up(flow)

        self._watching = Watching(
            plan,
            knowledge,
            _built(flow, names),
            WorkerLink(self._prepare, warm_up, _clean_up),
            log or None,
            since_ns=self._since_ns,
            grown_from=_grown_from(flow),
            deployment=flow.deployment_digest,
            machines=flow.machine_names,
            clock=time.monotonic,
            why=self._why,
            cwd=str(self._cwd),
        )
        return self._watching

    @property
    def begins_anew(self) -> bool:
        """Whether the launch has ended to be run anew."""
        return self._watching is not None and self._watching.begins_anew

    def begin_anew(self) -> NoReturn:
        """Run the same command again, in the place of this process."""
        sys.stdout.flush()
        sys.stderr.flush()
        signal.signal(signal.SIGINT, self._sigint)
        os.execv(sys.executable, sys.orig_argv)

    def _prepare(self, job: Job, tell: Tell) -> Prepared | Failed:
        """Prepare the launch as one that begins now; in a child."""
        since_ns = time.time_ns()
        flow = None
        try:
            # one that was made again is another one
            os.chdir(self._cwd)
            flow = LaunchFlow(
                self._options,
                self._cwd,
                self._environment,
                self._log_folder,
                lambda text: tell(Announced(text)),
                is_again=True,
            )
            flow.trees.update(self._trees)
            if flow.workspace.root is not None:
                flow.workspace.colcon.when_built = self._expect_restarts
            with closing(flow), flow.workspace.lock:
                return self._prepared(flow, job, since_ns)
        except GiveUpError as e:
            built = () if flow is None else tuple(flow.builds.names)
            return Failed('build' if e.is_build else 'plan', built)
        except UserError as e:
            say(f'colcon launch: error: {e}')
            return Failed('plan')
        except Exception as e:
            logger.debug('unexpected exception', exc_info=True)
            if os.path.isdir(self._cwd):
                # a defect of ours, as in `messages.report_errors`
                text = f'internal error: {type(e).__name__}: {e}'
            else:
                text = (
                    f'error: there is no {self._cwd} any more, in which the '
                    'launch was begun: restore it, or launch elsewhere'
                )
            say(f'colcon launch: {text}')
            return Failed('plan')

    def _prepared(self, flow: LaunchFlow, job: Job, since_ns: int) -> Prepared:
        plan, environment = flow.prepare()
        knowledge = self._knowledge_of(flow, plan, environment, job.libraries)
        names = {p.name for p in knowledge.packages} | job.built.keys()
        built = _built(flow, names)
        changed = changed_by_build(job.built, built)
        return Prepared(
            plan,
            environment,
            knowledge,
            built,
            {path: _package_of(name) for path, name in changed.items()},
            tuple(dict.fromkeys((*flow.builds.names, *flow.built_there))),
            since_ns,
            _grown_from(flow),
            flow.deployment_digest,
            flow.machine_names,
            {
                path: render([error], str(self._cwd))
                for path in job.suspects
                if (error := source_error(path, environment)) is not None
            },
        )

    def _expect_restarts(self) -> None:
        if self._environment.get(CGROUP_VARIABLE) != '0':
            # it ends with the child, if not before
            threading.Thread(target=expect_moves, daemon=True).start()

    def _knowledge_of(
        self,
        flow: LaunchFlow,
        plan: Plan,
        environment: Mapping[str, str],
        libraries: Mapping[str, frozenset[str] | None],
    ) -> Knowledge:
        assert flow.evaluation is not None
        known = knowledge_of(
            plan,
            flow.evaluation,
            flow.workspace,
            flow.wanted,
            libraries,
            environment,
            flow.runs_there,
        )
        if self._options.deploy is None:
            return known
        deployment = os.path.realpath(self._cwd / self._options.deploy)
        return replace(known, plan_files=known.plan_files | {deployment})


def _built(flow: LaunchFlow, names: Iterable[str]) -> Built:
    """Return what the last builds of packages made, here and elsewhere."""
    own = [name for name in names if _package_of(name) == name]
    return {**records(flow.workspace, own), **flow.records_there}


def _package_of(name: str) -> str:
    """Return the package of what a machine has built, as of `arm│my_pkg`."""
    return name.rpartition(MACHINE_SEPARATOR)[2]


def _grown_from(flow: LaunchFlow) -> Mapping[str, str] | None:
    """Return what a plan that grows was made from, see `Prepared`."""
    evaluation = flow.evaluation
    if evaluation is None or evaluation.growing is None:
        return None
    # few launches have event handlers in Python
    import hashlib

    files: dict[str, str] = {}
    for path in (*(f.path for f in evaluation.files), *evaluation.inputs):
        with suppress(OSError):
            files[path] = hashlib.sha256(Path(path).read_bytes()).hexdigest()
    return files


def _warm_up(flow: LaunchFlow) -> None:
    """Load what a build takes."""
    # what it says is nobody's business
    with redirect_stdout(io.StringIO()):
        for name in _FOR_BUILDS:
            import_module(name)
        if flow.workspace.root is not None:
            # it was understood when the launch began
            with suppress(UserError):
                workspace = flow.workspace
                workspace.colcon.warm_up(
                    workspace.build_environment().variables
                )
    gc.collect()
    # so that no job touches all of it
    gc.freeze()
    _trim()


def _trim() -> None:
    """Give the memory back that only loading has taken."""
    import ctypes

    # of the C library of GNU; most of it was for the compiler of Python
    with suppress(AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def _clean_up(pid: int) -> None:
    """End what a job left running."""
    BuildProcesses(builder=pid).end()
