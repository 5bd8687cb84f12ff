# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Those lines that somebody wants to see, and the rows that they take."""

from bisect import bisect_left
from bisect import bisect_right
from collections.abc import Iterable
from operator import attrgetter
import re

from colcon_yamllaunch.common.printable import SEQUENCE
from colcon_yamllaunch.observers.line_filter import Filtering
from colcon_yamllaunch.terminal.full_screen.output_store import Line
from colcon_yamllaunch.terminal.full_screen.output_store import OutputStore

#: Lines that a view has at most.
VIEW_LINES = 20_000

_SEQUENCE = re.compile(SEQUENCE)


def plain(text: str) -> str:
    """Return a line without colours."""
    return _SEQUENCE.sub('', text) if '\x1b' in text else text


class OutputView:
    """
    The lines that are seen.

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
        """Show something else."""
        self.filtering = filtering
        only = filtering.only or None
        self.lines = list(filter(self._has, self._store.lines(only)))
        self.dropped = 0
        self.version += 1
        self._trim()

    def add(self, lines: Iterable[Line]) -> None:
        """Take lines that are new in the store."""
        self.lines += filter(self._has, lines)
        self._trim()

    def place_of(self, order: int) -> int:
        """Return where a line stands, or the next one if it is not seen."""
        return bisect_left(self.lines, order, key=attrgetter('order'))

    def take_altered(self) -> list[int]:
        """Return where lines stand that have become others since."""
        altered, self._store.altered = self._store.altered, {}
        found = ((self.place_of(line.order), line) for line in altered)
        return [
            place
            for place, line in found
            if place < len(self.lines) and self.lines[place] is line
        ]

    def _has(self, line: Line) -> bool:
        """Tell whether a line is to be seen."""
        filtering = self.filtering
        if line.level < filtering.level:
            return False
        if line.label is not None and not filtering.has(line.label):
            return False
        return not filtering.search or filtering.matches(plain(line.text))

    def _trim(self) -> None:
        # a part of them at once, as that moves all others
        if len(self.lines) > self._limit:
            excess = len(self.lines) - self._limit * 3 // 4
            del self.lines[:excess]
            self.dropped += excess


class RowIndex:
    """Tells which line a row is of, where long lines take several."""

    def __init__(self) -> None:
        # for each line the rows up to it, with those of lines that are gone
        self._ends: list[int] = []
        self._gone = 0

    def __len__(self) -> int:
        return len(self._ends)

    @property
    def rows(self) -> int:
        """The rows of all lines."""
        return self._ends[-1] - self._gone if self._ends else 0

    def add(self, rows: int) -> None:
        """Take the next line."""
        self._ends.append(self._gone + self.rows + rows)

    def alter(self, line: int, rows: int) -> None:
        """Take into account that a line has other rows."""
        more = rows - (self._ends[line] - self._gone - self.first_row(line))
        if more:
            for number in range(line, len(self._ends)):
                self._ends[number] += more

    def drop(self, lines: int) -> int:
        """Leave out the first lines, and return how many rows they had."""
        if not lines or not self._ends:
            return 0
        before = self._gone
        self._gone = self._ends[min(lines, len(self._ends)) - 1]
        del self._ends[:lines]
        return self._gone - before

    def first_row(self, line: int) -> int:
        """Return the first row of a line."""
        return (self._ends[line - 1] if line else self._gone) - self._gone

    def at(self, row: int) -> tuple[int, int]:
        """Return the line that a row is of, and which of its rows it is."""
        line = bisect_right(self._ends, row + self._gone)
        return line, row - self.first_row(line)
