# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The table of started processes, for a terminal."""

from collections.abc import Sequence
from itertools import takewhile
import os
from typing import NamedTuple

from colcon_yamllaunch.common.table import (
    column_widths,
    table_lines,
    table_width,
    without_middle,
)
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.plan.plan import Plan, Process, Shutdown

_HEADER = ('NAME', 'PACKAGE', 'NODE', 'PID')


class StartRow(NamedTuple):
    """
    A process that runs.

    :param package: Its package, empty where there is none
    :param node: The full name of its node, empty where there is none
    :param program: The name of its program, which is not shown
    """

    label: str
    package: str
    node: str
    pid: str
    program: str


class StartTable:
    """
    Shows the processes that a plan starts at once in a table.

    Events before all have started are shown after it. Each process behind a
    timer, and each that is started again, later has a line of its own.
    """

    def __init__(
        self, plan: Plan, size: os.terminal_size, screen: Screen
    ) -> None:
        entries = takewhile(
            lambda entry: not isinstance(entry, Shutdown), plan.entries
        )
        self._pending = {e.label for e in entries if isinstance(e, Process)}
        self._size = size
        self._screen = screen
        self._started: list[events.Started] = []
        # events to show after the table, and their bytes of output
        self._held: list[events.Event] = []
        self._held_bytes = 0

    def handle(self, event: events.Event) -> None:
        """Show an event of the launch, now or after the table."""
        pending = self._pending
        if not pending:
            self._screen.handle(event)
            return
        if (
            isinstance(event, events.Started)
            and event.process.label in pending
        ):
            self._started.append(event)
        else:
            self._held.append(event)
        match event:
            case (
                events.Started(process=member)
                | events.StartFailed(process=member)
                | events.Dropped(member=member)
            ):
                pending.discard(member.label)
            case events.Output():
                self._held_bytes += len(event.data)
            case events.ShuttingDown() | events.MachineGone() | events.Ended():
                pending.clear()
        if not pending or self._held_bytes > limits.TABLE_BACKLOG_BYTES:
            pending.clear()
            self._show()

    def _show(self) -> None:
        rows = [row_of(s.process, s.pid) for s in self._started]
        lines = start_table_lines(rows, self._size)
        if not lines:
            for event in self._started:
                self._screen.handle(event)
        self._screen.show_table(lines)
        for held in self._held:
            self._screen.handle(held)
        self._held.clear()


def row_of(process: Process, pid: int) -> StartRow:
    """Return the row of a process."""
    return StartRow(
        process.label,
        process.package or '',
        process.node_name or '',
        str(pid),
        os.path.basename(str(process.argv[0])),
    )


def start_table_lines(
    rows: Sequence[StartRow], size: os.terminal_size
) -> list[str]:
    """
    Return a table that fits a terminal, or nothing where that is too narrow.

    Where it would be too high, the processes of one package share a row, and
    those of one program where there is no package.
    """
    if not rows or size.columns < limits.TABLE_COLUMNS:
        return []
    if len(rows) > size.lines - limits.TABLE_MARGIN_LINES:
        groups: dict[tuple[str, str], list[StartRow]] = {}
        for row in rows:
            key = row.package, '' if row.package else row.program
            groups.setdefault(key, []).append(row)
        rows = [_merged(group) for group in groups.values()]
    shown = [i for i in range(len(_HEADER)) if any(row[i] for row in rows)]
    cells = [[row[i] for i in shown] for row in (_HEADER, *rows)]
    widths = column_widths(cells)
    for _ in range(table_width(widths) - size.columns):
        widths[widths.index(max(widths))] -= 1
    return table_lines(cells, widths, without_middle)


def _merged(group: Sequence[StartRow]) -> StartRow:
    merged = StartRow(
        *(
            first if first == last else f'{first} … {last}'
            for first, last in zip(group[0], group[-1], strict=True)
        )
    )
    if len(group) == 1:
        return merged
    count = f'({len(group)})'
    return merged._replace(package=f'{merged.package} {count}'.lstrip())
