# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The processes and components of a launch as rows, or in their plan."""

from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import replace
import os
import re
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.engine.state import ComponentState
from colcon_yamllaunch.engine.state import Condition
from colcon_yamllaunch.engine.state import Part
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.terminal.full_screen.launch_model import LaunchModel
from colcon_yamllaunch.terminal.status_block import LOOKS
from colcon_yamllaunch.terminal.status_model import MUCH_CPU

#: The colour of each.
_STYLES: Mapping[Condition, str] = {
    'waiting': 'bright_black',
    'starting': 'yellow',
    'running': 'green',
    'stopping': 'yellow',
    'held': 'yellow',
    'respawn': 'yellow',
    'ended': 'bright_black',
    'stopped': 'bright_black',
    'failed': 'bold red',
}
#: How a process failed, in full; see `outcome.Outcome`.
_FAILED = re.compile(r'exited with code (\d+)|died by (\w+)( \([^)]*\))?')
#: What stands before a launch file, a group, a timer.
_BLOCKS: Mapping[str, str] = {'file': '▤', 'group': '▣', 'timer': '◷'}


@dataclass(frozen=True, slots=True)
class Row:
    """
    A row.

    :param label: The process or component, None for anything else
    :param depth: How far it is indented
    :param sign: Its state, or what it is, in one character
    :param style: The colour of that
    :param title: What it is called
    :param note: What else there is to say in short
    :param key: The key that chooses it
    """

    label: str | None
    depth: int
    sign: str
    style: str
    title: str
    note: str = ''
    key: str = ''


def part_rows(model: LaunchModel) -> list[Row]:
    """Return a row for each process, with its components below it."""
    rows: list[Row] = []
    state = model.state
    for process in state.processes:
        rows.append(_row(model, process, 0))
        rows += (_row(model, c, 1) for c in state.components_of(process.label))
    others = list(state.components_of(None))
    for container in dict.fromkeys(c.container for c in others):
        title = one_line(container)
        rows.append(Row(None, 0, '▢', 'dim', title, 'not of this launch'))
        rows += (_row(model, c, 1) for c in others if c.container == container)
    return _with_keys(model, rows)


def tree_rows(model: LaunchModel) -> list[Row]:
    """Return the plan: launch files, groups, timers, and what is in them."""
    parts = {part.label: part for part in model.state.parts()}
    rows = list(_branches(model, parts, model.tree, 0))
    return _with_keys(model, rows)


def _branches(
    model: LaunchModel,
    parts: Mapping[str, Part],
    branches: Sequence[Mapping[str, Any]],
    depth: int,
) -> Iterator[Row]:
    for branch in branches:
        kind, title = str(branch.get('kind')), str(branch.get('title'))
        part = parts.get(title)
        if kind in _BLOCKS:
            shown = os.path.basename(title) if kind == 'file' else title
            name = one_line(shown) or kind
            # the place in a file, as its path is long
            position = os.path.basename(one_line(str(branch.get('position'))))
            if not depth and kind == 'file':
                # what was launched is included nowhere
                position = ''
            yield Row(None, depth, _BLOCKS[kind], 'cyan', name, position)
        elif part is not None:
            yield _row(model, part, depth)
        children = branch.get('children')
        if isinstance(children, list):
            yield from _branches(model, parts, children, depth + 1)


def _row(model: LaunchModel, part: Part, depth: int) -> Row:
    condition = part.condition
    style = _STYLES[condition]
    if condition == 'respawn' and part.failure:
        style = _STYLES['failed']
    return Row(
        part.label,
        depth,
        LOOKS[condition].sign,
        style,
        one_line(part.label),
        _note(model, part),
    )


def _note(model: LaunchModel, part: Part) -> str:
    words = [_in_short(state_of(part))]
    if isinstance(part, ProcessState):
        if part.restarts:
            words.append(f'×{part.restarts}')
        history = model.usage.get(part.label)
        if part.pid is not None and history and history[-1].cpu >= MUCH_CPU:
            words.append(f'{history[-1].cpu:.0%}')
    return ' '.join(words)


def _in_short(state: str) -> str:
    """Return a state as the status block has it: the code, or the signal."""
    return _FAILED.sub(lambda m: m[2] or f'exit {m[1]}', state)


def state_of(part: Part) -> str:
    """Return the state of a process or component, as a word or a sentence."""
    if part.phase in ('running', 'loaded') and part.lifecycle is not None:
        return part.lifecycle
    if part.phase == 'respawn':
        return f'respawns ({part.ending})'
    if part.phase == 'failed' or not isinstance(part, ComponentState):
        return one_line(part.ending) or part.phase
    return part.phase


def _with_keys(model: LaunchModel, rows: list[Row]) -> list[Row]:
    """Give the first processes the keys that choose them."""
    labels = [p.label for p in model.state.processes][:10]
    keys = {label: str((n + 1) % 10) for n, label in enumerate(labels)}
    return [replace(row, key=keys.get(row.label or '', '')) for row in rows]


def label_of_key(model: LaunchModel, key: str) -> str | None:
    """Return the process that a digit chooses."""
    number = (int(key) - 1) % 10
    processes = model.state.processes
    return processes[number].label if number < len(processes) else None
