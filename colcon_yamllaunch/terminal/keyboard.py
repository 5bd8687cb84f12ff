# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The user's own keyboard while its keys go to a process."""

import os
import select
import termios
from typing import Any

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
    A terminal that each key is taken from as it comes.

    Ctrl-C and Ctrl-Z stay signals to whoever reads; all other keys are taken
    as they are.

    :param takes_keys: Whether we read them; if not, they are only not shown,
      and wait for who does
    """

    def __init__(self, descriptor: int, *, takes_keys: bool = True) -> None:
        self.descriptor = descriptor
        #: Whether keys are to be read from it.
        self.takes_keys = takes_keys
        self._before: list[Any] | None = None

    def grab(self) -> bool:
        """
        Take keys as they come, from now on.

        Called once more, it undoes what a shell has set meanwhile. Return
        False when another job has the terminal, or it is gone.
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
        """Leave the terminal as it was."""
        before, self._before = self._before, None
        if before is None or not is_in_foreground(self.descriptor):
            # the shell that has it now has set it as it wants it
            return
        try:
            termios.tcsetattr(self.descriptor, termios.TCSANOW, before)
        except termios.error:
            # it is gone
            return

    def read(self) -> tuple[bytes, bool]:
        """
        Return the keys that were typed, and whether the escape key was.

        What follows the escape key is dropped.

        :raises OSError: when the terminal is gone
        """
        keys, escape, _ = self.keys().partition(ESCAPE)
        return keys, bool(escape)

    def keys(self) -> bytes:
        """
        Return what was typed, or nothing; it does not wait for more.

        :raises OSError: when the terminal is gone
        """
        poll = select.poll()
        poll.register(self.descriptor, select.POLLIN)
        return _read(self.descriptor) if poll.poll(0) else b''

    def _modes(self, before: list[Any]) -> list[Any]:
        return _raw(before) if self.takes_keys else _silent(before)


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


def _silent(attributes: list[Any]) -> list[Any]:
    result = [*attributes[:_CC], list(attributes[_CC])]
    result[_LFLAG] &= ~termios.ECHO
    return result


def _raw(attributes: list[Any]) -> list[Any]:
    result = [*attributes[:_CC], list(attributes[_CC])]
    result[_IFLAG] &= ~_INPUT
    result[_LFLAG] &= ~_LOCAL
    characters = result[_CC]
    # what is read at once without a key is the end of the input for a shell
    # that has the terminal before the guard of a killed launch
    characters[termios.VMIN], characters[termios.VTIME] = 1, 0
    characters[termios.VQUIT] = _NONE
    return result


def is_in_foreground(descriptor: int) -> bool:
    """Tell whether a terminal is ours, and not that of another job."""
    try:
        return os.tcgetpgrp(descriptor) == os.getpgrp()
    except OSError:
        # it is a terminal, but not ours to control jobs with
        return os.isatty(descriptor)
