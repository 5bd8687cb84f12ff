# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon launch --watch`: the change loop of a launch and its jobs."""

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
from colcon_yamllaunch.engine.cgroup import CGROUP_VARIABLE
from colcon_yamllaunch.engine.cgroup import expect_moves
from colcon_yamllaunch.language.syntax.diagnostics import render
from colcon_yamllaunch.language.syntax.launch_tree import LaunchFile
from colcon_yamllaunch.plan.labels import MACHINE_SEPARATOR
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.verb.context import GiveUpError
from colcon_yamllaunch.verb.messages import say
from colcon_yamllaunch.verb.options import LaunchOptions
from colcon_yamllaunch.verb.run_launch import LaunchFlow
from colcon_yamllaunch.watch.change_loop import ChangeLoop
from colcon_yamllaunch.watch.consequences import changed_products
from colcon_yamllaunch.watch.consequences import Products
from colcon_yamllaunch.watch.dependencies import Dependencies
from colcon_yamllaunch.watch.find_dependencies import build_products
from colcon_yamllaunch.watch.find_dependencies import find_dependencies
from colcon_yamllaunch.watch.python_syntax import source_error
from colcon_yamllaunch.watch.watcher_client import is_installed
from colcon_yamllaunch.watch.watcher_client import MISSING
from colcon_yamllaunch.watch.worker import Announce
from colcon_yamllaunch.watch.worker import Failed
from colcon_yamllaunch.watch.worker import Job
from colcon_yamllaunch.watch.worker import Prepared
from colcon_yamllaunch.watch.worker import Worker
from colcon_yamllaunch.workspace.building.orphan_builds import BuildProcesses

logger = logging.getLogger('colcon.colcon_yamllaunch')

#: The log of the watcher, in the folder with the logs of the launch.
WATCHER_LOG = 'watcher.log'
#: Modules that a build needs, and few launches have loaded when they begin.
_BUILD_MODULES = (
    'colcon_yamllaunch.verb.builds',
    'colcon_yamllaunch.verb.preflight',
    'colcon_yamllaunch.workspace.colcon.colcon_adapter',
    'colcon_yamllaunch.workspace.freshness.build_inputs',
    'colcon_yamllaunch.workspace.packages.install_rules',
    'ctypes',
)


class WatchFlow:
    """
    The preparation of a launch whose files are watched.

    :raises UserError: when the library that watches files is not installed
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
        # jobs show only their errors
        self._options = options.replaced(quiet=True, force=False, why=False)
        self._why = options.why
        self._cwd = cwd
        self._environment = environment
        self._log_folder = log_folder
        self._since_ns = time.time_ns()
        self._trees: dict[str, LaunchFile] = {}
        self._changes: ChangeLoop | None = None
        self._sigint = signal.getsignal(signal.SIGINT)

    def begin(
        self, flow: LaunchFlow, plan: Plan, environment: Mapping[str, str]
    ) -> ChangeLoop:
        """Return the change loop of a launch that is about to run."""
        # the worker reads only changed files again
        self._trees = flow.trees
        log = self._log_folder and self._log_folder / WATCHER_LOG

        def warm_up() -> None:
            flow.disown()
            _warm_up(flow)

        self._changes = ChangeLoop(
            self._described(flow, plan, environment, self._since_ns),
            Worker(self._prepare, warm_up, _clean_up),
            log or None,
            clock=time.monotonic,
            why=self._why,
            cwd=str(self._cwd),
        )
        return self._changes

    @property
    def restarts_launch(self) -> bool:
        """Whether the launch has ended only to begin again."""
        return self._changes is not None and self._changes.restarts_launch

    def restart_launch(self) -> NoReturn:
        """Run the same command again, in this process."""
        sys.stdout.flush()
        sys.stderr.flush()
        signal.signal(signal.SIGINT, self._sigint)
        os.execv(sys.executable, sys.orig_argv)

    def _prepare(self, job: Job, announce: Announce) -> Prepared | Failed:
        """Prepare the launch as one that begins now, in a child."""
        since_ns = time.time_ns()
        flow = None
        try:
            # the folder may have been removed and created again
            os.chdir(self._cwd)
            flow = LaunchFlow(
                self._options,
                self._cwd,
                self._environment,
                self._log_folder,
                announce,
                is_again=True,
            )
            flow.trees.update(self._trees)
            if flow.workspace.root is not None:
                flow.workspace.colcon.when_built = self._expect_restarts
            with closing(flow), flow.workspace.lock:
                plan, environment = flow.prepare()
                return self._described(flow, plan, environment, since_ns, job)
        except GiveUpError as e:
            built = () if flow is None else tuple(flow.builds.names)
            return Failed('build' if e.is_build else 'plan', built)
        except UserError as e:
            say(f'colcon launch: error: {e}')
            return Failed('plan')
        except Exception as e:
            logger.debug('unexpected exception', exc_info=True)
            if os.path.isdir(self._cwd):
                # a bug, as in `messages.report_errors`
                text = f'internal error: {type(e).__name__}: {e}'
            else:
                text = (
                    f'error: there is no {self._cwd} any more, in which the '
                    'launch was begun: restore it, or launch elsewhere'
                )
            say(f'colcon launch: {text}')
            return Failed('plan')

    def _described(
        self,
        flow: LaunchFlow,
        plan: Plan,
        environment: Mapping[str, str],
        since_ns: int,
        job: Job | None = None,
    ) -> Prepared:
        """
        Return what a prepared launch runs, and what that uses.

        :param job: The job that prepared it; None when the launch begins
        """
        asked = job or Job({}, {})
        dependencies = self._dependencies(
            flow, plan, environment, asked.libraries
        )
        names = {p.name for p in dependencies.packages} | asked.built.keys()
        built = _built(flow, names)
        changed = changed_products(asked.built, built) if job else {}
        return Prepared(
            plan,
            environment,
            dependencies,
            built,
            {path: _package_of(name) for path, name in changed.items()},
            tuple(dict.fromkeys((*flow.builds.names, *flow.built_there))),
            since_ns,
            _grown_from(flow),
            flow.deployment_digest,
            flow.machine_names,
            {
                path: render([error], str(self._cwd))
                for path in asked.suspects
                if (error := source_error(path, environment)) is not None
            },
        )

    def _expect_restarts(self) -> None:
        if self._environment.get(CGROUP_VARIABLE) != '0':
            # it ends with the child at the latest
            threading.Thread(target=expect_moves, daemon=True).start()

    def _dependencies(
        self,
        flow: LaunchFlow,
        plan: Plan,
        environment: Mapping[str, str],
        libraries: Mapping[str, frozenset[str] | None],
    ) -> Dependencies:
        assert flow.evaluation is not None
        found = find_dependencies(
            plan,
            flow.evaluation,
            None if flow.workspace.root is None else flow.workspace.colcon,
            flow.workspace.locator,
            flow.wanted,
            libraries,
            environment,
            flow.runs_there,
        )
        if self._options.deploy is None:
            return found
        deployment = os.path.realpath(self._cwd / self._options.deploy)
        return replace(found, plan_files=found.plan_files | {deployment})


def _built(flow: LaunchFlow, names: Iterable[str]) -> Products:
    """Return the products of packages, here and on other machines."""
    if flow.workspace.root is None:
        return flow.records_there
    own = [name for name in names if _package_of(name) == name]
    return {**build_products(flow.workspace.colcon, own), **flow.records_there}


def _package_of(name: str) -> str:
    """Return the package of `name`, such as `arm│my_pkg` on a machine."""
    return name.rpartition(MACHINE_SEPARATOR)[2]


def _grown_from(flow: LaunchFlow) -> Mapping[str, str] | None:
    """Return the files of a plan that may grow; see `Prepared`."""
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
    """Load what a build needs."""
    # its output does not matter
    with redirect_stdout(io.StringIO()):
        for name in _BUILD_MODULES:
            import_module(name)
        if flow.workspace.root is not None:
            # errors were reported when the launch began
            with suppress(UserError):
                workspace = flow.workspace
                workspace.colcon.warm_up(
                    workspace.build_environment().variables
                )
    gc.collect()
    # so that garbage collection in jobs does not copy all pages
    gc.freeze()
    _trim()


def _trim() -> None:
    """Return the memory that only loading needed to the system."""
    import ctypes

    # a function of glibc; most of the memory was for the compiler of Python
    with suppress(AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def _clean_up(pid: int) -> None:
    """End the builds that a killed job left running."""
    BuildProcesses(builder=pid).end()
