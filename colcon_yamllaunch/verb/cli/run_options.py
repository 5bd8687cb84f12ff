# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The words of `colcon run`: its options stand in front of the package."""

from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.cli.options import add_build_options
from colcon_yamllaunch.verb.cli.options import check_build_options
from colcon_yamllaunch.verb.cli.options import split_option
from colcon_yamllaunch.verb.cli.options import unknown_option
from colcon_yamllaunch.verb.cli.options import workspace_option

_USAGE = 'Usage: colcon run [options] PKG EXEC [argument ...]'


@dataclass(frozen=True, slots=True)
class RunOptions:
    """
    What the user asks for.

    :param package: The package
    :param executable: The program as the user names it, or None
    :param arguments: The arguments of the program
    :param prefix: The command line to put in front of the program
    :param workspace: The workspace, if given
    :param paths: The paths of the packages to build, if given
    :param build: Whether anything is built
    :param build_all: Whether all packages are built
    :param build_arguments: Further arguments for `colcon build`
    """

    package: str
    executable: str | None = None
    arguments: tuple[str, ...] = ()
    prefix: tuple[str, ...] = ()
    workspace: Path | None = None
    paths: tuple[str, ...] | None = None
    build: bool = True
    build_all: bool = False
    build_arguments: tuple[str, ...] = ()


def add_run_options(parser: Any) -> None:
    """Add the options of `colcon run` to a parser."""
    parser.add_argument(
        '--prefix',
        metavar='"COMMAND ..."',
        help='A command in one word that gets the program and its arguments '
        'as its last arguments, such as "gdb -ex run --args"',
    )
    add_build_options(parser)


def parse_run_options(known: Any) -> RunOptions:
    """
    Read the whole command line.

    :param known: What colcon's parser has made of it: the options, and
      `words` from the first word on that is none
    :raises WorkspaceError: if it makes no sense
    """
    words = known.words[1:] if known.words[:1] == ['--'] else known.words
    check_build_options(known, known.paths)
    if not words:
        raise WorkspaceError(_nothing_to_run(known.paths))
    package, *rest = words
    if package.startswith('-'):
        raise WorkspaceError(unknown_option(package, 'run', add_run_options))
    if rest and rest[0].startswith('-'):
        raise WorkspaceError(
            f"'{rest[0]}' stands where the executable should: options stand "
            f'in front of the package. {_USAGE}'
        )
    return RunOptions(
        package=package,
        executable=rest[0] if rest else None,
        arguments=tuple(rest[1:]),
        prefix=split_option(known, 'prefix'),
        workspace=workspace_option(known),
        paths=None if known.paths is None else tuple(known.paths),
        build=not known.no_build,
        build_all=known.build_all,
        build_arguments=split_option(known, 'build_args'),
    )


def asks_for_help(known: Any) -> bool:
    """Tell whether help is asked for where the executable would stand."""
    words = [word for word in known.words[:3] if word != '--']
    return any(word in ('-h', '--help') for word in words[:2])


def _nothing_to_run(paths: list[str] | None) -> str:
    if paths:
        return (
            "--paths took all that follows it: put '--' after the paths. "
            f'{_USAGE}'
        )
    return f'there is nothing to run. {_USAGE}'
