# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From the command line of `colcon launch` to its exit code."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from typing import TYPE_CHECKING

from colcon_yamllaunch.verb.cli.messages import report_errors
from colcon_yamllaunch.verb.cli.options import Options
from colcon_yamllaunch.verb.cli.options import parse_options

if TYPE_CHECKING:
    from colcon_yamllaunch.verb.launching.plan_run import LaunchRun


def main(known: Any, environment: Mapping[str, str]) -> int:
    """
    Build, source and launch.

    :param known: What colcon's parser has made of the command line
    :param environment: The user's environment
    :returns: The exit code
    """
    if any(word in ('-h', '--help') for word in known.words):
        known.verb_parser.print_help()
        return 0
    return report_errors('launch', lambda: _launch(known, environment))


def _launch(known: Any, environment: Mapping[str, str]) -> int:
    options = parse_options(known)
    if options.control is not None:
        from colcon_yamllaunch.verb.sessions.controlling import control

        return control(options.control, environment)
    if options.look == 'schema':
        from colcon_yamllaunch.language.vocabulary.json_schema import (
            schema_text,
        )

        print(schema_text(), end='', flush=True)
        return 0
    # what looks at running launches does without all that this imports
    from colcon_yamllaunch.verb.launching.launch_flow import log_folder_of
    from colcon_yamllaunch.verb.launching.plan_run import LaunchRun

    log_folder = log_folder_of(known.log_base, environment)
    running = LaunchRun(options, Path.cwd(), environment)
    with running.reported():
        return _look_or_run(options, environment, log_folder, running)


def _look_or_run(
    options: Options,
    environment: Mapping[str, str],
    log_folder: Path | None,
    running: 'LaunchRun',
) -> int:
    from colcon_yamllaunch.verb.launching.launch_flow import Launching

    launching = Launching(options, Path.cwd(), environment, log_folder)
    if options.look is not None:
        # a launch that runs does without all that this imports
        from colcon_yamllaunch.verb.launching.inspect_launch import look

        return look(launching, options)
    if options.plan is not None:
        return launching.run_saved(options.plan, running)
    return launching.run(running)
