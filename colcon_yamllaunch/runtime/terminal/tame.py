# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The output of a process that has the keyboard, above a status block.

It is shown as it comes, half lines and all, so that prompts and editing work;
but it keeps to its line. A program that draws in all of its terminal needs a
terminal of its own.
"""

import re

# of ECMA-48: CSI, OSC and other strings, and escape sequences
_SEQUENCE = re.compile(
    rb'\x1b\[(?P<parameters>[0-?]*)(?P<end>[ -/]*[@-~])'
    rb'|\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)'
    rb'|\x1b[PX^_][^\x1b]*\x1b\\'
    rb'|\x1b[ -/]*[0-~]'
    rb'|\x1b'
    rb'|\xc2[\x80-\x9f]'
    rb'|[\x00-\x06\x0b\x0c\x0e-\x1f\x7f]'
)
# the start of one
_UNFINISHED = re.compile(
    rb'(?:\x1b(?:\[[0-?]*[ -/]*|\][^\x07\x1b]*\x1b?|[PX^_][^\x1b]*\x1b?'
    rb'|[ -/]*)|\xc2)\Z'
)
# colours, and what moves, erases and inserts inside a line
_HARMLESS = frozenset(
    (b'm', b'C', b'D', b'G', b'K', b'P', b'X', b'@', b'a', b'`')
)
# how the parameters of private sequences of terminals begin
_PRIVATE = frozenset((b'<', b'=', b'>', b'?'))
#: Bytes of a sequence that are waited for at most.
_LONGEST = 4096


class Tame:
    """What comes from one process, without what leaves its line."""

    def __init__(self) -> None:
        self._unfinished = b''

    def feed(self, data: bytes) -> bytes:
        """Return what is to be shown now."""
        data = self._unfinished + data
        self._unfinished = b''
        start = _UNFINISHED.search(data)
        if start is not None and len(start[0]) <= _LONGEST:
            self._unfinished = start[0]
            data = data[: start.start()]
        return _SEQUENCE.sub(_tamed, data)


def _tamed(match: re.Match[bytes]) -> bytes:
    parameters, end = match['parameters'], match['end']
    if end in _HARMLESS and not parameters.startswith(
        (b'<', b'=', b'>', b'?')
    ):
        return match[0]
    return b''
