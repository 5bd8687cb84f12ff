# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The keys that are typed at the status block, and lines of input."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.control.process_names import ProcessNames
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.terminal import keymap
from colcon_yamllaunch.terminal.keyboard import ESCAPE, ESCAPE_NAME, KeyDecoder
from colcon_yamllaunch.terminal.line_filter import Filtering
from colcon_yamllaunch.terminal.status_block import View, width
from colcon_yamllaunch.terminal.status_model import StatusModel


@dataclass(frozen=True, slots=True)
class KeyPress:
    """
    A key whose effect is outside of the status block.

    :param name: The name of the key in the keymap
    :param label: The process or component that it is for, None for all
    """

    name: str
    label: str | None = None


@dataclass(frozen=True, slots=True)
class Typed:
    """Input for the process that has the keyboard."""

    keys: bytes


_FOR_ONE = {key.key: key for key in keymap.FOR_ONE}
_FOR_ALL = {key.key: key for key in (*keymap.FOR_ALL, keymap.QUIT)}
# keys that only close an overlay, and those that show its next page first
_BACK = frozenset(('esc', 'q', 'E', '?', 'enter', ' '))
_ON = frozenset(('?', 'enter', ' '))
#: The conditions in which nothing can be stopped.
DOWN = frozenset(('ended', 'stopped', 'failed'))
# the keys in the hint while no process is chosen, the most important first
_IN_HINT = sorted(
    (key for key in _FOR_ALL.values() if key.hint_place),
    key=lambda key: key.hint_place,
)
#: Bytes that a line has at most; a terminal passes on no longer one
#: (N_TTY_BUF_SIZE of Linux, with the line end).
LONGEST = 4094
#: Lines that are remembered at most.
REMEMBERED = 1000
#: How many names are shown of those that `:` may mean.
NAMES_SHOWN = 5


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
        #: Lines from before, the oldest first.
        self.history = list(history)
        # the index of the shown line of the history, and the text before that
        self._index = len(self.history)
        self._draft = ''
        self._killed = ''

    def press(self, key: str) -> None:
        """
        Edit the line as a key does; other keys do nothing.

        The caller handles Enter and the keys that end the typing.
        """
        if len(key) == 1:
            self._insert(key)
        elif key == 'tab':
            self._insert('\t')
        elif key in _MOVES:
            self.cursor = _MOVES[key](self.text, self.cursor)
        elif key in _DELETIONS:
            place, is_kept = _DELETIONS[key]
            other = place(self.text, self.cursor)
            start, end = sorted((self.cursor, other))
            if is_kept and start < end:
                self._killed = self.text[start:end]
            self.text = self.text[:start] + self.text[end:]
            self.cursor = start
        elif key in ('up', 'ctrl-p'):
            self._recall(self._index - 1)
        elif key in ('down', 'ctrl-n'):
            self._recall(self._index + 1)
        elif key == 'ctrl-y':
            for character in self._killed:
                self._insert(character)

    def set(self, text: str) -> None:
        """Replace the text, and put the cursor at its end."""
        self.text = text
        self.cursor = len(text)

    def enter(self, *, remember: bool = True) -> str:
        """Return what was typed, and begin a new line."""
        text = self.text
        history = self.history
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

    def _recall(self, index: int) -> None:
        last = len(self.history)
        if 0 <= index <= last:
            if self._index == last:
                self._draft = self.text
            self._index = index
            self.set(self._draft if index == last else self.history[index])


def _next(text: str, place: int, step: int) -> int:
    """Return the place before or after a character with its accents."""
    place = max(0, min(place + step, len(text)))
    while 0 < place < len(text) and not width(text[place]):
        place += step
    return place


def _past_word(
    text: str, place: int, step: int, is_in_word: Callable[[str], bool]
) -> int:
    """Return the other end of a word, and of what separates it from here."""
    # to the left, the character before the place is the next one
    before = min(step, 0)
    for is_wanted in (False, True):
        while (
            0 <= place + before < len(text)
            and is_in_word(text[place + before]) == is_wanted
        ):
            place += step
    return place


def _start(text: str, place: int) -> int:  # noqa: ARG001
    return 0


def _end(text: str, place: int) -> int:  # noqa: ARG001
    return len(text)


_left, _right = partial(_next, step=-1), partial(_next, step=1)
_word_left = partial(_past_word, step=-1, is_in_word=str.isalnum)
_word_right = partial(_past_word, step=1, is_in_word=str.isalnum)
_blank_left = partial(
    _past_word, step=-1, is_in_word=lambda character: not character.isspace()
)
_Move = Callable[[str, int], int]
_MOVES: Mapping[str, _Move] = {
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
# the other end of the deleted text, and whether Ctrl-Y inserts it again
_DELETIONS: Mapping[str, tuple[_Move, bool]] = {
    'backspace': (_left, False),
    'delete': (_right, False),
    'ctrl-d': (_right, False),
    'ctrl-w': (_blank_left, True),
    'alt-backspace': (_word_left, True),
    'alt-d': (_word_right, True),
    'ctrl-u': (_start, True),
    'ctrl-k': (_end, True),
}


class Keys:
    """
    What the user types at the status block: keys, a search, or input.

    :param model: Has the processes
    """

    def __init__(self, model: StatusModel) -> None:
        self._model = model
        self._decoder = KeyDecoder()
        #: What the keys have made of the output that is shown.
        self.filtering = Filtering()
        # the process or component that the next key is for
        self._chosen: str | None = None
        self._note = ''
        # the pages of the overlay, which replaces the block
        self._pages: list[tuple[str, ...]] = []
        # `/` during a search, `:` while a name is typed
        self._prompt = ''
        self._line = self._search_line = InputLine()
        self._search_before = ''
        #: The process that has the keyboard, if one has.
        self.attached: str | None = None
        self._is_raw = False
        self._is_secret = False
        self._lines: dict[str, InputLine] = {}

    @property
    def is_waiting(self) -> bool:
        """Whether an Esc may be the start of another key."""
        return self._decoder.is_waiting

    def feed(self, data: bytes) -> Iterator[KeyPress | Typed]:
        """
        Handle what was typed; yield what has an effect elsewhere.

        The caller carries out each before it asks for the next.
        """
        while data:
            label = self.attached
            if label is not None and self._is_raw:
                keys, escape, data = data.partition(ESCAPE)
                if keys:
                    yield Typed(keys)
                if escape:
                    self.attached = None
                    yield KeyPress('detach', label)
                continue
            # a key may attach a process, which gets all following bytes
            for key in self._decoder.feed(data[:1]):
                yield from self._press(key)
            data = data[1:]

    def settle(self) -> Iterator[KeyPress | Typed]:
        """Handle an Esc that nothing followed, as :meth:`feed` does."""
        for key in self._decoder.settle():
            yield from self._press(key)

    def attach(
        self, label: str, *, is_raw: bool = False, is_secret: bool = False
    ) -> None:
        """
        Send what is typed to a process.

        :param is_raw: Whether it takes each key at once, and no lines
        :param is_secret: Whether what is typed is not to be seen
        """
        self._chosen = None
        self._prompt = ''
        self._pages.clear()
        self.attached = label
        self._is_raw = is_raw
        self._is_secret = is_secret

    def show_note(self, note: str) -> None:
        """Show a note until the next key."""
        self._pages.clear()
        self._note = note

    def show(self, lines: Sequence[str], height: int) -> None:
        """
        Show lines in place of the block until the next key.

        :param height: The lines of a page
        """
        height = max(1, height)
        self._pages = [
            tuple(lines[n : n + height]) for n in range(0, len(lines), height)
        ]

    def view(self, live: tuple[str, ...] = ()) -> View:
        """
        Return the member of this state that the block shows.

        :param live: Lines of output that may still change
        """
        filtering = self.filtering
        if self._prompt == '/':
            # the input line shows it already
            filtering = replace(filtering, search='')
        line, prompt = self._line, self._prompt
        is_hidden = False
        if self.attached is not None and not self._is_raw:
            line = self._input_line(self.attached)
            prompt = f'{self.attached}> '
            is_hidden = self._is_secret
        text = '*' * len(line.text) if is_hidden else line.text
        return View(
            live=live,
            chosen=self.attached or self._chosen or self._best_match(),
            filtering=filtering,
            hint=self._hint(),
            prompt=prompt or None,
            typed=text.replace('\t', ' '),
            cursor=line.cursor,
            note=self._note,
            overlay=self._pages[0] if self._pages else (),
        )

    def _hint(self) -> str:
        if self._pages:
            next_page = 'Enter shows more  ' * (len(self._pages) > 1)
            return f'  {next_page}Esc goes back'
        if self.attached is not None:
            how = 'each key goes to' if self._is_raw else 'typing at'
            return f'{ESCAPE_NAME} goes back  {how} {self.attached}'
        if self._prompt == '/':
            return 'Enter keeps the search  Esc drops it'
        if self._prompt == ':':
            matches = self._matches()
            if not matches:
                return 'no process name contains this  Esc goes back'
            words = ['a part of a name is enough']
            if self._line.text:
                words = [f'Enter chooses {matches.pop(0)}', 'Tab completes']
            # a narrow terminal cuts the names, which come last
            words += ('Esc goes back', *matches[:NAMES_SHOWN])
            more = len(matches) - NAMES_SHOWN
            if more > 0:
                words.append(f'… +{more}')
            return '  '.join(words)
        if self._chosen is not None:
            return f'{self._hint_for(self._chosen)}  Esc none'
        left_out = keymap.without_effect(self._model.state, None)
        words = [
            f'{key.key} {key.word}'
            for key in _IN_HINT
            if key.name not in left_out
        ]
        keys = self._range_of_keys()
        if keys:
            words.insert(1, f'{keys} choose')
        return '  '.join(words)

    def _hint_for(self, label: str) -> str:
        """Return what keys mean for a process as it is now."""
        state, member = self._model.state, self._model.member(label)
        is_down = member is not None and member.condition in DOWN
        left_out = keymap.without_effect(state, member)
        if is_down:
            left_out |= {'stop', 'kill'}
        if state.stopping:
            left_out |= {'restart', 'debug'}
        words: dict[str, str] = {}
        if is_down:
            words['restart'] = 'start'
        if label in self.filtering.muted:
            words['mute'] = 'unmute'
        if self.filtering.only == {label}:
            words['only'] = 'all'
        return '  '.join(
            f'{key.key} {words.get(key.name, key.word)}'
            for key in keymap.FOR_ONE
            if key.name not in left_out
        )

    def _range_of_keys(self) -> str:
        """Return the keys of the processes, in short."""
        given = self._model.keys
        keys = [
            given[p.label] for p in self._model.members if p.label in given
        ]
        if len(keys) < 2:
            return ''.join(keys)
        return f'{keys[0]}-{keys[-1]}'

    def _press(self, key: str) -> Iterator[KeyPress | Typed]:
        self._note = ''
        if self._pages:
            del self._pages[: 1 if key in _ON else None]
            if key in _BACK:
                return
        if self.attached is not None:
            yield from self._press_attached(self.attached, key)
        elif self._prompt:
            self._press_in_prompt(key)
        elif self._chosen is not None:
            yield from self._press_for_one(self._chosen, key)
        else:
            yield from self._press_for_all(key)

    # for all processes

    def _press_for_all(self, key: str) -> Iterator[KeyPress | Typed]:
        state = self._model.state
        row = _FOR_ALL.get(key)
        label = self._model.label_of(key)
        if key in ('/', ':'):
            self._begin_prompt(key)
        elif row is not None and row.filter is not None:
            self.filtering = row.filter(self.filtering, state)
            if row.name == 'times':
                self._note = (
                    'lines have their time from now on'
                    if self.filtering.times
                    else 'lines have no time any more'
                )
        elif key == 'E' and not state.errors:
            self._note = 'no build has failed'
        elif row is not None:
            yield KeyPress(row.name)
        elif key == 'enter':
            yield KeyPress('break')
        elif key == 'esc':
            if self.filtering.text:
                self._note = 'all is shown again'
            self.filtering = self.filtering.cleared()
        elif label is not None:
            self._chosen = label
        elif key in _FOR_ONE:
            self._note = (
                f"'{key}' is for one process; choose it first: "
                f'{self._range_of_keys()}, or : and its name'
            )
        elif len(key) == 1:
            self._note = f"no process has the key '{key}'; ? helps"

    def _begin_prompt(self, prompt: str) -> None:
        """Ask for a text that lines have (`/`), or for a name (`:`)."""
        self._prompt = prompt
        self._search_before = self.filtering.search
        self._line = InputLine()
        if prompt == '/':
            self._line = self._search_line
            self._search('')

    def _search(self, text: str) -> None:
        self.filtering = replace(self.filtering, search=text)

    # for one

    def _press_for_one(
        self, label: str, key: str
    ) -> Iterator[KeyPress | Typed]:
        member = self._model.member(label)
        self._chosen = None
        if member is None:
            return
        row = _FOR_ONE.get(key)
        if row is not None and row.filter is not None:
            if isinstance(member, ComponentState):
                self._note = keymap.only_its_container_writes(label)
            else:
                self.filtering = row.filter(self.filtering, label)
        elif key == '?':
            self._chosen = label
            yield KeyPress('help')
        elif row is not None:
            yield KeyPress(row.name, label)
        elif self._model.label_of(key) is not None:
            self._chosen = self._model.label_of(key)
        elif key == 'q':
            # q closes other views, so it must not stop the launch here
            self._note = f'{label} is not chosen now; q stops the launch'
        elif key == ':' or key in _FOR_ALL:
            yield from self._press_for_all(key)
        elif len(key) == 1 and key != ' ':
            self._note = f"no command has the key '{key}'; ? shows all keys"

    # what is typed

    def _press_in_prompt(self, key: str) -> None:
        line, is_search = self._line, self._prompt == '/'
        matches = [] if is_search else self._matches()
        is_dropped = key in ('esc', 'ctrl-g')
        if (
            key == 'enter'
            or is_dropped
            or (key == 'backspace' and not line.text)
        ):
            self._prompt = ''
            text = line.enter(remember=key == 'enter')
            if is_search and is_dropped:
                self._search(self._search_before)
            elif not is_search and key == 'enter':
                if not matches:
                    self._note = f"no process is called '{text}'"
                elif text:
                    self._chosen = matches[0]
            return
        if key == 'tab' and not is_search:
            if matches:
                line.set(matches[0])
        else:
            line.press(key)
        if is_search:
            self._search(line.text)

    def _best_match(self) -> str | None:
        """Return the process that the typed name means."""
        if self._prompt != ':' or not self._line.text:
            return None
        return next(iter(self._matches()), None)

    def _matches(self) -> list[str]:
        """Return the labels that are meant, the best first."""
        names = {
            p.label: ProcessNames.of_state(p) for p in self._model.members
        }
        return matching(self._line.text, names)

    def _press_attached(
        self, label: str, key: str
    ) -> Iterator[KeyPress | Typed]:
        line = self._input_line(label)
        if key == 'ctrl-]':
            self.attached = None
            yield KeyPress('detach', label)
        elif key == 'enter':
            text = line.enter(remember=not self._is_secret)
            yield Typed(text.encode(errors='replace') + b'\n')
        elif key == 'ctrl-d' and not line.text:
            # as on any terminal, Ctrl-D in an empty line is the end of file
            self._note = f'told {label} that the input ends (Ctrl-D)'
            yield Typed(b'\x04')
        else:
            line.press(key)

    def _input_line(self, label: str) -> InputLine:
        return self._lines.setdefault(label, InputLine())


def help_lines(columns: int = 80) -> list[str]:
    """
    Return what all keys do.

    :param columns: The width of the terminal
    """
    # imported late, as few users open the help
    import textwrap

    indent = max(len(key) for key, _ in keymap.BLOCK_HELP) + 4
    lines = []
    for key, text in keymap.BLOCK_HELP:
        lines += textwrap.wrap(
            text,
            # the last column stays free
            max(columns - 1, 2 * indent),
            initial_indent=f'  {key}'.ljust(indent),
            subsequent_indent=' ' * indent,
        )
    return lines


def matching(text: str, names: Mapping[str, Iterable[str]]) -> list[str]:
    """
    Return the labels that a part of a name means, the best first.

    A whole name comes before the beginning of one, and that before any other
    part; equals stay in the order of the plan.

    :param text: A part of a name, in upper or lower case
    :param names: The names of each, by label, in the order of the plan
    """
    wanted = text.lower()
    ranks = {}
    for label, called in names.items():
        fits = [n.lower() for n in called if wanted in n.lower()]
        if fits:
            begins = any(name.startswith(wanted) for name in fits)
            ranks[label] = (wanted not in fits, not begins)
    return sorted(ranks, key=ranks.__getitem__)
