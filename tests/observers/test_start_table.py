# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The table of what was started."""

import io
import os

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.events import (
    Dropped,
    Exited,
    MachineGone,
    Output,
    ShuttingDown,
    Started,
    StartFailed,
)
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.writer import TextWriter
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.observers.start_table import (
    row_of,
    start_table_lines,
    StartRow,
    StartTable,
)
from colcon_yamllaunch.plan.plan import Plan, Timer
import pytest


def size(columns=80, lines=24):
    return os.terminal_size((columns, lines))


@pytest.fixture
def table():
    """Return a function that shows events of a plan and returns the text."""

    def show(entries, *events, columns=80):
        stream = io.StringIO()
        plan = Plan(tuple(entries))
        screen = Screen(
            TextWriter(stream), plan.processes(), color=False, terminal=True
        )
        shown = StartTable(plan, size(columns), screen)
        for event in events:
            shown.handle(event)
        return stream.getvalue().replace('\r', '').splitlines()

    return show


def test_columns_are_aligned(process):
    node = process('counter', package='my_pkg', node_name='/demo/counter')
    rows = [row_of(node, 4329), row_of(process('pump-2'), 12)]
    assert start_table_lines(rows, size()) == [
        'NAME     PACKAGE  NODE           PID',
        'counter  my_pkg   /demo/counter  4329',
        'pump-2                           12',
    ]


def test_empty_column_is_left_out():
    lines = start_table_lines([StartRow('a', 'sh', '', '1', 'a')], size())
    assert lines == ['NAME  PACKAGE  PID', 'a     sh       1']


@pytest.mark.parametrize('columns', [40, 41, 60, 79])
def test_table_fits_the_width(columns):
    rows = [
        StartRow(
            'a' * 50, '/ws/' + 'b' * 60 + '/end', '/n' * 20, '123456', 'a'
        ),
        StartRow('short', 'pkg', '/', '1', 'b'),
    ]
    lines = start_table_lines(rows, size(columns))
    assert len(lines) == 3
    assert max(map(len, lines)) <= columns
    assert '…' in lines[1]
    assert '123456' in lines[1]
    assert 'end' in lines[1]


def test_too_narrow_terminal_gets_no_table():
    assert (
        start_table_lines([StartRow('a', 'b', '/', '1', 'c')], size(20)) == []
    )
    assert start_table_lines([], size()) == []


def test_many_processes_are_grouped_by_package():
    rows = [
        StartRow(f'node-{n}', f'pkg{n % 3}', f'/r{n}', str(1000 + n), 'node')
        for n in range(100)
    ]
    lines = start_table_lines(rows, size())
    assert len(lines) == 4
    line = 'node-0 … node-99  pkg0 (34)  /r0 … /r99  1000 … 1099'
    assert lines[1] == line
    # a higher terminal has room for all of them
    assert len(start_table_lines(rows, size(lines=200))) == 101


def test_processes_without_package_are_grouped_by_program():
    rows = [StartRow(f'p{n}', '', '', str(n), 'sleep') for n in range(1, 100)]
    rows.append(StartRow('p100', '', '', '100', 'echo'))
    assert start_table_lines(rows, size()) == [
        'NAME      PACKAGE  PID',
        'p1 … p99  (99)     1 … 99',
        'p100               100',
    ]


def test_table_comes_before_held_events(table, process):
    a, b, late = process('a'), process('b'), process('late')
    shown = table(
        [a, Timer(5.0, (late,)), b],
        Started(a, 1),
        Output(a, 'stdout', b'hello\n'),
        Exited(a, 1, Outcome(code=0), 0.1, asked=False, failed=False),
        Started(b, 2),
        Started(late, 3),
        Started(a, 4),
    )
    assert shown == [
        'NAME  PID',
        'a     1',
        'b     2',
        '[a]      hello',
        '[launch] a: finished after 0.1 s',
        '[launch] late: started, pid 3',
        '[launch] a: started, pid 4',
    ]


def test_much_output_shows_the_table_early(table, process):
    a, b = process('a'), process('b')
    much = b'x' * limits.TABLE_BACKLOG_BYTES + b'\n'
    shown = table([a, b], Started(a, 1), Output(a, 'stdout', much))
    assert shown[:2] == ['NAME  PID', 'a     1']
    assert len(shown) == 3


@pytest.mark.parametrize(
    ('happens', 'text'),
    [
        (Dropped, ''),
        (lambda b: MachineGone('arm', 'it is off', (b.label,)), ''),
        (lambda b: StartFailed(b, 'no such file'), 'no such file'),
        (lambda _: ShuttingDown('interrupted'), 'stopping'),
    ],
)
def test_who_will_not_start_is_not_waited_for(table, process, happens, text):
    a, b = process('a'), process('b')
    first, second, *lines = table([a, b], Started(a, 1), happens(b))
    assert (first, second) == ('NAME  PID', 'a     1')
    assert text in ''.join(lines)


def test_narrow_terminal_gets_lines(table, process):
    a = process('a')
    (line,) = table([a], Started(a, 1), columns=20)
    assert line == '[launch] a: started, pid 1'
