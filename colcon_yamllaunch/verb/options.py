# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The words of the command line.

colcon's parser keeps everything from the first word that is no option in one
list, so that options and launch arguments may stand in any order; they are
parsed here.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import field
from pathlib import Path
import re
import shlex
from typing import Any
from typing import NoReturn

from colcon_yamllaunch.workspace.error import WorkspaceError

_BUILD_ARGUMENTS = '--build-args'
_ARGUMENT = re.compile(r'[^-][^\s]*?:=|:=')


#: The format of what is shown to people.
TEXT = 'text'
#: What can be shown without running anything, with its formats.
LOOKS = {
    'show_args': (TEXT,),
    'check': (TEXT, 'json', 'github', 'sarif'),
    'plan': (TEXT, 'json', 'mermaid', 'dot'),
    'schema': (TEXT,),
}


@dataclass(frozen=True, slots=True)
class Options:
    """
    What the user asks for.

    :param words: The package and the launch file, or a path
    :param arguments: The launch arguments
    :param workspace: The workspace, if given
    :param paths: The paths of the packages to build, if given
    :param build: Whether anything is built
    :param build_all: Whether all packages are built
    :param build_arguments: Further arguments for `colcon build`
    :param look: The name in :data:`LOOKS` of what to show instead of running
    :param look_format: How to show it
    :param portable: Whether a check finds what `ros2 launch` would reject
    :param plan: The saved plan to run, if given
    """

    words: tuple[str, ...]
    arguments: dict[str, str] = field(default_factory=dict)
    workspace: Path | None = None
    paths: tuple[str, ...] | None = None
    build: bool = True
    build_all: bool = False
    build_arguments: tuple[str, ...] = ()
    look: str | None = None
    look_format: str = TEXT
    portable: bool = False
    plan: Path | None = None


def add_options(parser: Any) -> None:
    """Add the options of the verb to a parser."""
    parser.add_argument(
        '--workspace',
        metavar='PATH',
        help='The root of the workspace (default: found from the current '
        'folder upwards)',
    )
    parser.add_argument(
        '--paths',
        nargs='+',
        metavar='PATH',
        help='Build the packages at just these paths, as `colcon build '
        '--paths` takes them',
    )
    parser.add_argument(
        '--no-build', action='store_true', help='Build nothing'
    )
    parser.add_argument(
        '--build-all',
        action='store_true',
        help='Build all packages of the workspace',
    )
    parser.add_argument(
        _BUILD_ARGUMENTS,
        metavar='"ARG ..."',
        help='Further arguments for `colcon build`, in one word',
    )
    _add_looks(parser.add_argument_group('Looking without running'))


def _add_looks(group: Any) -> None:
    group.add_argument(
        '-s',
        '--show-args',
        action='store_true',
        help='Show the launch arguments',
    )
    group.add_argument(
        '--check',
        nargs='?',
        const=TEXT,
        metavar='FORMAT',
        help='Check every branch of the launch file and of its includes; '
        'written --check=json, --check=github or --check=sarif for programs',
    )
    group.add_argument(
        '--portable',
        action='store_true',
        help='With --check: find what `ros2 launch` would reject, too',
    )
    group.add_argument(
        '--plan',
        nargs='?',
        const=TEXT,
        metavar='FORMAT',
        help='Show what would run; --plan=json can be saved and run, '
        '--plan=mermaid and --plan=dot are drawings',
    )
    group.add_argument(
        '--from-plan', metavar='FILE', help='Run a plan that was saved'
    )
    group.add_argument(
        '--schema',
        action='store_true',
        help='Print the JSON Schema of launch files, for editors',
    )


class _Parser(argparse.ArgumentParser):
    """A parser that reports problems as all others are reported."""

    def error(self, message: str) -> NoReturn:
        raise WorkspaceError(message)


def parse_options(known: Any) -> Options:
    """
    Read the whole command line.

    :param known: What colcon's parser has made of it: options that stand
      before the first word, and `words`
    :raises WorkspaceError: if it makes no sense
    """
    words = [word for word in known.words if word != '--']
    words = _swallowed_words(known) + words
    arguments, words = _take_arguments(words)
    parser = _Parser(add_help=False, allow_abbrev=False)
    add_options(parser)
    defaults = argparse.Namespace(
        **{
            action.dest: getattr(known, action.dest, action.default)
            for action in parser._actions
        }
    )
    options, words = parser.parse_known_args(_joined(words), defaults)
    _refuse_unknown(words, parser)
    return _make_options(options, words, arguments)


def _swallowed_words(known: Any) -> list[str]:
    """Give back the word that colcon's parser took for a format."""
    for name in ('check', 'plan'):
        word = getattr(known, name)
        if word is not None and word not in LOOKS[name]:
            setattr(known, name, TEXT)
            return [word]
    return []


def _joined(words: Sequence[str]) -> list[str]:
    """
    Join an option with its value where argparse could not tell.

    That of --build-args looks like an option; --check and --plan take one
    only behind '='.
    """
    joined: list[str] = []
    for word in words:
        if joined and joined[-1] == _BUILD_ARGUMENTS:
            joined[-1] = f'{_BUILD_ARGUMENTS}={word}'
        elif word in ('--check', '--plan'):
            joined.append(f'{word}={TEXT}')
        else:
            joined.append(word)
    return joined


def _make_options(
    options: Any, words: Sequence[str], arguments: list[str]
) -> Options:
    paths = None
    if options.paths is not None:
        more, paths = _take_arguments(options.paths)
        arguments = more + arguments
    _check_build(options, paths)
    look, look_format = _look(options)
    plan = options.from_plan
    if plan is not None and (look or words):
        raise WorkspaceError('--from-plan FILE takes nothing else to launch')
    if not words and plan is None and look != 'schema':
        raise WorkspaceError(_nothing_to_launch(paths))
    try:
        build_arguments = shlex.split(options.build_args or '')
    except ValueError as e:
        raise WorkspaceError(f'--build-args has an open quote: {e}') from e
    return Options(
        words=tuple(words),
        arguments=dict(map(_split_argument, arguments)),
        workspace=None
        if options.workspace is None
        else Path(options.workspace).expanduser(),
        paths=None if paths is None else tuple(paths),
        build=not options.no_build,
        build_all=options.build_all,
        build_arguments=tuple(build_arguments),
        look=look,
        look_format=look_format,
        portable=options.portable,
        plan=None if plan is None else Path(plan).expanduser(),
    )


def _look(options: Any) -> tuple[str | None, str]:
    given = [name for name in LOOKS if getattr(options, name)]
    if len(given) > 1:
        raise WorkspaceError(
            f'--{given[0]} and --{given[1]} exclude one another'.replace(
                '_', '-'
            )
        )
    if not given:
        return None, TEXT
    name = given[0]
    value = getattr(options, name)
    form = TEXT if value is True else value
    if form not in LOOKS[name]:
        formats = ', '.join(LOOKS[name])
        raise WorkspaceError(
            f"--{name} has no format '{form}': it is one of {formats}"
        )
    if options.portable and name != 'check':
        raise WorkspaceError('--portable goes with --check')
    return name, form


def _take_arguments(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Separate the launch arguments from the other words."""
    arguments = [word for word in words if _ARGUMENT.match(word)]
    return arguments, [word for word in words if not _ARGUMENT.match(word)]


def _split_argument(word: str) -> tuple[str, str]:
    name, _, value = word.partition(':=')
    if not name:
        raise WorkspaceError(
            f"the launch argument '{word}' has no name: it is written "
            'name:=value'
        )
    return name, value


def _refuse_unknown(
    words: Sequence[str], parser: argparse.ArgumentParser
) -> None:
    from colcon_yamllaunch.language.suggest import did_you_mean

    known = [s for a in parser._actions for s in a.option_strings]
    for word in words:
        if word.startswith('-'):
            hint = did_you_mean(word, known) or (
                "'colcon launch --help' lists the options"
            )
            raise WorkspaceError(f"there is no option '{word}': {hint}")


def _check_build(options: Any, paths: Sequence[str] | None) -> None:
    given = [
        name
        for name, value in (
            ('--no-build', options.no_build),
            ('--build-all', options.build_all),
            ('--paths', paths is not None),
        )
        if value
    ]
    if len(given) > 1:
        raise WorkspaceError(f'{given[0]} and {given[1]} exclude one another')


def _nothing_to_launch(paths: Sequence[str] | None) -> str:
    usage = 'colcon launch PKG FILE, or colcon launch path/to/file.yaml'
    if paths:
        return (
            '--paths took all that follows it: put it behind PKG and FILE, '
            f"or '--' after the paths. Usage: {usage}"
        )
    return f'there is nothing to launch. Usage: {usage}'
