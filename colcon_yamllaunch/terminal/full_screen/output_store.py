# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The output of a launch: the kept lines, and a filtered view of them."""

from bisect import bisect_left
from collections import defaultdict, deque
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
import heapq
from operator import attrgetter
import re

from colcon_yamllaunch.common.printable import SEQUENCE
from colcon_yamllaunch.control.subscription import ReceivedOutput
from colcon_yamllaunch.engine.lines import legible
from colcon_yamllaunch.observers.log_levels import Level, level_of
from colcon_yamllaunch.terminal.line_filter import (
    Filtering,
    FIRST_LEVELS,
    last_state,
    TIMES,
)

#: Lines that are kept of each process.
LINES_KEPT = 5_000
#: Characters that are kept of all processes together.
CHARACTERS_KEPT = 16 * 1024 * 1024
#: Characters that are kept of a line; the log has all of it.
LONGEST_LINE = 4_000
#: Lines that a view has at most.
VIEW_LINES = 20_000

_SEQUENCE = re.compile(SEQUENCE)


@dataclass(slots=True, eq=False)
class Line:
    """
    A line.

    :param order: Its number among all lines of the launch
    :param time: When it came, in seconds since the epoch
    :param label: The process that wrote it; None for a line about the launch
    :param text: Its text, colours included
    :param level: Its level, or that of the line before
    :param is_leveled: Whether the line has a level of its own
    :param is_note: Whether it is an event and no output
    :param count: How often it came in a row
    """

    order: int
    time: float
    label: str | None
    text: str
    level: Level = Level.INFO
    is_leveled: bool = False
    is_note: bool = False
    count: int = 1


@dataclass(slots=True)
class _Kept:
    """
    The kept lines of one process.

    :param size: The characters of all lines
    :param levels: The level of the last line of each stream
    :param unfinished: The lines that go on in place, by stream
    """

    lines: deque[Line] = field(default_factory=deque)
    size: int = 0
    levels: dict[str, Level] = field(default_factory=dict)
    unfinished: dict[str, Line] = field(default_factory=dict)


class OutputStore:
    """
    Keeps the last lines of each process.

    :param limit: Lines that are kept of each process
    :param characters: Characters that are kept of all of them
    :param form: That of lines, see `log_levels.FORMAT`
    """

    def __init__(
        self,
        limit: int = LINES_KEPT,
        characters: int = CHARACTERS_KEPT,
        form: str | None = None,
    ) -> None:
        self._limit = limit
        self._characters = characters
        self._form = form
        self._kept: defaultdict[str | None, _Kept] = defaultdict(_Kept)
        #: The characters that are kept.
        self.size = 0
        self._order = 0
        # the last line, and its bytes without times, to find repetitions
        self._last: tuple[Line, bytes] | None = None
        #: Lines whose text changed since :meth:`OutputView.pop_altered`.
        self.altered: dict[Line, None] = {}

    def add(self, wrote: ReceivedOutput) -> list[Line]:
        """
        Add the output of a process, and return the lines that are new.

        A progress display that goes back by a carriage return is one line,
        which changes. So does one that comes again.
        """
        kept = self._kept[wrote.process]
        *pieces, rest = wrote.data.split(b'\n')
        if rest:
            pieces.append(rest)
        # of too many lines, the last ones are kept
        skipped = max(0, len(pieces) - self._limit)
        made = []
        for number, piece in enumerate(pieces[skipped:], skipped):
            is_open = number == len(pieces) - 1 and bool(rest)
            line = self._piece(kept, wrote, piece, is_open)
            if line is not None:
                made.append(line)
        self._shrink()
        return made

    def add_note(
        self, label: str | None, text: str, time: float, level: Level
    ) -> Line:
        """Add a line about a process, or about the launch."""
        kept = self._kept[label]
        # the next output of the process begins a new line
        kept.unfinished.clear()
        kept.levels.clear()
        line = self._append(time, label, text[:LONGEST_LINE], level)
        line.is_note = True
        self._last = None
        self._shrink()
        return line

    def alter(self, line: Line, text: str) -> None:
        """Replace the text of a line."""
        self._grow(self._kept[line.label], len(text) - len(line.text))
        line.text = text
        self.altered[line] = None

    def lines(self, labels: Collection[str] | None) -> Iterator[Line]:
        """
        Iterate over lines in the order in which they came.

        :param labels: The processes that are meant; None for all. Those of
          the launch are always among them
        """
        meant = [
            kept.lines
            for label, kept in self._kept.items()
            if label is None or labels is None or label in labels
        ]
        return heapq.merge(*meant, key=attrgetter('order'))

    def _piece(
        self, kept: _Kept, wrote: ReceivedOutput, piece: bytes, is_open: bool
    ) -> Line | None:
        """Add a line, or change the last one; return a new line."""
        stream = wrote.stream
        goes_on = is_open and piece.endswith(b'\r')
        # the last text after a carriage return replaces the others
        piece = last_state(piece)
        own_level = level_of(piece, self._form)
        level = own_level or kept.levels.get(stream)
        level = level or FIRST_LEVELS.get(stream, Level.INFO)
        kept.levels[stream] = level
        text = legible(piece[: 4 * LONGEST_LINE], terminal=True).decode()
        if len(text) > LONGEST_LINE:
            text = text[:LONGEST_LINE] + '…'
        before = kept.unfinished.pop(stream, None)
        if before is not None:
            if text:
                self.alter(before, text)
                before.time = wrote.time
                before.level = level
            if goes_on:
                kept.unfinished[stream] = before
            return None
        compared = TIMES.sub(b'', piece)
        if self._last is not None:
            last, by = self._last
            if by == compared and last.label == wrote.process:
                last.count += 1
                last.time = wrote.time
                self.alter(last, text)
                return None
        line = self._append(wrote.time, wrote.process, text, level)
        line.is_leveled = own_level is not None
        if goes_on:
            kept.unfinished[stream] = line
        # an empty line separates equal lines
        self._last = (line, compared) if piece else None
        return line

    def _append(
        self, time: float, label: str | None, text: str, level: Level
    ) -> Line:
        self._order += 1
        line = Line(self._order, time, label, text, level)
        kept = self._kept[label]
        kept.lines.append(line)
        self._grow(kept, len(text) + 1)
        if len(kept.lines) > self._limit:
            self._drop(kept)
        return line

    def _drop(self, kept: _Kept) -> None:
        self._grow(kept, -len(kept.lines.popleft().text) - 1)

    def _grow(self, kept: _Kept, size: int) -> None:
        kept.size += size
        self.size += size

    def _shrink(self) -> None:
        """Drop the oldest lines of the process with the most characters."""
        while self.size > self._characters:
            biggest = max(self._kept.values(), key=attrgetter('size'))
            for _ in range((len(biggest.lines) + 1) // 2):
                self._drop(biggest)


class OutputView:
    """
    The lines that the filter lets through.

    :param limit: How many there are at most
    """

    def __init__(self, store: OutputStore, limit: int = VIEW_LINES) -> None:
        self._store = store
        self._limit = limit
        self.filtering = Filtering()
        self.lines: list[Line] = []
        #: How many lines have been left out at the front since the last
        #: choice.
        self.dropped = 0
        #: Grows with each choice.
        self.version = 0

    def choose(self, filtering: Filtering) -> None:
        """Show the lines that a filter lets through."""
        self.filtering = filtering
        only = filtering.only or None
        self.lines = list(filter(self._has, self._store.lines(only)))
        self.dropped = 0
        self.version += 1
        self._trim()

    def add(self, lines: Iterable[Line]) -> None:
        """Add lines that are new in the store."""
        self.lines += filter(self._has, lines)
        self._trim()

    def place_of(self, order: int) -> int:
        """Return the index of a line, or of the next one in the view."""
        return bisect_left(self.lines, order, key=attrgetter('order'))

    def pop_altered(self) -> list[int]:
        """Return the indices of lines that changed since the last call."""
        altered, self._store.altered = self._store.altered, {}
        found = ((self.place_of(line.order), line) for line in altered)
        return [
            place
            for place, line in found
            if place < len(self.lines) and self.lines[place] is line
        ]

    def _has(self, line: Line) -> bool:
        """Return whether a line is shown."""
        return self.filtering.shows(line.label, line.level, plain(line.text))

    def _trim(self) -> None:
        # drop many at once, as each removal moves all others
        if len(self.lines) > self._limit:
            excess = len(self.lines) - self._limit * 3 // 4
            del self.lines[:excess]
            self.dropped += excess


def plain(text: str) -> str:
    """Return a line without colours."""
    return _SEQUENCE.sub('', text) if '\x1b' in text else text
