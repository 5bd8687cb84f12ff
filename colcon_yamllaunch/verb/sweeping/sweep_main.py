# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From the command line of `colcon sweep` to its exit code."""

from collections.abc import Mapping
from typing import Any

from colcon_yamllaunch.common.process_scan import need_proc
from colcon_yamllaunch.verb.cli.messages import report_errors
from colcon_yamllaunch.verb.cli.messages import show_help
from colcon_yamllaunch.verb.cli.messages import show_versions
from colcon_yamllaunch.verb.cli.sweep_options import parse_sweep_options


def main(known: Any, environment: Mapping[str, str]) -> int:
    """Build, source and run all, and return the exit code."""
    if any(word in ('-h', '--help') for word in known.positionals):
        return report_errors('sweep', lambda: show_help(known.verb_parser))
    return report_errors('sweep', lambda: _main(known, environment))


def _main(known: Any, environment: Mapping[str, str]) -> int:
    options = parse_sweep_options(known)
    if options.version:
        return show_versions()
    need_proc()
    # what shows a mistake of the command line does without all this imports
    from colcon_yamllaunch.verb.sweeping.sweep_flow import SweepFlow

    return SweepFlow(options, known.log_base, environment).run()
