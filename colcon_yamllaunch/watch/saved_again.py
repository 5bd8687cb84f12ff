# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Files that were saved as they are, so were something else for a moment.

Who has read one in that moment may fail, now or a little later. What follows
is told by `consequences.missed`; here it is kept which files are to be asked
about, and when: with the next look, or when something fails soon after.
"""

from collections.abc import Collection

from colcon_yamllaunch.watch.changes import Batch
from colcon_yamllaunch.watch.changes import Change

#: How long after a file was something else for a moment, or before that was
#: noticed, something may fail by that (seconds).
READING = 3.0


class SavedAgain:
    """
    The files that somebody may have read in a wrong moment.

    Times are by the clock that never goes back.
    """

    def __init__(self) -> None:
        # what was saved as it was lately, with when
        self._lately: list[tuple[float, Change]] = []
        # what of that is to be looked at yet, and since when
        self._later: list[Change] = []
        self._since = 0.0

    @property
    def is_due(self) -> bool:
        """Whether some are to be looked at."""
        return bool(self._later)

    def add(self, changes: Collection[Change], seen: float) -> None:
        """Take note that files were saved as they are."""
        self._lately = [c for c in self._lately if c[0] >= seen - READING]
        self._lately += [(seen, change) for change in changes]

    def look_later(self, changes: Collection[Change], seen: float) -> None:
        """Have files looked at as soon as that is possible."""
        if not self._later:
            self._since = seen
        self._later += changes

    def has_failed(self, began: float, now: float) -> None:
        """
        Have those looked at that something may have failed by.

        :param began: When it was started
        """
        since = max(began, now - READING)
        self.look_later([c for at, c in self._lately if at >= since], now)

    def take(self) -> Batch:
        """Return what is to be looked at, which then is no more."""
        changes, self._later = tuple(self._later), []
        return Batch(changes, round(self._since * 1e9))

    def clear(self) -> None:
        """Have nothing looked at."""
        self._later.clear()
