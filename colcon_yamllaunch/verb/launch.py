# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From the command line of `colcon launch` to its exit code."""

from collections.abc import Mapping
from contextlib import closing
import gc
from pathlib import Path
from typing import Any
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.process_scan import need_proc
from colcon_yamllaunch.verb.command_line import asks_for_help
from colcon_yamllaunch.verb.command_line import parse_launch_options
from colcon_yamllaunch.verb.command_line import show_help
from colcon_yamllaunch.verb.messages import show
from colcon_yamllaunch.verb.messages import show_versions
from colcon_yamllaunch.verb.options import LaunchOptions

if TYPE_CHECKING:
    from colcon_yamllaunch.verb.own_launch import Background


def main(known: Any, environment: Mapping[str, str]) -> int:
    """Build, source and launch, and return the exit code."""
    if asks_for_help(known.positionals):
        return show_help(known.verb_parser, 'launch')
    return _main(known, environment)


def _schema(options: LaunchOptions, environment: Mapping[str, str]) -> str:
    """Return the JSON Schema, with the actions that packages here bring."""
    # what few ask for is imported where it is needed
    from colcon_yamllaunch.language.vocabulary.json_schema import schema_text
    from colcon_yamllaunch.verb.target import find_workspace
    from colcon_yamllaunch.verb.workspace_session import exposed_by_packages
    from colcon_yamllaunch.workspace.colcon.package_scan import scan_packages

    root = find_workspace(options.workspace, ())
    locator = scan_packages(root, environment)
    return schema_text(exposed_by_packages(locator, environment)().actions())


def _main(known: Any, environment: Mapping[str, str]) -> int:
    options = parse_launch_options(known)
    if options.version:
        return show_versions()
    if options.help_all:
        show(known.verb_parser.format_help(), end='')
        return 0
    if options.control is not None:
        from colcon_yamllaunch.verb.controlling import control

        return control(options.control, environment)
    if options.schema:
        show(_schema(options, environment), end='')
        return 0
    if options.ui:
        from colcon_yamllaunch.verb.own_launch import launch_for_screen

        return launch_for_screen(
            lambda background: _launch(
                options, known, environment, background
            ),
            environment,
            plain=options.no_color,
        )
    return _launch(options, known, environment)


def _launch(
    options: LaunchOptions,
    known: Any,
    environment: Mapping[str, str],
    background: 'Background | None' = None,
) -> int:
    # nearly all that is imported and evaluated stays until the launch runs,
    # which collects garbage again; until then there is none to speak of
    gc.disable()
    try:
        return _inspect_or_run(options, known, environment, background)
    finally:
        gc.enable()


def _inspect_or_run(
    options: LaunchOptions,
    known: Any,
    environment: Mapping[str, str],
    background: 'Background | None',
) -> int:
    """
    Inspect a launch, or run it.

    :param background: Where it goes when it begins to run, if it is shown by
      another process
    """
    # what is about running launches does without all that this imports
    from colcon_yamllaunch.verb.log_folders import log_folder_of
    from colcon_yamllaunch.verb.run_launch import LaunchFlow
    from colcon_yamllaunch.verb.run_launch import PlanRun

    log_folder = log_folder_of(known, environment)
    cwd = Path.cwd()
    if not options.inspects:
        need_proc()
    watch = None
    if options.watch is not None:
        from colcon_yamllaunch.verb.watch_launch import WatchFlow

        watch = WatchFlow(options, cwd, environment, log_folder)
    plan_run = PlanRun(options, cwd, environment, background)
    code = 1
    with plan_run.reported(), plan_run.timed():
        flow = LaunchFlow(options, cwd, environment, log_folder)
        with closing(flow):
            flow.start_host()
            if options.inspects:
                # a launch that runs does without all that this imports
                from colcon_yamllaunch.verb import inspect_launch

                return inspect_launch.inspect(flow, options)
            if options.from_plan is not None:
                return flow.run_saved(options.from_plan, plan_run)
            code = flow.run(plan_run, None if watch is None else watch.begin)
    if watch is not None and watch.restarts_launch:
        watch.restart_launch()
    return code
