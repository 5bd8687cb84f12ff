# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A substitution that is being evaluated."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from colcon_yamllaunch.language.evaluation.scope import unknown, Value
from colcon_yamllaunch.language.syntax.text import Substitution
from colcon_yamllaunch.plan.position import Position

if TYPE_CHECKING:
    from colcon_yamllaunch.language.evaluation.walk import Walk


class Call:
    """
    A substitution to be made.

    :param walk: What it may look at
    :param substitution: The substitution
    :param position_at: Gives the position for an index in its text
    """

    __slots__ = ('_position_at', '_substitution', 'walk')

    def __init__(
        self,
        walk: 'Walk',
        substitution: Substitution,
        position_at: Callable[[int], Position],
    ) -> None:
        self.walk = walk
        self._substitution = substitution
        self._position_at = position_at

    def __len__(self) -> int:
        return len(self._substitution.arguments)

    def __getitem__(self, index: int) -> Value:
        template = self._substitution.arguments[index]
        literal = template.literal
        if literal is not None:
            return Value(literal, literal)
        return self.walk.template(template, self._position_at)

    def text(self, index: int) -> str | None:
        """Return an argument as text, None when it is not known."""
        literal = self._substitution.arguments[index].literal
        return self[index].text if literal is None else literal

    def all(self) -> list[Value]:
        """Return all arguments."""
        return [self[index] for index in range(len(self))]

    @property
    def name(self) -> str:
        """Which substitution it is."""
        return self._substitution.name

    @property
    def position(self) -> Position:
        """Where it is written."""
        return self._position_at(self._substitution.start)

    @property
    def length(self) -> int:
        """How many characters it takes there."""
        return self._substitution.end - self._substitution.start

    def key(self, values: Iterable[Value]) -> str:
        """Return the key of what is made of these arguments."""
        words = ' '.join([value.key for value in values])
        return f'$({self.name} {words})'

    def unknown(self, values: Iterable[Value]) -> Value:
        """
        Return the value that is not known.

        :raises AlreadyReportedError: when a launch has to know it
        """
        values = tuple(values)
        key = self.key(values)
        sources = {key}.union(*(value.sources for value in values))
        return self.walk.settled(unknown(key, sources))


#: What makes a substitution.
Maker = Callable[[Call], Value]
