# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Those lines that somebody wants to see."""

from collections.abc import Iterable

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.ui.line_levels import DEBUG
from colcon_yamllaunch.ui.line_levels import LEVELS
from colcon_yamllaunch.ui.line_levels import plain
from colcon_yamllaunch.ui.output_store import Line
from colcon_yamllaunch.ui.output_store import OutputStore

#: Lines that a view has at most.
VIEW_LINES = 20_000


@dataclass(frozen=True, slots=True)
class Choice:
    """
    What is to be seen.

    :param chosen: The processes whose lines are; none means all
    :param muted: Those whose lines are not
    :param mutes_all: Whether nothing of any process is
    :param search: What a line has to have, in whatever case if it is in
      lower case
    :param level: The least severity of a line
    """

    chosen: frozenset[str] = frozenset()
    muted: frozenset[str] = frozenset()
    mutes_all: bool = False
    search: str = ''
    level: int = DEBUG

    def shows_output_of(self, label: str) -> bool:
        """Tell whether lines of a process may be seen."""
        if self.mutes_all or label in self.muted:
            return False
        return not self.chosen or label in self.chosen

    def has(self, line: Line) -> bool:
        """Tell whether a line is to be seen."""
        if line.level < self.level:
            return False
        if line.label is not None and not self.shows_output_of(line.label):
            return False
        return not self.search or self.places(plain(line.text)) != []

    def places(self, text: str) -> list[tuple[int, int]]:
        """Return where a text has what is searched for."""
        search = self.search
        if not search:
            return []
        if search.islower():
            text = text.lower()
        found = []
        start = text.find(search)
        while start != -1:
            end = start + len(search)
            found.append((start, end))
            start = text.find(search, end)
        return found

    def words(self) -> list[str]:
        """Say what is left out, in short."""
        said = []
        if self.mutes_all:
            said.append('all muted')
        elif self.muted:
            said.append(f'{len(self.muted)} muted')
        if self.chosen:
            names = sorted(self.chosen)
            said.append(
                f'only {names[0]}'
                + (f' +{len(names) - 1}' if len(names) > 1 else '')
            )
        if self.level > DEBUG:
            said.append(f'{LEVELS[self.level]}+')
        if self.search:
            said.append(f'/{self.search}')
        return said


class OutputView:
    """
    The lines that are seen.

    :param limit: How many there are at most
    """

    def __init__(self, store: OutputStore, limit: int = VIEW_LINES) -> None:
        self._store = store
        self._limit = limit
        self.choice = Choice()
        self.lines: list[Line] = []
        #: How many lines have been left out at the front since the last
        #: choice.
        self.dropped = 0
        #: Grows with each choice.
        self.version = 0

    def choose(self, choice: Choice) -> None:
        """Show something else."""
        self.choice = choice
        chosen = choice.chosen or None
        self.lines = list(filter(choice.has, self._store.lines(chosen)))
        self.dropped = 0
        self.version += 1
        self._trim()

    def add(self, lines: Iterable[Line]) -> None:
        """Take lines that are new in the store."""
        self.lines += filter(self.choice.has, lines)
        self._trim()

    def _trim(self) -> None:
        # a part of them at once, as that moves all others
        if len(self.lines) > self._limit:
            excess = len(self.lines) - self._limit * 3 // 4
            del self.lines[:excess]
            self.dropped += excess
