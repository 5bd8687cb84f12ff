# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The frames that go through a connection before the launch, both ways.

A frame is a header of 12 bytes and a body. The header has what it is, how long
its body is, and a checksum of that, so that noise in between (a shell that
prints something) is not taken for a length. No body is longer than 16 MiB.
Behind each body stands an end of line, as `srun` passes on lines only.
"""

from collections.abc import Iterator
import json
import math
import struct
from typing import Any
import zlib

from colcon_yamllaunch.common.frozen import dataclass

#: Bytes of the longest body.
MAXIMUM_BODY = 16 * 1024 * 1024

#: A message, an object in JSON: a request or an answer, or a sign of life.
CONTROL = 8
#: Bytes to and from a program that runs there; empty at their end.
STREAM = 9

_KINDS = frozenset((CONTROL, STREAM))
_MAGIC = b'cl'
# magic, kind, nothing, length; then their checksum
_FIELDS = struct.Struct('>2sBBI')
_CHECKSUM = struct.Struct('>I')
_HEADER = _FIELDS.size + _CHECKSUM.size
_END = b'\n'
# no number that is meant is larger, and each that is not can be a float
_DIGITS = 19


class FrameError(Exception):
    """What has come is no frame; the text says why, as a part of a line."""


@dataclass(frozen=True, slots=True)
class Frame:
    """What came at once."""

    kind: int
    body: bytes

    def content(self) -> dict[str, Any]:
        """
        Return the object of a message; its numbers are finite.

        :raises FrameError: when it is none
        """
        return read_object(self.body)


def encode(kind: int, body: bytes) -> bytes:
    """Return a frame as it is sent."""
    fields = _FIELDS.pack(_MAGIC, kind, 0, len(body))
    return b''.join((fields, _CHECKSUM.pack(zlib.crc32(fields)), body, _END))


def message(content: object) -> bytes:
    """Return a message as it is sent."""
    body = json.dumps(content, separators=(',', ':')).encode()
    return encode(CONTROL, body)


def read_object(data: bytes) -> dict[str, Any]:
    """
    Return the JSON object in some bytes; its numbers are finite.

    :raises FrameError: when it is none
    """
    try:
        content = _READER.decode(data.decode())
    except (ValueError, RecursionError):
        content = None
    if not isinstance(content, dict):
        raise FrameError(
            'a message is no object in JSON, or a number in it too large'
        )
    return content


class FrameReader:
    """Makes frames of the bytes that arrive, with bounded memory."""

    def __init__(self) -> None:
        self._data = bytearray()
        self._at = 0

    def feed(self, data: bytes) -> Iterator[Frame]:
        """
        Iterate over the frames that are complete now.

        All of them must be taken before more is fed.

        :raises FrameError: when it is something else; what comes after that
          is not to be read
        """
        self._data += data
        while (frame := self._next()) is not None:
            yield frame
        del self._data[: self._at]
        self._at = 0

    @property
    def rest(self) -> bytes:
        """What has come of a frame that is not complete."""
        return bytes(self._data[self._at :])

    def _next(self) -> Frame | None:
        begin = self._at
        body = begin + _HEADER
        if len(self._data) < body:
            return None
        fields = bytes(self._data[begin : begin + _FIELDS.size])
        (checksum,) = _CHECKSUM.unpack_from(self._data, begin + _FIELDS.size)
        magic, kind, reserved, length = _FIELDS.unpack(fields)
        if magic != _MAGIC or checksum != zlib.crc32(fields):
            raise FrameError('what came is not what colcon launch sends')
        if kind not in _KINDS or reserved or length > MAXIMUM_BODY:
            raise FrameError('a frame has a wrong kind or length')
        end = body + length
        if len(self._data) < end + len(_END):
            return None
        content = bytes(memoryview(self._data)[body:end])
        self._at = end + len(_END)
        return Frame(kind, content)


def _integer(digits: str) -> int:
    if len(digits) > _DIGITS:
        raise ValueError
    return int(digits)


def _float(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError
    return number


_READER = json.JSONDecoder(
    parse_int=_integer, parse_float=_float, parse_constant=_float
)
