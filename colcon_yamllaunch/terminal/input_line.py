# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A line that is typed, with what moves and deletes in it."""

from collections.abc import Sequence

from colcon_yamllaunch.terminal.cells import width

#: Bytes that a line has at most; a terminal passes on no longer one
#: (N_TTY_BUF_SIZE of Linux, with the line end).
LONGEST = 4094
#: Lines that are remembered at most.
REMEMBERED = 1000


class InputLine:
    """
    A line that is edited as in readline.

    :param history: Lines from before, the oldest first
    """

    def __init__(self, history: Sequence[str] = ()) -> None:
        #: What is typed.
        self.text = ''
        #: How many characters of that are before the cursor.
        self.cursor = 0
        self._history = list(history)
        # which line of the history is shown, and what was typed before
        self._index = len(self._history)
        self._draft = ''
        self._killed = ''

    @property
    def history(self) -> tuple[str, ...]:
        """Lines from before, the oldest first."""
        return tuple(self._history)

    def press(self, key: str) -> bool:
        """
        Handle a key, and return whether it edits the line.

        The caller handles Enter and the keys that end the typing.
        """
        if len(key) == 1:
            self._insert(key)
        elif key == 'tab':
            self._insert('\t')
        elif key in _MOVES:
            self.cursor = _MOVES[key](self.text, self.cursor)
        elif key in _DELETIONS:
            self._delete(key)
        elif key in ('up', 'ctrl-p'):
            self._recall(self._index - 1)
        elif key in ('down', 'ctrl-n'):
            self._recall(self._index + 1)
        elif key == 'ctrl-y':
            for character in self._killed:
                self._insert(character)
        else:
            return False
        return True

    def set(self, text: str) -> None:
        """Replace the text, and put the cursor at its end."""
        self.text = text
        self.cursor = len(text)

    def enter(self, *, remember: bool = True) -> str:
        """Return what was typed, and begin a new line."""
        text = self.text
        history = self._history
        if remember and text.strip() and history[-1:] != [text]:
            history.append(text)
            del history[:-REMEMBERED]
        self._index = len(history)
        self.set('')
        return text

    def _insert(self, text: str) -> None:
        size = len(self.text.encode(errors='replace'))
        if size + len(text.encode(errors='replace')) <= LONGEST:
            before, after = self.text[: self.cursor], self.text[self.cursor :]
            self.text = f'{before}{text}{after}'
            self.cursor += 1

    def _delete(self, key: str) -> None:
        place, is_kept = _DELETIONS[key]
        other = place(self.text, self.cursor)
        start, end = sorted((self.cursor, other))
        if is_kept and start < end:
            self._killed = self.text[start:end]
        self.text = self.text[:start] + self.text[end:]
        self.cursor = start

    def _recall(self, index: int) -> None:
        if not 0 <= index <= len(self._history):
            return
        if self._index == len(self._history):
            self._draft = self.text
        self._index = index
        is_past = index < len(self._history)
        self.set(self._history[index] if is_past else self._draft)


def _left(text: str, place: int) -> int:
    place = max(0, place - 1)
    while place > 0 and not width(text[place]):
        place -= 1
    return place


def _right(text: str, place: int) -> int:
    place = min(len(text), place + 1)
    while place < len(text) and not width(text[place]):
        place += 1
    return place


def _start(text: str, place: int) -> int:  # noqa: ARG001
    return 0


def _end(text: str, place: int) -> int:  # noqa: ARG001
    return len(text)


def _word_left(text: str, place: int) -> int:
    while place > 0 and not text[place - 1].isalnum():
        place -= 1
    while place > 0 and text[place - 1].isalnum():
        place -= 1
    return place


def _word_right(text: str, place: int) -> int:
    while place < len(text) and not text[place].isalnum():
        place += 1
    while place < len(text) and text[place].isalnum():
        place += 1
    return place


def _blank_left(text: str, place: int) -> int:
    while place > 0 and text[place - 1].isspace():
        place -= 1
    while place > 0 and not text[place - 1].isspace():
        place -= 1
    return place


_MOVES = {
    'left': _left,
    'ctrl-b': _left,
    'right': _right,
    'ctrl-f': _right,
    'home': _start,
    'ctrl-a': _start,
    'end': _end,
    'ctrl-e': _end,
    'alt-b': _word_left,
    'ctrl-left': _word_left,
    'alt-f': _word_right,
    'ctrl-right': _word_right,
}
# up to which place, and whether Ctrl-Y brings it back
_DELETIONS = {
    'backspace': (_left, False),
    'delete': (_right, False),
    'ctrl-d': (_right, False),
    'ctrl-w': (_blank_left, True),
    'alt-backspace': (_word_left, True),
    'alt-d': (_word_right, True),
    'ctrl-u': (_start, True),
    'ctrl-k': (_end, True),
}
