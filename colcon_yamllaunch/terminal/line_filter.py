# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The filter of the output, and the output above the status block."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
import re
import time

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.lines import bare
from colcon_yamllaunch.observers.log_levels import Level, level_of, may_be_loud
from colcon_yamllaunch.plan.plan import Process, SHOWN

#: Lines that come at once up to which each one is compared.
FEW = 64
#: Bytes of much output that have so many lines, as a rule.
PROBE_SIZE = 8 * 1024
#: Live lines that are shown; the latest ones are.
MAXIMUM_LIVE = 3

_Key = tuple[str, events.Stream]

# the look-behind avoids matching again from each byte of a run
_CARRIAGE_RETURNS = re.compile(rb'(?<!\r)\r+\n')
#: The times in the lines of nodes, which differ where all else is the same.
TIMES = re.compile(rb'\[\d{6,}\.\d+\]')
#: The levels of lines before which none has one: what nodes log goes to
#: stderr, and begins with a level.
FIRST_LEVELS = {'stdout': Level.INFO, 'stderr': Level.ERROR}
_RESET = b'\x1b[0m'
_DIM = b'\x1b[2m'
_COLOURS = {
    Level.WARN: b'\x1b[33m',
    Level.ERROR: b'\x1b[31m',
    Level.FATAL: b'\x1b[1;31m',
}


@dataclass(frozen=True, slots=True)
class Filtering:
    """
    Which lines of the output are shown.

    :param muted: The labels of processes whose output is hidden
    :param only: The labels of the only processes whose output is shown; empty
      for all
    :param search: The text that shown lines contain; upper and lower case are
      the same unless it has upper case
    :param level: The lowest level of shown lines
    :param times: Whether lines begin with the time
    """

    muted: frozenset[str] = frozenset()
    only: frozenset[str] = frozenset()
    search: str = ''
    level: Level = Level.DEBUG
    times: bool = False

    def has(self, label: str) -> bool:
        """Return whether the output of a process is shown."""
        return label not in self.muted and (
            not self.only or label in self.only
        )

    def places(self, text: str) -> list[tuple[int, int]]:
        """Return the positions of the search in a text."""
        if not self.search:
            return []
        if self.search == self.search.lower():
            text = text.lower()
        return [m.span() for m in re.finditer(re.escape(self.search), text)]

    def matches(self, text: str) -> bool:
        """Return whether a text contains the search."""
        is_lower = self.search == self.search.lower()
        return self.search in (text.lower() if is_lower else text)

    def shows(self, label: str | None, level: Level, text: str) -> bool:
        """
        Return whether a line is shown.

        :param label: The process; None for a line about the launch
        """
        return (
            level >= self.level
            and (label is None or self.has(label))
            and self.matches(text)
        )

    # the effects of keys

    def mute(self, label: str) -> 'Filtering':
        """Mute a process, or unmute it."""
        return replace(self, muted=self.muted ^ {label})

    def mute_all(self, labels: Iterable[str]) -> 'Filtering':
        """Mute all processes, or unmute all."""
        every = frozenset(labels)
        is_quiet = every <= self.muted
        return replace(self, muted=frozenset() if is_quiet else every)

    def show_alone(self, label: str) -> 'Filtering':
        """Show a process alone, or all again."""
        is_alone = self.only == {label}
        return self._choose(frozenset(() if is_alone else (label,)))

    def show_beside(self, label: str) -> 'Filtering':
        """Show a process beside those chosen so far, or hide it again."""
        return self._choose(self.only ^ {label})

    def _choose(self, only: frozenset[str]) -> 'Filtering':
        # a process that was chosen is not muted
        return replace(self, only=only, muted=self.muted - only)

    def next_level(self) -> 'Filtering':
        """Show the next higher level; after the last one, everything."""
        levels = tuple(Level)
        place = levels.index(self.level) + 1
        return replace(self, level=levels[place % len(levels)])

    def switch_times(self) -> 'Filtering':
        """Show or hide the time of lines."""
        return replace(self, times=not self.times)

    def cleared(self) -> 'Filtering':
        """Show everything."""
        return Filtering(times=self.times)

    @property
    def text(self) -> str:
        """The filter in short, empty if all is shown."""
        parts = []
        if self.search:
            parts.append(f'/{self.search}')
        if self.level > Level.DEBUG:
            parts.append(f'level {self.level.name}')
        if self.only:
            parts.append(f'only {", ".join(sorted(self.only))}')
        if self.muted:
            parts.append(f'{len(self.muted)} muted')
        return ', '.join(parts)


class LineFilter:
    """
    Filters lines, counts repeated ones, and colours warnings and errors.

    :param color: Whether lines are coloured
    :param is_ascii: Whether there is nothing but ASCII
    :param form_of: Returns the form of the lines of a process, see
      `log_levels.FORMAT`
    """

    def __init__(
        self,
        *,
        color: bool,
        is_ascii: bool,
        form_of: Callable[[Process], str | None],
    ) -> None:
        self.filtering = Filtering()
        self._color = color
        self._times_sign = b'x' if is_ascii else '×'.encode()
        self._form_of = form_of
        # lines that processes rewrite in place, the latest last
        self._live: dict[_Key, events.Output] = {}
        # the levels of the last lines
        self._levels: dict[_Key, Level] = {}
        # what was shown last, without times, and how often in a row
        self._last: tuple[_Key, bytes] | None = None
        self._count = 0
        self._repeated: events.Output | None = None

    def shown(self, event: events.Output) -> Sequence[events.Output]:
        """Return what to show of the output of a process."""
        process = event.process
        if event.stream not in SHOWN[process.output]:
            return ()
        key = (process.label, event.stream)
        if b'\r' in event.data or key in self._live:
            event = self._whole_lines(key, event)
        data = self._filtered(key, event)
        if not data:
            return ()
        if _has_many_lines(data):
            shown, data = self._compared_at_once(key, event, data)
        else:
            shown, data = self._compared_by_line(key, event, data)
        if data:
            if self._color and may_be_loud(data):
                data = self._coloured(process, data)
            shown.append(_with_data(event, data))
        return shown

    @property
    def is_changing(self) -> bool:
        """Whether some lines may still change."""
        return bool(self._live) or self._repeated is not None

    @property
    def live(self) -> Iterable[events.Output]:
        """The lines that may still change."""
        changing = [
            event
            for key, event in self._live.items()
            if self._filtered(key, event)
        ]
        yield from changing[-MAXIMUM_LIVE:]
        if self._repeated is not None:
            yield self._counted(self._repeated)

    def settle(self) -> Iterator[events.Output]:
        """Return the counted line, as something else is shown next."""
        if self._repeated is not None:
            yield self._counted(self._repeated)
        self._last = self._repeated = None
        self._count = 0

    def end(self, label: str | None = None) -> Iterator[events.Output]:
        """
        Return what was held back.

        :param label: Of which process, by default of all
        """
        for key in list(self._live):
            if label in (None, key[0]):
                event = self._live.pop(key)
                yield from self.shown(_with_data(event, event.data + b'\n'))
        if label is None:
            yield from self.settle()

    def _whole_lines(self, key: _Key, event: events.Output) -> events.Output:
        """Keep lines that are rewritten in place, and return whole lines."""
        data = _CARRIAGE_RETURNS.sub(b'\n', event.data)
        if b'\r' in data or key in self._live:
            *lines, last = data.split(b'\n')
            lines = [last_state(line) for line in lines]
            text = last_state(last)
            goes_on = last.endswith(b'\r') and bool(text)
            # shown lines keep their places
            latest = list(self._live)[-MAXIMUM_LIVE:]
            if lines or (last and not (goes_on and key in latest)):
                self._live.pop(key, None)
            if goes_on:
                self._live[key] = _with_data(event, text)
            rest = b'' if last.endswith(b'\r') else text
            data = b'\n'.join((*lines, rest))
        return _with_data(event, data)

    def _filtered(self, key: _Key, event: events.Output) -> bytes:
        """Return the lines that the filter lets through."""
        process, data = event.process, event.data
        least = self.filtering.level
        if not self.filtering.has(process.label):
            return b''
        if not self.filtering.search and least == Level.DEBUG:
            return data
        matches = self.filtering.matches
        may_match = matches(bare(data))
        if least == Level.DEBUG and not may_match:
            return b''
        form = self._form_of(process) if least > Level.DEBUG else None
        level = self._levels.get(key) or FIRST_LEVELS[key[1]]
        kept = []
        for line in data.splitlines(keepends=True):
            if least > Level.DEBUG:
                level = level_of(line, form) or level
                if level < least:
                    continue
            if may_match and matches(bare(line)):
                kept.append(line)
        self._levels[key] = level
        return b''.join(kept)

    def _compared_by_line(
        self, key: _Key, event: events.Output, data: bytes
    ) -> tuple[list[events.Output], bytes]:
        """Return what ends a repetition, and the lines that are new."""
        ended: list[events.Output] = []
        kept: list[bytes] = []
        lines = data.splitlines(keepends=True)
        for line in lines:
            text = (key, TIMES.sub(b'', line))
            if text == self._last:
                self._count += 1
                self._repeated = _with_data(event, line)
                continue
            if self._repeated is not None:
                counted = self._counted(self._repeated)
                self._repeated = None
                if counted.process.label == key[0]:
                    kept.append(counted.data)
                else:
                    ended.append(counted)
            kept.append(line)
            is_line = line.endswith(b'\n') and line != b'\n'
            self._last = text if is_line else None
            self._count = 1
        return ended, data if kept == lines else b''.join(kept)

    def _compared_at_once(
        self, key: _Key, event: events.Output, data: bytes
    ) -> tuple[list[events.Output], bytes]:
        """Do the same at once for many lines, which are often all equal."""
        first = data[: data.index(b'\n') + 1]
        # the second line mostly shows whether the rest can be the same
        is_same = data.startswith(first, len(first))
        count = data.count(first) if is_same else 1
        if count * len(first) == len(data):
            ended, data = self._compared_by_line(key, event, first)
            if self._last is not None:
                self._count += count - 1
                self._repeated = _with_data(event, first)
                return ended, data
            return ended, first * count
        ended = list(self.settle())
        return ended, data

    def _counted(self, repeated: events.Output) -> events.Output:
        line = repeated.data
        if self._color:
            line = self._coloured(repeated.process, line)
        # a count of two would save no room
        if self._count > 2:
            sign = b'%s%d' % (self._times_sign, self._count)
            if self._color:
                sign = b'%s%s%s%s' % (_RESET, _DIM, sign, _RESET)
            line = b'%s %s\n' % (line.rstrip(b'\n'), sign)
        return _with_data(repeated, line)

    def _coloured(self, process: Process, data: bytes) -> bytes:
        """Colour the lines that have a level of WARN or more."""
        form = self._form_of(process)
        lines = data.splitlines(keepends=True)
        for index, line in enumerate(lines):
            if b'\x1b' in line or line[:9] == b'Traceback':
                continue
            colour = _COLOURS.get(level_of(line, form) or Level.INFO)
            if colour is not None:
                text = line.rstrip(b'\n')
                lines[index] = colour + text + _RESET + line[len(text) :]
        return b''.join(lines)


def _with_data(event: events.Output, data: bytes) -> events.Output:
    if data is event.data:
        return event
    return events.Output(event.process, event.stream, data)


def _has_many_lines(data: bytes) -> bool:
    # mostly the start is enough
    starts = data.count(b'\n', 0, PROBE_SIZE)
    return starts >= FEW or data.count(b'\n', 0, -1) >= FEW


def time_stamp(seconds: float) -> str:
    """Return the time in front of a line, from seconds since the epoch."""
    clock = time.strftime('%H:%M:%S', time.localtime(seconds))
    return f'{clock}.{int(seconds % 1 * 1000):03} '


def last_state(line: bytes) -> bytes:
    r"""Return what a line with carriage returns shows at last."""
    if b'\r' not in line:
        return line
    states = [state for state in line.split(b'\r') if state.strip()]
    return states[-1] if states else b''
