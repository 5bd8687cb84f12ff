# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A terminal, what can be read on its screen, and a launch in it."""

from collections.abc import Callable
import fcntl
import os
import select
import struct
import termios
import time
from typing import Any

import pyte

#: Seconds after which something will not be shown any more.
DEADLINE = 60.0
#: How the line begins that tells what the keys mean.
HINT = ' ? help'


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


class StatusLaunch:
    """A launch that has a terminal for itself, or the shell that runs it."""

    def __init__(
        self,
        make: Callable[..., Any],
        size: tuple[int, int],
        entries: tuple[dict[str, Any], ...],
        shell: tuple[str, ...],
        settings: dict[str, Any],
    ) -> None:
        self.screen = VirtualScreen(*size)
        self.modes = termios.tcgetattr(self.screen.theirs)
        terminal = self.screen.theirs
        environment = {
            'TERM': 'xterm',
            'PYTHONIOENCODING': 'utf-8',
            **settings.pop('variables', {}),
        }
        self.launch = make(
            *entries,
            color=True,
            status=True,
            environment=environment,
            popen={
                'stdin': settings.pop('stdin', terminal),
                'stdout': terminal,
                'stderr': terminal,
                'preexec_fn': lambda: fcntl.ioctl(1, termios.TIOCSCTTY, 0),
            },
            shell=shell,
            **settings,
        )

    def types(self, keys: str) -> 'StatusLaunch':
        """Type at the terminal."""
        os.write(self.screen.ours, keys.encode())
        return self

    def shows(self, *texts: str) -> list[str]:
        """
        Wait until the last lines begin with some texts, and return all.

        What the keys mean is left out.
        """

        def are_there(lines: list[str]) -> bool:
            lines = [line for line in lines if not line.startswith(HINT)]
            return len(lines) >= len(texts) and all(
                line.startswith(text)
                for line, text in zip(lines[-len(texts) :], texts, strict=True)
            )

        return self.screen.shows(are_there)

    def ends(self) -> int:
        """Wait for the end; the terminal is as it was."""
        # who writes at a terminal waits for it to be read
        self.screen.shows(lambda _: self.launch.popen.poll() is not None)
        assert termios.tcgetattr(self.screen.theirs) == self.modes
        return int(self.launch.popen.wait())
