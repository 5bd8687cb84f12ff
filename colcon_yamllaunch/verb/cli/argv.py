# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The command line, before colcon's parser gets it.

argparse looks at every word, also at those of a program that `colcon run`
runs: `-height` would be `-h` with something malformed behind it, `--log` an
ambiguous abbreviation. Behind a `--` it leaves them alone, so one is put in
front of the package. For other words see `option_scanner`.
"""

from collections.abc import Sequence
import os
from pathlib import Path
import sys
from typing import Any

from colcon_core.argument_parser import ArgumentParserDecorator
from colcon_core.argument_parser import ArgumentParserDecoratorExtensionPoint
from colcon_core.plugin_system import satisfies_version

# colcon imports this module for every command

#: The options in front of the verb that take a value (colcon-core).
_GLOBAL_OPTIONS = ('--log-base', '--log-level')
_SEPARATOR = '--'


class ArgvExtension(ArgumentParserDecoratorExtensionPoint):  # type: ignore[misc]
    """Write the words of our verbs so that argparse reads what is meant."""

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
        return self._parser.parse_args(
            args=rewritten(args), namespace=namespace
        )

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
    """
    words = list(sys.argv[1:] if argv is None else argv)
    start = _verb_index(words) + 1
    front, own = words[:start], words[start:]
    if front[-1:] not in (['launch'], ['run'], ['sweep']):
        return words
    from colcon_yamllaunch.verb.cli.option_scanner import normalised
    from colcon_yamllaunch.verb.cli.option_scanner import program_index

    if front[-1] == 'launch':
        return front + normalised(own, 'launch')
    if front[-1] == 'sweep':
        return front + normalised(own, 'sweep')
    package = program_index(own)
    own, program = own[:package], own[package:]
    if program and program[0] != _SEPARATOR:
        program.insert(0, _SEPARATOR)
    return front + normalised(own, 'run') + program


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
        if verb not in ('create', 'launch', 'run', 'sweep'):
            return
        if '_ARGCOMPLETE' not in os.environ:
            print(
                f'colcon {verb}: error: the current folder was removed, or '
                'may not be read: go to another one',
                file=sys.stderr,
            )
        raise SystemExit(1) from None


def words_behind(verb: str) -> list[str]:
    """Return the words behind the verb on the command line of this process."""
    words = sys.argv[1:]
    start = _verb_index(words)
    # where another command runs the verb, as an alias does, all may be its
    return words[start + 1 :] if words[start : start + 1] == [verb] else words


def _verb_index(words: Sequence[str]) -> int:
    """Return the index of the first word that is no option of colcon."""
    index = 0
    while index < len(words) and words[index].startswith('-'):
        if words[index] == _SEPARATOR:
            break
        index += 2 if words[index] in _GLOBAL_OPTIONS else 1
    return index
