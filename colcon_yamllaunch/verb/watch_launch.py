# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon launch --watch`: the change loop of a launch and its jobs."""

from collections.abc import Mapping
from contextlib import closing, redirect_stdout, suppress
from dataclasses import replace
from functools import partial
import gc
from importlib import import_module
import io
import logging
import os
from pathlib import Path
import threading
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import GiveUpError, say
from colcon_yamllaunch.engine.cgroup import expect_moves, is_wanted
from colcon_yamllaunch.language.policies.evaluate import Evaluation
from colcon_yamllaunch.language.syntax.diagnostics import render
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.verb.context import LaunchContext
from colcon_yamllaunch.verb.prepare import prepare
from colcon_yamllaunch.watch import preparer
from colcon_yamllaunch.watch.change_loop import ChangeLoop
from colcon_yamllaunch.watch.dependencies import (
    build_products,
    find_dependencies,
)
from colcon_yamllaunch.watch.python_syntax import source_error
from colcon_yamllaunch.workspace.building.build_processes import BuildProcesses

logger = logging.getLogger('colcon.colcon_yamllaunch')

#: The log of the watcher, in the folder with the logs of the launch.
WATCHER_LOG = 'watcher.log'
#: Modules that a build needs, and few launches have loaded when they begin.
_BUILD_MODULES = (
    'colcon_yamllaunch.workspace.builds',
    'colcon_yamllaunch.workspace.colcon.colcon_adapter',
    'colcon_yamllaunch.workspace.freshness.build_inputs',
    'colcon_yamllaunch.workspace.packages.build_files',
    'colcon_yamllaunch.workspace.packages.missing_files',
    'ctypes',
)


def change_loop(
    context: LaunchContext, plan: Plan, environment: Mapping[str, str]
) -> ChangeLoop:
    """Return the change loop of a launch that is about to run."""
    log = context.log_folder and context.log_folder / WATCHER_LOG
    return ChangeLoop(
        _described(context, plan, environment),
        preparer.Preparer(
            partial(prepare_again, context),
            partial(_warm_up, context),
            _clean_up,
        ),
        log or None,
        clock=time.monotonic,
        why=context.options.why,
        cwd=str(context.cwd),
    )


def prepare_again(
    first: LaunchContext,
    suspects: tuple[str, ...],
    announce: preparer.Announce,
) -> preparer.Prepared | preparer.Failed:
    """
    Prepare the launch as one that begins now, in a child.

    :param suspects: Python files that may not compile
    """
    context = None
    try:
        # the folder may have been removed and created again
        os.chdir(first.cwd)
        # only errors are shown
        options = first.options.replaced(quiet=True, force=False, why=False)
        context = first.again(options, announce)
        if context.workspace.root is not None:
            context.workspace.colcon.when_built = partial(
                _expect_restarts, first.environment
            )
        with closing(context), context.workspace.lock:
            plan, environment = prepare(context)
            return _described(context, plan, environment, suspects)
    except GiveUpError as e:
        built = () if context is None else tuple(context.builds.names)
        return preparer.Failed('build' if e.is_build else 'plan', built)
    except UserError as e:
        say(f'colcon launch: error: {e}')
        return preparer.Failed('plan')
    except Exception as e:
        logger.debug('unexpected exception', exc_info=True)
        # a bug, as in `options_verb.report_errors`
        text = f'internal error: {type(e).__name__}: {e}'
        if not os.path.isdir(first.cwd):
            text = (
                f'error: there is no {first.cwd} any more, in which the '
                'launch was begun: restore it, or launch elsewhere'
            )
        say(f'colcon launch: {text}')
        return preparer.Failed('plan')


def _described(
    context: LaunchContext,
    plan: Plan,
    environment: Mapping[str, str],
    suspects: tuple[str, ...] = (),
) -> preparer.Prepared:
    """Return what a prepared launch runs, and what that uses."""
    workspace, machines = context.workspace, context.machines
    assert context.evaluation is not None
    dependencies = find_dependencies(
        plan,
        context.evaluation,
        None if workspace.root is None else workspace.colcon,
        workspace.locator,
        context.wanted,
        environment,
        None if machines is None else machines.dependencies,
    )
    if context.deployment is not None:
        files = map(os.path.realpath, context.deployment.files)
        plan_files = dependencies.plan_files | {*files}
        dependencies = replace(dependencies, plan_files=plan_files)
    built: dict[str, Any] = {}
    if workspace.root is not None:
        names = [package.name for package in dependencies.packages]
        built |= build_products(workspace.colcon, names)
    packages = context.builds.names
    if machines is not None:
        built |= machines.records
        packages += machines.built
    return preparer.Prepared(
        plan,
        environment,
        dependencies,
        built,
        tuple(dict.fromkeys(packages)),
        context.begun_ns,
        _grown_from(context.evaluation),
        '' if machines is None else machines.digest,
        frozenset() if machines is None else machines.used,
        {
            path: render([error], str(context.cwd))
            for path in suspects
            if (error := source_error(path, environment)) is not None
        },
    )


def _expect_restarts(environment: Mapping[str, str]) -> None:
    if is_wanted(environment):
        # it ends with the child at the latest
        threading.Thread(target=expect_moves, daemon=True).start()


def _grown_from(evaluation: Evaluation) -> Mapping[str, str] | None:
    """Return the files of a plan that may grow; see `Prepared`."""
    if evaluation.growing is None:
        return None
    # few launches have event handlers in Python
    import hashlib

    files: dict[str, str] = {}
    for path in (*(f.path for f in evaluation.files), *evaluation.inputs):
        with suppress(OSError):
            files[path] = hashlib.sha256(Path(path).read_bytes()).hexdigest()
    return files


def _warm_up(context: LaunchContext) -> None:
    """Load what a build needs."""
    context.detach()
    workspace = context.workspace
    # its output does not matter
    with redirect_stdout(io.StringIO()):
        for name in _BUILD_MODULES:
            import_module(name)
        if workspace.root is not None:
            # errors were reported when the launch began
            with suppress(UserError):
                workspace.colcon.warm_up(
                    workspace.build_environment().variables
                )
    gc.collect()
    # so that garbage collection in jobs does not copy all pages
    gc.freeze()
    import ctypes

    # return the memory that only loading needed, most of it the compiler of
    # Python, to the system; this is a function of glibc
    with suppress(AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


def _clean_up(pid: int) -> None:
    """End the builds that a killed job left running."""
    BuildProcesses(builder=pid).end()
