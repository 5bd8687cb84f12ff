# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Searching lines of output for a regular expression, in bounded time."""

from collections.abc import Iterator
from contextlib import contextmanager
import functools
import re
import signal
import warnings

#: Seconds of computing that one search may take. Python's engine goes back
#: and tries again, which takes the square of a line's length with `[a-z]+x`,
#: and for ever with `(a+)+$`.
SEARCH_TIME = 0.2
#: Characters of a longer line that are searched at once; those of the next
#: piece begin in the middle. The engine heeds the time after 4096 attempts,
#: each of which may look at a whole piece: it was measured to be a quarter of
#: a second late with twice this.
PIECE = 8192

# What may match across a line end, or look over one, needs each line by
# itself; all else finds in a text what it finds in one of its lines. An
# expression that is refused here without need is only slower.
_MAY_SEE_LINE_ENDS = re.compile(
    r'\[\^'  # all characters but some
    r'|\\[^.+*?()\[\]{}|/"\'\-dwSb ]'  # \s, \W, \D, \A, \B, \n, \1, …
    r'|\(\?(?!:|P<|i\))'  # looking around, flags
    r'|[*+?}]\+'  # possessive: does not give a line end back
    r'|[\x00-\x1f\x7f]'  # a line end itself
)
# what a search skips anyway, at the price of the square of a line's length
_LEADING = re.compile(r'(?:\.\*\??(?![*+?{]))+')


class SearchTimeError(Exception):
    """A search takes too long; nothing is known of the lines."""


class LinePattern:
    """
    A regular expression that a line is searched for.

    `^` and `$` are the start and the end of the line.

    :param text: The expression, in Python's syntax
    :raises re.error: when it is none
    """

    def __init__(self, text: str) -> None:
        self.text = text
        with warnings.catch_warnings():
            # what a later Python may read in another way is valid today
            warnings.simplefilter('ignore')
            self._line = self._given = re.compile(text)
            leading = _LEADING.match(text)
            if leading is not None:
                text = text[leading.end() :]
                self._line = re.compile(text)
            self._whole = (
                None
                if _MAY_SEE_LINE_ENDS.search(text)
                else re.compile(text, re.MULTILINE)
            )

    def is_in(self, lines: str) -> bool:
        r"""
        Return whether one of several lines matches.

        In a line that is longer than a piece, a match that is longer than
        half of one may be missed. To be called in the main thread.

        :param lines: The lines; `\n` is their only line end
        :raises SearchTimeError: when that takes too long
        """
        with _time_limit():
            return self._search(lines.removesuffix('\n'))

    @property
    def groups(self) -> int:
        """How many groups the expression has."""
        return self._given.groups

    def last_group(self, lines: str) -> str | None:
        r"""
        Return the first group that took part in the last line that matches.

        :param lines: The lines; `\n` is their only line end
        :returns: None if no line matches
        :raises SearchTimeError: when that takes too long
        """
        if not self.is_in(lines):
            return None
        with _time_limit():
            for line in reversed(lines.removesuffix('\n').split('\n')):
                found = self._given.search(line[:PIECE])
                if found is not None:
                    groups = (g for g in found.groups() if g is not None)
                    return next(groups, found[0])
        return None

    def _search(self, lines: str) -> bool:
        if self._whole is not None and (
            len(lines) <= PIECE or max(map(len, lines.split('\n'))) <= PIECE
        ):
            return self._whole.search(lines) is not None
        return any(map(self._is_in_line, lines.split('\n')))

    def _is_in_line(self, line: str) -> bool:
        if len(line) <= PIECE:
            return self._line.search(line) is not None
        for start in range(0, len(line) - PIECE // 2, PIECE // 2):
            found = self._line.search(line, start, start + PIECE)
            # the end of a piece is not that of the line
            while found is not None:
                if self._line.match(line, found.start()):
                    return True
                found = self._line.search(
                    line, found.start() + 1, start + PIECE
                )
        return False


@contextmanager
def _time_limit() -> Iterator[None]:
    """End a search inside by `SearchTimeError` when it takes too long."""
    _heed_timer()
    try:
        # for our own work, so that a busy machine makes no difference
        signal.setitimer(signal.ITIMER_VIRTUAL, SEARCH_TIME)
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)


@functools.cache
def _heed_timer() -> None:
    """Install the timer that ends searches."""
    signal.signal(signal.SIGVTALRM, _over)


def _over(_number: int, _frame: object) -> None:
    raise SearchTimeError
