# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The attributes of an action, read as the table of actions says."""

from collections.abc import Callable, Mapping, Sequence
import math
from typing import NamedTuple, TYPE_CHECKING, TypeVar

from colcon_yamllaunch.language.evaluation.scope import Value
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.launch_tree import Entity, Item
from colcon_yamllaunch.language.syntax.text import (
    split_command_line,
    Text,
    UnclosedQuoteError,
)
from colcon_yamllaunch.language.vocabulary.actions import (
    Attribute,
    by_name,
    items_of,
    Type,
)
from colcon_yamllaunch.language.vocabulary.parameter import parse_boolean
from colcon_yamllaunch.plan.position import Position

if TYPE_CHECKING:
    from colcon_yamllaunch.language.evaluation.walk import Walk

_T = TypeVar('_T')


class Word(NamedTuple):
    """An argument of a command line, and the text that it stands in."""

    text: Text
    value: Value


class Attributes:
    """
    The attributes of an action, or of an item in one of its lists.

    What is read is checked against the table. A value is None when it is not
    known, or wrong; the default when the attribute is left out.

    :param walk: What evaluates their texts
    :param name: The name of the action or list
    :param item: What is written
    :param known: The attributes that there are, by name
    :param children: The actions inside of it
    :param length: How many characters stand for it in a message
    """

    __slots__ = (
        '_known',
        '_values',
        '_walk',
        'children',
        'item',
        'length',
        'name',
    )

    def __init__(
        self,
        walk: 'Walk',
        name: str,
        item: Item,
        known: Mapping[str, Attribute],
        children: tuple[Entity, ...] = (),
        length: int = 1,
    ) -> None:
        self._walk = walk
        self._known = known
        self._values: dict[str, Value] = {}
        self.name = name
        self.item = item
        self.children = children
        self.length = length

    @classmethod
    def of_action(cls, walk: 'Walk', entity: Entity) -> 'Attributes':
        """Return those of an action."""
        action = entity.action
        return cls(
            walk,
            action.name,
            entity.item,
            by_name(action.attributes),
            entity.children,
            len(action.name),
        )

    def __contains__(self, name: str) -> bool:
        item = self.item
        return name in item.texts or name in item.lists or name in item.items

    @property
    def position(self) -> Position:
        """Where the action or item starts."""
        return self.item.position

    def check(self) -> None:
        """Check all attributes that are one text, but its conditions."""
        others = (Type.PLAIN, Type.COMMAND, Type.CONDITION)
        for name in self.item.texts:
            if self._known[name].type not in others:
                self.value(name)

    def plain(self, name: str) -> str:
        """Return a text without substitutions, which there must be."""
        return self.item.texts[name].plain

    def value(self, name: str) -> Value | None:
        """Return an attribute as text, None when it is left out."""
        text = self.item.texts.get(name)
        if text is None:
            return None
        value = self._values.get(name)
        if value is None:
            value = self._walk.value(text)
            self._values[name] = value
            attribute = self._known[name]
            if value.text is not None and _is_checked(attribute):
                self._check(attribute, value)
        return value

    def required(self, name: str) -> Value:
        """Return an attribute as text, which there must be."""
        value = self.value(name)
        assert value is not None
        return value

    def text(self, name: str) -> str | None:
        """Return a text; empty when it is left out and has no default."""
        text = self.item.texts.get(name)
        if text is None:
            return self._known[name].default or ''
        if text.literal is not None and not _is_checked(self._known[name]):
            return text.literal
        return self.required(name).text

    def boolean(self, name: str) -> bool | None:
        """Return a boolean."""
        return self._parsed(name, parse_boolean)

    def whole(self, name: str) -> int | None:
        """Return a whole number."""
        return self._parsed(name, _whole)

    def seconds(self, name: str) -> float | None:
        """Return a time in seconds."""
        return self._parsed(name, parse_seconds)

    def _parsed(self, name: str, parse: Callable[[str], _T]) -> _T | None:
        value = self.value(name)
        if value is None:
            return parse(self._known[name].default or '')
        return None if value.text is None else parse(value.text)

    def items(self, name: str) -> Sequence['Attributes']:
        """Return the items of a list."""
        items = self.item.items.get(name)
        if items is None:
            return ()
        known = by_name(items_of(self._known[name]))
        return [Attributes(self._walk, name, i, known) for i in items]

    def command(self, name: str) -> list[Word]:
        """Return a command line as arguments."""
        walk, texts = self._walk, self.item.lists.get(name)
        if texts is not None:
            return [Word(text, walk.value(text)) for text in texts]
        text = self.item.texts.get(name)
        if text is None:
            return []
        try:
            pieces = split_command_line(text.template)
        except UnclosedQuoteError as e:
            self.fail(
                name,
                f"'{name}' has a {e} that is not closed",
                'close it, or put it into quotes of the other kind',
            )
            # what was meant for the program is not known now
            return [Word(text, walk.value(text).forgotten())]
        return [
            Word(text, walk.template(piece, text.position_at))
            for piece in pieces
        ]

    def fail(
        self,
        name: str,
        message: str,
        hint: str | None = None,
        *,
        is_certain: bool = True,
        may_pass_after_build: bool = False,
    ) -> None:
        """Record an error in an attribute; see :meth:`Walk.fail`."""
        text = self.item.texts[name]
        value = self._values.get(name)
        self._walk.fail(
            error(
                message,
                text,
                hint=hint,
                may_pass_after_build=may_pass_after_build,
                origins=() if value is None else value.origins,
            ),
            is_certain=is_certain,
        )

    def fail_as_whole(self, message: str, hint: str | None = None) -> None:
        """Record an error in the action or item."""
        self._walk.fail(error(message, self, hint=hint))

    def _check(self, attribute: Attribute, value: Value) -> None:
        name, written = attribute.name, value.text or ''
        if attribute.type in _WANTED:
            parse, wanted, hint = _WANTED[attribute.type]
            if parse(written) is None:
                message = f"'{name}' wants {wanted}, not '{written}'"
                self.fail(name, message, hint)
        problem = attribute.choice_problem(written)
        if problem is not None:
            self.fail(name, *problem)


def _is_checked(attribute: Attribute) -> bool:
    """Return whether an attribute cannot have any text."""
    return bool(attribute.values) or attribute.type in _WANTED


def _whole(text: str) -> int | None:
    try:
        return int(text)
    except ValueError:
        return None


def parse_seconds(text: str) -> float | None:
    """Return the time in seconds that a text is, None when it is none."""
    try:
        seconds = float(text)
    except ValueError:
        return None
    return seconds if math.isfinite(seconds) and seconds >= 0 else None


_WANTED: Mapping[Type, tuple[Callable[[str], object], str, str | None]] = {
    Type.BOOLEAN: (parse_boolean, 'a boolean', 'write true or false'),
    Type.INTEGER: (_whole, 'a whole number', None),
    Type.SECONDS: (
        parse_seconds,
        'a number of seconds',
        'write a number >= 0',
    ),
}
