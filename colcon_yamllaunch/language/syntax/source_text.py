# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The text of a file, and where in it something stands."""

from bisect import bisect_right
import codecs
from functools import lru_cache
import os
import re

from colcon_yamllaunch.common.files import content_of
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.plan.position import Position

#: The largest file that is read, in bytes.
MAXIMUM_FILE_SIZE = 8 * 1024 * 1024

# what YAML 1.1 does not allow in a stream (production c-printable)
_NOT_PRINTABLE = re.compile(
    '[^\x09\x0a\x0d\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]'
)
# the first line of an XML file may say how to read it (XML 1.0, 4.3.3)
_XML_ENCODING = (
    rb'<\?xml[^>]*?\sencoding\s*=\s*["\'](?P<name>[A-Za-z0-9._-]+)["\']'
)
_KNOWN_ENCODING = r'utf-8|us-ascii|iso-8859-([1-9]|1[013-6])|windows-125[0-8]'


@dataclass(frozen=True, slots=True)
class Source:
    """
    A file that was read.

    :param path: The file that was read
    :param name: The path that the file goes by: where it is installed
    :param text: What it says
    :param kind: What to call it in errors
    """

    path: str
    name: str
    text: str
    kind: str = 'launch file'

    @property
    def is_xml(self) -> bool:
        """
        Whether a launch file is written in XML.

        ROS 2 tries all its languages whatever the suffix; no launch file in
        YAML starts as one in XML does.
        """
        text = self.text.lstrip()
        is_yaml = text.startswith(('launch:', '---', '#'))
        is_named_so = self.path.endswith('.xml') and not is_yaml
        return text[:1] == '<' or is_named_so

    def position(self, line: int, column: int) -> Position:
        """Return the position for a line and column counted from 0."""
        return Position(self.path, line + 1, column + 1)

    def position_at(self, index: int) -> Position:
        """Return the position of the character with this index."""
        return self.position(*self.place_of(index))

    def place_of(self, index: int) -> tuple[int, int]:
        """Return the line and column of that, counted from 0."""
        starts = _line_starts(self.text)
        line = bisect_right(starts, index) - 1
        return line, index - starts[line]

    def index_of(self, line: int, column: int) -> int:
        """Return the index for a line and column counted from 0."""
        starts = _line_starts(self.text)
        # libyaml sees a line end that is not there behind the last line
        return starts[line] + column if line < len(starts) else len(self.text)


@lru_cache(maxsize=8)
def _line_starts(text: str) -> tuple[int, ...]:
    """Return the index of the first character of each line."""
    return (0, *(found.end() for found in re.finditer('\n', text)))


def read_source(path: str, name: str, kind: str = 'launch file') -> Source:
    """
    Read a launch file, or another one that people write.

    :param path: The file to read
    :param name: The path that the file goes by
    :param kind: What to call it in errors
    :raises LaunchError: when it can't be read or is not text
    """
    try:
        size = os.stat(path).st_size
        if size > MAXIMUM_FILE_SIZE:
            raise error(
                f"{kind} '{path}' has {size} bytes; the limit is "
                f'{MAXIMUM_FILE_SIZE}'
            )
        data = content_of(path, MAXIMUM_FILE_SIZE)
    except (OSError, ValueError) as e:
        reason = getattr(e, 'strerror', None) or e
        raise error(f"cannot read {kind} '{path}': {reason}") from e
    source = Source(path, name, _decode(path, data), kind)
    found = _NOT_PRINTABLE.search(source.text)
    if found:
        raise error(
            f'the character U+{ord(found.group()):04X} is not allowed in a '
            f'{kind}',
            source.position_at(found.start()),
        )
    return source


def _decode(path: str, data: bytes) -> str:
    encoding, shown = 'utf-8-sig', 'UTF-8'
    declared = None
    if data.startswith(b'<?xml'):
        declared = re.match(_XML_ENCODING, data)
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding = shown = 'utf-16'
    elif declared is not None:
        encoding = shown = _xml_encoding(path, declared)
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as e:
        before = data[: e.start]
        line = before.count(b'\n')
        column = len(before) - (before.rfind(b'\n') + 1)
        raise error(
            f'the byte 0x{data[e.start]:02x} is not {shown} text',
            Position(path, line + 1, column + 1),
            hint='save the file as UTF-8',
        ) from e
    return text


def _xml_encoding(path: str, declared: re.Match[bytes]) -> str:
    name = declared['name'].decode('ascii').lower()
    if re.fullmatch(_KNOWN_ENCODING, name) is None:
        raise error(
            f"the encoding '{name}' is not known",
            Position(path, 1, declared.start('name') + 1),
            hint='save the file as UTF-8, and declare that or nothing',
            length=len(name),
        )
    return 'utf-8-sig' if name == 'utf-8' else name
