# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is started anew after a change, replayed without a process."""

import signal

from colcon_yamllaunch.engine.events import (
    MessageShown,
    Requested,
    ShuttingDown,
)
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Message, Shutdown, Timer
import pytest
from support.history import component, History

STOPPED = Outcome(signal=signal.SIGINT)


@pytest.fixture
def history():
    def begin(*entries):
        made = History(*entries)
        made.supervisor.outlasts_failures = made.host.waits = True
        made.turn()
        return made

    return begin


def restarts(h, *labels):
    restarted = h.supervisor.restart_changed(labels)
    h.turn()
    return restarted


def says(h, state, before):
    h.says(event='state', node='/a', state=state, **{'from': before})


def test_changed_process_is_restarted(history, process):
    h = history(process('a'), process('b'))
    assert restarts(h, 'a', 'unknown') == ('a',)
    assert h.sent('a') == [signal.SIGINT]
    assert h.started() == ['a', 'b']
    h.exit('a', STOPPED)
    assert h.started() == ['a', 'b', 'a']
    assert [e.action for e in h.happened(Requested)] == ['change']


def test_changed_processes_start_in_plan_order(history, process):
    h = history(process('a'), process('b'), process('c'))
    assert restarts(h, 'c', 'a', 'b') == ('a', 'b', 'c')
    h.exit('b', STOPPED)
    h.exit('c', STOPPED)
    assert h.started() == ['a', 'b', 'c']
    h.exit('a', STOPPED)
    assert h.started() == ['a', 'b', 'c', 'a', 'b', 'c']


@pytest.mark.parametrize('way', ['stop_process', 'drop'])
def test_process_that_leaves_a_restart_delays_no_other(history, process, way):
    h = history(process('a'), process('b'))
    restarts(h, 'a', 'b')
    h.exit('b', STOPPED)
    getattr(h.supervisor, way)('a')
    h.turn()
    assert h.started() == ['a', 'b', 'b']
    h.exit('a', STOPPED)
    assert h.started() == ['a', 'b', 'b']


def test_second_change_during_a_restart_starts_nothing_twice(history, process):
    h = history(process('a'))
    restarts(h, 'a')
    restarts(h, 'a')
    h.exit('a', STOPPED)
    assert h.started() == ['a', 'a']
    assert h.sent('a') == []


def test_ended_process_is_started_again_after_a_change(history, process):
    h = history(process('a'))
    h.exit('a', Outcome(code=1))
    assert not h.supervisor.done
    assert restarts(h, 'a') == ('a',)
    assert h.started() == ['a', 'a']


def test_process_stopped_by_the_user_stays_stopped(history, process):
    h = history(process('a'))
    h.stop('a')
    h.exit('a', STOPPED)
    assert restarts(h, 'a') == ()
    h.restart('a')
    assert restarts(h, 'a') == ('a',)


def test_process_behind_a_timer_waits_for_it(history, process):
    h = history(Timer(5.0, (process('a'),)))
    assert restarts(h, 'a') == ()
    h.after(5.0)
    assert h.started() == ['a']


def test_failure_does_not_end_a_watched_launch(history, process):
    h = history(process('a', on_exit_shutdown=True))
    h.exit('a', Outcome(code=1))
    assert h.happened(ShuttingDown) == []
    h.host.refused.add('a')
    restarts(h, 'a')
    assert h.happened(ShuttingDown) == []
    h.host.refused.clear()
    restarts(h, 'a')
    h.exit('a')
    assert len(h.happened(ShuttingDown)) == 1


@pytest.mark.parametrize('revisions', [(True,), (True, False)])
def test_last_revision_applies_from_the_next_start(
    history, process, revisions
):
    h = history(process('a'))
    for respawn in revisions:
        h.supervisor.revise(process('a', respawn=respawn), at_once=False)
    assert not h.supervisor.task('a').process.respawn
    restarts(h, 'a')
    h.exit('a', STOPPED)
    assert h.supervisor.task('a').process.respawn == revisions[-1]


def test_revised_respawn_applies_at_once(history, process):
    h = history(process('a'))
    h.supervisor.revise(process('a', respawn=True), at_once=True)
    h.exit('a', Outcome(code=1))
    assert h.started() == ['a', 'a']
    # and no more
    h.supervisor.revise(process('a'), at_once=True)
    h.exit('a', Outcome(code=1))
    assert h.started() == ['a', 'a']


def test_forgotten_entries_are_not_executed(history, process):
    hello, bye = Message('INFO', 'hello'), Message('INFO', 'bye')
    inner = Timer(1.0, (hello, Shutdown('')))
    h = history(process('a'), Timer(1.0, (hello, bye, inner)))
    h.supervisor.forget([hello, Shutdown('')])
    h.after(5.0)
    assert [e.text for e in h.happened(MessageShown)] == ['bye', 'hello']
    assert h.happened(ShuttingDown) == []


def test_lifecycle_node_returns_to_its_state(history, process):
    h = history(process('a', node_name='/a', is_lifecycle=True))
    h.ready()
    says(h, 'unconfigured', None)
    says(h, 'inactive', 'configuring')
    says(h, 'active', 'activating')
    restarts(h, 'a')
    h.exit('a', STOPPED)
    says(h, 'unconfigured', None)
    (request,) = h.open('change_state')
    assert request['transition'] == 'configure'


@pytest.fixture
def box(history, process):
    """Return a launch with a container and two components in it."""
    container = process('box-1', node_name='/box', is_container=True)
    made = history(container, component('a'), component('b'))
    made.ready('/box')
    made.loads(1, 2)
    return made


def reloads(h, labels, processes=()):
    loaded = h.composition.reload_changed(labels, processes)
    h.turn()
    return loaded


def test_changed_component_is_reloaded(box):
    box.composition.revise(component('a', namespace='/other'))
    assert reloads(box, ['a']) == ('a',)
    assert box.answer('unload')['unique_id'] == 1
    (load,) = box.open('load')
    assert (load['name'], load['namespace']) == ('a', '/other')


def test_restarted_container_reloads_its_components(box):
    assert restarts(box, 'box-1') == ('box-1',)
    box.composition.revise(component('a', namespace='/other'))
    assert reloads(box, ['a'], ['box-1']) == ('a',)
    assert box.open('unload') == []
    box.there('/box', there=False)
    box.exit('box-1', STOPPED)
    box.there('/box')
    spaces = {r['name']: r['namespace'] for r in box.open('load')}
    assert spaces == {'a': '/other', 'b': ''}


def test_crashed_container_is_started_for_its_components(box):
    assert box.composition.ended_containers(['a']) == set()
    box.there('/box', there=False)
    box.exit('box-1', Outcome(code=1))
    assert box.composition.ended_containers(['b-1']) == set()
    ended = box.composition.ended_containers(['a'])
    assert ended == {'box-1'}
    assert restarts(box, *ended) == ('box-1',)
    assert reloads(box, ['a'], ['box-1']) == ('a',)
    box.there('/box')
    assert {r['name'] for r in box.open('load')} == {'a', 'b'}


def test_component_unloaded_by_the_user_stays_unloaded(box):
    box.composition.unload('a')
    box.turn()
    box.answer('unload')
    assert reloads(box, ['a']) == ()
