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

_HEADS = (
    *('PROCESS', 'STATE', 'READY', 'PID', 'UP', 'RESTARTS', 'CPU', 'MEMORY'),
    'AFTER',
)
_NUMBERS = frozenset(('PID', 'UP', 'RESTARTS', 'CPU', 'MEMORY'))
# of launches that know what is ready
_READINESS = frozenset(('READY', 'AFTER'))
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
    columns = [
        column
        for column, head in enumerate(_HEADS)
        if launch.has_readiness or head not in _READINESS
    ]
    rows = [
        [row[column] for column in columns]
        for row in (_HEADS, *_rows(launch, usage))
    ]
    if len(rows) == 1:
        lines = ['no processes']
    else:
        widths = column_widths(rows)
        if width is not None:
            _narrow(widths, width - len(_INDENT))
        right = [n for n, head in enumerate(rows[0]) if head in _NUMBERS]
        lines = table_lines(rows, widths, without_end, right)
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
        yield _process_row(launch, process, usage)
        for component in launch.components_of(process.label):
            yield _component_row(launch, component)
    others: dict[str, list[ComponentState]] = {}
    for component in launch.components_of(None):
        others.setdefault(component.container, []).append(component)
    for container, components in others.items():
        nothing = [''] * (len(_HEADS) - 2)
        yield (one_line(container), 'not of this launch', *nothing)
        for component in components:
            yield _component_row(launch, component)


def _process_row(
    launch: LaunchState, process: ProcessState, usage: Mapping[int, Usage]
) -> tuple[str, ...]:
    used = use_of(process, usage)
    runs = process.pid is not None
    return (
        one_line(process.label),
        _phase(process),
        _is_ready(process),
        str(process.pid) if runs else '',
        duration(process.seconds) if runs else '',
        str(process.restarts),
        *((f'{used.cpu:.1%}', size(used.memory)) if used else ('', '')),
        _after(launch, process),
    )


def _component_row(
    launch: LaunchState, component: ComponentState
) -> tuple[str, ...]:
    up = duration(component.seconds) if component.phase == 'loaded' else ''
    label = one_line(component.label)
    return (
        _INDENT + label,
        _phase(component),
        _is_ready(component),
        *('', up, '', '', ''),
        _after(launch, component),
    )


def _is_ready(member: MemberState) -> str:
    return 'yes' if member.is_ready else 'no'


def _after(launch: LaunchState, member: MemberState) -> str:
    """Return what a member waits for before it starts."""
    return one_line(', '.join(launch.after.get(member.label, ())))


def _phase(member: MemberState) -> str:
    if member.waits_for:
        return one_line(f'waiting for {", ".join(member.waits_for)}')
    if member.unmet:
        conditions = ' and '.join(member.unmet)
        return one_line(f'{member.phase}, waiting for {conditions}')
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
