# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Rewrites command lines of our verbs before argparse reads them."""

from collections.abc import Sequence
import os
from pathlib import Path
import sys
from typing import Any, NoReturn, TYPE_CHECKING

from colcon_core.argument_parser import (
    ArgumentParserDecorator,
    ArgumentParserDecoratorExtensionPoint,
)
from colcon_core.plugin_system import satisfies_version

if TYPE_CHECKING:
    from colcon_yamllaunch.verb.options import Verb

#: The options in front of the verb that take a value (colcon-core).
_GLOBAL_OPTIONS = ('--log-base', '--log-level')
_SEPARATOR = '--'
_REWRITTEN: 'tuple[Verb, ...]' = ('launch', 'run', 'sweep')
_VERBS = (*_REWRITTEN, 'create')


class ArgvExtension(ArgumentParserDecoratorExtensionPoint):  # type: ignore[misc]
    """
    Rewrite command lines of our verbs for argparse.

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
    Return a command line of our verbs as argparse needs it.

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
    from colcon_yamllaunch.verb.command_line import (
        program_index,
        written_for_argparse,
    )

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
    End our verbs if the current folder does not exist.

    Later, colcon would show a traceback.
    """
    try:
        Path.cwd()
    except OSError:
        words = sys.argv[1:]
        for verb in words[_verb_index(words) :][:1]:
            if verb in _VERBS:
                _exit(
                    verb,
                    'the current folder was removed, or may not be read: go '
                    'to another one',
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
