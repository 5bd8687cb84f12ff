# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The words of `colcon create`."""

from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.cli.options import unknown_option

#: The build types, the default first.
BUILD_TYPES = ('ament_cmake', 'ament_python', 'cmake')

_USAGE = 'Usage: colcon create PKG [options]'


@dataclass(frozen=True, slots=True)
class CreateOptions:
    """
    What the user asks for; None where it is not said.

    :param package: The name of the package
    :param build_type: One of :data:`BUILD_TYPES`
    :param dependencies: The packages that it needs
    :param node: The name of its node
    :param license: Its license
    :param description: What it is for
    :param maintainer_name: Who looks after it
    :param maintainer_email: The address of this person
    :param destination: The folder to make it in
    """

    package: str
    build_type: str
    dependencies: tuple[str, ...] = ()
    node: str | None = None
    license: str | None = None
    description: str | None = None
    maintainer_name: str | None = None
    maintainer_email: str | None = None
    destination: Path | None = None


def add_create_options(parser: Any) -> None:
    """Add the options of `colcon create` to a parser."""
    parser.add_argument(
        '--build-type',
        choices=BUILD_TYPES,
        default=BUILD_TYPES[0],
        help='How the package is built (default: %(default)s). That of type '
        'cmake needs no ROS',
    )
    parser.add_argument(
        '--dependencies',
        nargs='+',
        default=[],
        metavar='PKG',
        help='The packages that it needs, such as rclpy std_msgs',
    )
    parser.add_argument(
        '--node',
        metavar='NAME',
        help='The name of its node (default: that of the package and _node)',
    )
    parser.add_argument(
        '--license',
        metavar='NAME',
        help='Its license, as SPDX calls it; for Apache-2.0, BSD-3-Clause '
        'and MIT the text comes with it',
    )
    parser.add_argument(
        '--description', metavar='TEXT', help='What the package is for'
    )
    parser.add_argument(
        '--maintainer-name',
        metavar='NAME',
        help='Who looks after it (default: user.name of git)',
    )
    parser.add_argument(
        '--maintainer-email',
        metavar='ADDRESS',
        help='The address of this person (default: user.email of git)',
    )
    parser.add_argument(
        '--destination',
        metavar='PATH',
        help='The folder that the folder of the package is made in (default: '
        'src in the root of a workspace, elsewhere the current folder)',
    )


def parse_create_options(options: Any) -> CreateOptions:
    """
    Read what colcon's parser has made of the command line.

    :param options: The values of the options, and `words`, all others
    :raises WorkspaceError: if it makes no sense
    """
    words = options.words
    for word in words:
        if word.startswith('-'):
            raise WorkspaceError(
                unknown_option(word, 'create', add_create_options)
            )
    if not words:
        swallowed = ''
        if options.dependencies:
            swallowed = '--dependencies took all that follows it: put it '
            swallowed += 'behind the name of the package. '
        raise WorkspaceError(f'{swallowed}Which package? {_USAGE}')
    if len(words) > 1:
        raise WorkspaceError(
            f"'{words[1]}' is one word too many: one package is made at a "
            f'time. {_USAGE}'
        )
    destination = options.destination
    return CreateOptions(
        package=words[0],
        build_type=options.build_type,
        dependencies=tuple(dict.fromkeys(options.dependencies)),
        node=options.node,
        license=options.license,
        description=options.description,
        maintainer_name=options.maintainer_name,
        maintainer_email=options.maintainer_email,
        destination=None
        if destination is None
        else Path(destination).expanduser(),
    )
