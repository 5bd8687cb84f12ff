# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The pipes and terminals that processes write to."""

from contextlib import suppress
import fcntl
import os
import stat
import struct
import sys
import termios
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass

# the number of a terminal; Python has no name for it before 3.13
_TIOCGPTN = 0x80045430

#: Columns and lines of a terminal when we have none ourselves.
DEFAULT_SIZE = os.terminal_size((80, 24))


@dataclass(frozen=True, slots=True)
class Channel:
    """
    A way for output.

    :param reader: The end that the launcher reads from
    :param writer: The end that becomes a stream of the process
    """

    reader: int
    writer: int


def size_of(descriptor: int) -> os.terminal_size:
    """Return the size of a terminal, or :data:`DEFAULT_SIZE`."""
    try:
        size = os.get_terminal_size(descriptor)
    except OSError:
        return DEFAULT_SIZE
    return size if size.columns and size.lines else DEFAULT_SIZE


def resize(descriptor: int, size: os.terminal_size) -> None:
    """
    Set the size of a terminal.

    :raises OSError: when it is no terminal
    """
    data = struct.pack('HHHH', size.lines, size.columns, 0, 0)
    fcntl.ioctl(descriptor, termios.TIOCSWINSZ, data)


def writer_link(reader: int) -> str | None:
    """
    Return what /proc/PID/fd shows for those who write to the other end.

    :param reader: The end that is read from, of a pipe or a terminal
    """
    try:
        status = os.fstat(reader)
        if stat.S_ISFIFO(status.st_mode):
            return f'pipe:[{status.st_ino}]'
        number = fcntl.ioctl(reader, _TIOCGPTN, bytes(4))
    except OSError:
        return None
    return f'/dev/pts/{int.from_bytes(number, sys.byteorder)}'


def open_terminal(size: os.terminal_size) -> Channel:
    """
    Make a terminal.

    :raises OSError: when there are too many files or terminals
    """
    reader, writer = os.openpty()
    resize(writer, size)
    attributes = termios.tcgetattr(writer)
    # line ends stay as they are written, so that logs are exact
    attributes[1] &= ~termios.ONLCR
    termios.tcsetattr(writer, termios.TCSANOW, attributes)
    return Channel(reader, writer)


# the status block is below the cursor; it may have been cut off in the middle
# of a line, where the terminal wraps none (DECAWM), and output in the middle
# of a scroll region (DECSTBM), whose end moves the cursor
_ERASE = b'\x1b7\x1b[r\x1b8\x1b[?7h\x1b[0m\x1b[J'
# to where the output ends, which was saved with each drawing (DECRC)
_BACK = b'\x1b8'


@dataclass(frozen=True, slots=True)
class HeldTerminal:
    """
    A terminal, as the launcher has left it.

    :param descriptor: To write to; writing to it never waits
    :param before: The modes that it had before, as :mod:`termios` has them,
      but for numbers in the place of characters; or None
    :param now: Those that the launcher gave it, or None
    """

    descriptor: int
    before: list[Any] | None
    now: list[Any] | None

    def restore(self, *, goes_back: bool = False) -> None:
        """
        Leave the terminal as it was.

        A shell may be at its prompt already: what it has shown is before the
        cursor, and modes that it has set are left alone.

        :param goes_back: Whether the cursor is in the last line of the status
          block, as somebody types there, and not yet where a shell shows more
        """
        with suppress(OSError, termios.error):
            start = _BACK if goes_back else b''
            os.write(self.descriptor, start + _ERASE)
            modes = termios.tcgetattr(self.descriptor)
            if self.before is not None and as_numbers(modes) == self.now:
                termios.tcsetattr(
                    self.descriptor, termios.TCSANOW, self.before
                )


def as_numbers(modes: list[Any]) -> list[Any]:
    """Return modes of :mod:`termios` with numbers for their characters."""
    *numbers, characters = modes
    codes = [c if isinstance(c, int) else ord(c) for c in characters]
    return [*numbers, codes]
