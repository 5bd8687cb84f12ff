# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
An action of another package, as a launch file writes it.

What its attributes mean, and whether it has them, only that package knows.
"""

from collections.abc import Callable
from collections.abc import Iterator
from contextlib import suppress
from typing import Any
from typing import TypeGuard

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.xml_scalar import XmlScalar
from colcon_yamllaunch.language.syntax.yaml_reader import Mapping
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar
from colcon_yamllaunch.language.syntax.yaml_reader import Sequence
from colcon_yamllaunch.language.syntax.yaml_reader import Value
from colcon_yamllaunch.language.tree.text import Text
from colcon_yamllaunch.language.vocabulary.package_lookup import FindExposed
from colcon_yamllaunch.plan.position import Position

_CHILDREN = 'children'


@dataclass(frozen=True, slots=True)
class RawEntity:
    """
    An action, or an item in one of its lists, with nothing evaluated.

    :param type: The name of the action, or of the list
    :param package: The package that has it, or the action that it stands in
    :param attributes: A scalar, or a list of these and of items, each
    :param children: What stands inside; None when there is no place for it
    :param position: Where it starts
    :param written: The attributes that YAML takes no text for, as texts
    :param texts: Its texts as far as they are well-formed, those inside too
    """

    type: str
    package: str
    attributes: dict[str, Any]
    children: 'tuple[RawEntity, ...] | None'
    position: Position
    written: dict[str, str]
    texts: tuple[Text, ...]

    def message(self, prepare: Callable[[str], str]) -> dict[str, Any]:
        """
        Return it as the host of launch files in Python takes it.

        :param prepare: Makes a text what the host is to have
        """
        position = self.position
        return {
            'type': self.type,
            'attributes': {
                name: _plain(value, prepare)
                for name, value in self.attributes.items()
            },
            'texts': self.written,
            'children': _plain(self.children, prepare),
            'position': [position.path, position.line, position.column],
        }


def _plain(value: Any, prepare: Callable[[str], str]) -> Any:
    if isinstance(value, RawEntity):
        return value.message(prepare)
    if isinstance(value, list | tuple):
        return [_plain(item, prepare) for item in value]
    return prepare(value) if isinstance(value, str) else value


class RawReader:
    """
    Reads what an action of another package has.

    :param package: The package that has it
    :param exposed: Gives the substitutions that packages bring
    """

    def __init__(self, package: str, exposed: FindExposed) -> None:
        self._package = package
        self._exposed = exposed

    def read(self, name: str, at: Position, value: Value) -> RawEntity:
        """
        Read an action, or an item of a list.

        :param at: Where it starts
        :param value: What stands behind its name
        :raises LaunchError: when no attribute can be like that
        """
        texts: list[Text] = []
        attributes: dict[str, Any] = {}
        as_text: dict[str, str] = {}
        children: Value | None = None
        if isinstance(value, Mapping):
            for key, (_, written) in value.pairs.items():
                if key == _CHILDREN:
                    children = written
                else:
                    attributes[key] = self._attribute(key, written, texts)
                    if _is_of_yaml(written):
                        as_text[key] = written.text
        elif isinstance(value, Sequence):
            children = value
        elif not isinstance(value, Scalar) or value.kind != 'null':
            raise error(
                f"'{name}' has attributes or a list of actions, and no text",
                value.position,
                hint='write its attributes below it, indented deeper',
            )
        inside = None
        if children is not None:
            inside = tuple(self._children(name, children))
            texts += [text for child in inside for text in child.texts]
        return RawEntity(
            name,
            self._package,
            attributes,
            inside,
            at,
            as_text,
            tuple(texts),
        )

    def _attribute(self, name: str, value: Value, texts: list[Text]) -> Any:
        if isinstance(value, Sequence):
            return [self._item(name, item, texts) for item in value.items]
        if not isinstance(value, Scalar):
            raise error(
                f"'{name}' cannot be a mapping",
                value.position,
                hint='quote a text that starts with {, or put "- " before '
                'each item of a list',
            )
        return self._scalar(value, texts)

    def _item(self, name: str, value: Value, texts: list[Text]) -> Any:
        if isinstance(value, Scalar):
            return self._scalar(value, texts)
        item = self.read(name, value.position, value)
        texts += item.texts
        return item

    def _scalar(self, value: Scalar, texts: list[Text]) -> Any:
        is_null = value.kind == 'null' and not isinstance(value, XmlScalar)
        if is_null or _is_of_yaml(value):
            return value.value
        with suppress(LaunchError):
            # it may be a text that no substitutions are made in
            texts.append(Text(value, exposed=self._exposed))
        return value.text

    def _children(self, name: str, value: Value) -> Iterator[RawEntity]:
        items = value.items if isinstance(value, Sequence) else [value]
        for item in items:
            if not isinstance(item, Mapping) or len(item.pairs) != 1:
                raise error(
                    f"what stands in '{name}' is a list of names with "
                    'attributes',
                    item.position,
                    hint='put "- " before each',
                )
            for inner, (key, attributes) in item.pairs.items():
                yield self.read(inner, key.position, attributes)


def _is_of_yaml(value: Value) -> TypeGuard[Scalar]:
    """Say whether YAML takes a value for something that is no text."""
    return (
        isinstance(value, Scalar)
        and not isinstance(value, XmlScalar)
        and value.kind not in ('str', 'timestamp', 'null')
    )
