# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The command line of `colcon run`: options stand in front of the package."""

from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.cli.option_parser import read_options
from colcon_yamllaunch.verb.cli.option_parser import unknown_option

_USAGE = 'Usage: colcon run [options] PKG EXEC [argument ...]'


@dataclass(frozen=True, slots=True)
class RunOptions:
    """
    What the user asks for; the options by their keys in the table.

    :param executable: The program as the user names it, or None
    """

    package: str
    executable: str | None = None
    arguments: tuple[str, ...] = ()
    prefix: tuple[str, ...] = ()
    workspace: Path | None = None
    paths: tuple[str, ...] | None = None
    no_build: bool = False
    build_all: bool = False
    build_args: tuple[str, ...] = ()


def parse_run_options(known: Any) -> RunOptions:
    """
    Read the whole command line.

    :param known: What colcon's parser has made of it: the options, and
      `positionals` from the first word on that is none
    :raises UserError: when it makes no sense
    """
    words = known.positionals
    words = words[1:] if words[:1] == ['--'] else words
    read = read_options(known, 'run')
    if not words:
        raise UserError(_nothing_to_run(known.paths))
    package, *rest = words
    if package.startswith('-'):
        raise UserError(unknown_option(package, 'run'))
    if rest and rest[0].startswith('-'):
        raise UserError(
            f"'{rest[0]}' stands where the executable should: options stand "
            f'in front of the package. {_USAGE}'
        )
    executable = rest[0] if rest else None
    return RunOptions(package, executable, tuple(rest[1:]), **read)


def asks_for_help(known: Any) -> bool:
    """Tell whether help is asked for where the executable would stand."""
    words = [word for word in known.positionals[:3] if word != '--']
    return any(word in ('-h', '--help') for word in words[:2])


def _nothing_to_run(paths: list[str] | None) -> str:
    if paths:
        return (
            "--paths took all that follows it: put '--' after the paths. "
            f'{_USAGE}'
        )
    return f'there is nothing to run. {_USAGE}'
