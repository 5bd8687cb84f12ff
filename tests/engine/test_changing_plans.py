# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Plans that change while they run, replayed without a process."""

import signal

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.events import (
    Dropped,
    Exited,
    Loaded,
    LoadFailed,
    MessageShown,
    Planned,
    Signalled,
    Started,
    TransitionFailed,
    Unloaded,
    Warned,
)
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan import plan
import pytest
from support.history import component, History, POSITION

STOPPED = Outcome(signal=signal.SIGINT)


def replace_process(h, member):
    h.supervisor.revise(member, at_once=False)
    if member.label in h.started():
        h.supervisor.restart_process(member.label)


def replace_component(h, member):
    h.composition.revise(member)
    h.composition.reload(member.label)


@pytest.fixture
def box(process):
    return process('box-1', node_name='/box', is_container=True)


def arguments(history, label):
    """Return the first argument of each start of a process."""
    started = [e.process for e in history.happened(Started)]
    return [one.argv[0] for one in started if one.label == label]


def test_added_entries_follow_those_of_the_plan(history, process):
    h = history(process('a'))
    later = plan.Timer(2.0, (process('c'),))
    h.extend(process('b'), plan.Message('INFO', 'hello'), later)
    assert h.started() == ['a', 'b']
    assert [t.process.label for t in h.supervisor.tasks] == ['a', 'b', 'c']
    kinds = [type(e) for e in h.host.events]
    assert kinds == [Started, Planned, Started, MessageShown]
    assert [p.label for p in h.happened(Planned)[0].members] == ['b', 'c']
    h.after(2.0)
    assert h.started() == ['a', 'b', 'c']
    h.exit('a')
    h.stop('b')
    h.exit('b', STOPPED)
    h.restart('c')
    h.exit('c', STOPPED)
    assert h.phases() == ['ended', 'ended', 'running']
    h.exit('c')
    assert h.supervisor.done


def test_process_numbers_are_unique(history, process):
    h = history(process('a'), process('b'))
    h.supervisor.drop('b')
    h.exit('b', STOPPED)
    h.extend(process('b'), process('c'))
    numbers = [task.number for task in h.supervisor.tasks]
    assert len({*numbers, 1, h.supervisor.client_number}) == 5
    assert h.started() == ['a', 'b', 'b', 'c']


def test_taken_label_is_refused(history, process):
    h = history(process('a'))
    with pytest.raises(ValueError, match='a already'):
        h.extend(process('a'))


def test_launch_waits_while_its_plan_may_grow(history, process):
    h = History(process('a'))
    h.host.waits = True
    h.turn()
    h.exit('a')
    assert not h.supervisor.done
    assert not h.supervisor.is_stopping
    h.extend(process('b'))
    h.host.waits = False
    h.exit('b')
    assert h.supervisor.done


def test_added_entries_do_not_start_during_a_shutdown(history, process):
    h = history(process('a'))
    h.supervisor.stop('enough')
    bye, late = plan.Message('INFO', 'bye'), plan.Message('INFO', 'late')
    timer = plan.Timer(1.0, (late,), cancel_on_shutdown=False)
    h.extend(process('b'), bye, timer, plan.Shutdown('more'))
    h.exit('a', STOPPED)
    h.after(1.0)
    assert h.started() == ['a']
    assert [e.text for e in h.happened(MessageShown)] == ['bye', 'late']
    assert not h.happened(Planned)
    assert h.supervisor.done


def test_replaced_process_is_restarted(history, process):
    h = history(process('a', 'old', name='a.py-1', output='screen'))
    replace_process(h, process('a', 'new', name='a.py-1'))
    assert h.sent('a') == [signal.SIGINT]
    assert h.supervisor.task('a').process.argv == ('old',)
    h.exit('a', STOPPED)
    assert arguments(h, 'a') == ['old', 'new']
    ended, planned = h.happened(Exited)[0], h.happened(Planned)[0]
    assert ended.process.argv == ('old',)
    assert planned.members[0].argv == ('new',)
    assert not ended.failed
    assert h.state('a').restarts == 1


def test_replaced_process_that_has_ended_is_started(history, process):
    h = history(process('a', 'old'), process('b', on_exit_shutdown=True))
    h.exit('a', Outcome(code=1))
    replace_process(h, process('a', 'new'))
    replace_process(h, process('b', 'new'))
    h.turn()
    h.exit('b', STOPPED)
    assert arguments(h, 'a') == ['old', 'new']
    assert h.phases() == ['running', 'running']


def test_replaced_process_behind_a_timer_waits_for_it(history, process):
    h = history(process('a'), plan.Timer(2.0, (process('b', 'old'),)))
    replace_process(h, process('b', 'new'))
    assert h.started() == ['a']
    h.after(2.0)
    assert arguments(h, 'b') == ['new']


def test_dropped_process_is_stopped_and_forgotten(history, process):
    h = history(process('a'), process('b', respawn=True))
    h.supervisor.drop('b')
    assert h.phases() == ['running', 'stopping']
    h.exit('b', STOPPED)
    assert [t.process.label for t in h.supervisor.tasks] == ['a']
    assert [e.member.label for e in h.happened(Dropped)] == ['b']
    with pytest.raises(RefusedError, match='no process'):
        h.restart('b')
    h.exit('a')
    assert h.supervisor.done


def test_process_that_does_not_run_is_dropped(history, process):
    later = plan.Timer(1.0, (process('c'), process('d')))
    h = history(process('a'), process('b'), later)
    h.exit('b')
    h.supervisor.drop('b')
    h.supervisor.drop('c')
    h.after(1.0)
    assert h.started() == ['a', 'b', 'd']
    assert [t.process.label for t in h.supervisor.tasks] == ['a', 'd']


def test_process_dropped_during_its_restart_does_not_start(history, process):
    h = history(process('a'), process('b'))
    h.restart('b')
    h.supervisor.drop('b')
    h.exit('b', STOPPED)
    assert h.started() == ['a', 'b']
    # and the other way round
    h.supervisor.drop('a')
    replace_process(h, process('a', 'new'))
    h.exit('a', STOPPED)
    assert arguments(h, 'a') == ['true', 'new']
    assert not h.happened(Dropped)[1:]


def test_component_is_added_to_a_running_container(history, box):
    h = history(box)
    composition = h.compose(plan.Plan((box,)))
    h.composition = composition
    h.supervisor.compose(composition)
    h.extend(component())
    h.ready('/box')
    h.loads(1)
    assert [e.component.label for e in h.happened(Loaded)] == ['a']
    # the container is known as its own
    h.exit('box-1', Outcome(signal=signal.SIGSEGV))
    assert [e.component.label for e in h.happened(Unloaded)] == ['a']


def test_component_is_added_to_an_ended_container(history, box, process):
    h = history(box, process('other'))
    h.exit('box-1')
    h.supervisor.compose(h.compose(plan.Plan((box,))))
    h.extend(component())
    (failed,) = h.happened(LoadFailed)
    assert 'box-1' in failed.reason


def test_container_is_added_with_its_components(history, box, process):
    h = history(process('lc', is_lifecycle=True, node_name='/lc'))
    h.ready()
    h.extend(box, component('a'), component('b', is_lifecycle=True))
    h.there('/box')
    h.loads(1, 2)
    assert h.launch.by_label['b'].lifecycle is not None
    assert [t.label for t in h.composition.tasks] == ['a', 'b']
    with pytest.raises(ValueError, match='a already'):
        h.extend(component('a'))


def test_replaced_component_is_reloaded(history, box):
    h = history(box, component('a'))
    h.ready('/box')
    h.loads(1)
    replace_component(h, component('a', name='other'))
    assert h.composition.task('a').component.name == 'a'
    h.answer('unload')
    assert h.loads(2) == ['/other']
    assert h.happened(Planned)[0].members[0].name == 'other'


def test_component_moves_to_another_container(history, box, process):
    other = process('crate-2', node_name='/crate', is_container=True)
    h = history(box, other, component('a'))
    h.ready('/box', '/crate')
    h.loads(1)
    replace_component(h, component('a', container='/crate', is_lifecycle=True))
    assert h.answer('unload')['container'] == '/box'
    load = h.answer('load', full_name='/a', unique_id=1)
    assert load['container'] == '/crate'
    assert h.launch.by_label['a'].lifecycle is not None


def test_dropped_component_is_unloaded(history, box):
    later = plan.Timer(1.0, (component('c'),))
    h = history(box, component('a'), component('b'), later)
    h.ready('/box')
    h.loads(1)
    for label in 'abc':
        h.composition.drop(label)
    h.turn()
    # that is being loaded is unloaded first
    assert [t.label for t in h.composition.tasks] == ['a', 'b']
    h.answer('unload')
    h.loads(2)
    h.answer('unload')
    assert h.composition.tasks == []
    assert {e.member.label for e in h.happened(Dropped)} == set('abc')
    h.after(1.0)
    assert not h.open('load')


def test_replaced_lifecycle_node_gets_its_state(history, process):
    node = {'is_lifecycle': True, 'autostart': True, 'node_name': '/lc'}
    h = history(process('lc', **node))
    h.ready()
    replace_process(h, process('lc', 'new', **{**node, 'node_name': '/new'}))
    h.exit('lc', STOPPED)
    assert h.open('follow')[-1]['node'] == '/new'
    replace_process(h, process('lc', 'plain'))
    h.exit('lc', STOPPED)
    assert h.launch.by_label['lc'].lifecycle is None


def changes(*transitions, node='/lc'):
    return [plan.ChangeState(node, t, POSITION) for t in transitions]


@pytest.fixture
def lifecycle(process):
    return process('lc', node_name='/lc', is_lifecycle=True)


def test_transitions_of_the_plan_follow_one_another(history, lifecycle):
    h = history(*changes('configure', 'activate'), lifecycle)
    h.ready()
    assert h.answer('change_state')['transition'] == 'configure'
    assert h.answer('change_state')['transition'] == 'activate'
    assert not h.open('change_state')
    h.extend(*changes('deactivate'))
    assert h.answer('change_state')['transition'] == 'deactivate'


def test_failed_transition_cancels_those_after_it(history, lifecycle):
    h = history(lifecycle, *changes('configure', 'activate'))
    h.ready()
    h.answer('change_state', reason='the callback failed')
    (failed,) = h.happened(TransitionFailed)
    assert failed.transition == 'configure'
    assert 'the callback failed' in failed.reason
    assert not h.open('change_state')


def test_transition_of_a_node_of_another_launch(history):
    h = history(*changes('configure', node='/other'))
    h.after(2 * limits.WAIT_WARNING_DELAY)
    assert 'nothing in this launch provides it' in h.happened(Warned)[0].text
    h.ready()
    assert h.answer('change_state', reason='no')['node'] == '/other'
    warned = h.happened(Warned)[-1]
    assert '/other failed: no (from /ws/demo.yaml:7:9)' in warned.text
    assert h.supervisor.done


def test_transition_waits_for_a_node_of_another_launch(history, process):
    h = history(process('a'), process('b', node_name='/b', is_lifecycle=True))
    h.ready()
    h.extend(*changes('configure', node='/other'))
    h.exit('a')
    h.exit('b')
    assert not h.supervisor.done
    h.after(limits.WAIT_WARNING_DELAY)
    assert h.supervisor.done


def test_plan_decides_the_state_of_an_autostarted_node(history, process):
    node = {'node_name': '/lc', 'is_lifecycle': True}
    h = history(process('lc', autostart=True, **node))
    h.ready()
    h.says(event='state', node='/lc', state='inactive')
    h.extend(*changes('configure', 'cleanup'))
    # it is configured already, and not activated
    (asked,) = h.open('change_state')
    assert asked['transition'] == 'cleanup'


def test_transitions_continue_with_the_next_client(history, lifecycle):
    h = history(lifecycle, *changes('configure'))
    h.ready()
    h.asked.clear()
    h.composition.client_died()
    h.ready()
    assert h.answer('change_state')['transition'] == 'configure'
    h.extend(*changes('activate'))
    h.composition.client_given_up('it crashed')
    assert [e.transition for e in h.happened(TransitionFailed)] == ['activate']
    h.extend(*changes('activate'))
    assert len(h.happened(TransitionFailed)) == 2


def test_transitions_of_an_ended_node_are_cancelled(history, lifecycle):
    h = history(lifecycle, *changes('configure', 'activate'))
    h.ready()
    h.exit('lc')
    assert h.supervisor.done
    assert not h.happened(TransitionFailed)


def signalled(name, number):
    return plan.SignalProcess(name, number, POSITION)


def test_signal_entry_sends_a_signal(history, process):
    h = history(process('a', name='a.py-1'), process('b', respawn=True))
    h.extend(signalled('a.py-1', 10), signalled('b', 2))
    assert h.host.signalled == [(1000, 10), (1001, 2)]
    assert [e.signal for e in h.happened(Signalled)] == [10, 2]
    h.exit('b', STOPPED)
    h.exit('a', Outcome(signal=10))
    # what the plan itself asked for is no failure; but it is not stopped
    assert [e.failed for e in h.happened(Exited)] == [False, True]
    assert h.started() == ['a', 'b', 'b']


def test_signal_0_stops_a_process(history, process):
    h = history(process('a', respawn=True), process('b'), signalled('a', 0))
    assert h.sent('a') == [signal.SIGINT]
    h.after(5.0)
    assert h.sent('a') == [signal.SIGINT, signal.SIGTERM]
    h.exit('a', Outcome(signal=signal.SIGTERM))
    assert h.phases() == ['ended', 'running']


def test_undelivered_signal_is_reported(history, process):
    h = history(process('a'), process('b'))
    h.exit('a')
    h.extend(signalled('a', 2), signalled('c', 0))
    place = '(from /ws/demo.yaml:7:9)'
    texts = [e.text for e in h.happened(Warned)]
    unknown = f"stop: there is no process 'c' {place}"
    assert texts == [f'SIGINT: a does not run {place}', unknown]


def test_signal_waits_for_the_start(history, process):
    h = history(signalled('b', 10), plan.Timer(2.0, (process('b'),)))
    h.extend(signalled('b', 0))
    assert h.host.signalled == []
    h.after(2.0)
    assert h.host.signalled == [(1000, 10)]
    assert h.sent('b') == [signal.SIGINT]


def test_host_call_is_made_in_its_turn(history, process):
    call = plan.WorkerCall(3, 'OpaqueFunction spawn', POSITION)
    h = history(process('a'), plan.Timer(2.0, (call,)))
    assert h.host.calls == []
    h.after(2.0)
    assert h.host.calls == [3]


def test_launch_waits_for_the_last_answer_of_the_host(history, process):
    h = history(process('a'))
    h.supervisor.stop('enough')
    h.host.waits = True
    h.exit('a', STOPPED)
    assert not h.supervisor.done
    h.extend(plan.Message('INFO', 'bye'))
    h.host.waits = False
    h.turn()
    assert h.supervisor.done
    assert [e.text for e in h.happened(MessageShown)] == ['bye']
