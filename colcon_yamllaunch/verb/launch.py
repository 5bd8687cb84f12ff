# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verb `launch`."""

import argparse
import os
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
        from colcon_yamllaunch.verb.cli.log_base import choose_log_base
        from colcon_yamllaunch.verb.cli.options import add_options
        from colcon_yamllaunch.verb.cli.standard_streams import (
            open_standard_streams,
        )

        open_standard_streams()
        # what colcon adds to the environment is not the user's
        self._environment = dict(os.environ)
        parser.usage = _USAGE
        parser.epilog = _EPILOG
        # behind the first word an abbreviation is no option either
        parser.allow_abbrev = False
        parser.add_argument(
            'words',
            nargs=argparse.REMAINDER,
            metavar='PKG FILE [name:=value ...]',
            help='The package and its launch file: by name, with or without '
            'extension, or by its path in the package; or instead of both '
            'the path of a launch file. Then the launch arguments',
        )
        add_options(parser)
        choose_log_base()
        if '_ARGCOMPLETE' in os.environ:
            from colcon_yamllaunch.verb.completion.completing import complete

            complete('launch', parser, self._environment)

    def main(self, *, context: Any) -> int:  # noqa: D102
        from colcon_yamllaunch.verb.launching.main import main

        return main(context.args, self._environment)
