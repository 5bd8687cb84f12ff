# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What all readers know of XML.

The reader of XML itself is imported for launch files in XML only.
"""

from array import array
import re

from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.language.syntax.yaml_reader import Scalar

# what one character of an attribute's value is written as
_CHARACTER = re.compile(r'&[^;]*;|\r\n|.', re.DOTALL)


def is_xml(source: Source) -> bool:
    """
    Say whether a launch file is written in XML.

    ROS 2 tries all its languages whatever the suffix; no launch file in YAML
    starts as one in XML does.
    """
    text = source.text.lstrip()
    is_yaml = text.startswith(('launch:', '---', '#'))
    return text[:1] == '<' or (source.path.endswith('.xml') and not is_yaml)


class Written:
    """
    How the value of an attribute is written.

    :param source: The file
    :param start: The index in the file where the value starts
    :param end: The index behind it
    """

    __slots__ = ('_end', '_indices', '_is_plain', '_start', 'source')

    def __init__(self, source: Source, start: int, end: int) -> None:
        self.source = source
        self._start = start
        self._end = end
        raw = source.text[start:end]
        self._is_plain = '&' not in raw and '\n' not in raw
        self._indices: array[int] | None = None

    def index_of(self, count: int) -> int:
        """Return where the character of the value with this index stands."""
        if self._is_plain:
            return self._start + count
        if self._indices is None:
            pieces = _CHARACTER.finditer(
                self.source.text, self._start, self._end
            )
            starts = (piece.start() for piece in pieces)
            self._indices = array('Q', [*starts, self._end])
        return self._indices[min(count, len(self._indices) - 1)]


class XmlScalar(Scalar):
    """
    The value of an attribute, or a piece of it.

    XML has no types but text: what type is wanted decides what it is.

    :param written: How the value is written
    :param text: The text, its entities resolved
    :param offset: How many characters of the value stand before the text
    :param style: None where YAML's rules say what the text is, else a quote
    :param tag: The YAML tag that is written with it, if any
    """

    __slots__ = ('_offset', '_written')

    def __init__(
        self,
        written: Written,
        text: str,
        *,
        offset: int = 0,
        style: str | None = '"',
        tag: str | None = None,
    ) -> None:
        self._written = written
        self._offset = offset
        source = written.source
        start = source.place_of(written.index_of(offset))
        end = source.place_of(written.index_of(offset + len(text)))
        super().__init__(source, *start, text, style, tag, end)

    def locate(self, index: int) -> int:
        """Return where a character of the text stands in the file."""
        return self._written.index_of(self._offset + index)

    def piece(
        self,
        offset: int,
        text: str,
        style: str | None,
        tag: str | None = None,
    ) -> 'XmlScalar':
        """Return a piece of the text; see the class for the parameters."""
        return XmlScalar(
            self._written,
            text,
            offset=self._offset + offset,
            style=style,
            tag=tag,
        )
