# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What ROS 2 does not accept, though it has a meaning here.

The rules are those of the parsers of `launch` and `launch_ros`: they take a
YAML value of one type for each attribute, and change no type into another.
"""

from collections.abc import Iterator, Mapping
import shlex

from colcon_yamllaunch.language.syntax.diagnostics import error, LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import Item, LaunchFile
from colcon_yamllaunch.language.syntax.text import Text
from colcon_yamllaunch.language.vocabulary.actions import (
    Attribute,
    by_name,
    items_of,
    Type,
)
from colcon_yamllaunch.language.vocabulary.substitutions import KINDS
from colcon_yamllaunch.plan.position import Span

#: The release that has all actions, attributes and substitutions but those
#: that say otherwise.
OLDEST_RELEASE = 'Humble'

# what has to have a name, or a namespace, in ROS 2
_WANTED_NAMES: Mapping[str, tuple[str, ...]] = {
    'node_container': ('name', 'namespace'),
    'lifecycle_node': ('namespace',),
    'composable_node': ('name',),
    'composable_lifecycle_node': ('name',),
}
# what is a text in ROS 2, though it has another type here
_TEXTS = ('respawn', 'value', 'len')
_TYPED = (Type.BOOLEAN, Type.INTEGER, Type.SECONDS)
_VALUE = Attribute('value', Type.TEXT, '')
# ROS 2 reads these as a text, which it takes for a boolean afterwards
_SUBSTITUTED_BOOLEANS = ('autostart', 'cancel_on_shutdown', 'prepend')
_KIND_NAMES = {
    'bool': 'a boolean',
    'float': 'a number',
    'int': 'a number',
    'null': 'nothing',
    'timestamp': 'a date',
}


def not_portable(file: LaunchFile) -> Iterator[LaunchError]:
    """Report what ROS 2's own launcher does not accept in a launch file."""
    # in XML all values are texts, which ROS 2 reads as the type it wants
    is_typed = not file.source.is_xml
    for entity in file.walk():
        action, item = entity.action, entity.item
        name, length = action.name, len(action.name)
        yield from _newer(
            f"action '{name}'", action.since, item.position, length
        )
        yield from _missing_names(name, item, length)
        yield from _item(
            item, by_name(action.attributes), action.since, is_typed
        )
        if name == 'set_parameter':
            yield from _yaml_text(name, item, is_typed)


def _item(
    item: Item, known: Mapping[str, Attribute], since: str, is_typed: bool
) -> Iterator[LaunchError]:
    for text in item.own_texts():
        for found in text.template.substitutions():
            # one of another package is as old as that
            kind = KINDS.get(found.name)
            yield from _newer(
                f'substitution $({found.name} …)',
                None if kind is None else kind.since,
                text.position_at(found.start),
                found.end - found.start,
            )
    for name, text in item.texts.items():
        attribute = known[name]
        if is_typed:
            yield from _wrong_type(attribute, text)
        if attribute.type is Type.COMMAND:
            yield from _quotes(text)
        if attribute.since != since:
            yield from _newer(f"attribute '{name}'", attribute.since, text)
    for name, texts in item.lists.items():
        yield from _list(name, texts)
    for name, items in item.items.items():
        attribute = known[name]
        if items and attribute.since != since:
            at = items[0].position
            yield from _newer(f"attribute '{name}'", attribute.since, at)
        for inner in items:
            yield from _missing_names(name, inner)
            if name == 'extra_arg':
                yield from _yaml_text(name, inner, is_typed)
            yield from _item(
                inner,
                by_name(items_of(attribute)),
                attribute.since or since,
                is_typed,
            )


def _newer(
    what: str, since: str | None, at: Span, length: int | None = None
) -> Iterator[LaunchError]:
    if since not in (None, OLDEST_RELEASE):
        message = f'ROS 2 has the {what} since {since} only'
        yield error(message, at, length=length).as_warning()


def _missing_names(
    what: str, item: Item, length: int = 1
) -> Iterator[LaunchError]:
    for name in _WANTED_NAMES.get(what, ()):
        if name not in item.texts:
            yield error(
                f"ROS 2 wants a '{name}' for '{what}'",
                item.position,
                hint=f"add it, '{name}: /' for none"
                if name == 'namespace'
                else 'add it',
                length=length,
            )


def _wrong_type(attribute: Attribute, text: Text) -> Iterator[LaunchError]:
    name, kind = attribute.name, text.kind
    problem = None
    if attribute.type not in _TYPED or name in _TEXTS:
        if kind in _KIND_NAMES:
            problem = (
                f"ROS 2 wants a text for '{name}', and YAML reads "
                f'{text.plain} as {_KIND_NAMES[kind]}',
                f"quote it: '{text.plain}'",
            )
    elif attribute.type is Type.BOOLEAN:
        if kind != 'bool' and text.literal is not None:
            problem = (
                f"ROS 2 wants a boolean for '{name}', and takes any text for "
                'true or for an error',
                'write true or false, without quotes',
            )
        elif kind != 'bool' and name not in _SUBSTITUTED_BOOLEANS:
            problem = (
                f"ROS 2 makes no substitutions in '{name}', and takes any "
                'text for true or for an error',
                "write true and false in two actions, one with 'if', one with "
                "'unless'",
            )
    elif attribute.type is Type.INTEGER:
        if kind != 'int':
            problem = (
                f"ROS 2 wants a whole number for '{name}', and fails with a "
                'text',
                'write a number, without quotes or substitutions',
            )
    elif kind == 'int':
        problem = (
            f"ROS 2 wants a number with a decimal point for '{name}'",
            f'write {text.plain}.0',
        )
    elif kind != 'float' and name != 'period':
        problem = (
            f"ROS 2 wants a number for '{name}', and fails with a text",
            'write it without quotes or substitutions, with a decimal point: '
            '2.0',
        )
    if problem is not None:
        yield error(problem[0], text, hint=problem[1])


def _list(name: str, texts: tuple[Text, ...]) -> Iterator[LaunchError]:
    if texts:
        yield error(
            f"ROS 2 wants one text for '{name}', not a list",
            texts[0],
            hint=f'write one line: {shlex.join(t.plain for t in texts)}'
            if all(text.literal is not None for text in texts)
            else 'write the arguments in one line, with a space between',
        )


def _quotes(text: Text) -> Iterator[LaunchError]:
    # ROS 2 splits each text between substitutions by itself
    try:
        for part in text.template.parts:
            if isinstance(part, str):
                shlex.split(part)
    except ValueError:
        yield error(
            'in ROS 2 no quote of a command line spans a substitution',
            text,
            hint='remove the quotes: what a substitution gives is never split',
        )


def _yaml_text(what: str, item: Item, is_typed: bool) -> Iterator[LaunchError]:
    value = item.values['value']
    if value.is_list:
        yield error(
            f"ROS 2 wants one text for the value of '{what}'",
            value.position,
            hint="quote the whole list: '[…]'",
        )
    elif is_typed:
        yield from _wrong_type(_VALUE, value.texts[0])
