# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The grammar of text with substitutions in it.

ROS 2 defines it in `launch/frontend/grammar.lark`; this is the same language,
read in one pass.
"""

import re

from colcon_yamllaunch.common.frozen import dataclass

#: How deep substitutions may be nested.
MAXIMUM_DEPTH = 50

_IDENTIFIER = re.compile(r'[A-Za-z][A-Za-z0-9_-]*')
_ESCAPED = re.compile(r'\\(.)')
# a substitution starts at '$(' unless a backslash stands before it
_START = re.compile(r'(?<!\\)\$\(')


@dataclass(frozen=True, slots=True)
class Substitution:
    """
    A `$(name argument …)`.

    :param name: What kind it is
    :param arguments: Its arguments
    :param start: The index of its `$` in the text
    :param end: The index behind its `)`
    """

    name: str
    arguments: 'tuple[Template, ...]'
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class Template:
    """
    Text with substitutions in it.

    :param parts: Text, its backslashes resolved, and substitutions
    """

    parts: tuple[str | Substitution, ...]

    @property
    def literal(self) -> str | None:
        """The text when there is no substitution in it, else None."""
        if not self.parts:
            return ''
        if len(self.parts) == 1 and isinstance(self.parts[0], str):
            return self.parts[0]
        return None


class TemplateSyntaxError(Exception):
    """
    A text is not of the grammar.

    :param message: What is wrong
    :param index: Where in the text
    :param length: How many characters are meant
    :param hint: The way out
    """

    def __init__(
        self, message: str, index: int, length: int = 1, hint: str = ''
    ) -> None:
        super().__init__(message)
        self.message = message
        self.index = index
        self.length = length
        self.hint = hint or None


def unescape(text: str) -> str:
    """Drop the backslash of each backslash and character, as ROS 2 does."""
    return _ESCAPED.sub(r'\1', text) if '\\' in text else text


def parse_template(text: str) -> Template:
    """
    Read a text.

    :raises TemplateSyntaxError: when a substitution in it is malformed
    """
    if '$(' not in text:
        return Template((unescape(text),) if text else ())
    parts: list[str | Substitution] = []
    index = 0
    while True:
        found = _START.search(text, index)
        end = found.start() if found else len(text)
        if end > index:
            parts.append(unescape(text[index:end]))
        if not found:
            return Template(tuple(parts))
        substitution = _Parser(text).substitution(found.start(), None, 0)
        parts.append(substitution)
        index = substitution.end


class _Parser:
    """Reads one substitution and what is nested in it."""

    def __init__(self, text: str) -> None:
        self._text = text

    def substitution(
        self, start: int, quote: str | None, depth: int
    ) -> Substitution:
        if depth > MAXIMUM_DEPTH:
            raise TemplateSyntaxError(
                f'substitutions are nested more than {MAXIMUM_DEPTH} levels '
                'deep',
                start,
                2,
            )
        name = _IDENTIFIER.match(self._text, start + 2)
        if not name:
            raise TemplateSyntaxError(
                'a substitution starts with its name',
                start,
                2,
                "write '\\$(' for a '$(' that is no substitution",
            )
        index = name.end()
        arguments: list[Template] = []
        while True:
            character = self._text[index : index + 1]
            if character == ')':
                return Substitution(
                    name[0], tuple(arguments), start, index + 1
                )
            if character != ' ':
                raise self._unexpected(start, index)
            argument, index = self._argument(index + 1, start, quote, depth)
            arguments.append(argument)

    def _argument(
        self, index: int, start: int, quote: str | None, depth: int
    ) -> tuple[Template, int]:
        character = self._text[index : index + 1]
        if character in (' ', ')'):
            raise TemplateSyntaxError(
                'one space separates the arguments of a substitution; this '
                'one is too many',
                index - 1,
                hint="an empty argument is written ''",
            )
        if quote is None and character in ('"', "'"):
            return self._quoted(index, character, depth)
        return self._unquoted(index, start, quote, depth)

    def _quoted(
        self, start: int, quote: str, depth: int
    ) -> tuple[Template, int]:
        parts: list[str | Substitution] = []
        index = begin = start + 1
        while True:
            character = self._text[index : index + 1]
            if not character:
                raise TemplateSyntaxError('this quote is not closed', start)
            if character == '\\':
                index += 2
            elif self._text.startswith('$(', index):
                self._append_text(parts, begin, index)
                nested = self.substitution(index, quote, depth + 1)
                parts.append(nested)
                index = begin = nested.end
            elif character == quote:
                self._append_text(parts, begin, index)
                return Template(tuple(parts)), index + 1
            else:
                index += 1

    def _unquoted(
        self, start: int, opened: int, quote: str | None, depth: int
    ) -> tuple[Template, int]:
        parts: list[str | Substitution] = []
        index = begin = start
        while True:
            character = self._text[index : index + 1]
            if character == '\\' and self._text[index + 1 : index + 2] != ' ':
                index += 2
            elif self._text.startswith('$(', index):
                self._append_text(parts, begin, index)
                nested = self.substitution(index, quote, depth + 1)
                parts.append(nested)
                index = begin = nested.end
            elif character in (' ', ')', ''):
                self._append_text(parts, begin, index)
                if not character:
                    raise self._unexpected(opened, index)
                return Template(tuple(parts)), index
            elif self._is_forbidden(character, quote):
                raise self._unexpected(opened, index)
            else:
                index += 1

    @staticmethod
    def _is_forbidden(character: str, quote: str | None) -> bool:
        # within quotes, the other kind of quote is plain text
        return character == '(' or character in (quote or '\'"')

    def _append_text(
        self, parts: list[str | Substitution], begin: int, end: int
    ) -> None:
        if end > begin:
            parts.append(unescape(self._text[begin:end]))

    def _unexpected(self, start: int, index: int) -> TemplateSyntaxError:
        character = self._text[index : index + 1]
        if not character:
            return TemplateSyntaxError(
                "this substitution is not closed: a ')' is missing", start, 2
            )
        if character in ('"', "'"):
            return TemplateSyntaxError(
                'an argument of a substitution is quoted as a whole or not '
                'at all',
                index,
                hint="write '\\' before a quote that belongs to the text",
            )
        if character == '(':
            return TemplateSyntaxError(
                "'(' in an argument of a substitution must be quoted", index
            )
        if character in ('\t', '\n'):
            return TemplateSyntaxError(
                'the arguments of a substitution are separated by spaces, '
                'not by tabs or lines',
                index,
            )
        return TemplateSyntaxError(
            f"'{character}' does not belong here: a substitution is "
            '$(name argument …)',
            index,
        )
