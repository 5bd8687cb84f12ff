# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whether the attributes of an action can have the values that they have."""

from collections.abc import Callable
from collections.abc import Iterable
from dataclasses import replace
import math

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.language.checking.check_state import Checking
from colcon_yamllaunch.language.checking.possible_scope import Value
from colcon_yamllaunch.language.checking.possible_values import value_of
from colcon_yamllaunch.language.checking.possible_values import value_of_part
from colcon_yamllaunch.language.syntax.command_line import split_command_line
from colcon_yamllaunch.language.syntax.command_line import UnclosedQuoteError
from colcon_yamllaunch.language.tree.launch_tree import Item
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.actions import Action
from colcon_yamllaunch.language.vocabulary.actions import ACTIONS
from colcon_yamllaunch.language.vocabulary.actions import Attribute
from colcon_yamllaunch.language.vocabulary.actions import Type
from colcon_yamllaunch.language.vocabulary.substitutions import parse_boolean

#: The attributes that decide whether an action is done.
CONDITIONS = ('if', 'unless')


def check_attributes(
    checking: Checking, action: Action, item: Item
) -> dict[str, Value]:
    """
    Check the attributes of an action that are one text, but its conditions.

    :returns: The values of those with substitutions, as far as they are known
    """
    known = attributes_of(action)
    values = {}
    for name, text in item.texts.items():
        attribute = known.get(name)
        if attribute is None or name in CONDITIONS:
            continue
        if attribute.type not in (Type.PLAIN, Type.COMMAND):
            values[name] = check_text(checking, attribute, text)
    return values


_ATTRIBUTES = {
    action.name: {attribute.name: attribute for attribute in action.attributes}
    for action in ACTIONS.values()
}


def attributes_of(action: Action) -> dict[str, Attribute]:
    """Return the attributes of an action by name."""
    return _ATTRIBUTES[action.name]


def check_text(checking: Checking, attribute: Attribute, text: Text) -> Value:
    """Check one attribute, and return its value as far as it is known."""
    value = value_of(checking, text)
    if value.text is None:
        return value
    problem = _PROBLEMS.get(attribute.type)
    if problem is not None:
        wanted = problem(value.text)
        if wanted is not None:
            checking.error(
                f"'{attribute.name}' wants {wanted}, not '{value.text}'",
                text.position,
                length=text.length,
            )
    elif attribute.values:
        _check_values(checking, attribute, text, value.text)
    return value


def _check_values(
    checking: Checking, attribute: Attribute, text: Text, value: str
) -> None:
    if value in attribute.values or (
        attribute.ignore_case and value.upper() in attribute.values
    ):
        return
    checking.error(
        f"'{attribute.name}' cannot be '{value}'",
        text.position,
        hint=did_you_mean(value, attribute.values)
        or f'it is one of {", ".join(attribute.values)}',
        length=text.length,
    )


def check_pairs(
    checking: Checking, items: Iterable[Item]
) -> list[tuple[Item, Value, Value]]:
    """Return the items of a list with their names and values."""
    return [
        (
            item,
            value_of(checking, item.texts['name']),
            value_of(checking, item.texts['value']),
        )
        for item in items
    ]


def check_command(
    checking: Checking, item: Item, name: str
) -> list[tuple[Text, Value]]:
    """Return the arguments of a command line, and the text each is in."""
    if name in item.lists:
        return [(text, value_of(checking, text)) for text in item.lists[name]]
    text = item.texts.get(name)
    if text is None:
        return []
    try:
        pieces = split_command_line(text.template)
    except UnclosedQuoteError as e:
        checking.error(
            f"'{name}' has a {e} that is not closed",
            text.position,
            hint='close it, or put it into quotes of the other kind',
            length=text.length,
        )
        # what was meant for the program is not known now
        return [(text, replace(value_of(checking, text), text=None))]
    return [(text, value_of_part(checking, text, piece)) for piece in pieces]


def truth(value: Value | None, default: bool) -> bool | None:
    """Return the boolean that a value is, None when it is not known."""
    if value is None:
        return default
    return None if value.text is None else parse_boolean(value.text)


def whole_number(value: Value | None) -> int | None:
    """Return the whole number that a value is, None when it is none."""
    if value is None or value.text is None:
        return None
    try:
        return int(value.text)
    except ValueError:
        return None


def _boolean_problem(text: str) -> str | None:
    return 'true or false' if parse_boolean(text) is None else None


def _integer_problem(text: str) -> str | None:
    try:
        int(text)
    except ValueError:
        return 'a whole number'
    return None


def _seconds_problem(text: str) -> str | None:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if math.isfinite(seconds) and seconds >= 0:
        return None
    return 'a number of seconds >= 0'


_PROBLEMS: dict[Type, Callable[[str], str | None]] = {
    Type.BOOLEAN: _boolean_problem,
    Type.INTEGER: _integer_problem,
    Type.SECONDS: _seconds_problem,
}
