# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What keys the bytes are that a terminal sends."""

import codecs
from collections.abc import Iterator
import re

#: Seconds after which an Esc is the key, and not the start of a sequence.
ESCAPE_DELAY = 0.05

# ECMA-48: CSI with parameters, SS3, an Esc before a character for Alt
_SEQUENCE = re.compile(
    r'\x1b(?:'
    r'\[(?P<parameters>[0-?]{0,48})[ -/]{0,8}(?P<end>[@-~])'
    r'|O(?P<single>[ -~])'
    r'|(?P<alt>[^\x1b\[O])'
    r')'
)
# the start of one
_UNFINISHED = re.compile(r'\x1b(?:\[[0-?]{0,48}[ -/]{0,8}|O)?\Z')

# of xterm and those that do as it does; rxvt and the console differ in some
_BY_END = {
    'A': 'up',
    'B': 'down',
    'C': 'right',
    'D': 'left',
    'H': 'home',
    'F': 'end',
}
_BY_NUMBER = {
    '1': 'home',
    '3': 'delete',
    '4': 'end',
    '7': 'home',
    '8': 'end',
}
_CONTROLS = {
    '\r': 'enter',
    '\n': 'enter',
    '\t': 'tab',
    '\x7f': 'backspace',
    '\x08': 'backspace',
}


class KeyDecoder:
    """
    Makes keys of bytes, which may come split anywhere.

    A key is a character, or a name of several: `enter`, `left`, `ctrl-a`,
    `alt-b`, `ctrl-right`. Sequences that are no key here are passed over.
    """

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder('utf-8')('replace')
        self._text = ''

    @property
    def is_waiting(self) -> bool:
        """Whether an Esc may be the start of more."""
        return self._text.startswith('\x1b')

    def feed(self, data: bytes) -> None:
        """Take bytes, whose keys :meth:`pressed` returns."""
        self._text += self._decoder.decode(data)

    def pressed(self) -> Iterator[str]:
        """Return all keys so far."""
        while self._text:
            size, key = self._first(self._text)
            if not size:
                return
            self._text = self._text[size:]
            if key:
                yield key

    def settle(self) -> Iterator[str]:
        """Return all keys, as nothing has come for a while."""
        if self.is_waiting:
            self._text = self._text[1:]
            yield 'esc'
            yield from self.pressed()

    def _first(self, text: str) -> tuple[int, str]:
        """Return the first key and its characters, 0 for none yet."""
        if text[0] != '\x1b':
            return 1, _plain(text[0])
        match = _SEQUENCE.match(text)
        if match is None:
            return (0, '') if _UNFINISHED.match(text) else (1, 'esc')
        if match['alt']:
            key = _plain(match['alt'])
            return match.end(), f'alt-{key}' if key else ''
        if match['single']:
            return match.end(), _BY_END.get(match['single'], '')
        return match.end(), _named(match['parameters'], match['end'])


def _plain(character: str) -> str:
    if character in _CONTROLS:
        return _CONTROLS[character]
    if character < ' ':
        # as the keyboard has it (ASCII)
        return f'ctrl-{chr(ord(character) + 0x40).lower()}'
    return character if character.isprintable() else ''


def _named(parameters: str, end: str) -> str:
    first, _, modifier = parameters.partition(';')
    name = _BY_NUMBER.get(first) if end == '~' else _BY_END.get(end)
    # 1 is added to the sum of Shift 1, Alt 2 and Ctrl 4
    is_word = modifier.isdecimal() and (int(modifier[:3]) - 1) & 6
    return f'ctrl-{name}' if name and is_word else name or ''
