# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Completion of the verbs' command lines, by way of argcomplete.

argcomplete runs the command with a variable set. While the parser is made,
each argument gets a `completer`, which is asked for what may stand at the
cursor; then the process ends, before anything is run or written.
"""

import argparse
from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.verb.cli.control_options import ACTIONS
from colcon_yamllaunch.verb.cli.control_options import STATUS_FORMATS
from colcon_yamllaunch.verb.cli.log_base import PATH_SUFFIXES
from colcon_yamllaunch.verb.cli.log_base import root_of
from colcon_yamllaunch.verb.cli.options import LOOKS
from colcon_yamllaunch.verb.cli.options import split_words
from colcon_yamllaunch.verb.completion import candidates
from colcon_yamllaunch.verb.completion.candidates import Candidates
from colcon_yamllaunch.workspace.colcon.package_scan import scan_packages
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

_FORMATS = {
    'check': LOOKS['check'],
    'plan': LOOKS['plan'],
    'status': STATUS_FORMATS,
}


@dataclass(frozen=True, slots=True)
class _Cursor:
    """
    Where something is to be completed.

    :param prefix: The word up to the cursor
    :param known: What the parser has made of the words in front
    :param parser: The parser of the verb
    :param environment: The user's environment
    """

    prefix: str
    known: Any
    parser: Any
    environment: Mapping[str, str]

    def locator(self, words: Sequence[str] = ()) -> PackageLocator:
        """Get the packages; the words may have the path of a launch file."""
        given = getattr(self.known, 'workspace', None)
        root = Path(given).expanduser() if given else root_of(list(words))
        return scan_packages(root, self.environment)


class _Completer:
    """
    What argcomplete asks.

    :param find: Finds what may stand at the cursor
    :param environment: The user's environment
    """

    def __init__(
        self,
        find: Callable[[_Cursor], Candidates],
        environment: Mapping[str, str],
    ) -> None:
        self._find = find
        self._environment = environment

    def __call__(
        self, *, prefix: str, parsed_args: Any, parser: Any, **_: Any
    ) -> Candidates:
        # whatever is broken, Tab offers nothing rather than fail
        with suppress(Exception):
            cursor = _Cursor(prefix, parsed_args, parser, self._environment)
            return self._find(cursor)
        return {}


class _WordsCompleter(_Completer):
    """What argcomplete asks about the words that belong to no option."""

    def __init__(
        self,
        find: Callable[[_Cursor], Candidates],
        environment: Mapping[str, str],
        parser: Any,
    ) -> None:
        super().__init__(find, environment)
        self._parser = parser

    def __bool__(self) -> bool:
        # argcomplete asks for the first word, too, where the value of an
        # option is begun (--check=), and would take it for such a value
        word = _word_at_cursor(self._environment)
        known = getattr(self._parser, '_argcomplete_namespace', None)
        is_value = word.startswith('-') and '=' in word
        return not is_value or bool(getattr(known, 'words', None))


def complete(verb: str, parser: Any, environment: Mapping[str, str]) -> None:
    """
    Say how the arguments of a verb are completed.

    :param verb: The name of the verb
    :param parser: Its parser, with all arguments
    :param environment: The user's environment, with what argcomplete added
    """
    word = _word_at_cursor(environment)
    for action in parser._actions:
        find = _OPTIONS.get(action.dest)
        if action.dest in _FORMATS and '=' not in word:
            # what follows without it is the package
            find = _nothing
        if find is not None:
            action.completer = _Completer(find, environment)
        if action.dest == 'words':
            find = _WORDS[verb]
            action.completer = _WordsCompleter(find, environment, parser)
        if action.option_strings and not word.startswith('-'):
            # dozens of options would hide what is looked for
            action.help = argparse.SUPPRESS


def _word_at_cursor(environment: Mapping[str, str]) -> str:
    line = environment.get('COMP_LINE', '')
    point = environment.get('COMP_POINT', '')
    if point.isdecimal():
        line = line[: int(point)]
    return line.rpartition(' ')[2]


def _launch_words(cursor: _Cursor) -> Candidates:
    """Find words behind the package, which argparse leaves to the verb."""
    prefix = cursor.prefix
    last = cursor.known.words[-1] if cursor.known.words else None
    actions = cursor.parser._option_string_actions
    option, equals, value = prefix.partition('=')
    if prefix.startswith('-') and equals:
        found = _value(cursor, actions[option], value)
        return {f'{option}={name}': text for name, text in found.items()}
    if prefix.startswith('-'):
        return _options(cursor)
    if last in actions and _needs_value(actions[last]):
        return _value(cursor, actions[last], prefix)
    options, words, arguments = split_words(cursor.known)
    words = [word for word in words if not word.startswith('-')]
    cursor = _Cursor(prefix, options, cursor.parser, cursor.environment)
    if any(getattr(options, name) is not None for name in ACTIONS):
        return _processes(cursor)
    if options.status is not None or options.from_plan is not None:
        return {}
    return _launched(cursor, words, arguments)


def _launched(
    cursor: _Cursor, words: Sequence[str], arguments: Sequence[str]
) -> Candidates:
    """Find the package, then its launch file, then launch arguments."""
    locator = cursor.locator(words)
    if not words:
        found = candidates.packages(locator, cursor.prefix)
        return found or candidates.paths(cursor.prefix, PATH_SUFFIXES)
    if len(words) == 1 and not Path(words[0]).expanduser().is_file():
        return candidates.launch_files(words[0], locator, cursor.prefix)
    # reading launch files takes longer to import than all else
    from colcon_yamllaunch.verb.completion.argument_candidates import (
        launch_arguments,
    )

    return launch_arguments(
        words, locator, arguments, cursor.environment, cursor.prefix
    )


def _run_words(cursor: _Cursor) -> Candidates:
    words = [word for word in cursor.known.words if word != '--']
    if not words:
        return candidates.packages(cursor.locator(), cursor.prefix)
    if len(words) == 1:
        return candidates.executables(words[0], cursor.locator())
    return {}


def _options(cursor: _Cursor) -> Candidates:
    formatter = cursor.parser._get_formatter()
    return {
        option: formatter._expand_help(action)
        for option, action in cursor.parser._option_string_actions.items()
    }


def _needs_value(action: Any) -> bool:
    return action.nargs in (None, '+')


def _value(cursor: _Cursor, action: Any, prefix: str) -> Candidates:
    find = _OPTIONS.get(action.dest, _nothing)
    return find(
        _Cursor(prefix, cursor.known, cursor.parser, cursor.environment)
    )


def _processes(cursor: _Cursor, *, only_terminals: bool = False) -> Candidates:
    from colcon_yamllaunch.verb.completion.process_candidates import processes

    return processes(
        cursor.environment,
        getattr(cursor.known, 'of', None),
        cursor.prefix,
        only_terminals=only_terminals,
    )


def _terminals(cursor: _Cursor) -> Candidates:
    return _processes(cursor, only_terminals=True)


def _launches(cursor: _Cursor) -> Candidates:
    from colcon_yamllaunch.verb.completion.process_candidates import launches

    return launches(cursor.environment)


def _packages(cursor: _Cursor) -> Candidates:
    return candidates.packages(cursor.locator(), cursor.prefix)


def _licenses(_cursor: _Cursor) -> Candidates:
    from colcon_yamllaunch.workspace.create.new_package import LICENSES

    return dict.fromkeys(LICENSES, '')


def _folders(cursor: _Cursor) -> Candidates:
    return candidates.paths(cursor.prefix, ())


def _files(cursor: _Cursor) -> Candidates:
    return candidates.paths(cursor.prefix, ('',))


def _nothing(_cursor: _Cursor) -> Candidates:
    return {}


def _formats(name: str) -> Callable[[_Cursor], Candidates]:
    return lambda _: dict.fromkeys(_FORMATS[name], '')


_WORDS = {'launch': _launch_words, 'run': _run_words, 'create': _nothing}
_OPTIONS: Mapping[str, Callable[[_Cursor], Candidates]] = {
    **dict.fromkeys(ACTIONS, _processes),
    **{name: _formats(name) for name in _FORMATS},
    **dict.fromkeys(('workspace', 'paths', 'destination'), _folders),
    **dict.fromkeys(('from_plan', 'junit'), _files),
    'attach': _terminals,
    'of': _launches,
    'dependencies': _packages,
    'license': _licenses,
}
