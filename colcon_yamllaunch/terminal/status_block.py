# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The lines of the status block."""

from collections import Counter
from collections.abc import Iterable
import math
import re

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import COLOUR, one_line
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.outcome import signal_name
from colcon_yamllaunch.engine.state import (
    LaunchState,
    MemberState,
    StopProgress,
)
from colcon_yamllaunch.terminal.line_filter import Filtering
from colcon_yamllaunch.terminal.status_model import (
    ALARM,
    BOLD,
    DIM,
    GREEN,
    HEALTHY,
    LOOKS,
    readiness_text,
    RED,
    REVERSE,
    StatusModel,
    YELLOW,
)

#: Lines that the block takes at most.
MAXIMUM_LINES = 4
#: Processes that are all named, and lines up to which more of them are; where
#: they take more, those that are as they should be are counted.
FEW_PROCESSES, NAMED_LINES = 10, 2

#: Cells of the end of a line that may still change that are always seen: of a
#: count, or of what is behind a bar.
_LIVE_END = 10

_COLOUR = re.compile(COLOUR)
_GAP = '  '
_SPACE = '   '
_RESET = '\x1b[0m'
_CTRL_C = ' (Ctrl-C forces)'


@dataclass(frozen=True, slots=True)
class View:
    """
    The state of the keys, as far as the block shows it.

    :param live: Lines of output that may still change, above the block
    :param chosen: The label of the process that the next key is for
    :param filtering: What is shown of the output
    :param hint: The keys that may be pressed next, the most important first;
      empty for none
    :param prompt: The text before the input; with it, the last line of the
      block is the input line
    :param typed: The input
    :param cursor: How many characters of the input are before the cursor
    :param note: A note that is shown once, such as why a key did nothing
    :param overlay: Lines that replace the block, above the hint; they may take
      nearly all of the terminal
    """

    live: tuple[str, ...] = ()
    chosen: str | None = None
    filtering: Filtering = Filtering()
    hint: str = ''
    prompt: str | None = None
    typed: str = ''
    cursor: int = 0
    note: str = ''
    overlay: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Style:
    """
    What a terminal can show.

    :param columns: Its width
    :param lines: How many the block may take
    :param color: Whether colours are used
    :param ascii: Whether there is nothing but ASCII
    :param height: Its lines
    """

    columns: int
    lines: int = MAXIMUM_LINES
    color: bool = True
    ascii: bool = False
    height: int = 24


@dataclass(frozen=True, slots=True)
class StatusBlock:
    """
    The lines below the output.

    :param lines: None of them takes the last column
    :param cursor: The line and the column of the cursor, counted from 0; None
      to leave it where the output ends
    """

    lines: tuple[str, ...]
    cursor: tuple[int, int] | None = None


def block_of(
    model: StatusModel,
    view: View,
    style: Style,
    now: float,
    pending: str = '',
) -> StatusBlock:
    """
    Return the status block.

    :param now: The time by the clock of the launch
    :param pending: What the launch waits for, in one line
    """
    # the first column has the cursor, and the last is left free
    columns = max(1, style.columns - 2)
    if view.overlay:
        # one line stays for the output
        lines = [*view.overlay[: max(0, style.height - 2)]]
        return _block([*lines, _painted(view.hint, DIM, style)], style)
    typing = view.prompt is not None
    answer = _answer_lines(
        view, style, columns, max(1, style.lines - typing - 1)
    )
    summary = _summary(model.state, view, style, now, pending)
    if answer and width(
        tail := _SPACE.join(('', *summary))
    ) <= columns - width(answer[-1]):
        answer[-1] += tail
        summary = []
    if len(answer) > style.lines - typing - 2:
        # the hint for a choice is more important than the summary
        summary = [] if answer else summary
    hint = '' if answer or typing else view.hint
    rows = style.lines - len(answer) - bool(summary or hint) - typing
    if style.lines == 1 and not (typing or answer or model.state.stopping):
        # the states are more important than the summary and the hint
        summary, hint, rows = [], '', 1
    lines = []
    if rows > 0:
        lines += _processes(model, view, style, columns, rows)
    lines += answer
    room = style.lines - len(lines) - typing
    lines += _last_lines(_SPACE.join(summary), hint, style, columns, room)
    lines = [f' {line}' for line in lines]
    # one line stays for the output, and one for the input
    room = max(0, style.height - len(lines) - 2)
    live = view.live[max(0, len(view.live) - room) :]
    # the ends of live lines change, so they stay visible
    kept = min(_LIVE_END, columns // 4)
    live = tuple(cut_inside(line, columns + 1, kept) for line in live)
    block = _block([*live, *lines], style)
    if view.prompt is None:
        return block
    line, column = _typed(view, columns)
    return StatusBlock((*block.lines, line), (len(block.lines), column))


def next_change(state: LaunchState, now: float) -> float | None:
    """Return when the block changes without an event."""
    if state.changed is not None and not state.stopping:
        return now + 1.0 - (now - state.changed) % 1.0
    if state.has_readiness and not state.stopping:
        return min(
            (
                now + 1.0 - state.seconds_of(member) % 1.0
                for member in state.by_label.values()
                if member.waits_for or member.unmet
            ),
            default=None,
        )
    countdown = state.countdown
    if countdown is None or countdown.event.next_signal is None:
        return None
    return next_second(countdown.due, now) if countdown.due > now else None


def next_second(due: float, now: float) -> float:
    """Return when the number of whole seconds left changes."""
    left = due - now
    return now + (left - math.ceil(left) + 1.0)


def _block(lines: Iterable[str], style: Style) -> StatusBlock:
    if style.ascii:
        lines = (line.translate(_ASCII) for line in lines)
    return StatusBlock(
        tuple(cut(line, max(2, style.columns - 1)) for line in lines)
    )


# the processes


def _processes(
    model: StatusModel, view: View, style: Style, columns: int, count: int
) -> list[str]:
    """Return lines with all processes, or with the most important ones."""
    members = model.members
    shortest = 4
    is_few = len(members) <= FEW_PROCESSES
    named = count if is_few else min(count, NAMED_LINES)
    # skip the attempt if the chips cannot fit
    if len(members) * shortest <= named * (columns + len(_GAP)):
        lines = _packed(
            [_chip(p, model, view, style) for p in members], columns
        )
        if len(lines) <= named:
            return lines
    ordered = sorted(members, key=lambda member: _rank(member, model, view))
    healthy = (True, HEALTHY)
    notable = sum(_rank(member, model, view) < healthy for member in ordered)
    most = min(notable, count * columns // shortest)
    chips = [_chip(p, model, view, style) for p in ordered[:most]]
    best: list[str] = []
    for has_words in (True, False):
        low, high = 0, most
        while low <= high:
            middle = (low + high) // 2
            rest = _rest(ordered[middle:], style, has_words=has_words)
            lines = _packed([*chips[:middle], *rest], columns)
            if len(lines) <= count:
                best, low = lines, middle + 1
            else:
                high = middle - 1
        if high == most:
            break
    return best or [cut(_GAP.join(rest), columns)]


def _rank(
    member: MemberState, model: StatusModel, view: View
) -> tuple[bool, int, int]:
    condition = member.condition
    rank = LOOKS[condition].rank
    if member.label in model.cpu or (
        condition == 'running' and member.failure
    ):
        rank = min(rank, 1)
    if condition == 'stopping' and model.state.stopping:
        rank = HEALTHY
    return member.label != view.chosen, rank, -member.turn


def _chip(
    member: MemberState, model: StatusModel, view: View, style: Style
) -> str:
    """Return what is shown of one process."""
    row = model.row(member)
    label, look = member.label, row.look
    text, text_colour = row.title, look.text_colour
    if not view.filtering.has(label):
        text = f'({text})'
        text_colour = text_colour or DIM
    failure = member.failure
    if member.condition == 'running' and member.restarts:
        # the colour of the restarts shows it
        failure = ''
    words = [
        (row.key, BOLD),
        (look.sign, look.colour),
        (text, text_colour),
        (row.restarts, RED if member.failure else YELLOW),
        (row.cpu, YELLOW),
        (row.lifecycle, YELLOW),
        (failure, RED),
    ]
    words = [(word, colour) for word, colour in words if word]
    plain = ' '.join(word for word, _ in words)
    if label != view.chosen:
        return ' '.join(_painted(word, c, style) for word, c in words)
    return _painted(plain, REVERSE, style) if style.color else f'>{plain}<'


def _rest(
    members: Iterable[MemberState], style: Style, *, has_words: bool
) -> list[str]:
    """Return the numbers of processes that are not named, by state."""
    counts = Counter(member.condition for member in members)
    chips = []
    for condition, look in LOOKS.items():
        if counts[condition]:
            sign = _painted(look.sign, look.colour, style)
            word = f' {condition}' if has_words else ''
            chips.append(f'{sign} {counts[condition]}{word}')
    return chips


def _packed(chips: Iterable[str], columns: int, gap: str = _GAP) -> list[str]:
    """Return lines with as many chips as fit into each."""
    lines: list[str] = []
    room = 0
    for chip in chips:
        cells = width(chip)
        if lines and cells + len(gap) <= room:
            lines[-1] += gap + chip
            room -= cells + len(gap)
        else:
            lines.append(cut(chip, columns))
            room = columns - cells
    return lines


# results, notes and hints


def _last_lines(
    summary: str, hint: str, style: Style, columns: int, room: int
) -> list[str]:
    """Return the summary and the hint, in one line or two."""
    if not (summary or hint) or room < 1:
        return []
    # only whole words of the hint, and at least the first
    hint = _packed(hint.split(_GAP), columns)[0]
    if summary and hint and width(summary) + len(_SPACE + hint) > columns:
        if room > 1:
            return [cut(summary, columns), _painted(hint, DIM, style)]
        hint = hint.partition(_GAP)[0]
        summary = cut(summary, max(1, columns - len(_SPACE + hint)))
    return [_SPACE.join(filter(None, (summary, _painted(hint, DIM, style))))]


def _answer_lines(
    view: View, style: Style, columns: int, count: int
) -> list[str]:
    """Return lines with the note, or with the hint for a choice."""
    colour = ''
    if view.note:
        colour = YELLOW
        lines = _packed(one_line(view.note).split(), columns, ' ')
    elif view.hint and (view.chosen is not None or view.prompt is not None):
        lines = _packed(one_line(view.hint).split(_GAP), columns)
    else:
        return []
    if len(lines) > count:
        lines[count - 1 :] = [cut(f'{lines[count - 1]} …', columns)]
    return [_painted(line, colour, style) for line in lines]


def _summary(
    state: LaunchState, view: View, style: Style, now: float, pending: str
) -> list[str]:
    summary = []
    if state.stopping:
        text = _stopping(state.countdown, now)
        if width(text) > style.columns - 2:
            # it was shown when it began
            text = text.replace(_CTRL_C, '')
        summary.append(_painted(text, YELLOW, style))
    else:
        watched = state.change
        if watched is not None and not watched.is_final:
            text = _watched(watched, style)
            if state.changed is not None and now >= state.changed + 1.0:
                text = f'{math.floor(now - state.changed)} s {text}'
            summary.append(text)
        if readiness := readiness_text(state):
            summary.append(_painted(readiness, YELLOW, style))
        if pending:
            summary.append(one_line(pending))
        if watched is not None and watched.is_final:
            summary.append(_watched(watched, style))
    if view.filtering.text:
        summary.append(_painted(one_line(view.filtering.text), YELLOW, style))
    return summary


def _stopping(countdown: StopProgress | None, now: float) -> str:
    if countdown is None:
        return f'stopping{_CTRL_C}'
    event = countdown.event
    text = 'stopping'
    if event.next_signal is not None:
        seconds = max(0, math.ceil(countdown.due - now))
        text += f', {signal_name(event.next_signal)} in {seconds} s'
    names = list(event.labels[: limits.LISTED_NAMES])
    if len(event.labels) > len(names):
        names.append(f'{len(event.labels) - len(names)} more')
    if event.timers:
        names.append(f'{event.timers} timer' + 's' * (event.timers > 1))
    return f'{text}{_CTRL_C}: {one_line(", ".join(names))}'


def _watched(
    event: events.ChangeReported | events.ChangeChecked, style: Style
) -> str:
    failed = event.severity != 'INFO'
    if not event.is_final:
        sign, colour = '…', YELLOW
    elif failed:
        sign, colour = LOOKS['failed'].sign, ALARM
    else:
        sign, colour = LOOKS['ended'].sign, GREEN
    text = one_line(' '.join(event.lines()))
    return f'{_painted(sign, colour, style)} {text}'


# the line to type in


def _typed(view: View, columns: int) -> tuple[str, int]:
    """Return the line, and the column of the cursor in it."""
    prompt = cut(one_line(view.prompt or ''), max(1, columns // 2))
    room = columns + 1 - width(prompt)
    text = view.typed
    before = text[: view.cursor]
    # of a long text, the part around the cursor is shown
    start = 0
    while width(before[start:]) >= room:
        start += max(1, room // 2)
    shown = cut(text[start:], room)
    return f'{prompt}{shown}', width(prompt) + width(before[start:])


def _painted(text: str, colour: str, style: Style) -> str:
    return f'{colour}{text}{_RESET}' if colour and style.color else text


_ASCII = str.maketrans(
    {'…': '~', '×': 'x', **{k.sign: k.plain_sign for k in LOOKS.values()}}
)


# the cells of a terminal that a text takes


def width(text: str) -> int:
    """Return the cells that a text takes; colours take none."""
    if '\x1b' in text:
        text = _COLOUR.sub('', text)
    return len(text) if text.isascii() else sum(map(_cells, text))


def cut(text: str, cells: int) -> str:
    """
    Cut the end of a text that takes more than `cells` cells.

    A colour that is on there is ended.
    """
    if width(text) <= cells:
        return text
    kept: list[str] = []
    left = cells - 1
    end = 0
    while end < len(text):
        colour = _COLOUR.match(text, end)
        if colour is not None:
            kept.append(colour[0])
            end = colour.end()
            continue
        left -= width(text[end])
        if left < 0:
            break
        kept.append(text[end])
        end += 1
    reset = _RESET if '\x1b' in text else ''
    return ''.join((*kept, '…' if cells > 0 else '', reset))


def cut_inside(text: str, cells: int, kept: int) -> str:
    """
    Cut a text that takes more than `cells` cells before its end.

    :param kept: The cells of its end, of which the colours are lost
    """
    if width(text) <= cells:
        return text
    bare = _COLOUR.sub('', text)
    start = len(bare)
    while start and width(bare[start - 1 :]) <= min(kept, cells - 1):
        start -= 1
    end = bare[start:]
    return cut(text, cells - width(end)) + end


def _cells(character: str) -> int:
    if character < '\u0300':
        return 1
    # imported late, as few names have more than ASCII
    import unicodedata

    if unicodedata.category(character) in ('Mn', 'Me', 'Cf'):
        return 0
    return 1 + (unicodedata.east_asian_width(character) in 'WF')
