# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Lifecycle nodes in launches that are replayed without ROS."""

import signal

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine.events import (
    StateChanged,
    TransitionFailed,
    Warned,
)
from colcon_yamllaunch.engine.outcome import Outcome
import pytest
from support.history import component, History

CRASH = Outcome(signal=signal.SIGSEGV)


@pytest.fixture
def node(process):
    """Return a function that makes a lifecycle node."""

    def make(label='lc-1', node_name='/lc', autostart=True, **more):
        more |= {'is_lifecycle': True, 'autostart': autostart}
        return process(label, node_name=node_name, **more)

    return make


def begin(*entries):
    h = History(*entries)
    h.turn()
    h.ready()
    return h


@pytest.fixture
def loaded(process):
    """Return a function that loads a lifecycle node into a container."""

    def begin_loaded(**more):
        box = process('box-1', node_name='/box', **more)
        h = begin(box, component('a', is_lifecycle=True, autostart=True))
        assert h.open('follow') == []
        h.there('/box')
        h.loads(1)
        activate(h, '/a')
        return h

    return begin_loaded


def goes(h, state, before=None, node='/lc'):
    h.says(event='state', node=node, state=state, **{'from': before})


def transitions(h):
    return [r['transition'] for r in h.open('change_state')]


def activate(h, node='/lc'):
    goes(h, 'unconfigured', node=node)
    assert transitions(h) == ['configure']
    goes(h, 'configuring', 'unconfigured', node)
    goes(h, 'inactive', 'configuring', node)
    h.answer('change_state')
    assert transitions(h) == ['activate']
    h.answer('change_state')
    goes(h, 'activating', 'inactive', node)
    goes(h, 'active', 'activating', node)
    assert transitions(h) == []


def test_a_node_is_configured_and_activated(node):
    h = begin(node())
    assert [r['node'] for r in h.open('follow')] == ['/lc']
    activate(h)
    assert h.state('lc-1').lifecycle == 'active'
    lines = [line for e in h.happened(StateChanged) for line in e.lines()]
    assert lines == ['lc-1: inactive', 'lc-1: active']
    h.exit('lc-1')
    assert h.state('lc-1').lifecycle == 'unknown'
    assert h.supervisor.done
    assert not h.happened(TransitionFailed)


def test_a_respawned_node_gets_the_state_that_it_had_reached(node):
    h = begin(node(respawn=True))
    activate(h)
    h.exit('lc-1', CRASH)
    activate(h)
    goes(h, 'deactivating', 'active')
    goes(h, 'inactive', 'deactivating')
    h.exit('lc-1', CRASH)
    goes(h, 'unconfigured')
    h.answer('change_state')
    assert transitions(h) == []
    assert h.state('lc-1').lifecycle == 'inactive'
    assert not h.happened(TransitionFailed)


@pytest.mark.hostile
def test_an_end_before_the_activation_is_one_failure(node, process):
    h = begin(node(), process('other'))
    goes(h, 'unconfigured')
    h.exit('lc-1')
    (failure,) = h.happened(TransitionFailed)
    assert 'it finished' in failure.reason
    assert transitions(h) == []
    h = begin(node(), process('other'))
    h.exit('lc-1', CRASH)
    assert not h.happened(TransitionFailed)


def test_a_component_is_activated_once_it_is_loaded(loaded):
    h = loaded(respawn=True)
    assert h.composition.task('a').state.lifecycle == 'active'
    h.exit('box-1', CRASH)
    assert h.composition.task('a').state.lifecycle == 'unknown'
    h.loads(1)
    activate(h, '/a')


def test_new_client_continues_transitions(node):
    h = begin(node())
    goes(h, 'unconfigured')
    h.asked.clear()
    h.composition.client_died()
    h.ready()
    assert len(h.open('follow')) == 1
    assert transitions(h) == []
    goes(h, 'inactive')
    assert transitions(h) == ['activate']


def test_a_user_changes_the_state(node):
    said = []
    h = begin(node(autostart=False))
    goes(h, 'unconfigured')
    h.composition.change_state('/lc', 'configure', said.append)
    h.answer('change_state')
    h.composition.change_state('lc-1', 'activate', said.append)
    h.answer('change_state', 'it would not')
    assert said == [None, 'it would not']
    assert not h.happened(TransitionFailed)
    h.composition.change_state('lc-1', 'activate', said.append)
    h.composition.client_died()
    assert 'ended' in said[2]
    with pytest.raises(RefusedError, match="no lifecycle node 'x'"):
        h.composition.change_state('x', 'activate', said.append)
    with pytest.raises(RefusedError, match="no transition 'fly'"):
        h.composition.change_state('/lc', 'fly', said.append)


def test_early_request_waits_for_the_client(node):
    said = []
    h = History(node(autostart=False), node('lc-2', '/two', autostart=False))
    h.composition.change_state('lc-1', 'configure', said.append)
    h.composition.change_state('lc-2', 'configure', said.append)
    h.turn()
    h.composition.client_died()
    h.exit('lc-2')
    assert transitions(h) == []
    h.ready()
    assert [r['node'] for r in h.open('change_state')] == ['/lc']
    h.answer('change_state')
    assert said == ['it ended', None]
    h.composition.client_died()
    h.composition.change_state('lc-1', 'activate', said.append)
    h.composition.change_state('lc-2', 'activate', said.append)
    h.composition.change_state('lc-1', 'cleanup', said.append)
    h.ready()
    h.answer('change_state')
    assert said[2:] == [
        'somebody asked for something else',
        'lc-2 does not run',
        None,
    ]
    h.composition.client_died()
    h.composition.change_state('lc-1', 'configure', said.append)
    h.composition.client_given_up('it is broken')
    assert said[-1] == 'it is broken'
    with pytest.raises(RefusedError, match='it is broken'):
        h.composition.change_state('lc-1', 'configure', said.append)


def wish(h, transition, name='lc-1'):
    said = []
    h.composition.change_state(name, transition, said.append)
    h.answer('change_state')
    assert said == [None]


@pytest.mark.parametrize('transition', ['shutdown', 'deactivate'])
def test_a_node_that_is_restarted_on_request_is_activated(
    node, process, transition
):
    h = begin(node(), process('other'))
    activate(h)
    wish(h, transition)
    h.restart('lc-1')
    h.exit('lc-1')
    activate(h)
    wish(h, transition)
    h.stop('lc-1')
    h.exit('lc-1')
    h.restart('lc-1')
    activate(h)


def test_a_component_that_is_loaded_anew_is_activated(loaded):
    h = loaded()
    wish(h, 'shutdown', 'a')
    h.composition.reload('a')
    h.answer('unload')
    h.loads(2)
    activate(h, '/a')


def test_states_during_the_end_are_not_restored(loaded):
    h = loaded()
    h.restart('box-1')
    goes(h, 'deactivating', 'active', '/a')
    goes(h, 'inactive', 'deactivating', '/a')
    h.exit('box-1')
    h.there('/box')
    h.loads(1)
    activate(h, '/a')


def test_a_restarted_container_has_components_with_their_states(loaded):
    h = loaded()
    wish(h, 'deactivate', 'a')
    h.restart('box-1')
    h.exit('box-1')
    h.there('/box')
    h.loads(1)
    goes(h, 'unconfigured', node='/a')
    h.answer('change_state')
    goes(h, 'inactive', 'configuring', '/a')
    assert transitions(h) == []


def test_node_without_lifecycle_services_is_reported(node):
    h = begin(node())
    h.after(5.1)
    (warned,) = h.happened(Warned)
    assert 'does not offer the services of a lifecycle node' in warned.text
    activate(h)
    h.after(1000.0)
    assert len(h.happened(Warned)) == 1
