# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verb `run`."""

import argparse
from typing import Any

from colcon_core.plugin_system import satisfies_version
from colcon_core.verb import VerbExtensionPoint

# colcon imports this module for every command: all else is imported when the
# verb is used

_USAGE = 'colcon run [options] PKG EXEC [argument ...]'
_EPILOG = """\
examples:
  colcon run my_pkg counter.py
  colcon run my_pkg counter.py --ros-args -p delta:=2
  colcon run --prefix "gdb -ex run --args" flow pump 5"""


class RunVerb(VerbExtensionPoint):  # type: ignore[misc]
    """Build what a program of a package needs, source and become it."""

    def __init__(self) -> None:
        super().__init__()
        satisfies_version(VerbExtensionPoint.EXTENSION_POINT_VERSION, '^1.0')
        self._environment: dict[str, str] = {}

    def add_arguments(self, *, parser: Any) -> None:  # noqa: D102
        from colcon_yamllaunch.verb.verb_arguments import add_verb_arguments

        parser.usage = _USAGE
        parser.epilog = _EPILOG
        # an abbreviation would be taken from among the program's words, too
        parser.allow_abbrev = False
        parser.add_argument(
            'positionals',
            nargs=argparse.REMAINDER,
            metavar='PKG EXEC [argument ...]',
            help='The package and its executable, then the arguments of the '
            'program, which are passed as they are. Without EXEC the '
            'executables of the package are listed',
        )
        self._environment = add_verb_arguments(parser, 'run')

    def main(self, *, context: Any) -> int:  # noqa: D102
        from colcon_yamllaunch.verb.launching.run_flow import main

        return main(context.args, self._environment)
