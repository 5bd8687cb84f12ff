# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
XML launch files, as the values that YAML has for the same.

Every element and attribute keeps its position.
"""

from array import array
from collections.abc import Iterator
from collections.abc import Mapping as AbstractMapping
from collections.abc import Sequence as AbstractSequence
from dataclasses import dataclass, field
import re
from xml.parsers import expat

from colcon_yamllaunch.common.suggestions import did_you_mean, listing
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    error,
    LaunchError,
)
from colcon_yamllaunch.language.syntax.errors import explain_xml
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.yaml_reader import (
    Mapping,
    MAXIMUM_DEPTH,
    MAXIMUM_VALUES,
    read_yaml,
    Scalar,
    Sequence,
    Value,
)
from colcon_yamllaunch.language.vocabulary.actions import (
    ACTIONS,
    ALIASES,
    Attribute,
    by_name,
    items_of,
    SCALAR_TYPES,
    Type,
)

# what one character of an attribute's value is written as
_CHARACTER = re.compile(r'&[^;]*;|\r\n|.', re.DOTALL)


class XmlScalar(Scalar):
    """
    The value of an attribute, or a piece of it.

    XML has no types but text: what type is wanted decides what it is.

    :param source: The file
    :param indices: The index in the file for each character of the whole
      value, and the one behind it
    :param text: The text, its entities resolved
    :param offset: How many characters of the value stand before the text
    :param style: None where YAML's rules say what the text is, else a quote
    :param tag: The YAML tag that is written with it, if any
    """

    __slots__ = ('_indices', '_offset')
    is_of_xml = True

    def __init__(
        self,
        source: Source,
        indices: AbstractSequence[int],
        text: str,
        *,
        offset: int = 0,
        style: str | None = '"',
        tag: str | None = None,
    ) -> None:
        self._indices = indices
        self._offset = offset
        start, end = map(source.place_of, map(self.locate, (0, len(text))))
        super().__init__(source, *start, text, style, tag, end)

    def locate(self, index: int) -> int:
        """Return where a character of the text stands in the file."""
        return self._indices[min(self._offset + index, len(self._indices) - 1)]

    def piece(
        self,
        offset: int,
        text: str,
        style: str | None,
        tag: str | None = None,
    ) -> 'XmlScalar':
        """Return a piece of the text; see the class for the parameters."""
        return XmlScalar(
            self.source,
            self._indices,
            text,
            offset=self._offset + offset,
            style=style,
            tag=tag,
        )


#: How deep elements may be nested: as deep as the same actions in YAML, where
#: each takes a list and a mapping.
MAXIMUM_ELEMENT_DEPTH = MAXIMUM_DEPTH // 2

_ATTRIBUTE = re.compile(
    r'[ \t\r\n]+[^ \t\r\n=]+[ \t\r\n]*=[ \t\r\n]*(?:"[^"]*"|\'[^\']*\')'
)


@dataclass(slots=True)
class Element:
    """
    An element.

    :param name: Its name, and where that is written
    :param attributes: Its attributes by name
    :param children: The elements inside of it
    :param text: What to say of text inside of it, where none belongs
    """

    name: Scalar
    attributes: dict[str, tuple[Scalar, XmlScalar]]
    children: 'list[Element]' = field(default_factory=list)
    text: Diagnostic | None = None


def read_xml(source: Source) -> Element:
    """
    Return the root element of a file.

    :raises LaunchError: when it is not XML, has a document type or exceeds a
      limit
    """
    return _Reader(source).read()


class _Reader:
    """Builds the elements of one file from the parser's events."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._data = source.text.encode()
        self._is_ascii = len(self._data) == len(source.text)
        self._bytes = self._characters = 0
        self._root: Element | None = None
        self._open: list[Element] = []
        # the text is decoded already, whatever encoding the file declares
        self._parser = expat.ParserCreate('utf-8')
        self._parser.ordered_attributes = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text
        self._parser.StartDoctypeDeclHandler = self._doctype

    def read(self) -> Element:
        try:
            self._parser.Parse(self._data, True)
        except expat.ExpatError as e:
            index = max(0, self._index(self._parser.ErrorByteIndex))
            tags = [element.name for element in self._open]
            raise explain_xml(e.code, index, tags, self._source) from e
        assert self._root is not None
        return self._root

    def _index(self, count: int) -> int:
        """Return the index in the text for one in its bytes."""
        if self._is_ascii:
            return count
        if count < self._bytes:
            self._bytes = self._characters = 0
        between = self._data[self._bytes : count]
        self._characters += len(between.decode(errors='replace'))
        self._bytes = count
        return self._characters

    def _start(self, name: str, attributes: list[str]) -> None:
        index = self._index(self._parser.CurrentByteIndex) + 1
        key = Scalar(self._source, *self._source.place_of(index), name)
        if len(self._open) >= MAXIMUM_ELEMENT_DEPTH:
            raise error(
                f'nested more than {MAXIMUM_ELEMENT_DEPTH} levels deep',
                key,
            )
        found = self._attributes(index + len(name), attributes)
        element = Element(key, {pair[0].text: pair for pair in found})
        if self._open:
            self._open[-1].children.append(element)
        else:
            self._root = element
        self._open.append(element)

    def _attributes(
        self, at: int, attributes: list[str]
    ) -> Iterator[tuple[Scalar, XmlScalar]]:
        text = self._source.text
        pairs = iter(attributes)
        for name, value in zip(pairs, pairs, strict=True):
            written = _ATTRIBUTE.match(text, at)
            assert written is not None, 'expat has read it before'
            start = text.index(name, at)
            at = written.end()
            key = Scalar(self._source, *self._source.place_of(start), name)
            quote = text[at - 1]
            start = text.index(quote, start + len(name)) + 1
            indices: AbstractSequence[int] = range(start, at)
            if '&' in text[start:at] or '\n' in text[start:at]:
                pieces = _CHARACTER.finditer(text, start, at - 1)
                indices = array('Q', [*(p.start() for p in pieces), at - 1])
            yield key, XmlScalar(self._source, indices, value)

    def _end(self, _name: str) -> None:
        self._open.pop()

    def _text(self, text: str) -> None:
        element = self._open[-1]
        if element.text is not None or text.isspace():
            return
        index = self._index(self._parser.CurrentByteIndex)
        index += len(text) - len(text.lstrip())
        element.text = Diagnostic(
            # ROS 2 passes over it
            'warning',
            f"text stands inside of '{element.name.text}', where none "
            'belongs: it is ignored',
            self._source.position_at(index),
            'write a value as an attribute, name="value", and a comment as '
            '<!-- … -->',
            len(text.strip()),
        )

    def _doctype(self, *_arguments: object) -> None:
        # what it may declare makes a few bytes fill the memory
        opening = '<!DOCTYPE'
        end = self._index(self._parser.CurrentByteIndex) + len(opening)
        index = self._source.text.rfind(opening, 0, end)
        raise error(
            'a launch file has no document type',
            self._source.position_at(index),
            hint="remove '<!DOCTYPE …>'; use <arg> or <let> for values that "
            'are used often',
            length=len(opening),
        )


_SEPARATOR = 'value-sep'
# a text that is one plain scalar in YAML, most parameters are
_PLAIN = re.compile(r'[\w./$()](?:[\w./$()+-]|,(?=\S)|[ ](?=[\w./$()+-]))*')


def read_xml_document(source: Source, problems: list[Diagnostic]) -> Mapping:
    """
    Read an XML launch file as the YAML document that says the same.

    Attributes are the pairs of a mapping; elements are the items of their
    parent's list with that name, or its children. As in ROS 2's `launch_xml`,
    all values are texts until a type is wanted.

    :param problems: Where mistakes go that do not end the reading
    :raises LaunchError: when it is not XML, no launch file or exceeds a limit
    """
    root = read_xml(source)
    if root.name.text != 'launch':
        raise error(
            f"the root element is '{root.name.text}', not 'launch'",
            root.name,
            hint='a launch file is <launch> … </launch>',
        )
    return _Converter(source, problems).document(root)


class _Converter:
    """Makes the values of one file from its elements."""

    def __init__(self, source: Source, problems: list[Diagnostic]) -> None:
        self._source = source
        self._problems = problems

    def document(self, root: Element) -> Mapping:
        launch = self._mapping(root)
        for name, pair in root.attributes.items():
            # ROS 2 accepts any: files name their schema and its version
            if name == 'deprecated':
                launch.pairs[name] = pair
            elif not (name in ('version', 'xmlns') or ':' in name):
                self._report(
                    f"'launch' has no attribute '{name}'",
                    pair[0],
                    did_you_mean(name, ['deprecated', 'version']),
                )
        if root.text is not None:
            self._problems.append(root.text)
        children = [self._action(child) for child in root.children]
        launch.pairs['children'] = root.name, self._sequence(root, children)
        return self._pair(root, launch)

    def _action(self, element: Element) -> Value:
        name = element.name.text
        action = ACTIONS.get(ALIASES.get(name, name))
        if action is None:
            # of another package, or nobody's
            return self._raw(element)
        return self._pair(element, self._value(element, action.attributes))

    def _raw(self, element: Element) -> Mapping:
        """Return an element with all that it has, whatever that means."""
        value = self._mapping(element)
        value.pairs.update(element.attributes)
        children: list[Value] = list(map(self._raw, element.children))
        inside = self._sequence(element, children)
        value.pairs['children'] = element.name, inside
        return self._pair(element, value)

    def _value(
        self, element: Element, attributes: tuple[Attribute, ...]
    ) -> Mapping:
        """Return what an element has as the mapping that says the same."""
        value = self._mapping(element)
        known = by_name(attributes)
        for name, (key, text) in element.attributes.items():
            self._attribute(value, element, known.get(name), key, text)
        if element.text is not None:
            self._problems.append(element.text)
        children: list[Value] = []
        for child in element.children:
            attribute = known.get(child.name.text)
            if attribute is not None and attribute.type is Type.ITEMS:
                self._item(value, child, attribute)
            elif 'children' in known:
                children.append(self._action(child))
            else:
                self._report_element(element, child, known)
        if 'children' in known:
            inside = self._sequence(element, children)
            value.pairs['children'] = element.name, inside
        return value

    def _attribute(
        self,
        value: Mapping,
        element: Element,
        attribute: Attribute | None,
        key: Scalar,
        text: XmlScalar,
    ) -> None:
        kind = None if attribute is None else attribute.type
        if kind in (Type.ITEMS, Type.ACTIONS):
            self._report(
                f"'{key.text}' is no attribute in XML, but an element",
                key,
                f'write <{key.text} …/> inside of <{element.name.text}>'
                if kind is Type.ITEMS
                else f'write the actions inside of <{element.name.text}>',
            )
        elif kind is Type.VALUE:
            value.pairs[key.text] = key, text
            try:
                value.pairs[key.text] = key, parameter_value(element, text)
            except LaunchError as e:
                self._problems.extend(e.diagnostics)
        elif key.text != _SEPARATOR or not (
            element.name.text == 'param' and 'value' in element.attributes
        ):
            value.pairs[key.text] = key, text

    def _item(
        self, value: Mapping, element: Element, attribute: Attribute
    ) -> None:
        name = attribute.name
        if name not in value.pairs:
            value.pairs[name] = element.name, self._sequence(element, [])
        items = value.pairs[name][1]
        assert isinstance(items, Sequence)
        items.items.append(self._value(element, items_of(attribute)))

    def _report_element(
        self,
        parent: Element,
        child: Element,
        known: AbstractMapping[str, Attribute],
    ) -> None:
        name, outer = child.name.text, parent.name.text
        lists = [a.name for a in known.values() if a.type is Type.ITEMS]
        if name in known:
            hint: str | None = f'write it as an attribute: {name}="…"'
        elif ALIASES.get(name, name) in ACTIONS:
            hint = f"end the tag of '{outer}' with '/>' if '{name}' follows it"
        else:
            hint = did_you_mean(name, lists)
            if hint is None and lists:
                hint = f'the elements in it are {listing(lists)}'
        self._report(f"'{outer}' has no element '{name}'", child.name, hint)

    def _report(self, message: str, key: Scalar, hint: str | None) -> None:
        self._problems.extend(error(message, key, hint=hint).diagnostics)

    def _pair(self, element: Element, value: Value) -> Mapping:
        mapping = self._mapping(element)
        mapping.pairs[element.name.text] = element.name, value
        return mapping

    def _mapping(self, element: Element) -> Mapping:
        return Mapping(self._source, element.name.line, element.name.column)

    def _sequence(self, element: Element, items: list[Value]) -> Sequence:
        name = element.name
        sequence = Sequence(self._source, name.line, name.column)
        sequence.items = items
        return sequence


def parameter_value(element: Element, text: XmlScalar) -> Value:
    """
    Return the value of a parameter as YAML has it.

    :param element: The `param` or `set_parameter`
    :param text: Its attribute `value`
    :raises LaunchError: when it is nothing that a parameter can be
    """
    if element.name.text != 'param':
        # ROS 2 takes the text for YAML after its substitutions
        return text.piece(0, text.text, None)
    pair = element.attributes.get('type')
    kind = None if pair is None else pair[1].text
    if _SEPARATOR in element.attributes:
        separator = element.attributes[_SEPARATOR][1]
        return _separated(text, separator, is_text=kind == 'list_of_str')
    if kind in SCALAR_TYPES:
        # YAML has no say in their text
        return text
    return _as_yaml(text)


def _separated(
    text: XmlScalar, written: XmlScalar, *, is_text: bool
) -> Sequence:
    separator = written.text
    if not separator:
        raise error(
            f"'{_SEPARATOR}' is empty",
            written.position,
            hint="write the character between the values, such as ';'",
        )
    if text.text.count(separator) >= MAXIMUM_VALUES:
        raise error(
            f'a list has no more than {MAXIMUM_VALUES} values', text.position
        )
    sequence = Sequence(text.source, text.line, text.column)
    offset = 0
    for part in text.text.split(separator):
        style = '"' if is_text else None
        piece = text.piece(offset, part, style)
        sequence.items.append(piece if is_text else _as_yaml(piece))
        offset += len(part) + len(separator)
    return sequence


def _as_yaml(text: XmlScalar) -> Value:
    """Return a text as what YAML takes it for, a text if it is not YAML."""
    if not text.text:
        # ROS 2 leaves an empty text as it is
        return text.piece(0, '', '"')
    if _PLAIN.fullmatch(text.text):
        return text.piece(0, text.text, None)
    source = text.source
    try:
        value = read_yaml(Source(source.path, source.name, text.text))
    except LaunchError:
        return text
    if value is None:
        return text.piece(0, '', None)
    if isinstance(value, Mapping):
        raise error(
            'YAML reads this value as a mapping, which no parameter can be',
            text,
            hint='add type="str" to keep it a text, or nest <param> elements',
        )
    if isinstance(value, Sequence):
        sequence = Sequence(source, text.line, text.column)
        sequence.items = [_inside(text, item) for item in value.items]
        return sequence
    return _inside(text, value)


def _inside(text: XmlScalar, value: Value) -> Value:
    """Place a value of YAML in the attribute that it was read from."""
    offset = value.source.index_of(value.line, value.column)
    if not isinstance(value, Scalar):
        place = text.piece(offset, '', None)
        return Sequence(place.source, place.line, place.column)
    if value.style:
        offset += 1
    return text.piece(offset, value.text, value.style, value.tag)
