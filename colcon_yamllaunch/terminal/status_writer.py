# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A writer to a terminal that draws a block below the output.

The block is below the cursor, which stays where the output ends. So one
sequence erases the block, even after the terminal has wrapped its lines for
another size; and if the launcher is killed, its guard only erases what is
below the cursor, which is always visible.

Output erases the block, which is drawn again after it. In a flood, that would
be too often, or the block would be missing; so the lines above the block
scroll alone, in a scroll region that is set for one write.

This does not use a library such as prompt_toolkit: importing that takes 0.07 s
(all code for the terminal of a launch 0.01 s); and output above its prompt
waits in an unbounded queue, while processes that write more than a terminal
takes must wait.
"""

import codecs
from collections.abc import Callable
import math
import os
import re
import select
import time

from colcon_yamllaunch.engine.writer import Writer
from colcon_yamllaunch.terminal.status_block import StatusBlock

#: Seconds between two drawings of the block. What is written meanwhile is held
#: back, so that the block is not missing for a moment.
INTERVAL = 0.1
#: The same where the terminal does not take what it gets as fast as it comes.
SLOW_INTERVAL = 1.0
#: Bytes that are held back at most; as many in that time are a flood.
HELD = 64 * 1024
#: Seconds that a terminal gets to take the last of it before a suspension.
DRAIN_TIMEOUT = 0.2

# ECMA-48 but for the cursor, whose place DEC's terminals save (DECSC, DECRC)
_SAVE = '\x1b7'
_RESTORE = '\x1b8'
_INDEX = '\x1bD'
_PLAIN = '\x1b[0m'
# cut a line that is longer than computed, instead of wrapping it (DECAWM)
_CUT = '\x1b[?7l'
_WRAP = '\x1b[?7h'
_TO_LINE_END = '\x1b[K'
_TO_SCREEN_END = '\x1b[J'

# of ECMA-48: CSI, OSC and other strings, and escape sequences; controls of
# both sets, those of eight bits also where they are no UTF-8
_SEQUENCES = (
    r'\x1b\[(?P<parameters>[0-?]*)(?P<end>[ -/]*[@-~])'
    r'|\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)'
    r'|\x1b[PX^_][^\x1b]*\x1b\\'
    r'|\x1b[ -/]*[0-~]'
    r'|\x1b'
    r'|[\x00-\x06\x0b\x0c\x0e-\x1f\x7f-\x9f\udc80-\udc9f]'
)
# the start of one
_UNFINISHED = (
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

#: Returns the block at a time, None for none, and when it may be another one,
#: if nothing happens before.
Compose = Callable[[float], tuple[StatusBlock | None, float | None]]


class StatusWriter(Writer):
    """
    A writer to a terminal, with a block below the output.

    :param clock: Returns seconds that never go back
    """

    def __init__(
        self, descriptor: int, clock: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(descriptor)
        self._clock = clock
        self._compose: Compose | None = None
        self._block = StatusBlock(())
        # whether the block is drawn now; whether there is no block at
        # present; whether to compose it again
        self._is_shown = False
        self._is_hidden = False
        self._is_stale = False
        self._in_line: dict[object, InLineOutput] = {}
        # whether a process may have left its colours on
        self._is_painted = False
        # whether the output ends in the middle of a line
        self._is_mid_line = False
        # when the block may be drawn again, and when it changes by itself
        self._due = 0.0
        self._next: float | None = None
        self._is_holding = False
        # whether the terminal has not taken all that it got, and whether it
        # has taken anything since the last drawing
        self._is_behind = False
        self._has_moved = True
        # its size, if known, and how many lines there are below the cursor at
        # most
        self._size = os.terminal_size((0, 0))
        self._lines_below = 0
        # bytes of output since a time, and whether they were many before it
        self._amount = 0
        self._counted = 0.0
        self._is_flooded = False
        # whether the lines above the block scroll alone, in a region of theirs
        self._in_region = False

    def begin(self, compose: Compose) -> None:
        """Draw the block from now on."""
        self._compose = compose
        self.resized()

    def resized(self) -> None:
        """Redraw the block, as the size of the terminal may have changed."""
        self._size = self._size_now()
        self._lines_below = self._size.lines
        self._is_stale = True

    def end(self) -> None:
        """Erase the block; the output goes on in its place."""
        if self._is_shown:
            self._erase()
        self._end_colours()
        self._compose = None
        self._is_holding = False
        self.flush()

    def leave(self) -> None:
        """Erase the block before another program gets the terminal."""
        self.end()
        poll = select.poll()
        poll.register(self.descriptor, select.POLLOUT)
        end = time.monotonic() + DRAIN_TIMEOUT
        while self.waits() and poll.poll(
            1000 * max(0.0, end - time.monotonic())
        ):
            self.flush()

    def touch(self, *, at_once: bool = False) -> None:
        """
        Redraw the block as soon as it is due.

        :param at_once: Whether to redraw it now, as somebody types
        """
        self._is_stale = True
        if at_once:
            self._due = 0.0

    def write(self, key: object, data: bytes) -> None:
        """Write something above the block."""
        if data and self._is_painted:
            if self._is_shown:
                self._erase()
            self._end_colours()
        self._write_above(key, data)

    def write_raw(self, key: object, data: bytes) -> None:
        """Write the raw output of a process; it cannot alter the block."""
        if key not in self._in_line:
            self._in_line[key] = InLineOutput()
        data = self._in_line[key].feed(data)
        self._is_painted |= b'\x1b' in data
        self._write_above(key, data)
        # typed characters are shown at once
        self._due = 0.0

    def steer(self, data: bytes) -> None:
        """Write something invisible, such as the title; the block stays."""
        super().write(None, data)

    def flush(self) -> None:
        """Show as much as can be shown without waiting, and the block."""
        # in a flood, this is called for every few kilobytes
        self._is_holding = False
        if self._in_region:
            self._end_region()
        if self._compose is not None and not self.broken:
            now = self._clock()
            if now >= self._counted + INTERVAL:
                self._is_flooded = self._amount >= HELD
                self._amount, self._counted = 0, now
            if self._next is not None and now >= self._next:
                self._is_stale = True
            if self._is_stale or not (self._is_shown or self._is_hidden):
                if now >= self._due_now():
                    self._draw(self._compose, now)
                elif self._may_hold():
                    self._is_holding = True
                    return
        super().flush()
        self._is_behind = bool(self._queue)

    def waits(self) -> bool:
        """Return whether something waits for the terminal."""
        return not self._is_holding and super().waits()

    def due(self) -> float | None:
        """Return the time when the block is to be drawn again, or None."""
        if self._compose is None or self.broken:
            return None
        if self._is_stale or not (self._is_shown or self._is_hidden):
            return self._due_now()
        return self._next

    def _write_above(self, key: object, data: bytes) -> None:
        if not data or self.broken:
            return
        self._amount += len(data)
        if self._is_shown:
            if self._may_scroll_above(data):
                self._scroll_above(key, data)
                return
            self._erase()
        super().write(key, data)
        self._is_mid_line = not data.endswith(b'\n')
        if self._lines_below:
            self._lines_below = max(0, self._lines_below - data.count(b'\n'))

    def _end_colours(self) -> None:
        if self._is_painted:
            self._is_painted = False
            super().write(None, _PLAIN.encode())

    def _may_hold(self) -> bool:
        """Return whether to hold output back until the next drawing."""
        is_missing = not (self._is_shown or self._is_hidden)
        return is_missing and self._total < HELD and not self._is_behind

    def _due_now(self) -> float:
        if not self._is_behind:
            return self._due
        if not self._has_moved:
            # the terminal takes nothing at all
            return math.inf
        if not self._is_shown and self._lines_below < len(self._block.lines):
            # once drawn, the block stays
            return self._due
        return self._due - INTERVAL + SLOW_INTERVAL

    def _draw(self, compose: Compose, now: float) -> None:
        if self._is_stale:
            before = self._block
            block, self._next = compose(now)
            self._is_stale = False
            self._is_hidden = block is None
            if block is None:
                if self._is_shown:
                    self._erase()
                return
            if self._is_shown and block == before:
                return
            if self._is_shown and before.cursor is not None:
                super().write(None, _RESTORE.encode())
            self._block = block
        super().write(None, drawn(self._block, self._is_mid_line))
        lines = len(self._block.lines) - 1 + self._is_mid_line
        self._lines_below = max(self._lines_below, lines)
        self._is_shown = True
        self._has_moved = False
        self._due = now + INTERVAL

    def _took(self, size: int) -> None:
        super()._took(size)
        self._has_moved = True

    def _may_scroll_above(self, data: bytes) -> bool:
        """Return whether the block can stay while lines scroll above it."""
        if self._in_region:
            return data.endswith(b'\n')
        below = len(self._block.lines) - 1
        return (
            (self._is_flooded or self._is_behind)
            and data.endswith(b'\n')
            and not self._is_mid_line
            # the block would be drawn in these colours
            and not self._is_painted
            # the block is certainly at the end of the terminal
            and self._lines_below == below
            and self._size.lines > below + 2
            and self._size == self._size_now()
        )

    def _scroll_above(self, key: object, data: bytes) -> None:
        """Show lines above the block, which stays."""
        if not self._in_region:
            self._in_region = True
            last = self._size.lines - len(self._block.lines)
            super().write(None, b'\x1b[1;%dr\x1b[%d;1H' % (last, last))
        # the line end comes first, as the block begins below the last line
        self._add(None, b'\n')
        self._add(key, memoryview(data)[:-1])

    def _end_region(self) -> None:
        """Scroll the whole screen again, with the cursor at its place."""
        if self._in_region:
            self._in_region = False
            line, column = self._block.cursor or (0, 0)
            line += self._size.lines - len(self._block.lines) + 1
            super().write(None, b'\x1b[r\x1b[%d;%dH' % (line, column + 1))

    def _size_now(self) -> os.terminal_size:
        try:
            return os.get_terminal_size(self.descriptor)
        except OSError:
            return os.terminal_size((0, 0))

    def _erase(self) -> None:
        self._end_region()
        self._is_shown = False
        data = erased(self._block, self._is_mid_line)
        super().write(None, data)


def drawn(block: StatusBlock, is_mid_line: bool) -> bytes:
    """
    Return what draws a block, and leaves the cursor where it was.

    :param is_mid_line: Whether it is in the middle of a line, which stays
    """
    lines = block.lines
    if not lines:
        return _TO_SCREEN_END.encode()
    below = len(lines) - 1 + is_mid_line
    # making room may scroll, and the cursor moves with its line
    room = f'{_INDEX * below}\x1b[{below}A' if below else ''
    start = '\r\n' if is_mid_line else '\r'
    text = f'{_TO_LINE_END}\r\n'.join(lines)
    back = _RESTORE
    if block.cursor is not None:
        line, column = block.cursor
        up = len(lines) - 1 - line
        back = '\r'
        if up:
            back += f'\x1b[{up}A'
        if column:
            back += f'\x1b[{column}C'
    body = f'{_PLAIN}{_CUT}{start}{text}{_TO_SCREEN_END}{_WRAP}'
    return f'{room}{_SAVE}{body}{back}'.encode(errors='replace')


def erased(block: StatusBlock, is_mid_line: bool) -> bytes:
    """Return what erases a block, and moves the cursor back."""
    back = _RESTORE if block.cursor is not None else ''
    if is_mid_line and not block.lines:
        return back.encode()
    # it may be at the start of its line, though in the middle of what is
    # written, and what is erased gets the background that is on
    start, down = ('', '\x1b[B') if is_mid_line else ('\r', '')
    erase = f'{_PLAIN}{down}\r{_TO_SCREEN_END}'
    return f'{back}{start}{_SAVE}{erase}{_RESTORE}'.encode()


class InLineOutput:
    """
    The output of a process that has the keyboard, without what leaves a line.

    It is shown as it comes, half lines and all, so that prompts and editing
    work; but it keeps to its line. A program that draws in all of its terminal
    needs a terminal of its own.
    """

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder('utf-8')(_ERRORS)
        self._unfinished = ''

    def feed(self, data: bytes) -> bytes:
        """Return what is to be shown now."""
        text = self._unfinished + self._decoder.decode(data)
        self._unfinished = ''
        start = re.search(_UNFINISHED, text)
        if start is not None and len(start[0]) <= _LONGEST:
            self._unfinished = start[0]
            text = text[: start.start()]
        return re.sub(_SEQUENCES, _if_harmless, text).encode(errors=_ERRORS)


def _if_harmless(match: re.Match[str]) -> str:
    parameters, end = match['parameters'], match['end']
    if end in _HARMLESS and not parameters.startswith(_PRIVATE):
        return match[0]
    return ''
