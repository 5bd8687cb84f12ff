# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the keys mean that are typed at the terminal of a launch."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Sequence
from dataclasses import replace
from typing import Any
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.observers.line_filter import Filtering
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.terminal.input_line import InputLine
from colcon_yamllaunch.terminal.key_decoder import KeyDecoder
from colcon_yamllaunch.terminal.keyboard import ESCAPE
from colcon_yamllaunch.terminal.keyboard import ESCAPE_NAME
from colcon_yamllaunch.terminal.keymap import BLOCK_HELP
from colcon_yamllaunch.terminal.keymap import FOR_ALL
from colcon_yamllaunch.terminal.keymap import FOR_ONE
from colcon_yamllaunch.terminal.keymap import hint
from colcon_yamllaunch.terminal.keymap import OneAction
from colcon_yamllaunch.terminal.keymap import only_its_container_writes
from colcon_yamllaunch.terminal.name_search import matching
from colcon_yamllaunch.terminal.status_block import View
from colcon_yamllaunch.terminal.status_model import StatusModel

#: What is done with one process.
Action = OneAction | Literal['detach']
#: What is done otherwise: `break` ends a line, as in any terminal, to tell
#: what comes from what was.
General = Literal['watch', 'errors', 'help', 'quit', 'break']


@dataclass(frozen=True, slots=True)
class Act:
    """Something is to be done with a process or component."""

    action: Action
    label: str


@dataclass(frozen=True, slots=True)
class Typed:
    """Keys are to go to the process that has the keyboard."""

    keys: bytes


Command = Act | Typed | General

_ACTIONS = {meaning.key: action for action, meaning in FOR_ONE.items()}
# those that mean the same whether a process is chosen or not
_FOR_ALL = frozenset(('/', ':', 'L', 't', 'M', 'w', 'E'))
# those that go back from an overlay and do nothing else, and those of them
# that go on to its next page
_BACK = frozenset(('esc', 'q', 'E', '?', 'enter', ' '))
_ON = frozenset(('?', 'enter', ' '))
#: What does not run, and so cannot be stopped
DOWN = frozenset(('ended', 'stopped', 'failed'))
#: How many names are shown of those that `:` may mean.
NAMES_SHOWN = 5
#: How the keys for all processes are told in the block.
_HINT = hint(
    FOR_ALL[action]
    for action in ('help', 'search', 'level', 'times', 'mute_all')
)
_HINT += '  q stop'


class Keys:
    """
    Makes commands of what is typed.

    :param model: Has the processes
    :param names_of: Returns further names of a process by its label
    :param can_type_at: Tells whether a process takes keys now, by its label
    """

    def __init__(
        self,
        model: StatusModel,
        names_of: Callable[[str], Iterable[str]],
        can_type_at: Callable[[str], bool],
    ) -> None:
        self._model = model
        self._names_of = names_of
        self._can_type_at = can_type_at
        self._decoder = KeyDecoder()
        #: Whether there is a `--watch` to be switched.
        self.can_watch = False
        #: What the keys have made of the output that is shown.
        self.filtering = Filtering()
        # what the next key is for
        self._chosen: str | None = None
        self._note = ''
        # what stands in place of the block, page by page
        self._pages: list[tuple[str, ...]] = []
        # what is being typed, if anything but what a process gets
        self._prompt = ''
        self._line = InputLine()
        self._searches: tuple[str, ...] = ()
        # those by which processes are found, while one is typed
        self._names: dict[str, tuple[str, ...]] = {}
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

    def feed(self, data: bytes) -> Iterator[Command]:
        """
        Take what was typed, and return what is to be done.

        Each of it is to be done before the next is asked for.
        """
        while data:
            label = self.attached
            if label is not None and self._is_raw:
                keys, escape, data = data.partition(ESCAPE)
                if keys:
                    yield Typed(keys)
                if escape:
                    self.detach()
                    yield Act('detach', label)
                continue
            # where a key is the last one, those after it go elsewhere
            self._decoder.feed(data[:1])
            data = data[1:]
            for key in self._decoder.pressed():
                yield from self._press(key)

    def settle(self) -> Iterator[Command]:
        """Take into account that nothing has come for a while."""
        for key in self._decoder.settle():
            yield from self._press(key)

    def attach(
        self, label: str, *, is_raw: bool = False, is_secret: bool = False
    ) -> None:
        """
        Have what is typed go to a process.

        :param is_raw: Whether it takes each key at once, and no lines
        :param is_secret: Whether what is typed is not to be seen
        """
        self._chosen = None
        self._prompt = ''
        self._pages.clear()
        self.attached = label
        self._is_raw = is_raw
        self._is_secret = is_secret

    def detach(self) -> None:
        """Take the keys back."""
        self.attached = None

    def tell(self, note: str) -> None:
        """Tell something until the next key."""
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
        Return what is shown of all this.

        :param live: Lines of output that may still change
        """
        filtering = self.filtering
        if self._prompt == '/':
            # which is seen in the line that it is typed in
            filtering = replace(filtering, search='')
        view = View(
            live=live,
            chosen=self.attached or self._chosen or self._meant(),
            muted=filtering.muted,
            only=filtering.only,
            filter=filtering.text,
            hint=self._hint(),
            note=self._note,
            overlay=self._pages[0] if self._pages else (),
        )
        line = self._line
        prompt = self._prompt
        text = line.text
        if self.attached is not None:
            if self._is_raw:
                return view
            line = self._input_line(self.attached)
            prompt = f'{self.attached}> '
            text = '*' * len(line.text) if self._is_secret else line.text
        if not prompt:
            return view
        return replace(
            view,
            prompt=prompt,
            typed=text.replace('\t', ' '),
            cursor=line.cursor,
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
                return 'no process is called so  Esc goes back'
            words = ['a part of a name is enough']
            if self._line.text:
                words = [f'Enter chooses {matches.pop(0)}', 'Tab completes']
            # the names are what is cut
            words += ('Esc goes back', *matches[:NAMES_SHOWN])
            more = len(matches) - NAMES_SHOWN
            if more > 0:
                words.append(f'… +{more}')
            return '  '.join(words)
        if self._chosen is not None:
            return f'{self._meant_by_keys(self._chosen)}  Esc none'
        first, rest = _HINT.split('  ', 1)
        if self._model.state.errors:
            rest = rest.replace('q stop', 'E errors  q stop')
        if self.can_watch:
            rest = rest.replace('q stop', 'w watch  q stop')
        keys = self._process_keys()
        return f'{first}  {keys} choose  {rest}' if keys else _HINT

    def _meant_by_keys(self, label: str) -> str:
        """Return what keys mean for a process as it is now."""
        part = self._model.part(label)
        is_down = part is not None and part.condition in DOWN
        left_out: set[OneAction] = set()
        if is_down:
            left_out |= {'stop', 'kill'}
        if isinstance(part, ComponentState):
            left_out |= {'kill', 'attach', 'mute', 'only', 'debug'}
        if is_down or not self._can_type_at(label):
            left_out.add('attach')
        if self._model.state.stopping:
            left_out |= {'restart', 'debug'}
        words: dict[OneAction, str] = {}
        if is_down:
            words['restart'] = 'start'
        if label in self.filtering.muted:
            words['mute'] = 'unmute'
        if self.filtering.only == {label}:
            words['only'] = 'all'
        return hint(
            replace(meaning, short=words.get(action, meaning.short))
            for action, meaning in FOR_ONE.items()
            if action not in left_out
        )

    def _process_keys(self) -> str:
        """Return the keys of the processes, in short."""
        given = self._model.keys
        keys = [given[p.label] for p in self._model.parts if p.label in given]
        if len(keys) < 2:
            return ''.join(keys)
        return f'{keys[0]}-{keys[-1]}'

    def _press(self, key: str) -> Iterator[Command]:
        self._note = ''
        if self._pages:
            del self._pages[: 1 if key in _ON else None]
            if key in _BACK:
                return
        if self.attached is not None:
            yield from self._press_in_input(self.attached, key)
        elif self._prompt == '/':
            self._press_in_search(key)
        elif self._prompt == ':':
            self._press_in_name(key)
        elif self._chosen is not None:
            yield from self._press_for_one(self._chosen, key)
        else:
            yield from self._press_for_all(key)

    # for all processes

    def _press_for_all(self, key: str) -> Iterator[Command]:
        filtering = self.filtering
        match key:
            case '/' | ':':
                self._prompt = key
                self._names.clear()
                self._search_before = filtering.search
                self._line = InputLine(self._searches if key == '/' else ())
                if key == '/':
                    self._filter(search='')
            case 'L':
                levels = list(Level)
                place = levels.index(filtering.level) + 1
                self._filter(level=levels[place % len(levels)])
            case 't':
                self._filter(times=not filtering.times)
                self._note = (
                    'lines have no time any more'
                    if filtering.times
                    else 'lines have their time from now on'
                )
            case 'M':
                labels = {p.label for p in self._model.state.processes}
                is_quiet = labels <= filtering.muted
                muted = frozenset(() if is_quiet else labels)
                self._filter(muted=muted)
            case 'w':
                yield 'watch'
            case 'E' if not self._model.state.errors:
                self._note = 'no build has failed'
            case 'E':
                yield 'errors'
            case '?':
                yield 'help'
            case 'q':
                yield 'quit'
            case 'enter':
                yield 'break'
            case 'esc':
                if self.filtering.text:
                    self._note = 'all is shown again'
                self.filtering = Filtering(times=filtering.times)
            case _:
                label = self._model.label_of(key)
                if label is not None:
                    self._chosen = label
                elif key in _ACTIONS or key in ('m', 'o'):
                    keys = self._process_keys()
                    self._note = (
                        f"'{key}' is for one process; choose it first: "
                        f'{keys}, or : and its name'
                    )
                elif len(key) == 1:
                    self._note = f"no process has the key '{key}'; ? helps"

    def _filter(self, **changes: Any) -> None:
        self.filtering = replace(self.filtering, **changes)

    # for one

    def _press_for_one(self, label: str, key: str) -> Iterator[Command]:
        part = self._model.part(label)
        self._chosen = None
        if part is None:
            return
        if key in ('m', 'o') and isinstance(part, ComponentState):
            self._note = only_its_container_writes(label)
        elif key == 'm':
            self._filter(muted=self.filtering.muted ^ {label})
        elif key == 'o':
            is_off = self.filtering.only == {label}
            self._filter(only=frozenset(() if is_off else (label,)))
        elif key == '?':
            self._chosen = label
            yield 'help'
        elif key in _ACTIONS:
            yield Act(_ACTIONS[key], label)
        elif self._model.label_of(key) is not None:
            self._chosen = self._model.label_of(key)
        elif key in _FOR_ALL:
            yield from self._press_for_all(key)
        elif key == 'q':
            # who goes back so elsewhere does not end the launch by it
            self._note = f'{label} is not chosen now; q stops the launch'
        elif len(key) == 1 and key != ' ':
            self._note = f"'{key}' is nothing to do with a process; ? helps"

    # what is typed

    def _press_in_search(self, key: str) -> None:
        if key == 'enter':
            self._line.enter()
            self._searches = self._line.history
            self._prompt = ''
        elif key in ('esc', 'ctrl-g'):
            self._prompt = ''
            self._filter(search=self._search_before)
        elif key == 'backspace' and not self._line.text:
            self._prompt = ''
        else:
            self._line.press(key)
            self._filter(search=self._line.text)

    def _press_in_name(self, key: str) -> None:
        matches = self._matches()
        if key == 'enter':
            self._prompt = ''
            if not matches:
                self._note = f"no process is called '{self._line.text}'"
            elif self._line.text:
                self._chosen = matches[0]
        elif key in ('esc', 'ctrl-g') or (
            key == 'backspace' and not self._line.text
        ):
            self._prompt = ''
        elif key == 'tab':
            if matches:
                self._line.set(matches[0])
        else:
            self._line.press(key)

    def _meant(self) -> str | None:
        """Return whom the name means that is typed now."""
        if self._prompt != ':' or not self._line.text:
            return None
        return next(iter(self._matches()), None)

    def _matches(self) -> list[str]:
        """Return the labels that are meant, the best first."""
        before = self._names
        self._names = {
            label: before.get(label) or (label, *self._names_of(label))
            for label in self._model.state.by_label
        }
        return matching(self._line.text, self._names)

    def _press_in_input(self, label: str, key: str) -> Iterator[Command]:
        line = self._input_line(label)
        if key == 'ctrl-]':
            self.detach()
            yield Act('detach', label)
        elif key == 'enter':
            text = line.enter(remember=not self._is_secret)
            yield Typed(text.encode(errors='replace') + b'\n')
        elif key == 'ctrl-d' and not line.text:
            # the end of the file, as any terminal has it
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
    # few ask
    import textwrap

    width = max(len(key) for key, _ in BLOCK_HELP) + 4
    lines = []
    for key, text in BLOCK_HELP:
        lines += textwrap.wrap(
            text,
            # the last column stays free
            max(columns - 1, 2 * width),
            initial_indent=f'  {key}'.ljust(width),
            subsequent_indent=' ' * width,
        )
    return lines
