# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verb `launch`."""

import argparse
from typing import Any

from colcon_core.plugin_system import satisfies_version
from colcon_core.verb import VerbExtensionPoint

# colcon imports this module for every command: all else is imported when the
# verb is used

_USAGE = """\
colcon launch [options] PKG FILE [name:=value ...]
       colcon launch [options] path/to/file.yaml [name:=value ...]"""
_EPILOG = """\
examples:
  colcon launch my_pkg demo.yaml
  colcon launch my_pkg demo.yaml rate:=5
  colcon launch src/my_pkg/launch/demo.yaml
  colcon launch my_pkg demo.yaml --until "Received .*" --timeout 60"""


class LaunchVerb(VerbExtensionPoint):  # type: ignore[misc]
    """Build what a launch file needs, source the workspace and run it."""

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
            metavar='PKG FILE [name:=value ...]',
            help='The package and its launch file: by name, with or without '
            'extension, or by its path in the package; or instead of both '
            'the path of a launch file. Then the launch arguments',
        )
        self._environment = add_verb_arguments(parser, 'launch')

    def main(self, *, context: Any) -> int:  # noqa: D102
        from colcon_yamllaunch.verb.launching.main import main

        return main(context.args, self._environment)
