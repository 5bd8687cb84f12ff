# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What colcon loads: the verbs, their words and environment variables.

colcon imports this module for every command, so all else is imported when a
verb is used.
"""

import argparse
from collections.abc import Mapping
from collections.abc import Sequence
from functools import partial
import logging
import os
from pathlib import Path
import sys
from typing import Any
from typing import NoReturn
from typing import TYPE_CHECKING

from colcon_core.argument_parser import ArgumentParserDecorator
from colcon_core.argument_parser import ArgumentParserDecoratorExtensionPoint
from colcon_core.environment_variable import EnvironmentVariable
from colcon_core.plugin_system import satisfies_version
from colcon_core.verb import VerbExtensionPoint

if TYPE_CHECKING:
    from colcon_yamllaunch.verb.options import Verb

#: How many former launches keep their folder, unless the user says otherwise.
KEPT_LOG_FOLDERS = 100
#: How many keep it if the user does.
LOG_FOLDERS = EnvironmentVariable(
    'COLCON_LAUNCH_LOG_FOLDERS',
    'How many former launches keep their folder in the log folder: a number '
    f'(default: {KEPT_LOG_FOLDERS}), or `all`',
)
#: Whether a launch has a control group; the runtime reads it.
CGROUP = EnvironmentVariable(
    'COLCON_LAUNCH_CGROUP',
    'Whether launches get a control group where one can be made: 0 for none',
)
#: Bytes that the log folders of all launches may take together, unless the
#: user says otherwise.
ALL_LOGS_LIMIT = 10_000_000_000
#: What they may take if the user does.
LOG_TOTAL = EnvironmentVariable(
    'COLCON_LAUNCH_LOG_TOTAL',
    'What the log folders of all launches may take together: a size such as '
    f'500MB (default: {ALL_LOGS_LIMIT // 10**9}GB), or `none`',
)
#: How long launch files in Python may take; the name is
#: `language.python_files.python_errors.TIMEOUT_VARIABLE`.
PYTHON_TIMEOUT = EnvironmentVariable(
    'COLCON_LAUNCH_PYTHON_TIMEOUT',
    'How many seconds may pass without a sign of life while a launch file in '
    'Python is read (default: 60)',
)
#: Whose workspaces are used; its name is `workspace.packages.trust.TRUST`.
TRUSTED = EnvironmentVariable(
    'COLCON_LAUNCH_TRUST',
    'Folders of other users whose workspaces are used, separated by colons, '
    'or `*` for those of everybody',
)

#: The options in front of the verb that take a value (colcon-core).
_GLOBAL_OPTIONS = ('--log-base', '--log-level')
_SEPARATOR = '--'
_REWRITTEN: 'tuple[Verb, ...]' = ('launch', 'run', 'sweep')
_VERBS = (*_REWRITTEN, 'create')


class _Verb(VerbExtensionPoint):  # type: ignore[misc]
    """A verb: options that are described in `options`, and other words."""

    NAME: 'Verb'
    USAGE: str
    EPILOG: str
    #: The words that are no options: how many, and their name and help.
    NARGS: str = argparse.REMAINDER
    WORDS: str
    WORDS_HELP: str

    def __init__(self) -> None:
        super().__init__()
        satisfies_version(VerbExtensionPoint.EXTENSION_POINT_VERSION, '^1.0')
        self._environment: dict[str, str] = {}

    def add_arguments(self, *, parser: Any) -> None:
        from colcon_yamllaunch.verb.command_line import add_options
        from colcon_yamllaunch.verb.command_line import print_help
        from colcon_yamllaunch.verb.messages import open_standard_streams

        open_standard_streams()
        # on a full disk each message to colcon's log would show a traceback
        logging.raiseExceptions = False
        # what colcon adds to the environment is not the user's
        self._environment = dict(os.environ)
        parser.usage = self.USAGE
        parser.epilog = self.EPILOG
        # an abbreviation could be a word of a program, or a mistake
        parser.allow_abbrev = self.NARGS != argparse.REMAINDER
        parser.add_argument(
            'positionals',
            nargs=self.NARGS,
            metavar=self.WORDS,
            help=self.WORDS_HELP,
        )
        add_options(parser, self.NAME)
        parser.print_help = partial(print_help, parser, self.NAME)
        if '_ARGCOMPLETE' in self._environment:
            from colcon_yamllaunch.verb.completing import complete

            complete(self.NAME, parser, self._environment)

    def main(self, *, context: Any) -> int:
        from colcon_yamllaunch.verb.messages import report_errors

        return report_errors(
            self.NAME, lambda: self._main(context.args, self._environment)
        )

    def _main(self, known: Any, environment: Mapping[str, str]) -> int:
        """
        Do what the command line asks for; return the exit code.

        :param known: What colcon's parser has read: the options in front of
          the first other word, and `positionals`
        :param environment: The user's
        """
        raise NotImplementedError


class LaunchVerb(_Verb):
    """Build what a launch file needs, source the workspace and run it."""

    NAME = 'launch'
    USAGE = """\
colcon launch [options] PKG FILE [name:=value ...]
       colcon launch [options] path/to/file.yaml [name:=value ...]"""
    EPILOG = """\
examples:
  colcon launch my_pkg demo.yaml
  colcon launch my_pkg demo.yaml rate:=5
  colcon launch src/my_pkg/launch/demo.yaml
  colcon launch my_pkg demo.yaml --until "Received .*" --timeout 60"""
    WORDS = 'PKG FILE [name:=value ...]'
    WORDS_HELP = (
        'The package and its launch file: by name, with or without '
        'extension, or by its path in the package; or instead of both '
        'the path of a launch file. Then the launch arguments'
    )

    def _main(self, known: Any, environment: Mapping[str, str]) -> int:
        from colcon_yamllaunch.verb.launch import main

        return main(known, environment)


class RunVerb(_Verb):
    """Build what a program of a package needs, source and become it."""

    NAME = 'run'
    USAGE = 'colcon run [options] PKG EXEC [argument ...]'
    EPILOG = """\
examples:
  colcon run my_pkg counter.py
  colcon run my_pkg counter.py --ros-args -p delta:=2
  colcon run --prefix "gdb -ex run --args" flow pump 5"""
    WORDS = 'PKG EXEC [argument ...]'
    WORDS_HELP = (
        'The package and its executable, then the arguments of the '
        'program, which are passed as they are. Without EXEC the '
        'executables of the package are listed'
    )

    def _main(self, known: Any, environment: Mapping[str, str]) -> int:
        from colcon_yamllaunch.verb.run import main

        return main(known, environment)


class SweepVerb(_Verb):
    """Launch the same many times with other arguments, and compare."""

    NAME = 'sweep'
    USAGE = """\
colcon sweep [options] PKG FILE [name:=values ...]
       colcon sweep [options] path/to/file.yaml [name:=values ...]"""
    EPILOG = """\
examples:
  colcon sweep my_pkg sim.yaml seed:=1..1000 world:=lab,street
  colcon sweep my_pkg sim.yaml gain:=0.5..2.0..0.1 --repeat 5 --jobs 8
  colcon sweep my_pkg sim.yaml --table runs.csv --require 95%
  colcon sweep my_pkg sim.yaml seed:=1..1000 --on slurm:partition=cpu,time=10
  colcon sweep my_pkg sim.yaml seed:=1..1000 --again failed"""
    WORDS = 'PKG FILE [name:=values ...]'
    WORDS_HELP = (
        'The package and its launch file, or the path of one, as '
        'colcon launch takes them. Then the launch arguments with their '
        'values: a list such as lab,street, or a range such as 1..1000 '
        'or 0..1..0.1, which is first..last..step'
    )

    def _main(self, known: Any, environment: Mapping[str, str]) -> int:
        from colcon_yamllaunch.verb.sweep import main

        return main(known, environment)


class CreateVerb(_Verb):
    """Create a package with a node, a launch file and tests."""

    NAME = 'create'
    USAGE = 'colcon create [options] PKG [options]'
    EPILOG = """\
examples:
  colcon create my_pkg
  colcon create my_pkg --node counter --dependencies rclpy std_msgs
  colcon create my_pkg --build-type cmake --license MIT"""
    NARGS = '*'
    WORDS = 'PKG'
    WORDS_HELP = 'The name of the package, which is that of its folder, too'

    def _main(self, known: Any, environment: Mapping[str, str]) -> int:
        from colcon_yamllaunch.verb.create import main

        return main(known, environment)


class ArgvExtension(ArgumentParserDecoratorExtensionPoint):  # type: ignore[misc]
    """
    Write the words of our verbs so that argparse reads what is meant.

    argparse looks at every word, also at those of a program that `colcon run`
    runs: `-height` would be `-h` with something malformed behind it, `--log`
    an ambiguous abbreviation. Behind a `--` it leaves them alone, so one is
    put in front of the package. For other words see `command_line`.
    """

    # below all others: colcon-argcomplete needs the parser that it decorates
    # to be a real one, not a decorator of ours
    PRIORITY = 1

    def __init__(self) -> None:
        super().__init__()
        satisfies_version(
            ArgumentParserDecoratorExtensionPoint.EXTENSION_POINT_VERSION,
            '^1.0',
        )

    def decorate_argument_parser(self, *, parser: Any) -> Any:  # noqa: D102
        _need_current_folder()
        return _Decorator(parser)


class _Decorator(ArgumentParserDecorator):  # type: ignore[misc]
    def parse_args(
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> Any:
        known = self._parser.parse_args(
            args=rewritten(args), namespace=namespace
        )
        if known.verb_name in _VERBS:
            from colcon_yamllaunch.verb.log_folders import choose_log_base

            choose_log_base(known)
        return known

    def parse_known_args(
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> Any:
        return self._parser.parse_known_args(
            args=rewritten(args), namespace=namespace
        )


def rewritten(argv: Sequence[str] | None = None) -> list[str]:
    """
    Write a command line of our verbs so that argparse reads what is meant.

    :param argv: The command line without `colcon`; by default that of this
      process
    :raises SystemExit: if argparse cannot
    """
    words = list(sys.argv[1:] if argv is None else argv)
    start = _verb_index(words) + 1
    front, own = words[:start], words[start:]
    verb = next((verb for verb in _REWRITTEN if front[-1:] == [verb]), None)
    if verb is None:
        return words
    from colcon_yamllaunch.common.errors import UserError
    from colcon_yamllaunch.verb.command_line import program_index
    from colcon_yamllaunch.verb.command_line import written_for_argparse

    program: list[str] = []
    if verb == 'run':
        index = program_index(own)
        own, program = own[:index], own[index:]
        if program and program[0] != _SEPARATOR:
            program.insert(0, _SEPARATOR)
    try:
        return [*front, *written_for_argparse(own, verb), *program]
    except UserError as e:
        _exit(verb, e)


def _need_current_folder() -> None:
    """
    End our verbs at once where there is no current folder.

    Here, as colcon shows a traceback for each of its own verbs otherwise.
    """
    try:
        Path.cwd()
    except OSError:
        words = sys.argv[1:]
        index = _verb_index(words)
        verb = next(iter(words[index : index + 1]), None)
        if verb in _VERBS:
            _exit(
                verb,
                'the current folder was removed, or may not be read: go to '
                'another one',
            )


def _exit(verb: str, error: object) -> NoReturn:
    if '_ARGCOMPLETE' not in os.environ:
        print(f'colcon {verb}: error: {error}', file=sys.stderr)
    raise SystemExit(1) from None


def _verb_index(words: Sequence[str]) -> int:
    """Return the index of the first word that is no option of colcon."""
    index = 0
    while index < len(words) and words[index].startswith('-'):
        if words[index] == _SEPARATOR:
            break
        index += 2 if words[index] in _GLOBAL_OPTIONS else 1
    return index
