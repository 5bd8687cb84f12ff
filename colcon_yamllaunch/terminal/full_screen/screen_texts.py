# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The texts of the full screen: its lines, its help, and descriptions."""

from collections.abc import Collection, Sequence

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import duration, size
from colcon_yamllaunch.engine.description import Description
from colcon_yamllaunch.engine.state import ComponentState, ProcessState
from colcon_yamllaunch.terminal.full_screen.launch_model import LaunchModel
from colcon_yamllaunch.terminal.keyboard import ESCAPE_NAME
from colcon_yamllaunch.terminal.keymap import ON_ALL, ON_ONE
from colcon_yamllaunch.terminal.status_model import (
    description_lines,
    readiness_text,
    state_of,
    waiting_text,
)
from rich.table import Table
from rich.text import Text

# keys that are always shown: the help lists all others, and Tab leads to the
# pane that a narrow terminal hides
_LEADING = ('?', 'q')
_SWITCH = 'Tab'
_BARS = '▁▂▃▄▅▆▇█'


def title_text(model: LaunchModel, *, follows: bool) -> Text:
    """
    Return what one should know of a launch, the most important first.

    :param follows: Whether the end of the output is in sight
    """
    state = model.state
    text = Text(no_wrap=True, overflow='ellipsis')
    if model.ending:
        words = 'ended'
        if state.exit_code is not None:
            words += f', exit code {state.exit_code}'
        text.append(f' {words} ', 'bold reverse')
    elif state.stopping:
        text.append(' stopping ', 'bold reverse yellow')
    failed = sum(bool(member.failure) for member in state.members())
    if failed:
        text.append(f' {failed} failed ', 'bold reverse red')
    if readiness := readiness_text(state):
        text.append(f' {readiness.partition(",")[0]} ', 'reverse yellow')
    filtering = model.view.filtering.text
    if filtering:
        text.append(f' {one_line(filtering)} ', 'reverse cyan')
    if not follows:
        text.append(' held, End follows ', 'reverse')
    if model.missed_bytes:
        text.append(f' {size(model.missed_bytes)} missed ', 'yellow')
    text.append(f' {one_line(state.title)}', 'bold')
    text.append(f'  {duration(state.seconds)}  pid {state.pid}')
    if state.watch_paused:
        text.append('  --watch is off', 'yellow')
    elif state.watch is not None:
        style = 'red' if state.watch_failed else ''
        text.append(f'  watch: {one_line(state.watch) or "…"}', style)
    return text


def keys_text(
    width: int, *, is_narrow: bool, left_out: Collection[str]
) -> Text:
    """
    Return what keys do, as far as there is room.

    :param is_narrow: Whether there is one pane at a time
    :param left_out: The names of keys that can do nothing now
    """
    text = Text(no_wrap=True)
    leading = (*_LEADING, _SWITCH) if is_narrow else _LEADING
    keys = [
        key
        for key in (*ON_ONE, *ON_ALL)
        if key.word and key.name not in left_out
    ]
    last = [key for key in keys if key.key in leading]
    room = width - sum(len(key.key) + len(key.word) + 3 for key in last)
    shown = []
    for key in keys:
        cells = len(key.key) + len(key.word) + 3
        if key not in last and cells <= room:
            room -= cells
            shown.append(key)
    for key in (*shown, *last):
        text.append(f'{key.key} ', 'bold cyan')
        text.append(f'{key.word}  ', 'dim')
    return text


def help_table(last: str) -> Table:
    """
    Return what all keys do.

    :param last: What Ctrl-C does
    """
    table = Table.grid(padding=(0, 2), pad_edge=True)
    table.add_column(style='cyan', no_wrap=True)
    table.add_column()
    for title, keys in (
        ('What the cursor is on', ON_ONE),
        ('All', ON_ALL),
    ):
        table.add_row('', Text(title, 'bold'))
        for key in keys:
            table.add_row(key.key, key.text)
        table.add_row()
    table.add_row(ESCAPE_NAME, 'come back from the process that is typed at')
    table.add_row('Ctrl-C', last)
    table.add_row('Ctrl-Z', 'suspend the full screen, and not the launch')
    table.add_row()
    table.add_row(
        'Arrows',
        'scroll, as Page up and down, Home and End do; the output follows '
        'what comes while its end is in sight',
    )
    return table


def in_short(model: LaunchModel, label: str, width: int) -> Text:
    """Return a process or component in four lines: state and resources."""
    member = model.member(label)
    text = Text(no_wrap=True, overflow='ellipsis')
    if member is None:
        return text
    text.append(one_line(label), 'bold')
    if member.node is not None:
        text.append(f'  {one_line(member.node)}', 'dim')
    text.append(f'\n{waiting_text(model.state, member) or state_of(member)}')
    if isinstance(member, ProcessState) and member.pid is not None:
        up = duration(model.state.seconds_of(member))
        text.append(f'  pid {member.pid}  up {up}')
        if member.restarts:
            text.append(f'  restarts {member.restarts}')
    elif isinstance(member, ComponentState):
        text.append(f'  {one_line(member.plugin)}')
    history = list(model.usage.get(label, ()))
    if history:
        latest = history[-1]
        for name, shown, values in (
            ('CPU', f'{latest.cpu:.1%}', [u.cpu for u in history]),
            ('RAM', size(latest.memory), [float(u.memory) for u in history]),
        ):
            text.append(f'\n{name} ', 'dim')
            text.append(f'{shown:>10} ')
            room = max(0, width - len(name) - 13)
            text.append(curve(values[-room:] if room else ()), 'cyan')
    return text


def curve(values: Sequence[float]) -> str:
    """Draw numbers above 0, the largest one highest."""
    top = max(values, default=0.0)
    if not top:
        return _BARS[0] * len(values)
    last = len(_BARS) - 1
    return ''.join(_BARS[round(v / top * last)] for v in values)


def in_full(model: LaunchModel, label: str, description: Description) -> Text:
    """Return a process or component with all that is known of it."""
    text = in_short(model, label, 60)
    text.no_wrap = False
    # below its name, which is there already
    for line in tuple(description_lines(description))[1:]:
        text.append(f'\n{one_line(line)}')
    return text
