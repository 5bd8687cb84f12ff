# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A terminal in which a command runs, and what stands on its screen."""

from collections.abc import Iterator, Mapping
import fcntl
from itertools import groupby
import os
from pathlib import Path
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from typing import NamedTuple

import pyte

#: Seconds until what is waited for is there, on a busy machine.
PATIENCE = 120.0
#: Seconds after which what is drawn at once has been drawn.
SETTLED = 0.02


class Piece(NamedTuple):
    """
    A text of one colour in a row.

    :param column: Where it begins
    :param color: `default`, a name of pyte, or six hexadecimal digits
    :param ground: Likewise, behind it
    """

    column: int
    text: str
    color: str
    ground: str
    is_bold: bool


#: What stands in a row.
Row = tuple[Piece, ...]


class _Screen(pyte.HistoryScreen):
    def select_graphic_rendition(self, *attrs: int) -> None:
        # pyte knows no faint text
        super().select_graphic_rendition(*(90,) if attrs == (2,) else attrs)


class RecordedTerminal:
    """
    A terminal of a size, in which one command runs after the other.

    :param environment: What differs in it from that of this program
    """

    def __init__(
        self, columns: int, rows: int, environment: Mapping[str, str]
    ) -> None:
        #: Its width.
        self.columns = columns
        self._ours, self._theirs = os.openpty()
        self._screen = _Screen(columns, rows, history=10_000, ratio=0.5)
        self._stream = pyte.ByteStream(self._screen)
        self._environment = dict(environment)
        self._process: subprocess.Popen[bytes] | None = None
        self.resize(columns, rows)

    def __enter__(self) -> 'RecordedTerminal':
        return self

    def __exit__(self, *_: object) -> None:
        process = self._process
        if process is not None and process.poll() is None:
            # as Ctrl-C does, so that nothing is left
            process.send_signal(signal.SIGINT)
            while process.poll() is None:
                self.read(0.1)
        os.close(self._ours)
        os.close(self._theirs)

    def resize(self, columns: int, rows: int) -> None:
        """Give it another size."""
        self.columns = columns
        self._screen.resize(rows, columns)
        size = struct.pack('HHHH', rows, columns, 0, 0)
        fcntl.ioctl(self._ours, termios.TIOCSWINSZ, size)
        if self._process is not None:
            self._process.send_signal(signal.SIGWINCH)

    def run(self, *command: str, folder: Path) -> None:
        """Start a command, which has the terminal for its own."""
        self._process = subprocess.Popen(
            command,
            cwd=folder,
            env=_environment() | self._environment,
            stdin=self._theirs,
            stdout=self._theirs,
            stderr=self._theirs,
            start_new_session=True,
            preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
        )

    @property
    def is_running(self) -> bool:
        """Whether the command has not ended."""
        return self._process is not None and self._process.poll() is None

    def show(self, text: str) -> None:
        """Show something as if it had been written in it."""
        self._stream.feed(text.replace('\n', '\r\n').encode())

    def type(self, keys: str) -> None:
        """Press keys."""
        os.write(self._ours, keys.encode())

    def read(self, seconds: float) -> bool:
        """Take what comes, and return whether anything has come."""
        has_come = False
        while select.select([self._ours], [], [], seconds)[0]:
            self._stream.feed(os.read(self._ours, 1 << 16))
            has_come, seconds = True, SETTLED
        return has_come

    def wait_for(self, *texts: str, count: int = 1) -> None:
        """
        Wait until texts stand on the screen.

        :param count: How often each of them at least
        """
        if not self.comes(*texts, count=count):
            raise SystemExit(f'{texts} did not come:\n{self.text}')

    def comes(
        self, *texts: str, count: int = 1, seconds: float = PATIENCE
    ) -> bool:
        """Wait for texts, and return whether they have come in time."""
        deadline = time.monotonic() + seconds
        while not all(self.text.count(text) >= count for text in texts):
            if time.monotonic() > deadline:
                return False
            self.read(0.1)
        return True

    def wait(self, seconds: float) -> None:
        """Let it go on for a while."""
        deadline = time.monotonic() + seconds
        while (left := deadline - time.monotonic()) > 0.0:
            self.read(left)

    @property
    def text(self) -> str:
        """What stands on the screen."""
        return '\n'.join(line.rstrip() for line in self._screen.display)

    def rows(self, *, with_cursor: bool = False) -> list[Row]:
        """Return the rows up to the last one that is not empty."""
        screen = self._screen
        if with_cursor:
            cells = screen.buffer[screen.cursor.y]
            column = screen.cursor.x
            cells[column] = cells[column]._replace(reverse=True)
        rows = range(screen.lines)
        return _without_empty(self._row(screen.buffer[y]) for y in rows)

    @property
    def written(self) -> int:
        """How many rows have been written above that of the cursor."""
        return len(self._screen.history.top) + self._screen.cursor.y

    def output(self, start: int) -> list[Row]:
        """Return these, from a number on."""
        screen = self._screen
        gone = screen.history.top
        return [
            self._row(
                gone[n] if n < len(gone) else screen.buffer[n - len(gone)]
            )
            for n in range(start, self.written)
        ]

    def below(self) -> list[Row]:
        """Return the rows from that of the cursor on."""
        screen = self._screen
        rows = range(screen.cursor.y, screen.lines)
        return _without_empty(self._row(screen.buffer[y]) for y in rows)

    def _row(self, cells: Mapping[int, pyte.screens.Char]) -> Row:
        return tuple(_pieces(cells, self._screen.columns))


def _pieces(
    cells: Mapping[int, pyte.screens.Char], columns: int
) -> Iterator[Piece]:
    looks = ((n, cells[n].data, *_look(cells[n])) for n in range(columns))
    for (color, ground, is_bold), group in groupby(looks, lambda c: c[2:]):
        found = list(group)
        text = ''.join(cell[1] for cell in found)
        if text.strip() or ground != 'default':
            yield Piece(found[0][0], text, color, ground, is_bold)


def _look(cell: pyte.screens.Char) -> tuple[str, str, bool]:
    color, ground = cell.fg, cell.bg
    if cell.reverse:
        color, ground = (
            'background' if ground == 'default' else ground,
            'foreground' if color == 'default' else color,
        )
    return color, ground, cell.bold


def _without_empty(rows: Iterator[Row]) -> list[Row]:
    found = list(rows)
    while found and not found[-1]:
        found.pop()
    return found


def _environment() -> dict[str, str]:
    """Return that of a user at a terminal of a desktop."""
    ours = Path(sys.executable).parent
    passed = {
        name: value
        for name, value in os.environ.items()
        if name in ('HOME', 'TMPDIR', 'USER', 'XDG_RUNTIME_DIR')
    }
    return passed | {
        'PATH': f'{ours}:{os.environ["PATH"]}',
        'LANG': 'C.UTF-8',
        'TERM': 'xterm-256color',
        'COLORTERM': 'truecolor',
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
