# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Texts with substitutions in them.

ROS 2 defines the grammar in `launch/frontend/grammar.lark`; this is the same
language, read in one pass.
"""

from collections.abc import Iterator
import re

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean, listing
from colcon_yamllaunch.language.evaluation.request import (
    FindExposed,
    NothingExposed,
)
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.yaml_reader import Kind, Scalar
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
from colcon_yamllaunch.plan.position import Position

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

    def substitutions(self) -> Iterator[Substitution]:
        """Iterate over all substitutions, outer ones before inner ones."""
        for part in self.parts:
            if isinstance(part, Substitution):
                yield part
                for argument in part.arguments:
                    yield from argument.substitutions()


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
        is_quoted = quote is None and character in ('"', "'")
        own = character if is_quoted else ''
        parts: list[str | Substitution] = []
        opening = index
        begin = index = index + len(own)
        while True:
            character = self._text[index : index + 1]
            follower = self._text[index + 1 : index + 2]
            if character == '\\' and (own or follower != ' '):
                index += 2
            elif character == '$' and follower == '(':
                self._append_text(parts, begin, index)
                nested = self.substitution(index, own or quote, depth + 1)
                parts.append(nested)
                index = begin = nested.end
            elif not character:
                if own:
                    message = 'this quote is not closed'
                    raise TemplateSyntaxError(message, opening)
                raise self._unexpected(start, index)
            elif character == own or (not own and character in ' )'):
                self._append_text(parts, begin, index)
                return Template(tuple(parts)), index + len(own)
            # within quotes, the other kind of quote is plain text
            elif not own and character in '(' + (quote or '\'"'):
                raise self._unexpected(start, index)
            else:
                index += 1

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
        shown = 'this line end' if character == '\n' else f"'{character}'"
        return TemplateSyntaxError(
            f'{shown} does not belong here: a substitution is '
            '$(name argument …)',
            index,
            hint='an argument is quoted as a whole or not at all'
            if character in '\'"'
            else 'quote the argument if this belongs to it',
        )


class UnclosedQuoteError(ValueError):
    """A quote of a command line is not closed."""


_DOUBLE = r'"([^"\\]*(?:\\.[^"\\]*)*)"'
_SINGLE = r"'([^']*)'"
# an argument of a command line, or a quote that is not closed
_ARGUMENT = re.compile(
    rf'(?:[^ \t\r\n\\"\']+|\\.?|{_DOUBLE}|{_SINGLE})+|(?P<open>["\'])',
    re.DOTALL,
)
_QUOTED = re.compile(rf'\\(.?)|{_DOUBLE}|{_SINGLE}', re.DOTALL)


def split_command_line(template: Template) -> tuple[Template, ...]:
    """
    Split a text into arguments as a POSIX shell does.

    The result of a substitution is never split: it is, or is a part of, one
    argument.

    :raises UnclosedQuoteError: when a quote is not closed
    """
    texts = [part for part in template.parts if isinstance(part, str)]
    # a character of private use stands for each substitution
    private = map(chr, range(0xE000, 0xF900))
    marker = next(c for c in private if not any(c in text for text in texts))
    substitutions = (p for p in template.parts if not isinstance(p, str))
    line = ''.join(
        part if isinstance(part, str) else marker for part in template.parts
    )
    arguments = []
    for found in _ARGUMENT.finditer(line):
        if found['open']:
            raise UnclosedQuoteError(found['open'])
        first, *others = _QUOTED.sub(_unquoted, found[0]).split(marker)
        parts: list[str | Substitution] = [first]
        for text in others:
            parts += [next(substitutions), text]
        arguments.append(Template(tuple(part for part in parts if part)))
    return tuple(arguments)


def _unquoted(found: re.Match[str]) -> str:
    escaped, double, single = found.groups()
    if escaped is not None:
        return escaped or '\\'
    if double is not None:
        # in double quotes, a backslash stays before a character that it does
        # not escape (POSIX shell, 2.2.3)
        return re.sub(r'\\(["\\])', r'\1', double)
    return str(single)


# substitutions, by their names in ROS 1
_NAMES_ELSEWHERE = {'arg': 'var', 'find': 'find-pkg-share', 'optenv': 'env'}


class Text:
    """
    A text with substitutions, and where it is written.

    :param scalar: The YAML scalar
    :param plain: Whether it has no substitutions by definition
    :param exposed: Returns the substitutions of packages
    :raises LaunchError: when a substitution in it is malformed or unknown
    """

    __slots__ = ('_scalar', 'literal', 'template')

    def __init__(
        self,
        scalar: Scalar,
        *,
        plain: bool = False,
        exposed: FindExposed = NothingExposed,
    ) -> None:
        self._scalar = scalar
        if plain or '$(' not in scalar.text:
            self.literal: str | None = unescape(scalar.text)
            is_empty = not self.literal and not plain
            self.template = Template(() if is_empty else (self.literal,))
            return
        try:
            self.template = parse_template(scalar.text)
        except TemplateSyntaxError as e:
            raise error(
                e.message,
                self.position_at(e.index),
                hint=e.hint,
                length=e.length,
            ) from e
        #: The text when it has no substitutions, else None.
        self.literal = self.template.literal
        if self.literal is None:
            for substitution in self.template.substitutions():
                self._check(substitution, exposed)

    @property
    def plain(self) -> str:
        """The text as it is written, its backslashes resolved."""
        return unescape(self._scalar.text)

    @property
    def kind(self) -> Kind:
        """What YAML takes the text for."""
        return self._scalar.kind

    @property
    def is_coerced(self) -> bool:
        """Whether a type that is wanted decides what the text is."""
        return self._scalar.is_of_xml

    @property
    def value(self) -> str | int | float | bool | None:
        """The text as YAML takes it."""
        return self._scalar.value

    @property
    def position(self) -> Position:
        """The position of its first character, or of its quote."""
        return self._scalar.position

    @property
    def length(self) -> int:
        """How many characters of its first line it takes."""
        scalar = self._scalar
        if scalar.end[0] != scalar.line:
            return 1
        return max(1, scalar.end[1] - scalar.column)

    def position_at(self, index: int) -> Position:
        """Return the position of the character with this index."""
        return self._scalar.source.position_at(self._scalar.locate(index))

    def _check(self, substitution: Substitution, exposed: FindExposed) -> None:
        name = substitution.name
        kind = KINDS.get(name)
        if kind is None:
            if exposed().substitution(name) is not None:
                return
            raise error(
                f"unknown substitution '{name}'",
                self.position_at(substitution.start),
                hint=_meant(substitution, exposed),
                length=len(name) + 2,
            )
        problem = kind.arity_problem(len(substitution.arguments))
        if problem is not None:
            raise error(
                problem,
                self.position_at(substitution.start),
                hint=f'it is written {kind.usage}',
                length=substitution.end - substitution.start,
            )


def _meant(substitution: Substitution, exposed: FindExposed) -> str:
    """Return what may be meant by a substitution that does not exist."""
    name = substitution.name
    known = _NAMES_ELSEWHERE.get(name)
    if known is not None:
        return f'$({name} …) of ROS 1 is {KINDS[known].usage} in ROS 2'
    near = did_you_mean(name, [*KINDS, *exposed().substitutions()])
    if near is not None:
        return near
    if not substitution.arguments:
        return f"for the value of the launch argument '{name}', write " + (
            f'$(var {name})'
        )
    return f'the substitutions are {listing(KINDS)}'
