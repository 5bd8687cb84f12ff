# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verb `sweep`."""

import argparse
from typing import Any

from colcon_core.plugin_system import satisfies_version
from colcon_core.verb import VerbExtensionPoint

# colcon imports this module for every command: all else is imported when the
# verb is used

_USAGE = """\
colcon sweep [options] PKG FILE [name:=values ...]
       colcon sweep [options] path/to/file.yaml [name:=values ...]"""
_EPILOG = """\
examples:
  colcon sweep my_pkg sim.yaml seed:=1..1000 world:=lab,street
  colcon sweep my_pkg sim.yaml gain:=0.5..2.0..0.1 --repeat 5 --jobs 8
  colcon sweep my_pkg sim.yaml --table runs.csv --require 95%
  colcon sweep my_pkg sim.yaml seed:=1..1000 --on slurm:partition=cpu,time=10
  colcon sweep my_pkg sim.yaml seed:=1..1000 --again failed"""


class SweepVerb(VerbExtensionPoint):  # type: ignore[misc]
    """Launch the same many times with other arguments, and compare."""

    def __init__(self) -> None:
        super().__init__()
        satisfies_version(VerbExtensionPoint.EXTENSION_POINT_VERSION, '^1.0')
        self._environment: dict[str, str] = {}

    def add_arguments(self, *, parser: Any) -> None:  # noqa: D102
        from colcon_yamllaunch.verb.verb_arguments import add_verb_arguments

        parser.usage = _USAGE
        parser.epilog = _EPILOG
        # behind the first word an abbreviation is no option either
        parser.allow_abbrev = False
        parser.add_argument(
            'positionals',
            nargs=argparse.REMAINDER,
            metavar='PKG FILE [name:=values ...]',
            help='The package and its launch file, or the path of one, as '
            'colcon launch takes them. Then the launch arguments with their '
            'values: a list such as lab,street, or a range such as 1..1000 '
            'or 0..1..0.1, which is first..last..step',
        )
        self._environment = add_verb_arguments(parser, 'sweep')

    def main(self, *, context: Any) -> int:  # noqa: D102
        from colcon_yamllaunch.verb.cli.messages import report_errors

        return report_errors('sweep', lambda: self._main(context.args))

    def _main(self, known: Any) -> int:
        from colcon_yamllaunch.common.process_scan import need_proc
        from colcon_yamllaunch.verb.cli.messages import show_help
        from colcon_yamllaunch.verb.cli.messages import show_versions
        from colcon_yamllaunch.verb.cli.sweep_options import (
            parse_sweep_options,
        )

        if any(word in ('-h', '--help') for word in known.positionals):
            return show_help(known.verb_parser)
        options = parse_sweep_options(known)
        if options.version:
            return show_versions()
        need_proc()
        # a mistake in the command line is found without all this imports
        from colcon_yamllaunch.verb.sweeping.sweep_flow import SweepFlow

        return SweepFlow(options, known, self._environment).run()
