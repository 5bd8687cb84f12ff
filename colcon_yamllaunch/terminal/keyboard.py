# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The keyboard of a terminal: its modes, its bytes, and keys made of them."""

import codecs
from collections.abc import Callable, Iterator
import os
import re
import select
import termios
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.engine.loop import Loop

#: Seconds after which an Esc is the key, and not the start of a sequence.
ESCAPE_DELAY = 0.05

#: Ctrl-], as telnet has it: terminals pass it, and hardly a program needs it.
ESCAPE = b'\x1d'
#: How the key is called.
ESCAPE_NAME = 'Ctrl-]'

_SIZE = 4096
_INPUT = (
    termios.ICRNL
    | termios.IGNCR
    | termios.INLCR
    | termios.ISTRIP
    | termios.IXON
    | termios.IXOFF
)
_LOCAL = termios.ICANON | termios.ECHO | termios.IEXTEN
_IFLAG, _LFLAG, _CC = 0, 3, 6
_NONE = b'\0'


class Keyboard:
    """
    A terminal from which each key is read as it comes.

    Ctrl-C and Ctrl-Z stay signals; all other keys are read as they are.

    :param takes_keys: Whether keys are read; if not, they are only not shown,
      and wait for another reader
    """

    def __init__(self, descriptor: int, *, takes_keys: bool = True) -> None:
        self.descriptor = descriptor
        #: Whether keys are to be read from it.
        self.takes_keys = takes_keys
        self._before: list[Any] | None = None

    def grab(self) -> bool:
        """
        Set the modes in which keys come at once.

        Called again, it undoes what a shell has set meanwhile. Return False
        when another job has the terminal, or it is gone.
        """
        try:
            if not is_in_foreground(self.descriptor):
                return False
            before = self._before or termios.tcgetattr(self.descriptor)
            modes = self._modes(before)
            termios.tcsetattr(self.descriptor, termios.TCSANOW, modes)
        except termios.error:
            return False
        self._before = before
        return True

    @property
    def modes(self) -> tuple[list[Any], list[Any]] | None:
        """The modes that it had, and those that it has while it is grabbed."""
        before = self._before
        return None if before is None else (before, self._modes(before))

    def release(self) -> None:
        """Restore the modes of the terminal."""
        before, self._before = self._before, None
        if before is None or not is_in_foreground(self.descriptor):
            # the shell has the terminal now, and has set its own modes
            return
        try:
            termios.tcsetattr(self.descriptor, termios.TCSANOW, before)
        except termios.error:
            # it is gone
            return

    def keys(self) -> bytes:
        """
        Return what was typed, or nothing; it does not wait for more.

        :raises OSError: when the terminal is gone
        """
        poll = select.poll()
        poll.register(self.descriptor, select.POLLIN)
        return _read(self.descriptor) if poll.poll(0) else b''

    def _modes(self, before: list[Any]) -> list[Any]:
        modes = [*before[:_CC], list(before[_CC])]
        if not self.takes_keys:
            modes[_LFLAG] &= ~termios.ECHO
            return modes
        modes[_IFLAG] &= ~_INPUT
        modes[_LFLAG] &= ~_LOCAL
        characters = modes[_CC]
        # with VMIN 0, a shell that reads before the guard of a killed launch
        # has restored the modes would take an empty read for the end of file
        characters[termios.VMIN], characters[termios.VTIME] = 1, 0
        characters[termios.VQUIT] = _NONE
        return modes


def _read(descriptor: int) -> bytes:
    """
    Return what was typed, or nothing.

    Ctrl-C drops what was typed before it, also after the terminal was found to
    be readable; a read that waits would miss Ctrl-C then. The mode of the
    descriptor is shared with the shell, so the terminal is opened once more.
    """
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
    try:
        unblocked = os.open(f'/proc/self/fd/{descriptor}', flags)
    except OSError:
        # it belongs to another user, as after `su`
        return os.read(descriptor, _SIZE)
    try:
        return os.read(unblocked, _SIZE)
    except BlockingIOError:
        return b''
    finally:
        os.close(unblocked)


def need_terminal() -> int:
    """
    Return the descriptor of the keyboard.

    :raises UserError: when standard input is no terminal
    """
    if not os.isatty(0):
        raise UserError(
            '--attach needs a keyboard, but standard input is no terminal'
        )
    return 0


def is_in_foreground(descriptor: int) -> bool:
    """Return whether this job is in the foreground of a terminal."""
    try:
        return os.tcgetpgrp(descriptor) == os.getpgrp()
    except OSError:
        # it is not the controlling terminal of this job
        return os.isatty(descriptor)


class WatchedKeyboard(Keyboard):
    """
    A keyboard in the loop of a launch, while its terminal is the launch's.

    :param typed: Is called with what was typed, and with nothing when the
      terminal is gone
    """

    def __init__(
        self,
        descriptor: int,
        typed: Callable[[bytes], None],
        *,
        takes_keys: bool = True,
    ) -> None:
        super().__init__(descriptor, takes_keys=takes_keys)
        self._typed = typed
        self._has_had_keys = False

    def connect(self, loop: Loop) -> None:
        """Use the loop of a launch, before it runs."""
        self._loop: Loop = loop

    @property
    def has_keys(self) -> bool:
        """Whether keys are read now."""
        return self.modes is not None and self.takes_keys

    def watch(
        self, *, keeps_early: bool
    ) -> tuple[list[Any], list[Any]] | None:
        """
        Read keys from now on.

        Return the modes that the terminal had, and those that it has now, or
        None if they are as they were.

        :param keeps_early: Whether to keep what was typed before the first
          time, as it is for a process
        """
        if not self.grab():
            return None
        if self.takes_keys:
            if not self._has_had_keys and not keeps_early:
                termios.tcflush(self.descriptor, termios.TCIFLUSH)
            self._has_had_keys = True
            self._loop.add_reader(self.descriptor, self._readable)
            self._loop.add_hangup_handler(self.descriptor, self._hung_up)
        return self.modes

    def release(self) -> None:
        """Stop reading keys, and restore the modes of the terminal."""
        if self.modes is not None:
            self._loop.remove(self.descriptor)
        super().release()

    def _hung_up(self) -> None:
        if not self._readable():
            self.release()
            self._typed(b'')

    def _readable(self) -> bool:
        """Read what was typed, and return whether there was something."""
        try:
            keys = self.keys()
        except OSError:
            keys = b''
        if keys:
            self._typed(keys)
        return bool(keys)


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

# of xterm and compatible terminals; rxvt and the console differ in some
_BY_END = {
    'A': 'up',
    'B': 'down',
    'C': 'right',
    'D': 'left',
    'H': 'home',
    'F': 'end',
}
_BY_NUMBER = {'1': 'home', '3': 'delete', '4': 'end', '7': 'home', '8': 'end'}
_CONTROLS = {
    **dict.fromkeys('\r\n', 'enter'),
    **dict.fromkeys('\x7f\x08', 'backspace'),
    '\t': 'tab',
}


class KeyDecoder:
    """
    Decodes bytes, which may be split anywhere, into keys.

    A key is a character, or a name of several: `enter`, `left`, `ctrl-a`,
    `alt-b`, `ctrl-right`. Other sequences are ignored.
    """

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder('utf-8')('replace')
        self._text = ''

    @property
    def is_waiting(self) -> bool:
        """Whether an Esc may be the start of more."""
        return self._text.startswith('\x1b')

    def feed(self, data: bytes) -> Iterator[str]:
        """Iterate over the keys up to the end of some more bytes."""
        self._text += self._decoder.decode(data)
        while self._text:
            size, key = self._first(self._text)
            if not size:
                return
            self._text = self._text[size:]
            if key:
                yield key

    def settle(self) -> Iterator[str]:
        """Return all keys, as nothing has followed an Esc for a while."""
        if self.is_waiting:
            self._text = self._text[1:]
            yield 'esc'
            yield from self.feed(b'')

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
        # Ctrl subtracts 0x40 from a letter (ASCII)
        return f'ctrl-{chr(ord(character) + 0x40).lower()}'
    return character if character.isprintable() else ''


def _named(parameters: str, end: str) -> str:
    first, _, modifier = parameters.partition(';')
    name = _BY_NUMBER.get(first) if end == '~' else _BY_END.get(end)
    # 1 is added to the sum of Shift 1, Alt 2 and Ctrl 4
    is_word = modifier.isdecimal() and (int(modifier[:3]) - 1) & 6
    return f'ctrl-{name}' if name and is_word else name or ''
