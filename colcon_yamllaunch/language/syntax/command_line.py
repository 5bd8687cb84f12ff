# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Splitting a command line before its substitutions are put in.

ROS 2 splits each piece of text between substitutions by itself
(`ExecuteProcess._parse_cmdline`); here quotes may also span a substitution.
"""

from colcon_yamllaunch.language.syntax.template import Substitution
from colcon_yamllaunch.language.syntax.template import Template

_WHITESPACE = ' \t\r\n'


class UnclosedQuoteError(ValueError):
    """A quote of a command line is not closed."""


def split_command_line(template: Template) -> tuple[Template, ...]:
    """
    Split a text into arguments as a POSIX shell does.

    The result of a substitution is never split: it is, or is a part of, one
    argument.

    :raises UnclosedQuoteError: when a quote is not closed
    """
    splitter = _Splitter()
    for part in template.parts:
        if isinstance(part, Substitution):
            splitter.substitution(part)
        else:
            for character in part:
                splitter.character(character)
    return splitter.finish()


class _Splitter:
    """The state between two characters of a command line."""

    def __init__(self) -> None:
        self._arguments: list[Template] = []
        self._parts: list[str | Substitution] = []
        # a text that grows bit by bit would take quadratic time
        self._text: list[str] = []
        self._started = False
        self._quote = ''
        self._escape = False

    def substitution(self, part: Substitution) -> None:
        self._flush_text()
        self._parts.append(part)
        self._started = True

    def character(self, character: str) -> None:
        if self._escape:
            # within double quotes a backslash stays before a character that
            # it does not escape (POSIX shell, 2.2.3)
            if self._quote and character not in '"\\':
                self._text.append('\\')
            self._text.append(character)
            self._escape = False
        elif character == '\\' and self._quote != "'":
            self._escape = self._started = True
        elif self._quote:
            if character == self._quote:
                self._quote = ''
            else:
                self._text.append(character)
        elif character in '\'"':
            self._quote = character
            self._started = True
        elif character in _WHITESPACE:
            self._end_argument()
        else:
            self._text.append(character)
            self._started = True

    def finish(self) -> tuple[Template, ...]:
        if self._quote:
            raise UnclosedQuoteError(self._quote)
        if self._escape:
            self._text.append('\\')
        self._end_argument()
        return tuple(self._arguments)

    def _flush_text(self) -> None:
        if self._text:
            self._parts.append(''.join(self._text))
            self._text = []

    def _end_argument(self) -> None:
        if self._started:
            self._flush_text()
            self._arguments.append(Template(tuple(self._parts)))
        self._parts = []
        self._started = False
