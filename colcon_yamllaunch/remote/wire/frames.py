# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The frames that go through a connection, in both directions.

A frame is a header of 20 bytes and a body. The header has what it is, how
long its body is, its number, and a checksum of that, so that noise in between
(a shell that prints something) is not taken for a length. No body is longer
than 16 MiB, packed or not. Numbers count what must arrive exactly once;
what has none has the number 0. Behind each body stands an end of line, as
`srun` passes on lines only.
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

# Kinds that have a number while a launch runs.
#: A message, an object in JSON.
MESSAGE = 1
#: What a process has written; see :func:`output_body`.
OUTPUT = 2
#: What the terminal of a process that somebody types at has echoed; likewise.
ECHO = 3

# Kinds without a number.
#: A message between the two ends of a connection, an object in JSON: the
#: greeting, heartbeats with what has arrived, and requests before the launch.
CONTROL = 8
#: Bytes to and from a program that runs there; empty at their end.
STREAM = 9

_KINDS = frozenset((MESSAGE, OUTPUT, ECHO, CONTROL, STREAM))
_MAGIC = b'cl'
# magic, kind, flags, length, number; then their checksum
_FIELDS = struct.Struct('>2sBBIQ')
_CHECKSUM = struct.Struct('>I')
_HEADER = _FIELDS.size + _CHECKSUM.size
_END = b'\n'
_PACKED = 1
# below that nothing is gained
_WORTH_PACKING = 512
_STREAMS = ('stdout', 'stderr')
# no number that is meant is larger, and each that is not can be a float
_DIGITS = 19
# time, stream, length of the label
_OUTPUT = struct.Struct('>dBH')


class FrameError(Exception):
    """What has come is no frame; the text says why, as a part of a line."""


@dataclass(frozen=True, slots=True)
class Frame:
    """
    What came at once.

    :param number: Which it is among those that must arrive; 0 for the others
    """

    kind: int
    number: int
    body: bytes

    def content(self) -> dict[str, Any]:
        """
        Return the object of a message; its numbers are finite.

        :raises FrameError: when it is none
        """
        try:
            content = _READER.decode(self.body.decode())
        except (ValueError, RecursionError):
            content = None
        if not isinstance(content, dict):
            raise FrameError(
                'a message is no object in JSON, or a number in it too large'
            )
        return content


def encode(
    kind: int, body: bytes, number: int = 0, *, packed: bool = False
) -> bytes:
    """
    Return a frame as it is sent.

    :param packed: Whether its body is compressed, if that makes it shorter
    """
    flags = 0
    if packed and len(body) >= _WORTH_PACKING:
        short = zlib.compress(body, 1)
        if len(short) < len(body):
            flags, body = _PACKED, short
    fields = _FIELDS.pack(_MAGIC, kind, flags, len(body), number)
    return b''.join((fields, _CHECKSUM.pack(zlib.crc32(fields)), body, _END))


def message(content: object, kind: int = CONTROL, number: int = 0) -> bytes:
    """Return a message as it is sent."""
    return encode(kind, json_body(content), number)


def json_body(content: object) -> bytes:
    """Return the body of a message."""
    return json.dumps(content, separators=(',', ':')).encode()


def output_body(label: str, stream: str, data: bytes, seconds: float) -> bytes:
    """
    Return the body of a frame with output.

    :param seconds: When it was read, by the clock of that machine
    """
    name = label.encode('utf-8', 'surrogateescape')[: (1 << 16) - 1]
    head = _OUTPUT.pack(seconds, _STREAMS.index(stream), len(name))
    return b''.join((head, name, data))


def read_output(body: bytes) -> tuple[str, str, bytes, float]:
    """
    Return label, stream, data and time of a frame with output.

    :raises FrameError: when it is none
    """
    try:
        seconds, stream, length = _OUTPUT.unpack_from(body)
        start = _OUTPUT.size
        label = body[start : start + length]
        if len(label) != length:
            raise FrameError('output is cut off')
        name = label.decode('utf-8', 'surrogateescape')
        return name, _STREAMS[stream], body[start + length :], seconds
    except (struct.error, IndexError) as error:
        raise FrameError('output has a wrong form') from error


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
        magic, kind, flags, length, number = _FIELDS.unpack(fields)
        if magic != _MAGIC or checksum != zlib.crc32(fields):
            raise FrameError('what came is not what colcon launch sends')
        if kind not in _KINDS or flags & ~_PACKED or length > MAXIMUM_BODY:
            raise FrameError('a frame has a wrong kind or length')
        end = body + length
        if len(self._data) < end + len(_END):
            return None
        content = bytes(memoryview(self._data)[body:end])
        self._at = end + len(_END)
        return Frame(kind, number, _unpacked(content, flags))


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


def _unpacked(body: bytes, flags: int) -> bytes:
    if not flags & _PACKED:
        return body
    unpacker = zlib.decompressobj()
    try:
        # so that a few bytes do not become gigabytes
        content = unpacker.decompress(body, MAXIMUM_BODY)
    except zlib.error as error:
        raise FrameError('a packed frame is damaged') from error
    if not unpacker.eof:
        raise FrameError('a packed frame is damaged or too long')
    return content
