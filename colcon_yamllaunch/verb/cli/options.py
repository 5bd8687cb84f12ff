# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The words of the command line.

colcon's parser keeps everything from the first word that is no option in one
list, so that options and launch arguments may stand in any order; they are
parsed here.
"""

import argparse
from collections.abc import Callable
from collections.abc import Sequence
from dataclasses import field
from pathlib import Path
import re
import shlex
import sys
from typing import Any
from typing import NoReturn

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.cli.control_options import add_control_options
from colcon_yamllaunch.verb.cli.control_options import add_prefix_options
from colcon_yamllaunch.verb.cli.control_options import control_options
from colcon_yamllaunch.verb.cli.control_options import ControlOptions
from colcon_yamllaunch.verb.cli.control_options import prefix_arguments
from colcon_yamllaunch.verb.cli.ending_options import add_ending
from colcon_yamllaunch.verb.cli.ending_options import add_shown
from colcon_yamllaunch.verb.cli.ending_options import joined_patterns
from colcon_yamllaunch.verb.cli.ending_options import LaunchRunOptions
from colcon_yamllaunch.verb.cli.ending_options import run_options
from colcon_yamllaunch.verb.cli.exclusion import at_most_one
from colcon_yamllaunch.verb.cli.exclusion import excluded
from colcon_yamllaunch.verb.cli.exclusion import option_of
from colcon_yamllaunch.verb.cli.output_options import add_output_options
from colcon_yamllaunch.verb.cli.output_options import output_options
from colcon_yamllaunch.verb.cli.output_options import OutputOptions

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
    :param why: Whether the decision about each package is explained
    :param force: Whether packages that are up to date are built as well
    :param look: The name in :data:`LOOKS` of what to show instead of running
    :param look_format: How to show it
    :param portable: Whether a check finds what `ros2 launch` would reject
    :param plan: The saved plan to run, if given
    :param run: How it runs
    :param output: How output is shown and kept
    :param control: What is asked of running launches, if anything is
    :param attach: The process to connect the keyboard to, if any
    """

    words: tuple[str, ...]
    arguments: dict[str, str] = field(default_factory=dict)
    workspace: Path | None = None
    paths: tuple[str, ...] | None = None
    build: bool = True
    build_all: bool = False
    build_arguments: tuple[str, ...] = ()
    why: bool = False
    force: bool = False
    look: str | None = None
    look_format: str = TEXT
    portable: bool = False
    plan: Path | None = None
    run: LaunchRunOptions = field(default_factory=LaunchRunOptions)
    output: OutputOptions = field(default_factory=OutputOptions)
    control: ControlOptions | None = None
    attach: str | None = None


def add_options(parser: Any) -> None:
    """Add the options of `colcon launch` to a parser, the common first."""
    _add_looks(parser.add_argument_group('Looking without running'))
    building = parser.add_argument_group('Building')
    add_build_options(building)
    _add_building(building)
    shown = parser.add_argument_group('What is shown and kept')
    add_shown(shown)
    add_output_options(shown)
    running = parser.add_argument_group('Running')
    add_prefix_options(running)
    add_ending(parser.add_argument_group('Ending by itself, as in CI'))
    add_control_options(parser.add_argument_group('Running launches'))


def add_build_options(parser: Any) -> None:
    """Add the options that say which workspace and what is built."""
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


def _add_building(group: Any) -> None:
    group.add_argument(
        '--why',
        action='store_true',
        help='Say of each package that the launch needs why it is built or '
        'not, and what needs it; with --plan or --no-build: why it would be',
    )
    group.add_argument(
        '--force',
        action='store_true',
        help='Build all packages that the launch needs, not just those that '
        'are not up to date',
    )


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
    options, words, arguments = split_words(known)
    for word in words:
        if word.startswith('-'):
            raise WorkspaceError(unknown_option(word, 'launch', add_options))
    return _make_options(options, words, arguments)


def split_words(known: Any) -> tuple[Any, list[str], list[str]]:
    """
    Tell options, other words and launch arguments apart, in any order.

    :param known: As for :func:`parse_options`
    :returns: The values of all options, the words that belong to none (and
      options that do not exist), and the launch arguments
    :raises WorkspaceError: if an option lacks its value
    """
    words = [word for word in known.words if word != '--']
    words = joined_patterns(_swallowed_words(known) + words)
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
    return options, words, arguments


def unknown_option(word: str, verb: str, add: Callable[[Any], None]) -> str:
    """
    Return what to say of an option that does not exist.

    :param word: The option
    :param verb: The name of the verb
    :param add: Adds the options of the verb to a parser
    """
    from colcon_yamllaunch.common.suggestions import did_you_mean

    parser = argparse.ArgumentParser(add_help=False)
    add(parser)
    known = [s for a in parser._actions for s in a.option_strings]
    hint = did_you_mean(word, known) or (
        f"'colcon {verb} --help' lists the options"
    )
    return f"there is no option '{word}': {hint}"


def _swallowed_words(known: Any) -> list[str]:
    """Give back the word that colcon's parser took for a format."""
    for name in ('check', 'plan'):
        word = getattr(known, name)
        is_separate = f'--{name}={word}' not in sys.argv
        if word is not None and word not in LOOKS[name] and is_separate:
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
    check_build_options(options, paths)
    look, look_format = _look(options)
    _check_building(options, look)
    plan = options.from_plan
    control = control_options(options, words, has_plan=plan is not None)
    if control is not None:
        return Options((), control=control)
    if plan is not None and (look or words):
        raise WorkspaceError('--from-plan FILE takes nothing else to launch')
    if not words and plan is None and look != 'schema':
        raise WorkspaceError(_nothing_to_launch(paths))
    return Options(
        words=tuple(words),
        arguments=dict(map(_split_argument, arguments))
        | prefix_arguments(options, plan is not None),
        workspace=workspace_option(options),
        paths=None if paths is None else tuple(paths),
        build=not options.no_build,
        build_all=options.build_all,
        build_arguments=split_option(options, 'build_args'),
        why=options.why,
        force=options.force,
        look=look,
        look_format=look_format,
        portable=options.portable,
        plan=None if plan is None else Path(plan).expanduser(),
        run=run_options(options, look),
        output=output_options(options),
        attach=options.attach,
    )


def workspace_option(options: Any) -> Path | None:
    """Return the workspace that is given, if one is."""
    given = options.workspace
    return None if given is None else Path(given).expanduser()


def split_option(options: Any, name: str) -> tuple[str, ...]:
    """
    Split the value of an option into words, as a shell would.

    :param options: The values of all options
    :param name: The name that the option has there
    :raises WorkspaceError: if a quote is not closed
    """
    try:
        return tuple(shlex.split(getattr(options, name) or ''))
    except ValueError as e:
        raise WorkspaceError(
            f'{option_of(name)} has an open quote: {e}'
        ) from e


def _look(options: Any) -> tuple[str | None, str]:
    given = [name for name in LOOKS if getattr(options, name)]
    at_most_one([option_of(name) for name in given])
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


def check_build_options(options: Any, paths: Sequence[str] | None) -> None:
    """
    Check that the options that say what is built fit together.

    :param options: The values of :func:`add_build_options`
    :param paths: What `--paths` has, without what it swallowed
    :raises WorkspaceError: if they do not
    """
    given = [
        name
        for name, value in (
            ('--no-build', options.no_build),
            ('--build-all', options.build_all),
            ('--paths', paths is not None),
        )
        if value
    ]
    at_most_one(given)


def _check_building(options: Any, look: str | None) -> None:
    if options.force and options.no_build:
        raise excluded('--no-build', '--force')
    if options.why and look not in (None, 'plan'):
        raise excluded('--why', option_of(str(look)))


def _nothing_to_launch(paths: Sequence[str] | None) -> str:
    usage = 'colcon launch PKG FILE, or colcon launch path/to/file.yaml'
    if paths:
        return (
            '--paths took all that follows it: put it behind PKG and FILE, '
            f"or '--' after the paths. Usage: {usage}"
        )
    return f'there is nothing to launch. Usage: {usage}'
