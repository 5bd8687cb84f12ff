# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The text of a file, and where in it something stands."""

import codecs
from dataclasses import dataclass
from pathlib import Path
import re

from colcon_yamllaunch.language.diagnostics import error
from colcon_yamllaunch.language.position import Position

#: The largest file that is read, in bytes.
MAXIMUM_FILE_SIZE = 8 * 1024 * 1024

# what YAML 1.1 does not allow in a stream (production c-printable)
_NOT_PRINTABLE = re.compile(
    '[^\x09\x0a\x0d\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]'
)


@dataclass(frozen=True, slots=True)
class Source:
    """
    A file that was read.

    :param path: The file that was read
    :param name: The path that the file goes by: where it is installed
    :param text: What it says
    """

    path: str
    name: str
    text: str

    def position(self, line: int, column: int) -> Position:
        """Return the position for a line and column counted from 0."""
        return Position(self.path, line + 1, column + 1)

    def position_at(self, index: int) -> Position:
        """Return the position of the character with this index."""
        before = self.text[:index]
        line = before.count('\n')
        return self.position(line, index - (before.rfind('\n') + 1))


def read_source(path: str, name: str) -> Source:
    """
    Read a launch file.

    :param path: The file to read
    :param name: The path that the file goes by
    :raises LaunchError: if it can't be read or is not text
    """
    file = Path(path)
    try:
        size = file.stat().st_size
        if size > MAXIMUM_FILE_SIZE:
            raise error(
                f"launch file '{path}' has {size} bytes; the limit is "
                f'{MAXIMUM_FILE_SIZE}'
            )
        data = file.read_bytes()
    except OSError as e:
        raise error(
            f"cannot read launch file '{path}': {e.strerror or e}"
        ) from e
    source = Source(path, name, _decode(path, data))
    found = _NOT_PRINTABLE.search(source.text)
    if found:
        raise error(
            f'the character U+{ord(found.group()):04X} is not allowed in YAML',
            source.position_at(found.start()),
        )
    return source


def _decode(path: str, data: bytes) -> str:
    encoding = 'utf-8-sig'
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding = 'utf-16'
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as e:
        before = data[: e.start]
        line = before.count(b'\n')
        column = len(before) - (before.rfind(b'\n') + 1)
        raise error(
            f'the byte 0x{data[e.start]:02x} is not UTF-8 text',
            Position(path, line + 1, column + 1),
            hint='save the file as UTF-8',
        ) from e
    return text
