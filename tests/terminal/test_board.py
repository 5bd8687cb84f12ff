# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the status block knows of a launch."""

import signal

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Timer
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.terminal.board import Board
from colcon_yamllaunch.terminal.board import KEYS
import pytest

FINE = Outcome(code=0)
BAD = Outcome(code=3)
STOPPED = Outcome(signal=signal.SIGINT)


@pytest.fixture
def one(process):
    """Return a process."""
    return process('a')


@pytest.fixture
def board(one, process):
    """Return the board of a launch of three, one of them behind a timer."""
    entries = (one, process('b'), Timer(5.0, (process('c'),)))
    return Board(entries, lambda: 100.0)


def exited(process, outcome=FINE, *, asked=False, failed=False, again=None):
    return events.Exited(process, 7, outcome, 1.0, asked, failed, again)


def test_what_is_to_be_started(board):
    assert [(r.label, r.key, r.phase) for r in board.rows] == [
        ('a', '1', 'starting'),
        ('b', '2', 'starting'),
        ('c', '3', 'waiting'),
    ]
    assert board.label_of('2') == 'b'
    assert board.label_of('9') is None


@pytest.mark.parametrize(
    ('happens', 'phase', 'failure'),
    [
        ([], 'running', ''),
        ([{}], 'ended', ''),
        ([{'outcome': STOPPED, 'asked': True}], 'stopped', ''),
        ([{'outcome': BAD, 'failed': True}], 'failed', 'exit 3'),
        (
            [{'outcome': Outcome(signal=signal.SIGSEGV), 'failed': True}],
            'failed',
            'SIGSEGV',
        ),
        (
            [{'outcome': BAD, 'failed': True, 'again': 2.0}],
            'respawn',
            'exit 3',
        ),
        ([{'again': 0.0}], 'respawn', ''),
    ],
)
def test_how_a_process_ends(board, one, happens, phase, failure):
    board.handle(events.Started(one, 7))
    assert board.groups() == {'a': 7}
    for options in happens:
        board.handle(exited(one, **options))
        assert board.groups() == {}
    row = board.row('a')
    assert (row.phase, row.failure) == (phase, failure)


def test_a_failure_is_told_of_until_somebody_starts_it_anew(board, one):
    board.handle(events.Started(one, 7))
    board.handle(exited(one, BAD, failed=True, again=0.0))
    board.handle(events.Started(one, 8))
    row = board.row('a')
    assert (row.phase, row.failure, row.starts) == ('running', 'exit 3', 2)
    board.handle(events.Requested(one, 'restart'))
    assert (row.phase, row.failure) == ('stopping', '')
    board.handle(exited(one, STOPPED, asked=True))
    board.handle(events.Started(one, 9))
    assert (row.phase, row.starts) == ('running', 3)


@pytest.mark.parametrize('action', ['stop', 'kill'])
def test_what_has_failed_stays_so_when_it_is_stopped(board, one, action):
    board.handle(events.Started(one, 7))
    board.handle(exited(one, BAD, failed=True))
    board.handle(events.Requested(one, action))
    row = board.row('a')
    assert (row.phase, row.failure) == ('failed', 'exit 3')
    board.handle(events.Requested(one, 'restart'))
    assert (row.phase, row.failure) == ('starting', '')


def test_what_could_not_be_started(board, one):
    board.handle(events.StartFailed(one, 'no such file'))
    row = board.row('a')
    assert (row.phase, row.failure) == ('failed', 'cannot start')


def test_who_is_held(board, one):
    board.handle(events.Started(one, 7))
    board.handle(events.Suspended(one, 7, signal.SIGSTOP))
    assert board.row('a').phase == 'held'
    board.handle(events.Suspended(one, 7, None))
    assert board.row('a').phase == 'running'


def test_the_launch_is_stopped(board, one):
    board.handle(events.Started(one, 7))
    board.handle(events.ShuttingDown('interrupted'))
    phases = [row.phase for row in board.rows]
    assert phases == ['stopping', 'waiting', 'waiting']
    board.handle(events.StillRunning(('a',), 0, 2, 15, 4.0))
    assert board.countdown.due == 104.0
    board.handle(exited(one, FINE, asked=True))
    assert board.row('a').phase == 'stopped'


def test_a_component_is_loaded_again(board):
    component = Component('lens', 'p', 'p::Lens', '/box', Position('f', 1, 1))
    board.handle(events.Planned((component,)))
    row = board.row('lens')
    assert (row.phase, row.key, row.is_process) == ('starting', '4', False)
    board.handle(events.LoadFailed(component, 'no such class', again=True))
    assert (row.phase, row.failure) == ('respawn', 'cannot load')
    board.handle(events.Loaded(component, '/lens', 1, 0.1))
    assert row.phase == 'running'
    board.handle(events.StateChanged(component, '/lens', 'inactive', None))
    assert row.lifecycle == 'inactive'
    board.handle(events.Unloaded(component, events.CONTAINER_ENDED))
    assert row.phase == 'ended'


def test_keys_stay_with_their_processes(board, one, process):
    board.handle(events.Dropped(one))
    assert board.label_of('2') == 'b'
    board.handle(events.Planned((process('b'), process('d'))))
    # that of the one that is gone is free again
    assert board.label_of('1') == 'd'


def test_there_are_only_so_many_keys(process):
    count = len(KEYS) + 3
    board = Board([process(f'p{n}') for n in range(count)], lambda: 0.0)
    keys = [row.key for row in board.rows]
    assert ''.join(keys) == KEYS
    assert keys[-3:] == ['', '', '']


def test_only_much_of_a_processor_is_told(board, one):
    board.handle(events.Started(one, 7))
    version = board.version
    board.take_cpu({'a': 0.49})
    assert (board.row('a').cpu, board.version) == (0.0, version)
    board.take_cpu({'a': 0.871})
    assert (board.row('a').cpu, board.version) == (0.87, version + 1)
    board.take_cpu({'a': 0.8689})
    assert board.version == version + 1
    board.take_cpu({})
    assert board.row('a').cpu == 0.0


def test_output_changes_nothing(board, one):
    version = board.version
    board.handle(events.Output(one, 'stdout', b'line\n'))
    board.handle(events.Silent(one, 10.0))
    assert board.version == version
