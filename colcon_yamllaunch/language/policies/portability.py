# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What ROS 2 does not accept, though it has a meaning here.

The rules are those of the parsers of `launch` and `launch_ros`: they take a
YAML value of one type for each attribute, and change no type into another.
"""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
import shlex

from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.launch_tree import Entity
from colcon_yamllaunch.language.syntax.launch_tree import Item
from colcon_yamllaunch.language.syntax.launch_tree import LaunchFile
from colcon_yamllaunch.language.syntax.text import Text
from colcon_yamllaunch.language.vocabulary.actions import Attribute
from colcon_yamllaunch.language.vocabulary.actions import by_name
from colcon_yamllaunch.language.vocabulary.actions import items_of
from colcon_yamllaunch.language.vocabulary.actions import Type
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
# ROS 2 reads these as a text, which it takes for a boolean afterwards
_TEXT_BOOLEANS = ('respawn', 'value')
# ROS 2 makes substitutions in these, and takes no other text
_SUBSTITUTED_BOOLEANS = ('autostart', 'cancel_on_shutdown', 'prepend')
# ROS 2 takes a text for these too, and makes its substitutions
_TEXT_SECONDS = ('period',)
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
        yield from _newer_action(entity)
        name = entity.action.name
        yield from _missing_names(name, entity.item, len(name))
        known = by_name(entity.action.attributes)
        since = entity.action.since
        yield from _item(entity.item, known, since, is_typed)
        if entity.action.name == 'set_parameter':
            yield from _yaml_text('set_parameter', entity.item, is_typed)


def _item(
    item: Item, known: Mapping[str, Attribute], since: str, is_typed: bool
) -> Iterator[LaunchError]:
    for name, text in item.texts.items():
        attribute = known[name]
        if is_typed:
            yield from _TYPE_RULES.get(attribute.type, _text)(name, text)
        if attribute.type is Type.COMMAND:
            yield from _quotes(text)
        yield from _newer_substitutions(text)
        yield from _newer_attribute(attribute, since, text)
    for name, texts in item.lists.items():
        yield from _list(name, texts)
    for value in item.values.values():
        for text in value.texts:
            yield from _newer_substitutions(text)
    for name, items in item.items.items():
        attribute = known[name]
        inner_known = by_name(items_of(attribute))
        if items:
            yield from _newer_attribute(attribute, since, items[0].position)
        for inner in items:
            yield from _missing_names(name, inner)
            if name == 'extra_arg':
                yield from _yaml_text(name, inner, is_typed)
            yield from _item(
                inner, inner_known, attribute.since or since, is_typed
            )


def _newer_action(entity: Entity) -> Iterator[LaunchError]:
    action = entity.action
    if action.since != OLDEST_RELEASE:
        yield error(
            f"ROS 2 has the action '{action.name}' since {action.since} only",
            entity.item.position,
            length=len(action.name),
        ).as_warning()


def _newer_attribute(
    attribute: Attribute, since: str, at: Span
) -> Iterator[LaunchError]:
    if attribute.since not in (None, OLDEST_RELEASE, since):
        yield error(
            f"ROS 2 has the attribute '{attribute.name}' since "
            f'{attribute.since} only',
            at,
        ).as_warning()


def _newer_substitutions(text: Text) -> Iterator[LaunchError]:
    for found in text.template.substitutions():
        # one of another package is as old as that
        kind = KINDS.get(found.name)
        since = OLDEST_RELEASE if kind is None else kind.since
        if since != OLDEST_RELEASE:
            yield error(
                f'ROS 2 has the substitution $({found.name} …) since {since} '
                'only',
                text.position_at(found.start),
                length=found.end - found.start,
            ).as_warning()


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


def _problem(text: Text, message: str, hint: str) -> Iterator[LaunchError]:
    yield error(message, text, hint=hint)


def _text(name: str, text: Text) -> Iterator[LaunchError]:
    if text.kind in _KIND_NAMES:
        yield from _problem(
            text,
            f"ROS 2 wants a text for '{name}', and YAML reads "
            f'{text.plain} as {_KIND_NAMES[text.kind]}',
            f"quote it: '{text.plain}'",
        )


def _boolean(name: str, text: Text) -> Iterator[LaunchError]:
    if name in _TEXT_BOOLEANS:
        yield from _text(name, text)
    elif text.kind == 'bool':
        return
    elif text.literal is not None:
        yield from _problem(
            text,
            f"ROS 2 wants a boolean for '{name}', and takes any "
            'text for true or for an error',
            'write true or false, without quotes',
        )
    elif name not in _SUBSTITUTED_BOOLEANS:
        yield from _problem(
            text,
            f"ROS 2 makes no substitutions in '{name}', and takes "
            'any text for true or for an error',
            "write true and false in two actions, one with 'if', one with "
            "'unless'",
        )


def _integer(name: str, text: Text) -> Iterator[LaunchError]:
    if name == 'len':
        yield from _text(name, text)
    elif text.kind != 'int':
        yield from _problem(
            text,
            f"ROS 2 wants a whole number for '{name}', and fails with a text",
            'write a number, without quotes or substitutions',
        )


def _seconds(name: str, text: Text) -> Iterator[LaunchError]:
    if text.kind == 'float':
        return
    if text.kind == 'int':
        yield from _problem(
            text,
            f"ROS 2 wants a number with a decimal point for '{name}'",
            f'write {text.plain}.0',
        )
    elif name not in _TEXT_SECONDS:
        yield from _problem(
            text,
            f"ROS 2 wants a number for '{name}', and fails with a text",
            'write it without quotes or substitutions, with a decimal point: '
            '2.0',
        )


_TYPE_RULES: Mapping[Type, Callable[[str, Text], Iterator[LaunchError]]] = {
    Type.BOOLEAN: _boolean,
    Type.INTEGER: _integer,
    Type.SECONDS: _seconds,
}


def _list(name: str, texts: tuple[Text, ...]) -> Iterator[LaunchError]:
    if texts:
        yield error(
            f"ROS 2 wants one text for '{name}', not a list",
            texts[0],
            hint=f'write one line: {shlex.join(t.plain for t in texts)}'
            if all(text.literal is not None for text in texts)
            else 'write the arguments in one line, with a space between',
        )
    for text in texts:
        yield from _newer_substitutions(text)


def _quotes(text: Text) -> Iterator[LaunchError]:
    # ROS 2 splits each text between substitutions by itself
    for part in text.template.parts:
        if not isinstance(part, str):
            continue
        try:
            shlex.split(part)
        except ValueError:
            yield from _problem(
                text,
                'in ROS 2 no quote of a command line spans a substitution',
                'remove the quotes: what a substitution gives is never split',
            )
            return


def _yaml_text(what: str, item: Item, is_typed: bool) -> Iterator[LaunchError]:
    value = item.values['value']
    if value.is_list:
        yield error(
            f"ROS 2 wants one text for the value of '{what}'",
            value.position,
            hint="quote the whole list: '[…]'",
        )
        return
    # in XML all is text
    if is_typed:
        yield from _text('value', value.texts[0])
