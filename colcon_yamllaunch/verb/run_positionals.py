# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Where the command line of `colcon run` stops being ours.

argparse looks at every word, also at those of the program: `-height` would be
`-h` with something malformed behind it, `--log` an ambiguous abbreviation.
Behind a `--` it leaves them alone, so one is put in front of the package.
"""

from collections.abc import Sequence
import sys
from typing import Any

from colcon_core.argument_parser import ArgumentParserDecorator
from colcon_core.argument_parser import ArgumentParserDecoratorExtensionPoint
from colcon_core.plugin_system import satisfies_version

# colcon imports this module for every command

_VERB = 'run'
#: The options in front of the verb that take a value (colcon-core).
_GLOBAL_OPTIONS = ('--log-base', '--log-level')
#: The verb's options that take one value.
_OPTIONS = ('--prefix', '--workspace', '--build-args')
_SEPARATOR = '--'


class RunWordsExtension(ArgumentParserDecoratorExtensionPoint):  # type: ignore[misc]
    """Leave the words of the program that `colcon run` runs alone."""

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
        return _Decorator(parser)


class _Decorator(ArgumentParserDecorator):  # type: ignore[misc]
    def parse_args(
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> Any:
        return self._parser.parse_args(
            args=separated(args), namespace=namespace
        )

    def parse_known_args(
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> Any:
        return self._parser.parse_known_args(
            args=separated(args), namespace=namespace
        )


def separated(argv: Sequence[str] | None = None) -> list[str]:
    """
    Put `--` in front of the package, if the command line is `colcon run`.

    :param argv: The command line without `colcon`; by default that of this
      process
    """
    words = list(sys.argv[1:] if argv is None else argv)
    verb = _skip_options(words, 0, _GLOBAL_OPTIONS)
    if words[verb : verb + 1] != [_VERB]:
        return words
    package = _skip_options(words, verb + 1, _OPTIONS)
    if package < len(words) and words[package] != _SEPARATOR:
        words.insert(package, _SEPARATOR)
    return words


def own_words(argv: Sequence[str] | None = None) -> list[str]:
    """Return the part of the command line in front of the package."""
    words = separated(argv)
    if _SEPARATOR not in words:
        return words
    return words[: words.index(_SEPARATOR)]


def _skip_options(
    words: Sequence[str], start: int, with_value: Sequence[str]
) -> int:
    """Return the index of the first word that is no option or its value."""
    index = start
    while index < len(words) and words[index].startswith('-'):
        if words[index] == _SEPARATOR:
            break
        if words[index] == '--paths':
            return len(words)
        index += 2 if words[index] in with_value else 1
    return index
