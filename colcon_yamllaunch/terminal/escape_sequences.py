# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The output of a process that has the keyboard, above a status block.

It is shown as it comes, half lines and all, so that prompts and editing work;
but it keeps to its line. A program that draws in all of its terminal needs a
terminal of its own.
"""

import codecs
import re

# of ECMA-48: CSI, OSC and other strings, and escape sequences; controls of
# both sets, those of eight bits also where they are no UTF-8
_SEQUENCE = re.compile(
    r'\x1b\[(?P<parameters>[0-?]*)(?P<end>[ -/]*[@-~])'
    r'|\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)'
    r'|\x1b[PX^_][^\x1b]*\x1b\\'
    r'|\x1b[ -/]*[0-~]'
    r'|\x1b'
    r'|[\x00-\x06\x0b\x0c\x0e-\x1f\x7f-\x9f\udc80-\udc9f]'
)
# the start of one
_UNFINISHED = re.compile(
    r'\x1b(?:\[[0-?]*[ -/]*|\][^\x07\x1b]*\x1b?|[PX^_][^\x1b]*\x1b?'
    r'|[ -/]*)\Z'
)
# colours, and what moves, erases and inserts inside a line
_HARMLESS = frozenset('mCDGKPX@a`')
# how the parameters of private sequences of terminals begin
_PRIVATE = ('<', '=', '>', '?')
#: Bytes that are no UTF-8 stay as they are.
_ERRORS = 'surrogateescape'
#: Characters of a sequence that are waited for at most.
_LONGEST = 4096


class InLineOutput:
    """What comes from one process, without what leaves its line."""

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder('utf-8')(_ERRORS)
        self._unfinished = ''

    def feed(self, data: bytes) -> bytes:
        """Return what is to be shown now."""
        text = self._unfinished + self._decoder.decode(data)
        self._unfinished = ''
        start = _UNFINISHED.search(text)
        if start is not None and len(start[0]) <= _LONGEST:
            self._unfinished = start[0]
            text = text[: start.start()]
        return _SEQUENCE.sub(_if_harmless, text).encode(errors=_ERRORS)


def _if_harmless(match: re.Match[str]) -> str:
    parameters, end = match['parameters'], match['end']
    if end in _HARMLESS and not parameters.startswith(_PRIVATE):
        return match[0]
    return ''
