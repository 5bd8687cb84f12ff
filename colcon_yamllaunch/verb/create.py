# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The verb `create`."""

from typing import Any

from colcon_core.plugin_system import satisfies_version
from colcon_core.verb import VerbExtensionPoint

# colcon imports this module for every command: all else is imported when the
# verb is used

_USAGE = 'colcon create [options] PKG [options]'
_EPILOG = """\
examples:
  colcon create my_pkg
  colcon create my_pkg --node counter --dependencies rclpy std_msgs
  colcon create my_pkg --build-type cmake --license MIT"""


class CreateVerb(VerbExtensionPoint):  # type: ignore[misc]
    """Create a package with a node, a launch file and tests."""

    def __init__(self) -> None:
        super().__init__()
        satisfies_version(VerbExtensionPoint.EXTENSION_POINT_VERSION, '^1.0')
        self._environment: dict[str, str] = {}

    def add_arguments(self, *, parser: Any) -> None:  # noqa: D102
        from colcon_yamllaunch.verb.verb_arguments import add_verb_arguments

        parser.usage = _USAGE
        parser.epilog = _EPILOG
        parser.add_argument(
            'positionals',
            nargs='*',
            metavar='PKG',
            help='The name of the package, which is that of its folder, too',
        )
        self._environment = add_verb_arguments(parser, 'create')

    def main(self, *, context: Any) -> int:  # noqa: D102
        from colcon_yamllaunch.verb.launching.create_flow import main

        return main(context.args, self._environment)
