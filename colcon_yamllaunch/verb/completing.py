# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Completion of the verbs' command lines, by way of argcomplete.

argcomplete runs the command with a variable set. While the parser is made,
each argument gets a `completer`, which is asked for what may stand at the
cursor; then the process ends, before anything is run or written.
"""

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
import os
from pathlib import Path
import sys
from types import TracebackType
from typing import Any

from colcon_yamllaunch.common.errors import OutputError
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.verb import candidates
from colcon_yamllaunch.verb.candidates import Candidates, Cursor
from colcon_yamllaunch.verb.command_line import given_options, split_line
from colcon_yamllaunch.verb.messages import say
from colcon_yamllaunch.verb.options import (
    Completer,
    Option,
    OPTIONS,
    REQUESTS,
    Verb,
)
from colcon_yamllaunch.verb.target import PATH_SUFFIXES

_Find = Callable[[Cursor], Candidates]


class _Completer:
    """
    What argcomplete asks.

    :param find: Finds what may stand at the cursor
    :param parser: The parser of the positionals that this is for, if it is
    """

    def __init__(
        self, find: _Find, environment: Mapping[str, str], parser: Any = None
    ) -> None:
        self._find = find
        self._environment = environment
        self._parser = parser

    def __call__(
        self, *, prefix: str, parsed_args: Any, parser: Any, **_: Any
    ) -> Candidates:
        # whatever is broken, Tab offers nothing rather than fail
        with suppress(Exception):
            cursor = Cursor(prefix, parsed_args, parser, self._environment)
            # what a shell would show or put into the line as something else
            return {
                word: one_line(text)
                for word, text in self._find(cursor).items()
                if one_line(word) == word
            }
        return {}

    def __bool__(self) -> bool:
        # argcomplete asks for the first word, too, where the value of an
        # option is begun (--check=), and would take it for such a value
        word = _word_at_cursor(self._environment)
        known = getattr(self._parser, '_argcomplete_namespace', None)
        is_value = word.startswith('-') and '=' in word
        is_begun = bool(getattr(known, 'positionals', None))
        return self._parser is None or not is_value or is_begun


def complete(verb: Verb, parser: Any, environment: Mapping[str, str]) -> None:
    """
    Register the completers of the arguments of a verb.

    :param environment: The user's environment, with what argcomplete added
    """
    sys.excepthook = _report_output_error
    word = _word_at_cursor(environment)
    options = {option.key: option for option in OPTIONS[verb].all()}
    for action in parser._actions:
        option = options.get(action.dest)
        if option is not None:
            find = _finder(option)
            if option.arity == 'choice' and '=' not in word:
                # what follows without it is the package
                find = _nothing
            action.completer = _Completer(find, environment)
        if action.dest == 'positionals':
            find = _POSITIONALS[verb]
            action.completer = _Completer(find, environment, parser)
        if action.option_strings and not word.startswith('-'):
            # dozens of options would hide what is looked for
            action.help = argparse.SUPPRESS


def _report_output_error(
    kind: type[BaseException],
    error: BaseException,
    trace: TracebackType | None,
) -> None:
    """Report in one line that argcomplete could not write its results."""
    if isinstance(error, OSError):
        say(f'colcon: error: {OutputError(error)}')
    else:
        sys.__excepthook__(kind, error, trace)


def _word_at_cursor(environment: Mapping[str, str]) -> str:
    line = environment.get('COMP_LINE', '')
    point = environment.get('COMP_POINT', '')
    if point.isdecimal():
        line = line[: int(point)]
    return line.rpartition(' ')[2]


def _launch_positionals(cursor: Cursor, verb: Verb = 'launch') -> Candidates:
    """Find words behind the package, which argparse leaves to the verb."""
    prefix = cursor.prefix
    options = OPTIONS[verb].by_flag()
    last = options.get((cursor.known.positionals or [''])[-1])
    name, equals, begun = prefix.partition('=')
    if prefix.startswith('-') and equals:
        found = _finder(options[name])(replace(cursor, prefix=begun))
        return {f'{name}={value}': text for value, text in found.items()}
    if prefix.startswith('-'):
        return _options(cursor)
    if last and last.value and last.arity in ('one', 'each', 'some'):
        return _finder(last)(cursor)
    _give_back(cursor.known, OPTIONS[verb].all())
    values, words, arguments = split_line(cursor.known, verb)
    words = [word for word in words if not word.startswith('-')]
    cursor = replace(cursor, known=values)
    given = given_options(values, verb)
    if '--status' in given or '--from-plan' in given:
        return {}
    if '--lifecycle' in given:
        return _of_launches(cursor, 'lifecycles', words)
    if given.keys() & set(REQUESTS):
        return _of_launches(cursor, 'parts')
    return _launched(cursor, words, arguments)


def _give_back(known: Any, options: Iterable[Option[Any]]) -> None:
    """Make a positional of the word that argparse took for a choice."""
    for option in options:
        if option.arity == 'choice':
            word = getattr(known, option.key)
            if word not in (None, *option.choices):
                known.positionals = [word, *known.positionals]
                setattr(known, option.key, option.choices[0])


def _launched(
    cursor: Cursor, words: Sequence[str], arguments: Sequence[str]
) -> Candidates:
    """Find the package, then its launch file, then launch arguments."""
    if not words:
        found = candidates.packages(cursor)
        return found or candidates.paths(cursor.prefix, PATH_SUFFIXES)
    if len(words) == 1 and not os.path.isfile(Path(words[0]).expanduser()):
        return candidates.launch_files(cursor, words[0])
    return candidates.launch_arguments(cursor, words, arguments)


def _run_positionals(cursor: Cursor) -> Candidates:
    words = [word for word in cursor.known.positionals if word != '--']
    if not words:
        return candidates.packages(cursor)
    return candidates.executables(cursor, *words) if len(words) == 1 else {}


def _options(cursor: Cursor) -> Candidates:
    formatter = cursor.parser._get_formatter()
    return {
        option: formatter._expand_help(action)
        for option, action in cursor.parser._option_string_actions.items()
    }


def _finder(option: Option[Any]) -> _Find:
    """Return what finds the values of an option."""
    if option.choices:
        choices = dict.fromkeys(option.choices, '')
        return lambda _: choices
    value = option.value
    return _nothing if value is None else COMPLETERS[value.completer]


def _of_launches(
    cursor: Cursor, completer: Completer, words: Sequence[str] = ()
) -> Candidates:
    """Find running launches, or processes and components of these."""
    from colcon_yamllaunch.verb.process_candidates import candidates_of

    return candidates_of(cursor, completer, words)


def _licenses(_cursor: Cursor) -> Candidates:
    from colcon_yamllaunch.workspace.create.new_package import LICENSES

    return dict.fromkeys(LICENSES, '')


def _places(_cursor: Cursor) -> Candidates:
    """Offer Slurm where it is installed."""
    from shutil import which

    return {'slurm:': 'array jobs'} if which('sbatch') else {}


def _nothing(_cursor: Cursor) -> Candidates:
    return {}


_POSITIONALS: Mapping[Verb, _Find] = {
    'launch': _launch_positionals,
    'run': _run_positionals,
    'create': _nothing,
    'sweep': lambda cursor: _launch_positionals(cursor, 'sweep'),
}
COMPLETERS: Mapping[Completer, _Find] = {
    'files': lambda cursor: candidates.paths(cursor.prefix, ('',)),
    'folders': lambda cursor: candidates.paths(cursor.prefix, ()),
    'hosts': candidates.hosts,
    'launches': lambda cursor: _of_launches(cursor, 'launches'),
    'licenses': _licenses,
    'lifecycles': lambda cursor: _of_launches(cursor, 'lifecycles'),
    'nothing': _nothing,
    'packages': candidates.packages,
    'parts': lambda cursor: _of_launches(cursor, 'parts'),
    'places': _places,
    'terminals': lambda cursor: _of_launches(cursor, 'terminals'),
}
