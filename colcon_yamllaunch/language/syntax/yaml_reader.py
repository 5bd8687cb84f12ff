# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""YAML 1.1 with the position of every value."""

from collections.abc import Callable
import re
from typing import Any, Literal

from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.position import Position
import yaml

#: How deep lists and mappings may be nested.
MAXIMUM_DEPTH = 200
#: How many values a file may have once its aliases are expanded.
MAXIMUM_VALUES = 1_000_000

_PREFIX = 'tag:yaml.org,2002:'
_PROPERTIES = re.compile(r'(?:[&!]\S*\s+)*')
_BLOCK_HEADER = re.compile(r'[|>][^\n]*\n')
# what one or more characters of a text in double quotes are written as
_DOUBLE_QUOTED = r"""
    (?P<continuation>\\\r?\n(?:[ \t]*\r?\n)*[ \t]*)
    |\\(?:x[0-9A-Fa-f]{2}|u[0-9A-Fa-f]{4}|U[0-9A-Fa-f]{8}|.)
    |(?P<folding>[ \t]*\r?\n(?:[ \t]*\r?\n)*[ \t]*)
    |.
    """
_Loader: Any = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)

Kind = Literal['str', 'int', 'float', 'bool', 'null', 'timestamp', 'merge']


class Value:
    """A value in a YAML file."""

    __slots__ = ('column', 'line', 'size', 'source')

    def __init__(self, source: Source, line: int, column: int) -> None:
        self.source = source
        self.line = line
        self.column = column
        self.size = 1

    @property
    def position(self) -> Position:
        """The position of its first character."""
        return self.source.position(self.line, self.column)


class Scalar(Value):
    """
    A text, number, boolean or nothing.

    :param text: The scalar as YAML reads it, before any type is seen in it
    :param style: None when plain, else the character that starts it
    :param tag: The tag that is written with it, if any
    :param end: The line and column behind it, counted from 0
    """

    __slots__ = ('_kind', 'end', 'style', 'tag', 'text')

    #: Whether the type that is wanted decides what the text is, as in XML.
    is_of_xml = False

    def __init__(
        self,
        source: Source,
        line: int,
        column: int,
        text: str,
        style: str | None = None,
        tag: str | None = None,
        end: tuple[int, int] | None = None,
    ) -> None:
        super().__init__(source, line, column)
        self.text = text
        self.style = style
        self.tag = tag
        self.end = end or (line, column + len(text))
        self._kind: Kind | None = None

    @property
    def kind(self) -> Kind:
        """What YAML 1.1 takes the scalar for."""
        if self._kind is None:
            self._kind = _resolve(self)
        return self._kind

    @property
    def length(self) -> int:
        """How many characters its text has."""
        return len(self.text)

    @property
    def value(self) -> str | int | float | bool | None:
        """The scalar as a Python object; a timestamp stays a text."""
        return construct(self.kind, self.text)

    def locate(self, index: int) -> int:
        """Return where a character of the text is in the file."""
        raw = self.source.text
        at = self.source.index_of(self.line, self.column)
        properties = _PROPERTIES.match(raw, at)
        at = properties.end() if properties else at
        if self.style in ('|', '>'):
            header = _BLOCK_HEADER.match(raw, at)
            at = header.end() if header else at
        elif self.style:
            at += 1
        if self.style == '"':
            return _locate_in_double_quotes(raw, at, index)
        for character in self.text[:index]:
            at = _step(raw, at, character, self.style)
        return _skip_folding(raw, at, self.text[index : index + 1])


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


class Sequence(Value):
    """A list."""

    __slots__ = ('items',)

    def __init__(self, source: Source, line: int, column: int) -> None:
        super().__init__(source, line, column)
        self.items: list[Value] = []


class Mapping(Value):
    """A mapping; its keys are scalars and unique."""

    __slots__ = ('merged', 'pairs')

    def __init__(self, source: Source, line: int, column: int) -> None:
        super().__init__(source, line, column)
        self.pairs: dict[str, tuple[Scalar, Value]] = {}
        self.merged: list[Mapping] = []


def construct(kind: Kind, text: str) -> str | int | float | bool | None:
    """
    Return the Python object for a scalar.

    :raises ValueError: when the text is no value of that kind
    """
    if kind in ('str', 'timestamp', 'merge'):
        return text
    make = _CONSTRUCTORS[_PREFIX + kind]
    node = yaml.ScalarNode(_PREFIX + kind, text)
    result: str | int | float | bool | None = make(_CONSTRUCTOR, node)
    return result


def read_yaml(source: Source) -> Value | None:
    """
    Return the one document of a file, None when it has none.

    :raises LaunchError: when it is not YAML, has duplicate keys or exceeds a
      limit
    """
    return _Reader(source).read()


_CONSTRUCTOR = yaml.constructor.SafeConstructor()
_CONSTRUCTORS = yaml.constructor.SafeConstructor.yaml_constructors
_RESOLVERS = yaml.SafeLoader.yaml_implicit_resolvers


def plain_kind(text: str) -> Kind:
    """Return what YAML 1.1 takes a plain scalar with this text for."""
    for tag, pattern in _RESOLVERS.get(text[:1], ()):
        if pattern.match(text):
            kind: Kind = tag[len(_PREFIX) :]
            return 'str' if kind not in _KINDS else kind
    return 'str'


_KINDS = ('int', 'float', 'bool', 'null', 'timestamp', 'merge')


def _resolve(scalar: Scalar) -> Kind:
    if scalar.tag is None or scalar.tag == '!':
        if scalar.style is None and scalar.tag is None:
            return plain_kind(scalar.text)
        return 'str'
    prefix, _, name = scalar.tag.rpartition(':')
    if f'{prefix}:' != _PREFIX or name not in (*_KINDS, 'str'):
        message = f"the YAML tag '{scalar.tag}' is not known"
        raise error(message, scalar.position)
    kind: Kind = name  # type: ignore[assignment]
    try:
        construct(kind, scalar.text)
    except (ValueError, KeyError, IndexError) as e:
        message = f"'{scalar.text}' is no value for the tag !!{kind}"
        raise error(message, scalar.position) from e
    return kind


class _Reader:
    """Builds the values of one file from the parser's events."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._anchors: dict[str, Value] = {}
        self._open: list[tuple[Value, Scalar | None]] = []
        self._open_anchors: list[str | None] = []
        self._root: Value | None = None
        self._documents = 0

    def read(self) -> Value | None:
        visitors: dict[type, Callable[[Any], None]] = {
            yaml.ScalarEvent: self._scalar,
            yaml.MappingStartEvent: self._start,
            yaml.SequenceStartEvent: self._start,
            yaml.MappingEndEvent: self._end,
            yaml.SequenceEndEvent: self._end,
            yaml.AliasEvent: self._alias,
            yaml.DocumentStartEvent: self._document,
        }
        loader = None
        try:
            loader = _Loader(self._source.text)
            while True:
                event = loader.get_event()
                visit = visitors.get(type(event))
                if visit is not None:
                    visit(event)
                elif isinstance(event, yaml.StreamEndEvent):
                    return self._root
        except yaml.YAMLError as e:
            # most launch files have no mistakes
            from colcon_yamllaunch.language.syntax.errors import explain_yaml

            raise explain_yaml(e, self._source) from e
        finally:
            if loader is not None:
                loader.dispose()

    def _document(self, event: Any) -> None:
        self._documents += 1
        if self._documents > 1:
            mark = event.start_mark
            raise error(
                f'a {self._source.kind} has one YAML document; a second one '
                'starts here',
                self._source.position(mark.line, mark.column),
                hint="remove the line '---', or put the second document into "
                'a file of its own and include it',
                length=3,
            )

    def _scalar(self, event: Any) -> None:
        start, end = event.start_mark, event.end_mark
        scalar = Scalar(
            self._source,
            start.line,
            start.column,
            event.value,
            event.style or None,
            event.tag,
            (end.line, end.column),
        )
        if event.anchor is not None:
            self._anchors[event.anchor] = scalar
        self._put(scalar)

    def _start(self, event: Any) -> None:
        mark = event.start_mark
        value: Value
        if isinstance(event, yaml.MappingStartEvent):
            value = Mapping(self._source, mark.line, mark.column)
            allowed = 'map'
        else:
            value = Sequence(self._source, mark.line, mark.column)
            allowed = 'seq'
        if event.tag not in (None, '!', _PREFIX + allowed):
            raise error(
                f"the YAML tag '{event.tag}' is not known", value.position
            )
        if len(self._open) >= MAXIMUM_DEPTH:
            raise error(
                f'nested more than {MAXIMUM_DEPTH} levels deep',
                value.position,
            )
        self._open.append((value, None))
        self._open_anchors.append(event.anchor)

    def _end(self, _event: Any) -> None:
        value, _ = self._open.pop()
        anchor = self._open_anchors.pop()
        if isinstance(value, Mapping):
            # what is written here wins over what is merged, an earlier merge
            # over a later one (https://yaml.org/type/merge.html)
            for other in value.merged:
                for name, pair in other.pairs.items():
                    value.pairs.setdefault(name, pair)
        if anchor is not None:
            self._anchors[anchor] = value
        self._put(value)

    def _alias(self, event: Any) -> None:
        mark = event.start_mark
        position = self._source.position(mark.line, mark.column)
        length = len(event.anchor) + 1
        if event.anchor in self._open_anchors:
            raise error(
                f"the alias '*{event.anchor}' stands inside of what it names",
                position,
                length=length,
            )
        try:
            value = self._anchors[event.anchor]
        except KeyError:
            raise error(
                f"the alias '*{event.anchor}' names no anchor",
                position,
                hint=f"quote the text if '*{event.anchor}' is no alias",
                length=length,
            ) from None
        self._put(value)

    def _put(self, value: Value) -> None:
        if not self._open:
            self._root = value
            return
        parent, key = self._open[-1]
        parent.size += value.size
        if parent.size > MAXIMUM_VALUES:
            raise error(
                f'the file has more than {MAXIMUM_VALUES} values once its '
                'aliases are expanded',
                parent.position,
            )
        if isinstance(parent, Sequence):
            parent.items.append(value)
        elif key is None:
            if not isinstance(value, Scalar):
                raise error(
                    'a list or mapping stands where a name is meant',
                    value.position,
                    hint='quote a text that starts with { or [',
                )
            self._open[-1] = (parent, value)
        else:
            assert isinstance(parent, Mapping)
            _add_pair(parent, key, value)
            self._open[-1] = (parent, None)


def _add_pair(mapping: Mapping, key: Scalar, value: Value) -> None:
    if key.style is None and key.tag is None and key.text == '<<':
        for item in value.items if isinstance(value, Sequence) else [value]:
            if not isinstance(item, Mapping):
                raise error(
                    "'<<' takes a mapping or a list of them", item.position
                )
            mapping.merged.append(item)
        return
    if key.text in mapping.pairs:
        first = mapping.pairs[key.text][0]
        raise error(
            f"the key '{key.text}' stands twice in this mapping, first in "
            f'line {first.line + 1}',
            key,
            hint='remove one, or start a new list item with "-"',
        )
    mapping.pairs[key.text] = (key, value)


#: How many values a text may have once its aliases are expanded: whoever
#: shows or merges them expands them.
MAXIMUM_EXPANDED = 100_000


class UnusableYamlError(Exception):
    """A text is no YAML, or such that nobody can use it; says why."""


def load_yaml(text: str) -> Any:
    """
    Return what PyYAML makes of a text.

    :raises UnusableYamlError: when it is not YAML, or exceeds a limit
    """
    loader = None
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
        # without aliases a text has fewer values than characters
        if '*' in text and '&' in text and _size(node, {}) > MAXIMUM_EXPANDED:
            raise UnusableYamlError(
                f'it has more than {MAXIMUM_EXPANDED} values once its aliases '
                'are expanded'
            )
        return None if node is None else loader.construct_document(node)
    except RecursionError as e:
        raise UnusableYamlError('it is nested too deep') from e
    except (yaml.YAMLError, ValueError, LookupError, OverflowError) as e:
        # a scalar with a tag that it does not fit fails in its own way
        raise UnusableYamlError(str(e).split('\n', 1)[0]) from e
    finally:
        if loader is not None:
            loader.dispose()


def _size(node: yaml.Node | None, sizes: dict[int, int]) -> int:
    """
    Return the number of values of a node with its aliases expanded.

    :param sizes: The results so far, by the identity of the node
    """
    if id(node) not in sizes:
        # for an alias within what it names: such a circle shows as an error
        sizes[id(node)] = 1
        inner: list[yaml.Node] = []
        if isinstance(node, yaml.MappingNode):
            inner = [one for pair in node.value for one in pair]
        elif isinstance(node, yaml.SequenceNode):
            inner = node.value
        sizes[id(node)] += sum(_size(one, sizes) for one in inner)
    return sizes[id(node)]
