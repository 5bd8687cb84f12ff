# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""XML with the position of every element and attribute."""

from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
import re
from xml.parsers import expat

from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic, error
from colcon_yamllaunch.language.syntax.errors import explain_xml
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.yaml_reader import MAXIMUM_DEPTH, Scalar

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
        indices: Sequence[int],
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
            indices: Sequence[int] = range(start, at)
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
