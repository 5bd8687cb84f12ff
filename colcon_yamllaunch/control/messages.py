# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Reading the messages of a running launch from the bytes that arrive."""

from collections.abc import Callable
from collections.abc import Iterator
from typing import Any

from colcon_yamllaunch.control.protocol import decode
from colcon_yamllaunch.control.protocol import ProtocolError

#: Bytes of the longest message of a launch, and of the bytes that follow one.
MAXIMUM_MESSAGE = 64 * 1024 * 1024
# messages that bytes follow; see `protocol`
_RAW = ('output', 'shown', 'packed', 'stream')

#: Reads the object of a line; raises `ProtocolError`.
Decode = Callable[[bytes], dict[str, Any]]


class MessageReader:
    """
    The messages in a stream of bytes, with bounded memory.

    Bytes that follow a message are its `data`, and packed messages are
    unpacked.
    """

    def __init__(self, decode: Decode = decode) -> None:
        self._decode = decode
        self._data = bytearray()
        # a message whose bytes have not all come, and their number
        self._incomplete: tuple[dict[str, Any], dict[str, Any], int] | None
        self._incomplete = None
        # where a search for the end of a line goes on
        self._searched = 0

    def feed(self, data: bytes) -> Iterator[dict[str, Any]]:
        """
        Iterate over the messages that are complete now.

        :raises ProtocolError: when there is something else; what comes after
          that is not to be read
        """
        self._data += data
        while (message := self._next()) is not None:
            packed = message.get('packed')
            if packed is None:
                yield message
            else:
                yield from self._unpacked(packed['data'])

    def _next(self) -> dict[str, Any] | None:
        if self._incomplete is None:
            line = self._line()
            if line is None:
                return None
            message = self._decode(line)
            fields, size = _raw_fields(message)
            if not fields:
                return message
            self._incomplete = message, fields, size
        message, fields, size = self._incomplete
        if len(self._data) < size:
            return None
        self._incomplete = None
        fields['data'] = bytes(memoryview(self._data)[:size])
        del self._data[:size]
        return message

    def _line(self) -> bytes | None:
        """Return the next line that is not empty, None if it has not come."""
        line = b'\n'
        while line == b'\n':
            end = self._data.find(b'\n', self._searched) + 1
            if not end:
                self._searched = len(self._data)
                if self._searched > MAXIMUM_MESSAGE:
                    raise ProtocolError('a message is too long')
                return None
            line = bytes(memoryview(self._data)[:end])
            del self._data[:end]
            self._searched = 0
        return line

    def _unpacked(self, data: bytes) -> Iterator[dict[str, Any]]:
        import zlib

        unpacker = zlib.decompressobj()
        try:
            # so that a few bytes do not become gigabytes
            content = unpacker.decompress(data, MAXIMUM_MESSAGE)
        except zlib.error as error:
            raise ProtocolError('a packed message is damaged') from error
        if not unpacker.eof:
            raise ProtocolError('a packed message is damaged or too long')
        reader = MessageReader(self._decode)
        for message in reader.feed(content):
            if 'packed' in message:
                raise ProtocolError('a message is packed twice')
            yield message


def _raw_fields(message: dict[str, Any]) -> tuple[dict[str, Any], int]:
    """Return what bytes follow a message, and how many; empty for none."""
    for kind in _RAW:
        fields = message.get(kind)
        if isinstance(fields, dict) and 'bytes' in fields:
            size = fields['bytes']
            if type(size) is not int or not 0 <= size <= MAXIMUM_MESSAGE:
                raise ProtocolError('a message has a wrong number of bytes')
            return fields, size
    if 'packed' in message:
        raise ProtocolError('a packed message has no bytes')
    return {}, 0
