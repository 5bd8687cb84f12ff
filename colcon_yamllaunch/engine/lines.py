# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Cutting output into lines, and making lines fit for a screen."""

import re

from colcon_yamllaunch.common.printable import COLOUR, replaced, SEQUENCE
from colcon_yamllaunch.engine import limits

_RESET = b'\x1b[0m'
_PLAIN = bytes(range(0x20, 0x7F)) + b'\t\n'
_AT_LINE_START = re.compile(rb'(?m:^)\r+')
_COLOURS = re.compile(COLOUR.encode())
_CARRIAGE_RETURNS = re.compile(rb'\r+\n?')
# colours pass; what moves the cursor, changes the character set or the like
# does not, and neither do half sequences
_SEQUENCES = re.compile(SEQUENCE)


class LineBuffer:
    """
    Collects output up to the end of a line.

    A carriage return ends a line, too, as progress displays have no other
    end; those that come last wait for the line feed that may follow.
    """

    def __init__(self) -> None:
        self._pieces: list[bytes] = []
        #: Bytes that are kept.
        self.size = 0

    def feed(self, chunk: bytes) -> bytes:
        """Return all whole lines up to here; what remains is kept."""
        last = len(chunk.rstrip(b'\r'))
        end = 1 + max(chunk.rfind(b'\n'), chunk.rfind(b'\r', 0, last))
        pieces = self._pieces
        is_waiting = bool(pieces) and pieces[-1].endswith(b'\r')
        if not end and not (is_waiting and last):
            pieces.append(chunk)
            self.size += len(chunk)
            return self.flush() if self.size > limits.LINE_BYTES else b''
        lines = b''.join((*pieces, chunk[:end])) if pieces else chunk[:end]
        self._pieces = [chunk[end:]] if end < len(chunk) else []
        self.size = len(chunk) - end
        return lines

    @property
    def unfinished(self) -> bytes:
        """What has been kept, such as a prompt."""
        return b''.join(self._pieces)

    def flush(self) -> bytes:
        """Return what remains."""
        rest = b''.join(self._pieces)
        self._pieces = []
        self.size = 0
        return rest


def normalised(data: bytes) -> bytes:
    r"""
    Return output with `\n` as its only line end.

    :param data: Output from the start of a line on
    """
    if b'\r' not in data:
        return data
    return _CARRIAGE_RETURNS.sub(b'\n', _AT_LINE_START.sub(b'', data))


def legible(data: bytes, terminal: bool) -> bytes:
    """
    Return lines as valid UTF-8 that does a terminal no harm.

    Invalid bytes become U+FFFD. For a terminal, colours stay, other control
    sequences vanish, and other control characters become U+FFFD.
    """
    if not terminal:
        if data.isascii():
            return data
        return data.decode(errors='replace').encode()
    if not data.translate(None, _PLAIN):
        return data
    text = _SEQUENCES.sub(_without_controls, data.decode(errors='replace'))
    return text.encode()


def bare(data: bytes) -> str:
    """Return lines without any control sequence, colours included."""
    if b'\x1b' in data:
        data = _COLOURS.sub(b'', data)
    if not data.translate(None, _PLAIN):
        return data.decode()
    text = normalised(data).decode(errors='replace')
    return _SEQUENCES.sub(replaced, text)


def colourless(data: bytes) -> bytes:
    """Return lines without colours."""
    return _COLOURS.sub(b'', data) if b'\x1b' in data else data


def prefixed(data: bytes, prefix: bytes, reset: bool = False) -> bytes:
    r"""
    Put a prefix before each line.

    :param data: Lines that end with `\n`; the last one's may be missing
    :param reset: Whether lines with colours of their own end these
    """
    if not data:
        return b''
    body = data.removesuffix(b'\n')
    end = _RESET + b'\n' if reset and b'\x1b' in body else b'\n'
    # one copy fewer than by adding, as a line may have many megabytes
    return b''.join((prefix, body.replace(b'\n', end + prefix), end))


def _without_controls(match: re.Match[str]) -> str:
    if match[1]:
        return match[1]
    return replaced(match)
