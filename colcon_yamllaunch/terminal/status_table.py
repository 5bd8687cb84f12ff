# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running launches as a table."""

from collections.abc import Iterator, Mapping

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import (
    column_widths,
    duration,
    size,
    table_lines,
    table_width,
    without_end,
)
from colcon_yamllaunch.control.resource_usage import Usage, use_of
from colcon_yamllaunch.engine.state import (
    ComponentState,
    LaunchState,
    MemberState,
    ProcessState,
)
from colcon_yamllaunch.terminal.status_model import state_of

_HEADS = ('PROCESS', 'STATE', 'PID', 'UP', 'RESTARTS', 'CPU', 'MEMORY')
_RIGHT = frozenset((2, 3, 4, 5, 6))
_INDENT = '  '
_SMALLEST_LABEL = 12
# the states of connections to machines that are shown
_BROKEN = {'lost': 'the link is lost', 'gone': 'is gone'}
_SMALLEST_STATE = 10
# of the process, its state and its process id
_LEAST_COLUMNS = 3


def table(
    launch: LaunchState,
    usage: Mapping[int, Usage],
    width: int | None,
    orphaned: bool = False,
) -> str:
    """
    Return a launch and its processes, components below their containers.

    :param usage: What the process groups use
    :param width: The columns that there are, None for any number
    :param orphaned: Whether its launcher was killed
    """
    title = one_line(f'{launch.title}: {_state_of(launch, orphaned)}')
    rows = [_HEADS, *_rows(launch, usage)]
    if len(rows) == 1:
        lines = ['no processes']
    else:
        widths = column_widths(rows)
        if width is not None:
            _narrow(widths, width - len(_INDENT))
        lines = table_lines(rows, widths, without_end, _RIGHT)
    for machine in launch.machines.values():
        if machine.link in _BROKEN:
            what = _BROKEN[machine.link]
            lines.append(f'{machine.name}: {what}: {machine.reason}')
    if launch.watch is not None:
        last = f'last change: {launch.watch}' if launch.watch else 'no change'
        lines.append(f'watches its files; {last}')
    lines = [title, *(_INDENT + one_line(line) for line in lines)]
    if width is not None:
        lines = [without_end(line, width) for line in lines]
    return '\n'.join(lines)


def _state_of(launch: LaunchState, orphaned: bool) -> str:
    if not orphaned:
        state = 'stopping' if launch.stopping else 'running'
        return (
            f'{state} for {duration(launch.seconds)}, pid {launch.pid}, '
            f'in {launch.folder}'
        )
    what = 'these still run, --stop ends them'
    if launch.stopping:
        what = 'its guard is stopping what is left'
    where = f', in {launch.folder}' if launch.folder else ''
    return f'launcher {launch.pid} was killed, {what}{where}'


def _rows(
    launch: LaunchState, usage: Mapping[int, Usage]
) -> Iterator[tuple[str, ...]]:
    for process in launch.processes:
        yield _process_row(process, usage)
        for component in launch.components_of(process.label):
            yield _component_row(component)
    others: dict[str, list[ComponentState]] = {}
    for component in launch.components_of(None):
        others.setdefault(component.container, []).append(component)
    for container, components in others.items():
        nothing = [''] * (len(_HEADS) - 2)
        yield (one_line(container), 'not of this launch', *nothing)
        yield from map(_component_row, components)


def _process_row(
    process: ProcessState, usage: Mapping[int, Usage]
) -> tuple[str, ...]:
    used = use_of(process, usage)
    runs = process.pid is not None
    return (
        one_line(process.label),
        _phase(process),
        str(process.pid) if runs else '',
        duration(process.seconds) if runs else '',
        str(process.restarts),
        *((f'{used.cpu:.1%}', size(used.memory)) if used else ('', '')),
    )


def _component_row(component: ComponentState) -> tuple[str, ...]:
    up = duration(component.seconds) if component.phase == 'loaded' else ''
    label = one_line(component.label)
    return (_INDENT + label, _phase(component), '', up, '', '', '')


def _phase(member: MemberState) -> str:
    if member.phase in ('running', 'loaded') and member.lifecycle is not None:
        return f'{member.phase}, {member.lifecycle}'
    if member.phase == 'failed':
        return f'not loaded: {member.ending}'
    return state_of(member)


def _narrow(widths: list[int], width: int) -> None:
    """Shorten states and labels, then drop columns at the end, to fit."""
    for column, least in ((1, _SMALLEST_STATE), (0, _SMALLEST_LABEL)):
        least = min(widths[column], least)
        excess = max(0, table_width(widths) - width)
        widths[column] = max(least, widths[column] - excess)
    while table_width(widths) > width and len(widths) > _LEAST_COLUMNS:
        widths.pop()
