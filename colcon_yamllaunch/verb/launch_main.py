# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From the command line of `colcon launch` to its exit code."""

from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from functools import partial
import gc
from importlib import import_module
import os
from pathlib import Path
import signal
import sys
import time
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import GiveUpError, show
from colcon_yamllaunch.common.process_scan import need_proc
from colcon_yamllaunch.verb.options import DEPLOYMENT, LaunchOptions

if TYPE_CHECKING:
    from colcon_yamllaunch.observers.junit import JUnitReport
    from colcon_yamllaunch.verb.background_launch import Background

# what few launches need is imported where it is needed


def main(
    options: LaunchOptions, known: Any, environment: Mapping[str, str]
) -> int:
    """Build, source and launch, and return the exit code."""
    if options.request == 'timeline':
        from colcon_yamllaunch.verb.timeline import show_timeline

        return show_timeline(options, known.log_base, environment)
    if options.request is not None:
        from colcon_yamllaunch.verb.controlling import control

        return control(options, environment)
    if options.remove_service is not None:
        from colcon_yamllaunch.verb import services

        return services.remove(options)
    if options.schema is not None:
        show(_schema(options, environment), end='')
        return 0
    launch = partial(_launch, options, known, environment)
    if options.demo:
        from colcon_yamllaunch.verb.demo import launch_demo

        launch = partial(launch_demo, _launch, options, known, environment)
    if options.ui:
        from colcon_yamllaunch.verb import background_launch

        return background_launch.launch_for_screen(
            launch, environment, plain=options.no_color
        )
    return launch()


def _schema(options: LaunchOptions, environment: Mapping[str, str]) -> str:
    """
    Return a JSON Schema.

    That of launch files has the actions that packages here bring.
    """
    if options.schema == DEPLOYMENT:
        from colcon_yamllaunch.deployment import json_schema

        return json_schema.schema_text()
    from colcon_yamllaunch.language.vocabulary.json_schema import schema_text
    from colcon_yamllaunch.verb.target import find_workspace
    from colcon_yamllaunch.workspace.colcon.package_scan import scan_packages

    root = find_workspace(options.workspace, ())
    return schema_text(scan_packages(root, environment).exposed.actions())


def _launch(
    options: LaunchOptions,
    known: Any,
    environment: Mapping[str, str],
    background: 'Background | None' = None,
) -> int:
    """
    Inspect a launch, or run it.

    :param background: Where it goes when it begins to run, if it is shown by
      another process
    """
    # nearly all that is imported and evaluated stays until the launch runs,
    # which collects garbage again; until then there is none to speak of
    gc.disable()
    from colcon_yamllaunch.verb.context import LaunchContext
    from colcon_yamllaunch.verb.log_folders import log_folder_of

    log_folder = log_folder_of(known, environment)
    cwd = Path.cwd()
    if not options.inspects:
        need_proc()
    if options.watch is not None:
        from colcon_yamllaunch.watch import watcher

        if not watcher.is_installed():
            raise UserError(watcher.MISSING)
    sigint = signal.getsignal(signal.SIGINT)
    with _junit_report(options, cwd) as report, _time_limit(options):
        if options.attach is not None:
            from colcon_yamllaunch.terminal.keyboard import need_terminal

            need_terminal()
        context = LaunchContext(options, cwd, environment, log_folder)
        context.junit, context.background = report, background
        with closing(context):
            if ''.join(options.positionals[-1:]).endswith('.py'):
                # it imports `launch` while this process imports the rest
                context.worker(context.process_environment()).start()
                import_module('colcon_yamllaunch.workspace.builds')
                import_module('colcon_yamllaunch.run')
            if options.inspects:
                from colcon_yamllaunch.verb.inspect_launch import inspect

                return inspect(context)
            if options.install_service is not None:
                from colcon_yamllaunch.verb import services

                return services.install(context)
            from colcon_yamllaunch.verb.run_launch import launch

            code, changes = launch(context)
    if changes is not None and changes.restarts_launch:
        # the same command again, in this process
        sys.stdout.flush()
        sys.stderr.flush()
        signal.signal(signal.SIGINT, sigint)
        os.execv(sys.executable, sys.orig_argv)
    return code


@contextmanager
def _time_limit(options: LaunchOptions) -> Iterator[None]:
    """
    Interrupt the steps before the launch runs when --timeout is over.

    :raises UserError: when it was
    """
    seconds = options.timeout
    if seconds is None or options.watch is not None:
        yield
        return
    is_late = False

    def end(_number: int, _frame: object) -> None:
        nonlocal is_late
        is_late = True
        signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    except (KeyboardInterrupt, SystemExit, GiveUpError):
        if not is_late:
            raise
    finally:
        # the launch takes it away when it begins
        is_late = is_late and signal.getsignal(signal.SIGALRM) is end
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    if is_late:
        raise UserError(
            f'--timeout: the launch did not begin within {seconds:g} s'
        )


@contextmanager
def _junit_report(
    options: LaunchOptions, cwd: Path
) -> 'Iterator[JUnitReport | None]':
    """
    Write the report that --junit asks for after whatever happens inside.

    :raises UserError: when the file cannot be written
    """
    if options.junit is None:
        yield None
        return
    from colcon_yamllaunch.observers.junit import JUnitReport

    path = cwd / options.junit.expanduser()
    begun = time.monotonic()
    # the package and the launch file
    names = [Path(word).name for word in options.title_words]
    name = '.'.join(n.partition('.')[0] or n for n in names)
    report = JUnitReport(options.title, name, time.time())
    # now rather than after a launch of an hour
    _write_report(path, b'')
    try:
        yield report
    finally:
        _write_report(path, report.document(time.monotonic() - begun))


def _write_report(path: Path, data: bytes) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    except (OSError, ValueError) as e:
        reason = getattr(e, 'strerror', e)
        raise UserError(
            f"--junit: '{path}' cannot be written: {reason}"
        ) from e
