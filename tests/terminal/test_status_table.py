# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running launches as a table."""

from dataclasses import replace
import re
from typing import Any

from colcon_yamllaunch.common.table import duration, size
from colcon_yamllaunch.control.resource_usage import Usage
from colcon_yamllaunch.engine.state import (
    ComponentState,
    LaunchState,
    ProcessState,
)
from colcon_yamllaunch.terminal.status_table import table
import pytest
from support.launch_states import component_state, launch_state
from support.launch_states import process_state as process


def component(label: str, **more: Any) -> ComponentState:
    return component_state(label, **{'seconds': 12.0, **more})


def launch(
    *processes: ProcessState, components: tuple[ComponentState, ...] = ()
) -> LaunchState:
    return launch_state(*processes, *components, seconds=75.0)


def test_a_table_of_all_states() -> None:
    state = launch(
        process('counter.py-1', pid=4250, seconds=74.0, restarts=1),
        process('late', phase='waiting'),
        process('flaky', phase='respawn', ending='exited with code 3'),
        process('gone', phase='ended', ending='finished'),
        process('slow', phase='stopping', pid=4251, seconds=3.0),
    )
    usage = {4250: Usage(0.256, 24_222_106), 4251: Usage(0.0, 1024)}
    assert table(state, usage, None).splitlines() == [
        'my_pkg demo.yaml: running for 1 min 15 s, pid 4242, in /ws',
        '  PROCESS       STATE                           PID'
        '          UP  RESTARTS    CPU    MEMORY',
        '  counter.py-1  running                        4250'
        '  1 min 14 s         1  25.6%  23.1 MiB',
        '  late          waiting                            '
        '                     0',
        '  flaky         respawns (exited with code 3)      '
        '                     0',
        '  gone          finished                           '
        '                     0',
        '  slow          stopping                       4251'
        '         3 s         0   0.0%   1.0 KiB',
    ]


def test_components_stand_below_their_containers() -> None:
    there = {'container': '/there', 'process': None}
    reason = 'Failed to find class with the requested plugin name.'
    state = launch(
        process('box-1', pid=4250, seconds=14.0),
        process('camera-2', pid=4251, seconds=3.0, lifecycle='inactive'),
        process('gone-3', phase='ended', ending='died', lifecycle='unknown'),
        components=(
            component('far', phase='waiting', ending='it went', **there),
            component('talker', lifecycle='active'),
            component('wrong', phase='failed', ending=reason),
            component('out', phase='unloaded', ending='its container ended'),
        ),
    )
    lines = table(state, {}, None).splitlines()
    assert [re.split(' {2,}', line.rstrip()) for line in lines[2:]] == [
        ['', 'box-1', 'running', '4250', '14 s', '0'],
        ['', 'talker', 'loaded, active', '12 s'],
        ['', 'wrong', f'not loaded: {reason}'],
        ['', 'out', 'unloaded'],
        ['', 'camera-2', 'running, inactive', '4251', '3 s', '0'],
        ['', 'gone-3', 'died', '0'],
        ['', '/there', 'not of this launch'],
        ['', 'far', 'waiting'],
    ]
    assert lines[2].startswith('  box')
    assert lines[3].startswith('    talker')
    for width in (40, 60, 80):
        fitting = table(state, {}, width).splitlines()
        assert max(map(len, fitting)) <= width


@pytest.mark.parametrize('width', [40, 70, 80, 100])
def test_a_table_fits_its_width(width: int) -> None:
    long = 'a_label_that_is_much_longer_than_it_should_be-1'
    ending = 'could not be started: a reason that takes a whole line or more'
    state = launch(
        process(long, pid=1234567, seconds=40_000.0),
        process('b', phase='ended', ending=ending),
    )
    lines = table(state, {1234567: Usage(1.0, 10**9)}, width).splitlines()
    assert max(map(len, lines)) <= width
    assert any('…' in line for line in lines)
    assert '1234567' in lines[2]


def test_a_launch_without_processes() -> None:
    assert table(launch(), {}, 80).endswith('\n  no processes')


@pytest.mark.parametrize(
    ('seconds', 'text'),
    [
        (0.9, '0 s'),
        (59.9, '59 s'),
        (61, '1 min 01 s'),
        (3599, '59 min 59 s'),
        (7500, '2 h 05 min'),
        (200_000, '2 d 07 h'),
    ],
)
def test_durations(seconds: float, text: str) -> None:
    assert duration(seconds) == text


@pytest.mark.parametrize(
    ('number', 'text'),
    [
        (0, '0.0 KiB'),
        (1_023_900, '999.9 KiB'),
        (1_048_576, '1.0 MiB'),
        (3 * 2**30, '3.0 GiB'),
        (2**50, '1024.0 TiB'),
    ],
)
def test_sizes(number: int, text: str) -> None:
    assert size(number) == text


def test_a_launch_that_watches_has_a_line_about_its_last_change() -> None:
    watching = replace(launch(process('a')), watch='')
    last = table(watching, {}, None).split('\n')[-1]
    assert last == '  watches its files; no change'
    text = 'a.py changed: restarted a (0.12 s)'
    watching = replace(launch(process('a')), watch=text)
    last = table(watching, {}, None).split('\n')[-1]
    assert last == f'  watches its files; last change: {text}'
    assert all(len(x) <= 40 for x in table(watching, {}, 40).split('\n'))


def test_what_is_ready_and_what_it_waits_for() -> None:
    unmet = ('a publisher of scan',)
    state = launch(
        process('driver', pid=4250, seconds=4.0, unmet=unmet),
        process('box', pid=4251, seconds=4.0, is_ready=True),
        process('nav', phase='waiting', waits_for=('driver',)),
        components=(component('filter', process='box', is_ready=True),),
    )
    state.has_readiness = True
    state.after = {'nav': ('driver', 'box'), 'driver': ()}
    lines = table(state, {}, None).splitlines()
    assert [re.split(' {2,}', line.strip()) for line in lines[1:]] == [
        [
            *('PROCESS', 'STATE', 'READY', 'PID', 'UP', 'RESTARTS', 'CPU'),
            *('MEMORY', 'AFTER'),
        ],
        [
            *('driver', 'running, waiting for a publisher of scan', 'no'),
            *('4250', '4 s', '0'),
        ],
        ['box', 'running', 'yes', '4251', '4 s', '0'],
        ['filter', 'loaded', 'yes', '12 s'],
        ['nav', 'waiting for driver', 'no', '0', 'driver, box'],
    ]
