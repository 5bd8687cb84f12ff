# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A text of a launch file, ready to have its substitutions put in."""

import re

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.common.suggestions import listing
from colcon_yamllaunch.language.evaluation.request import FindExposed
from colcon_yamllaunch.language.evaluation.request import NothingExposed
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.template import parse_template
from colcon_yamllaunch.language.syntax.template import Substitution
from colcon_yamllaunch.language.syntax.template import Template
from colcon_yamllaunch.language.syntax.template import TemplateSyntaxError
from colcon_yamllaunch.language.syntax.template import unescape
from colcon_yamllaunch.language.syntax.xml_scalar import XmlScalar
from colcon_yamllaunch.language.syntax.yaml_reader import Kind
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
from colcon_yamllaunch.plan.position import Position

# substitutions, by their names in ROS 1
_NAMES_ELSEWHERE = {'arg': 'var', 'find': 'find-pkg-share', 'optenv': 'env'}
_PROPERTIES = re.compile(r'(?:[&!]\S*\s+)*')
_BLOCK_HEADER = re.compile(r'[|>][^\n]*\n')
# what one or more characters of a text in double quotes are written as
_DOUBLE_QUOTED = r"""
    (?P<continuation>\\\r?\n(?:[ \t]*\r?\n)*[ \t]*)
    |\\(?:x[0-9A-Fa-f]{2}|u[0-9A-Fa-f]{4}|U[0-9A-Fa-f]{8}|.)
    |(?P<folding>[ \t]*\r?\n(?:[ \t]*\r?\n)*[ \t]*)
    |.
    """


class Text:
    """
    A text with substitutions, and where it is written.

    :param scalar: The YAML scalar
    :param plain: Whether it has no substitutions by definition
    :param exposed: Gives the substitutions that packages bring
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
        return isinstance(self._scalar, XmlScalar)

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
        return self._scalar.source.position_at(_locate(self._scalar, index))

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


def _locate(scalar: Scalar, index: int) -> int:
    """Return where a character of a scalar's text stands in its file."""
    if isinstance(scalar, XmlScalar):
        return scalar.locate(index)
    raw = scalar.source.text
    at = scalar.source.index_of(scalar.line, scalar.column)
    properties = _PROPERTIES.match(raw, at)
    at = properties.end() if properties else at
    if scalar.style in ('|', '>'):
        header = _BLOCK_HEADER.match(raw, at)
        at = header.end() if header else at
    elif scalar.style:
        at += 1
    if scalar.style == '"':
        return _locate_in_double_quotes(raw, at, index)
    for character in scalar.text[:index]:
        at = _step(raw, at, character, scalar.style)
    return _skip_folding(raw, at, scalar.text[index : index + 1])


def _locate_in_double_quotes(raw: str, at: int, index: int) -> int:
    written = re.compile(_DOUBLE_QUOTED, re.DOTALL | re.VERBOSE)
    # escapes are not the characters that they stand for, so it is by count
    while piece := written.match(raw, at):
        # of several line ends in a row, the first is dropped
        count = piece[0].count('\n') - 1
        if piece['continuation'] is None:
            count = max(1, count if piece['folding'] else 1)
        if count > index:
            break
        index -= count
        at = piece.end()
    return at


def _step(raw: str, at: int, character: str, style: str | None) -> int:
    at = _skip_folding(raw, at, character)
    if style == "'" and raw.startswith("''", at):
        return at + 2
    if raw[at : at + 1] == character:
        return at + 1
    if character.isspace():
        # a line end that was folded into a space
        return at + 1 if raw[at : at + 1].isspace() else at
    return at


def _skip_folding(raw: str, at: int, character: str) -> int:
    """Skip the white space that YAML drops before a character."""
    if character.isspace():
        return at
    while at < len(raw) and raw[at] in ' \t\n\r' and raw[at] != character:
        at += 1
    return at
