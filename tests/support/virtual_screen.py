# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A terminal, and what can be read on its screen."""

from collections.abc import Callable
import fcntl
import os
import select
import struct
import termios
import time

import pyte

#: Seconds after which something will not be shown any more.
DEADLINE = 60.0


class VirtualScreen:
    """
    A terminal that is emulated, with what has scrolled away.

    It is one of those that do not wrap lines anew for another size.
    """

    def __init__(self, columns: int = 80, lines: int = 24) -> None:
        #: The end of the terminal for us to type at.
        self.ours, self.theirs = os.openpty()
        self._screen = pyte.HistoryScreen(
            columns, lines, history=10_000, ratio=0.5
        )
        self._stream = pyte.ByteStream(self._screen)
        #: How many bytes have been shown.
        self.received = 0
        self.resize(columns, lines)

    def resize(self, columns: int, lines: int) -> None:
        """Give it another size."""
        self._take(0.0)
        self._screen.resize(lines, columns)
        size = struct.pack('HHHH', lines, columns, 0, 0)
        fcntl.ioctl(self.ours, termios.TIOCSWINSZ, size)

    @property
    def lines(self) -> list[str]:
        """The lines up to the last one that is not empty."""
        self._take(0.0)
        return _without_empty(self._screen.display)

    @property
    def all_lines(self) -> list[str]:
        """The same with those that have scrolled away."""
        self._take(0.0)
        columns = self._screen.columns
        gone = [
            ''.join(line[n].data for n in range(columns))
            for line in self._screen.history.top
        ]
        return _without_empty([*gone, *self._screen.display])

    @property
    def cursor(self) -> tuple[int, int]:
        """The line and the column of the cursor, counted from 0."""
        self._take(0.0)
        return self._screen.cursor.y, self._screen.cursor.x

    def colour_of(self, text: str) -> str:
        """Return the colour of the first letter of a text."""
        for number, line in enumerate(self.lines):
            if text in line:
                cells = self._screen.buffer[number]
                return str(cells[line.index(text)].fg)
        raise AssertionError(f'{text!r} is not on the screen: {self.lines}')

    def background_of(self, line: int) -> str:
        """Return the colour behind the first letter of a line."""
        self._take(0.0)
        return str(self._screen.buffer[line][0].bg)

    def shows(self, condition: Callable[[list[str]], object]) -> list[str]:
        """Wait until the lines are such, and return them."""
        deadline = time.monotonic() + DEADLINE
        while not condition(lines := self.lines):
            assert time.monotonic() < deadline, '\n'.join(self.all_lines)
            self._take(0.1)
        return lines

    def close(self) -> None:
        """Free it."""
        os.close(self.ours)
        os.close(self.theirs)

    def _take(self, seconds: float) -> None:
        while select.select([self.ours], [], [], seconds)[0]:
            try:
                data = os.read(self.ours, 1 << 16)
            except OSError:
                # nobody has it open any more
                return
            self.received += len(data)
            self._stream.feed(data)
            seconds = 0.0


def _without_empty(lines: list[str]) -> list[str]:
    lines = [line.rstrip() for line in lines]
    while lines and not lines[-1]:
        lines.pop()
    return lines
