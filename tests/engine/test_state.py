# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The state of a launch follows from its events."""

import signal

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.state import from_json, to_json
from colcon_yamllaunch.plan.plan import Timer
from colcon_yamllaunch.terminal.status_model import KEYS, StatusModel
import pytest
from support.history import component
from support.launch_states import planned_state

FINE = Outcome(code=0)
BAD = Outcome(code=3)
STOPPED = Outcome(signal=signal.SIGINT)
CRASH = Outcome(signal=signal.SIGSEGV)


@pytest.fixture
def one(process):
    """Return a process."""
    return process('a')


@pytest.fixture
def state(one, process):
    """Return the state of a launch of three, one of them behind a timer."""
    return planned_state(one, process('b'), Timer(5.0, (process('c'),)))


def exited(process, outcome=FINE, *, asked=False, failed=False, again=None):
    return events.Exited(process, 7, outcome, 1.0, asked, failed, again)


def test_what_is_to_be_started(state):
    assert [(p.label, p.phase, p.condition) for p in state.processes] == [
        ('a', 'waiting', 'starting'),
        ('b', 'waiting', 'starting'),
        ('c', 'waiting', 'waiting'),
    ]


@pytest.mark.parametrize(
    ('options', 'phase', 'failure'),
    [
        (None, 'running', ''),
        ({}, 'ended', ''),
        ({'outcome': STOPPED, 'asked': True}, 'stopped', ''),
        ({'outcome': BAD, 'failed': True}, 'failed', 'exit 3'),
        ({'outcome': CRASH, 'failed': True}, 'failed', 'SIGSEGV'),
        ({'outcome': BAD, 'failed': True, 'again': 2.0}, 'respawn', 'exit 3'),
        ({'again': 0.0}, 'respawn', ''),
    ],
)
def test_how_a_process_ends(state, one, options, phase, failure):
    state.apply(events.Started(one, 7))
    assert state.groups() == {'a': 7}
    if options is not None:
        state.apply(exited(one, **options))
        assert state.groups() == {}
    row = state.process('a')
    assert (row.condition, row.failure) == (phase, failure)


def test_a_failure_is_told_of_until_somebody_starts_it_anew(state, one):
    state.apply(events.Started(one, 7))
    state.apply(exited(one, BAD, failed=True, again=0.0))
    state.apply(events.Started(one, 8))
    row = state.process('a')
    assert (row.condition, row.failure) == ('running', 'exit 3')
    assert row.restarts == 1
    state.apply(events.Requested(one, 'restart'))
    assert (row.condition, row.failure) == ('stopping', '')
    state.apply(exited(one, STOPPED, asked=True))
    state.apply(events.Started(one, 9))
    assert (row.condition, row.restarts) == ('running', 2)


@pytest.mark.parametrize('action', ['stop', 'kill'])
def test_what_has_failed_stays_so_when_it_is_stopped(state, one, action):
    state.apply(events.Started(one, 7))
    state.apply(exited(one, BAD, failed=True))
    state.apply(events.Requested(one, action))
    row = state.process('a')
    assert (row.condition, row.failure) == ('stopping', 'exit 3')
    state.apply(events.MemberChanged(one, 'ended'))
    assert (row.condition, row.failure) == ('failed', 'exit 3')
    state.apply(events.Requested(one, 'restart'))
    assert (row.condition, row.failure) == ('stopping', '')


def test_what_could_not_be_started(state, one):
    state.apply(events.StartFailed(one, 'no such file'))
    row = state.process('a')
    assert (row.condition, row.failure) == ('failed', 'cannot start')


def test_who_is_held(state, one):
    state.apply(events.Started(one, 7))
    state.apply(events.Suspended(one, 7, signal.SIGSTOP))
    assert state.process('a').condition == 'held'
    state.apply(events.Suspended(one, 7, None))
    assert state.process('a').phase == 'running'


def test_the_launch_is_stopped(state, one):
    state.apply(events.Started(one, 7))
    state.apply(events.ShuttingDown('interrupted'))
    phases = [row.condition for row in state.processes]
    assert phases == ['stopping', 'waiting', 'waiting']
    state.apply(events.StillRunning(('a',), 0, 2, 15, 4.0))
    assert state.countdown.due == 104.0
    state.apply(exited(one, FINE, asked=True))
    assert state.process('a').condition == 'stopped'


def test_a_component_is_loaded_again(state):
    lens = component('lens')
    state.apply(events.Planned((lens,)))
    (row,) = state.components
    assert row.condition == 'starting'
    state.apply(events.LoadFailed(lens, 'no such class', again=True))
    assert (row.condition, row.failure) == ('respawn', 'cannot load')
    state.apply(events.Loaded(lens, '/lens', 1, 0.1))
    assert row.condition == 'running'
    state.apply(events.StateChanged(lens, '/lens', 'inactive', None))
    assert row.lifecycle == 'inactive'
    state.apply(events.Unloaded(lens, events.CONTAINER_ENDED))
    assert row.condition == 'ended'


def test_process_that_is_stopped_is_stopping_until_nothing_is_left(state, one):
    state.apply(events.Started(one, 7))
    state.apply(events.Requested(one, 'stop'))
    state.apply(exited(one, STOPPED, asked=True))
    row = state.process('a')
    assert (row.phase, row.pid, row.ending) == ('stopping', None, 'stopped')
    state.apply(events.MemberChanged(one, 'ended'))
    assert (row.phase, row.condition) == ('ended', 'stopped')


def test_process_that_a_signal_of_the_plan_ends_was_stopped(state, one):
    state.apply(events.Started(one, 7))
    state.apply(events.Signalled(one, 7, signal.SIGTERM, group=True))
    row = state.process('a')
    assert (row.phase, row.condition) == ('running', 'stopping')
    state.apply(exited(one, STOPPED))
    assert row.condition == 'stopped'


def test_debugged_process_has_a_terminal_once(state, one):
    row = state.process('a')
    seen = []
    for action in ('debug', 'restart'):
        state.apply(events.Started(one, 7))
        seen.append(row.terminal)
        state.apply(events.Requested(one, action))
        state.apply(exited(one, STOPPED, asked=True))
    state.apply(events.Started(one, 8))
    assert [*seen, row.terminal] == [False, True, False]


def test_machine_that_is_gone_fails_the_launch_until_it_is_back(one):
    state = planned_state(one)
    state.machine_of = lambda _label: 'arm'
    state.add_machines(['arm'])
    state.apply(events.MachineGone('arm', 'no answer', ('a',)))
    assert state.has_failed
    assert state.machines['arm'].link == 'gone'
    state.apply(events.LinkBack('arm', 2.0))
    assert not state.has_failed


def test_events_that_change_nothing_keep_the_version(state, one):
    version = state.version
    state.apply(events.Output(one, 'stdout', b'line\n'))
    state.apply(events.Silent(one, 10.0))
    assert state.version == version


def test_keys_stay_with_their_processes(state, one, process):
    model = StatusModel(state)
    assert model.keys == {'a': '1', 'b': '2', 'c': '3'}
    state.apply(events.Dropped(one))
    assert model.label_of('2') == 'b'
    state.apply(events.Planned((process('b'), process('d'))))
    # that of the one that is gone is free again
    assert model.label_of('1') == 'd'


def test_there_are_only_so_many_keys(process):
    count = len(KEYS) + 3
    many = [process(f'p{n}') for n in range(count)]
    model = StatusModel(planned_state(*many))
    assert ''.join(model.keys.values()) == KEYS


def test_only_much_of_a_processor_is_shown(state):
    model = StatusModel(state)
    version = model.version
    model.measure({'a': 0.49})
    assert (model.cpu, model.version) == ({}, version)
    model.measure({'a': 0.871})
    assert model.cpu == {'a': 0.87}
    version = model.version
    model.measure({'a': 0.8689})
    assert model.version == version


def test_a_client_that_gets_changes_has_the_same_state(state, one, process):
    state.machine_of = {'b': 'arm'}.get
    state.by_label['b'].machine = 'arm'
    state.add_machines(['arm'])
    lens = component('lens')
    client = from_json(to_json(state), lambda: 100.0)
    version = state.version
    sizes = []
    for event in (
        events.Started(one, 7),
        events.StateChanged(one, '/a', 'active', None),
        events.Planned((process('d'), lens)),
        events.Loaded(lens, '/lens', 1, 0.1),
        events.UsageMeasured('arm', {'b': (0.5, 1024)}),
        events.LinkLost('arm', 'no answer', is_kept=True),
        events.LinkBack('arm', 2.0),
        exited(one, BAD, failed=True),
        events.Requested(one, 'restart'),
        events.Dropped(process('c')),
        events.ChangeReported('a.cpp changed: restarted a'),
        events.ShuttingDown('interrupted'),
        events.MemberChanged(one, 'ended'),
        events.Ended(1),
    ):
        state.apply(event)
        changes = to_json(state, version)
        version = state.version
        client.apply(events.StateReceived(changes))
        assert to_json(client) == to_json(state), event
        sizes.append(len(changes['processes']) + len(changes['components']))
    # what did not change is not sent
    assert sizes == [1, 1, 5, 1, 1, 1, 1, 1, 1, 4, 0, 4, 1, 0]
