# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A text of a launch file, ready to have its substitutions put in."""

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
from colcon_yamllaunch.language.syntax.yaml_reader import Kind
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
from colcon_yamllaunch.plan.position import Position

# substitutions, by their names in ROS 1
_NAMES_ELSEWHERE = {'arg': 'var', 'find': 'find-pkg-share', 'optenv': 'env'}


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
