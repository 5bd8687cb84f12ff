# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From a launch file to the tree of its actions."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
import re
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import (
    did_you_mean,
    listing,
    nearest,
    nearest_first,
    question,
)
from colcon_yamllaunch.language.evaluation.request import (
    FindExposed,
    NothingExposed,
)
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    error,
    LaunchError,
)
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.text import Text
from colcon_yamllaunch.language.syntax.yaml_reader import (
    Mapping,
    read_yaml,
    Scalar,
    Sequence,
    Value,
)
from colcon_yamllaunch.language.vocabulary.actions import (
    Action,
    ACTIONS,
    ALIASES,
    Attribute,
    by_name,
    COMPONENTS,
    CONDITIONS,
    items_of,
    PARAMETER,
    required_of,
    Type,
)
from colcon_yamllaunch.plan.position import Position, Span

if TYPE_CHECKING:
    from colcon_yamllaunch.language.python_files.exposed_actions import (
        RawEntity,
    )

#: How many actions are listed for one that does not exist.
NEAREST = 5

_RENAMING = 'from', 'to'
# attributes, by their names in ROS 1 and in ROS 2's Python launch files
_NAMES_ELSEWHERE = {
    'additional_env': 'env',
    'arguments': 'args',
    'composable_node_descriptions': 'composable_node',
    'environment': 'env',
    'executable': 'exec',
    'extra_arguments': 'extra_arg',
    'ns': 'namespace',
    'package': 'pkg',
    'parameters': 'param',
    'prefix': 'launch-prefix',
    'remappings': 'remap',
    'rosparam': 'param',
    'target_container': 'target',
    'type': 'exec',
}
_PYTHON = (
    r'^(from[ \t]+[\w.]+[ \t]+import\b|import[ \t]+[\w.]+|def[ \t]+\w+\()'
)


@dataclass(frozen=True, slots=True)
class Item:
    """
    The attributes of an action, or of an item in one of its lists.

    :param position: Where it starts
    :param texts: The attributes that are one text
    :param lists: The attributes that are a list of texts (a command line)
    :param values: The attributes that are a parameter's value
    :param items: The attributes that are a list of items
    :param raw: The action itself, if it is one of another package: then only
      its conditions are among the texts
    """

    position: Position
    texts: dict[str, Text]
    lists: dict[str, tuple[Text, ...]]
    values: 'dict[str, ParameterValue]'
    items: 'dict[str, tuple[Item, ...]]'
    raw: 'RawEntity | None' = None

    def own_texts(self) -> 'Iterator[Text]':
        """Return the texts of the attributes, but not those of items."""
        yield from self.texts.values()
        for texts in self.lists.values():
            yield from texts
        for value in self.values.values():
            yield from value.texts

    def every_text(self) -> 'Iterator[Text]':
        """Return all texts of the attributes, also those of items."""
        yield from self.own_texts()
        for items in self.items.values():
            for inner in items:
                yield from inner.every_text()
        if self.raw is not None:
            yield from self.raw.texts


@dataclass(frozen=True, slots=True)
class ParameterValue:
    """
    A parameter's value as it is written.

    :param texts: Its scalars
    :param is_list: Whether it is a list
    """

    position: Position
    texts: tuple[Text, ...]
    is_list: bool


@dataclass(frozen=True, slots=True)
class Entity:
    """
    An action in a launch file.

    :param action: Which action it is
    :param item: Its attributes
    :param children: The actions inside of it
    """

    action: Action
    item: Item
    children: 'tuple[Entity, ...]' = ()


#: Stands for the action of an entry that has mistakes.
UNREADABLE = Action('', 'Something that cannot be read.', ())


@dataclass(frozen=True, slots=True)
class LaunchFile:
    """
    A launch file as it is written.

    :param source: The file
    :param entities: Its actions; one with mistakes is :data:`UNREADABLE`
    :param deprecated: Why it should not be used any more, if so
    :param problems: The mistakes of single entries, and what is no mistake in
      ROS 2, but hardly meant
    """

    source: Source
    entities: tuple[Entity, ...]
    deprecated: str | None = None
    problems: tuple[Diagnostic, ...] = ()

    @property
    def has_mistakes(self) -> bool:
        """Whether it cannot be launched as it is."""
        return any(problem.severity == 'error' for problem in self.problems)

    def walk(self) -> Iterator[Entity]:
        """Iterate over all actions of the file, outer ones first."""
        pending = list(reversed(self.entities))
        while pending:
            entity = pending.pop()
            yield entity
            pending.extend(reversed(entity.children))


def read_launch_file(
    source: Source, exposed: FindExposed = NothingExposed
) -> LaunchFile:
    """
    Read a launch file, all but the entries that have mistakes.

    :param exposed: Returns the actions and substitutions of packages
    :raises LaunchError: when there is nothing in it that can be read
    """
    try:
        return _TreeReader(source, exposed).read()
    except LaunchError:
        found = re.search(_PYTHON, source.text, re.M)
        if found is None:
            raise
    raise error(
        'this launch file is written in Python, but its name says otherwise',
        source.position_at(found.start()),
        hint="let its name end in '.launch.py'",
    )


class _TreeReader:
    """Reads one file, and collects its mistakes."""

    def __init__(self, source: Source, exposed: FindExposed) -> None:
        self._source = source
        self._exposed = exposed
        self._problems: list[Diagnostic] = []

    def read(self) -> LaunchFile:
        if self._source.is_xml:
            # most launch files are in YAML
            from colcon_yamllaunch.language.syntax.xml_reader import (
                read_xml_document,
            )

            document: Value | None = read_xml_document(
                self._source, self._problems
            )
        else:
            document = read_yaml(self._source)
        value, position = self._root(document)
        deprecated = None
        if isinstance(value, Mapping):
            deprecated, value = self._root_mapping(value)
        entities = self._entities(value, "'launch:'", position)
        problems = tuple(sorted(self._problems, key=_place))
        return LaunchFile(self._source, entities, deprecated, problems)

    def _root(self, document: Value | None) -> tuple[Value, Position]:
        start = self._source.position(0, 0)
        hint = "a launch file starts with 'launch:' and a list of actions"
        if document is None:
            raise error('the launch file is empty', start, hint=hint)
        if not isinstance(document, Mapping):
            raise error(
                "there is no 'launch:' around the actions",
                document.position,
                hint=hint,
            )
        for name, (key, content) in document.pairs.items():
            if name != 'launch':
                if (
                    isinstance(content, Mapping)
                    and 'ros__parameters' in content.pairs
                ):
                    hint = (
                        'this is a parameter file: a node reads it by '
                        "'param: [{from: …}]'"
                    )
                raise error(
                    f"'{name}' stands where only 'launch' is known",
                    key,
                    hint=did_you_mean(name, ['launch']) or hint,
                )
        if 'launch' not in document.pairs:
            raise error('the launch file is empty', start, hint=hint)
        key, value = document.pairs['launch']
        return value, key.position

    def _root_mapping(self, root: Mapping) -> tuple[str | None, Value]:
        deprecated = None
        children: Value | None = None
        for name, (key, value) in root.pairs.items():
            if name == 'children':
                children = value
            elif name == 'deprecated' and isinstance(value, Scalar):
                deprecated = value.text
            else:
                hint = did_you_mean(name, ['children', 'deprecated'])
                if name in ACTIONS:
                    hint = 'put "- " before it: the actions are a list'
                raise error(
                    f"'launch' has no attribute '{name}'",
                    key,
                    hint=hint,
                )
        if children is None:
            raise error(
                "'launch' has no list of actions",
                root.position,
                hint="write the actions as a list: 'launch:', then '- node:'",
            )
        return deprecated, children

    def _entities(
        self, value: Value, what: str, position: Position
    ) -> tuple[Entity, ...]:
        if not isinstance(value, Sequence):
            is_empty = isinstance(value, Scalar) and value.kind == 'null'
            hint = 'put "- " before each action'
            self._report(
                f'{what} wants a list of actions',
                position if is_empty else value.position,
                "write '[]' if there are none" if is_empty else hint,
            )
            return ()
        return tuple([self._entity(item) for item in value.items])

    def _entity(self, value: Value) -> Entity:
        if not isinstance(value, Mapping) or not value.pairs:
            self._report(
                'an action is a name with attributes',
                value.position,
                'for example: node: {pkg: my_pkg, exec: my_node}',
            )
            return _unreadable(value.position)
        pairs = iter(value.pairs.items())
        name, (key, attributes) = next(pairs)
        for other, (other_key, _) in pairs:
            empty = (
                isinstance(attributes, Scalar) and attributes.kind == 'null'
            )
            hint = 'put "- " before it'
            if empty and name in ACTIONS:
                hint = f"indent it deeper than '{name}' if it is its attribute"
            message = f"'{other}' stands beside '{name}' in one list item"
            self._report(message, other_key, hint)
            return _unreadable(key.position)
        action = ACTIONS.get(ALIASES.get(name, name))
        if action is not None:
            return self._read_action(action, key, attributes)
        package = self._exposed().action(name)
        if package is not None:
            return self._read_exposed(package, key, attributes)
        if name in COMPONENTS:
            message = f"'{name}' is no action of its own"
            hint = "it stands in 'node_container' or 'load_composable_node'"
        else:
            message = f"unknown action '{name}'"
            known = [*ACTIONS, *self._exposed().actions()]
            near = ', '.join(nearest_first(name, known)[:NEAREST])
            hint = did_you_mean(name, known) or f'the nearest are {near}'
        self._report(message, key, hint)
        return _unreadable(key.position)

    def _read_exposed(self, package: str, key: Scalar, value: Value) -> Entity:
        """Read an action that another package has."""
        # most launch files have none
        from colcon_yamllaunch.language.python_files.exposed_actions import (
            read_exposed,
        )

        name, known = key.text, len(self._problems)
        conditions = Mapping(self._source, key.line, key.column)
        if isinstance(value, Mapping):
            for attribute in CONDITIONS:
                if attribute.name in value.pairs:
                    written = value.pairs[attribute.name]
                    conditions.pairs[attribute.name] = written
                    value = _without(value, attribute.name)
        item = self._item(f"'{name}'", CONDITIONS, key.position, conditions)
        self._check_conditions(item)
        try:
            raw = read_exposed(
                package, name, key.position, value, self._exposed
            )
        except LaunchError as e:
            self._problems.extend(e.diagnostics)
        if len(self._problems) > known:
            return _unreadable(key.position)
        help_text = f'An action of the package {package}.'
        action = Action(name, help_text, CONDITIONS)
        return Entity(action, replace(item, raw=raw))

    def _read_action(
        self, action: Action, key: Scalar, value: Value
    ) -> Entity:
        children: tuple[Entity, ...] | None = None
        if not action.has_children:
            pass
        elif isinstance(value, Sequence):
            children = self._entities(value, f"'{action.name}'", key.position)
            value = Mapping(self._source, value.line, value.column)
        elif isinstance(value, Mapping) and 'children' in value.pairs:
            inner_key, inner = value.pairs['children']
            children = self._entities(inner, "'children'", inner_key.position)
            value = _without(value, 'children')
        if not isinstance(value, Mapping):
            hint = 'indent them deeper than the action'
            if isinstance(value, Scalar) and '\u00a0' in value.text:
                hint = 'a no-break space stands in them; type it anew'
            self._report(f"'{action.name}' wants its attributes", key, hint)
            return _unreadable(key.position)
        known = len(self._problems)
        item = self._item(
            f"'{action.name}'",
            action.attributes,
            key.position,
            value,
            None if children is None else 'children',
        )
        self._check_conditions(item)
        if len(self._problems) > known:
            return _unreadable(key.position, children or ())
        return Entity(action, item, children or ())

    def _check_conditions(self, item: Item) -> None:
        if 'if' in item.texts and 'unless' in item.texts:
            self._report(
                "'if' and 'unless' exclude one another",
                item.texts['unless'].position,
                hint='join them with $(and … $(not …))',
            )

    def _item(
        self,
        what: str,
        known: tuple[Attribute, ...],
        position: Position,
        value: Mapping,
        done: str | None = None,
    ) -> Item:
        """
        Read the attributes of an action, or of an item in one of its lists.

        :param done: The attribute that was read before, if any
        """
        table = by_name(known)
        item = Item(position, {}, {}, {}, {})
        missing = [
            name
            for name in required_of(known)
            if name not in value.pairs and name != done
        ]
        for name, (key, attribute_value) in value.pairs.items():
            attribute = table.get(name)
            if attribute is not None:
                self._attribute(item, attribute, attribute_value)
            else:
                names = [other for other in table if other != done]
                first = self._item_above(known, value, name)
                if first is not None:
                    self._report(
                        f"{what} has no attribute '{name}'",
                        key,
                        f"indent it below '{first}'",
                    )
                    continue
                meant = _meant(name, missing) or _meant(name, names)
                # one mistake, one error
                missing = [other for other in missing if other != meant]
                self._report_unknown(
                    what, name, key, attribute_value, names, meant
                )
        for name in missing:
            self._report(
                f"{what} needs the attribute '{name}'",
                position,
                length=len(what) - 2,
            )
        return item

    def _item_above(
        self, known: tuple[Attribute, ...], value: Mapping, name: str
    ) -> str | None:
        """
        Return the first attribute of a list item that lacks one below it.

        That this one is missing there is said no more.

        :param name: The attribute, which is indented too little
        """
        table, names = by_name(known), list(value.pairs)
        before = names[: names.index(name)]
        above = next((n for n in reversed(before) if n in table), None)
        if above is None or table[above].type is not Type.ITEMS:
            return None
        items = value.pairs[above][1]
        last = items.items[-1] if isinstance(items, Sequence) else None
        if (
            not isinstance(last, Mapping)
            or name in last.pairs
            or name not in by_name(items_of(table[above]))
        ):
            return None
        self._problems = [
            problem
            for problem in self._problems
            if problem.position != last.position
            or ' needs ' not in problem.message
        ]
        return next(iter(last.pairs), None)

    def _report_unknown(
        self,
        what: str,
        name: str,
        key: Scalar,
        value: Value,
        known: list[str],
        meant: str | None,
    ) -> None:
        hint = question(meant)
        if isinstance(value, Scalar) and value.kind == 'null' and not hint:
            hint = "quote a value that has a ',' in it"
        if name == 'autostart':
            hint = "'lifecycle_node' and 'composable_lifecycle_node' have it"
        if hint is None and known:
            hint = f'the attributes are {listing(known)}'
        self._report(f"{what} has no attribute '{name}'", key, hint)

    def _attribute(
        self, item: Item, attribute: Attribute, value: Value
    ) -> None:
        try:
            if attribute.type is Type.ITEMS:
                self._read_items(item, attribute, value)
            elif attribute.type is Type.VALUE:
                item.values[attribute.name] = _read_value(value, self._exposed)
            elif attribute.type is Type.COMMAND and isinstance(
                value, Sequence
            ):
                item.lists[attribute.name] = tuple(
                    _read_text(attribute, v, self._exposed)
                    for v in value.items
                )
            else:
                item.texts[attribute.name] = _read_text(
                    attribute, value, self._exposed
                )
        except LaunchError as e:
            self._problems.extend(e.diagnostics)

    def _read_items(
        self, item: Item, attribute: Attribute, value: Value
    ) -> None:
        known = items_of(attribute)
        if not isinstance(value, Sequence) or not value.items:
            hint = 'put "- " before each item'
            if isinstance(value, Mapping):
                if len(value.pairs) > 1:
                    hint = (
                        f'put "- " before \'{next(iter(value.pairs))}\', and '
                        'two spaces before each line below it'
                    )
                hint = self._as_pairs(value, known) or hint
            raise error(
                f"'{attribute.name}' is a list, one item for each",
                value.position,
                hint=hint,
            )
        names = listing(a.name for a in known)
        found = []
        for element in value.items:
            if not isinstance(element, Mapping):
                hint = f'its attributes are {names}'
                if len(known) == 1 and isinstance(element, Scalar):
                    hint = f'write {{{names}: {element.text}}}'
                raise error(
                    f"an item of '{attribute.name}' is a mapping",
                    element.position,
                    hint=hint,
                )
            pairs = self._as_pairs(element, known)
            if pairs is not None:
                name, (key, _) = next(iter(element.pairs.items()))
                meant = did_you_mean(name, by_name(known))
                self._report(
                    f"'{attribute.name}' has no attribute '{name}'",
                    key,
                    pairs if meant is None else f'{meant} Or {pairs}',
                )
                continue
            found.append(
                self._item(
                    f"'{attribute.name}'", known, element.position, element
                )
            )
            # an attribute that there is not is reported before
            if (
                known is PARAMETER
                and element.pairs.keys() <= by_name(known).keys()
            ):
                # also the names whose values have mistakes of their own
                problem = parameter_problem(set(element.pairs))
                if problem is not None:
                    self._report(problem[0], element.position, problem[1])
            self._check_conditions(found[-1])
        item.items[attribute.name] = tuple(found)

    def _as_pairs(
        self, written: Mapping, known: tuple[Attribute, ...]
    ) -> str | None:
        """Return how to write `period: 0.5` as an item, if it is one."""
        names = by_name(known).keys()
        first, second = ('name', 'value') if 'name' in names else _RENAMING
        is_pair = second in names and names.isdisjoint(written.pairs)
        if not is_pair or not written.pairs:
            return None
        name, (_, value) = next(iter(written.pairs.items()))
        text = '…'
        if isinstance(value, Scalar) and value.style in (None, '"', "'"):
            text = value.text
        more = ', and so for each' if len(written.pairs) > 1 else ''
        if self._source.is_xml:
            return f'write {first}="{name}" {second}="{text}"{more}'
        if isinstance(value, Scalar) and value.style and text != '…':
            text = f'{value.style}{text}{value.style}'
        return (
            f"write '- {first}: {name}', and '{second}: {text}' below "
            f"'{first}'{more}"
        )

    def _report(
        self,
        message: str,
        at: Span,
        hint: str | None = None,
        length: int | None = None,
    ) -> None:
        problem = error(message, at, hint=hint, length=length)
        self._problems.extend(problem.diagnostics)


def _unreadable(
    position: Position, children: tuple[Entity, ...] = ()
) -> Entity:
    return Entity(UNREADABLE, Item(position, {}, {}, {}, {}), children)


def _meant(name: str, known: Iterable[str]) -> str | None:
    """Return the attribute that is meant by one that does not exist."""
    elsewhere = _NAMES_ELSEWHERE.get(name, name)
    return elsewhere if elsewhere in known else nearest(name, known)


def _without(value: Mapping, name: str) -> Mapping:
    # a copy, since an alias may name the same mapping
    rest = Mapping(value.source, value.line, value.column)
    rest.pairs = {n: p for n, p in value.pairs.items() if n != name}
    return rest


def _place(problem: Diagnostic) -> tuple[int, int]:
    position = problem.position
    return (0, 0) if position is None else (position.line, position.column)


def parameter_problem(names: set[str]) -> tuple[str, str] | None:
    """Return what is wrong with a parameter's attributes, and the way out."""
    if 'from' in names:
        others = names - {'from', 'allow_substs'}
        if others:
            return (
                f"a parameter with 'from' takes no '{min(others)}'",
                'make it an item of its own',
            )
        return None
    if 'name' not in names:
        return ("a parameter needs 'name', or 'from' with a file", 'name it')
    if 'allow_substs' in names:
        return ("'allow_substs' goes with 'from'", 'remove it')
    if 'param' in names and names & {'value', 'type'}:
        return (
            "a parameter has either 'value' or 'param'",
            "put the value among those of 'param', with a name",
        )
    if not names & {'param', 'value'}:
        return ("a parameter needs a 'value'", "write '' for an empty text")
    return None


def _read_text(
    attribute: Attribute, value: Value, exposed: FindExposed
) -> Text:
    if not isinstance(value, Scalar):
        raise error(
            f"'{attribute.name}' is a text, not a list or mapping",
            value.position,
            hint='quote a text that starts with { or [',
        )
    if value.kind == 'null' and value.text in ('', '~', 'null'):
        raise error(
            f"'{attribute.name}' has no value",
            value.position,
            hint="write '' for an empty text",
        )
    if attribute.type is Type.NAME and value.kind == 'bool':
        raise error(
            f"YAML reads {value.text} as a boolean, but '{attribute.name}' "
            'is a name',
            value,
            hint=f"quote it: '{value.text}'",
        )
    text = Text(value, plain=attribute.type is Type.PLAIN, exposed=exposed)
    problem = None
    if attribute.type is Type.PLAIN:
        problem = attribute.choice_problem(text.plain)
    if problem is not None:
        message, hint = problem
        raise error(message, text.position, hint=hint, length=len(text.plain))
    return text


def _read_value(value: Value, exposed: FindExposed) -> ParameterValue:
    if isinstance(value, Scalar):
        return ParameterValue(
            value.position, (_scalar_text(value, exposed),), False
        )
    if isinstance(value, Sequence):
        texts = []
        for element in value.items:
            if not isinstance(element, Scalar):
                raise error(
                    "a parameter's list has scalars in it, no lists or "
                    'mappings',
                    element.position,
                )
            texts.append(_scalar_text(element, exposed))
        return ParameterValue(value.position, tuple(texts), True)
    raise error(
        "a parameter's value is a scalar or a list",
        value.position,
        hint="nest parameters with 'param:' instead of 'value:', or quote "
        "a text that starts with '{'",
    )


def _scalar_text(value: Scalar, exposed: FindExposed) -> Text:
    if value.kind == 'null':
        raise error(
            'a parameter cannot be null',
            value.position,
            hint="write '' for an empty text",
        )
    if value.kind == 'timestamp':
        raise error(
            f'YAML reads {value.text} as a date, and no parameter is a date',
            value.position,
            hint='quote it',
        )
    return Text(value, plain=value.kind != 'str', exposed=exposed)
