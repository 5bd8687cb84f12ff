# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The last lines of each process, in bounded memory."""

from collections import deque
from collections.abc import Collection
from collections.abc import Iterator
from dataclasses import dataclass
import heapq
from operator import attrgetter

from colcon_yamllaunch.runtime.clients.subscription import Wrote
from colcon_yamllaunch.runtime.streams.lines import legible
from colcon_yamllaunch.ui.line_levels import INFO
from colcon_yamllaunch.ui.line_levels import level_of

#: Lines that are kept of each process.
LINES = 5_000
#: Characters that are kept of all processes together.
CHARACTERS = 16 * 1024 * 1024
#: Characters that are kept of a line; the log has all of it.
LINE = 4_000


@dataclass(slots=True, eq=False)
class Line:
    """
    A line.

    :param order: Counts all lines of the launch
    :param time: When it came, in seconds since the epoch
    :param label: The process that it is of; None where it is of the launch
    :param text: What is shown of it, colours included
    :param level: Its severity, a number of `line_levels`
    :param is_told: Whether it tells of the process, which did not write it
    :param count: How often it came in a row
    """

    order: int
    time: float
    label: str | None
    text: str
    level: int = INFO
    is_told: bool = False
    count: int = 1


@dataclass(slots=True)
class _Kept:
    """
    What is kept of one process.

    :param size: The characters of all lines
    :param levels: The severity of the last line of each stream
    :param unfinished: The lines that go on in place, by stream
    """

    lines: deque[Line]
    size: int
    levels: dict[str, int]
    unfinished: dict[str, Line]


class OutputStore:
    """
    Keeps the last lines.

    :param limit: Lines that are kept of each process
    :param characters: Characters that are kept of all of them
    """

    def __init__(
        self, limit: int = LINES, characters: int = CHARACTERS
    ) -> None:
        self._limit = limit
        self._characters = characters
        self._kept: dict[str | None, _Kept] = {}
        self._size = 0
        self._order = 0
        self._last: Line | None = None

    @property
    def size(self) -> int:
        """The characters that are kept."""
        return self._size

    def take(self, wrote: Wrote) -> list[Line]:
        """
        Take what a process wrote, and return the lines that are new.

        A progress display that goes back by a carriage return is one line,
        which changes. So does one that comes again.
        """
        kept = self._of(wrote.process)
        text = wrote.data
        *pieces, rest = text.split(b'\n')
        if rest:
            pieces.append(rest)
        # of a lot only the end is kept
        skipped = max(0, len(pieces) - self._limit)
        made = []
        for number, piece in enumerate(pieces[skipped:], skipped):
            is_open = number == len(pieces) - 1 and bool(rest)
            line = self._piece(kept, wrote, piece, is_open)
            if line is not None:
                made.append(line)
        self._shrink()
        return made

    def tell(
        self, label: str | None, text: str, time: float, level: int
    ) -> Line:
        """Take a line about a process, or about the launch."""
        kept = self._of(label)
        # what the process writes next is no part of the line before
        kept.unfinished.clear()
        kept.levels.clear()
        line = self._new(time, label, text[:LINE], level, is_told=True)
        self._add(kept, line)
        self._shrink()
        return line

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
        self, kept: _Kept, wrote: Wrote, piece: bytes, is_open: bool
    ) -> Line | None:
        """Take a line; return it unless it is one that was there."""
        stream = wrote.stream
        goes_on = is_open and piece.endswith(b'\r')
        if b'\r' in piece:
            # what was written over is not seen any more
            piece = piece.rstrip(b'\r').rpartition(b'\r')[2]
        text = legible(piece[: 4 * LINE], terminal=True).decode()
        if len(text) > LINE:
            text = text[:LINE] + '…'
        level = level_of(text)
        if level is None:
            level = kept.levels.get(stream, INFO)
        else:
            kept.levels[stream] = level
        before = kept.unfinished.pop(stream, None)
        if before is not None:
            if text:
                self._size += len(text) - len(before.text)
                kept.size += len(text) - len(before.text)
                before.text = text
                before.time = wrote.time
            if goes_on:
                kept.unfinished[stream] = before
            return None
        last = self._last
        if (
            last is not None
            and last.text == text
            and last.label == wrote.process
            and not last.is_told
        ):
            last.count += 1
            last.time = wrote.time
            return None
        line = self._new(wrote.time, wrote.process, text, level)
        if goes_on:
            kept.unfinished[stream] = line
        self._add(kept, line)
        return line

    def _of(self, label: str | None) -> _Kept:
        kept = self._kept.get(label)
        if kept is None:
            kept = self._kept[label] = _Kept(deque(), 0, {}, {})
        return kept

    def _new(
        self,
        time: float,
        label: str | None,
        text: str,
        level: int,
        *,
        is_told: bool = False,
    ) -> Line:
        self._order += 1
        return Line(self._order, time, label, text, level, is_told)

    def _add(self, kept: _Kept, line: Line) -> None:
        kept.lines.append(line)
        self._grow(kept, len(line.text) + 1)
        self._last = line
        if len(kept.lines) > self._limit:
            self._drop(kept)

    def _drop(self, kept: _Kept) -> None:
        self._grow(kept, -len(kept.lines.popleft().text) - 1)

    def _grow(self, kept: _Kept, size: int) -> None:
        kept.size += size
        self._size += size

    def _shrink(self) -> None:
        """Leave out the oldest lines of whoever has most."""
        while self._size > self._characters:
            biggest = max(self._kept.values(), key=attrgetter('size'))
            for _ in range((len(biggest.lines) + 1) // 2):
                self._drop(biggest)
