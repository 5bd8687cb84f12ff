# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Components in launches that are replayed without ROS and processes."""

import math
import signal

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.composition import load_request
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import SetParameter, Timer
import pytest
from support.history import component, History, POSITION

CRASH = Outcome(signal=signal.SIGSEGV)


@pytest.fixture
def box(process):
    """Return a function that makes a container."""

    def make(label='box-1', node_name='/box', **more):
        return process(label, node_name=node_name, is_container=True, **more)

    return make


def begin(*entries):
    h = History(*entries)
    h.turn()
    return h


def loaded(*entries, ids=(1,), container='/box'):
    """Begin a launch, and load its first components."""
    h = begin(*entries)
    h.ready(container)
    h.loads(*ids)
    return h


def phases(h):
    return [task.phase for task in h.composition.tasks]


def failed(h):
    return [
        (e.component.label, e.reason) for e in h.happened(events.LoadFailed)
    ]


def warnings(h):
    return [e.text for e in h.happened(events.Warned)]


def test_components_are_loaded_in_the_order_of_the_file(box):
    h = begin(box(), component('a'), component('b'))
    assert h.asked == []
    h.ready()
    assert [r['name'] for r in h.open('load')] == ['a', 'b']
    assert phases(h) == ['waiting', 'waiting']
    h.there('/box')
    assert phases(h) == ['loading', 'loading']
    h.loads(1, 2)
    assert phases(h) == ['loaded', 'loaded']
    lines = [line for e in h.happened(events.Loaded) for line in e.lines()]
    assert lines == ['a: loaded into /box', 'b: loaded into /box']
    h.exit('box-1')
    assert h.supervisor.done
    assert not failed(h)


def parameters(**values):
    """Return parameters, as an action sets them."""
    return tuple(SetParameter(*item, POSITION) for item in values.items())


def test_load_request_has_all_fields():
    values = {'n': '1', 'x': '1.0', 'list': '[.inf, -.inf, .nan, 1.5]'}
    values['text'] = '".inf \\" .nan"'
    asked = load_request(
        component(
            'a',
            namespace='/ns',
            remaps=('x:=y',),
            parameters=(*parameters(**values), *parameters(n='2')),
            extra_arguments=parameters(use_intra_process_comms='true'),
        )
    )
    (_, _, (_, doubles), _) = asked['parameters']
    assert math.isnan(doubles.pop(2))
    given = {'n': 2, 'x': 1.0, 'list': [math.inf, -math.inf, 1.5]}
    given['text'] = '.inf " .nan'
    assert asked == {
        'container': '/box',
        'package': 'demo',
        'plugin': 'demo::It',
        'name': 'a',
        'namespace': '/ns',
        'remaps': ['x:=y'],
        'parameters': [[*item] for item in given.items()],
        'extra_arguments': [['use_intra_process_comms', True]],
    }


def test_invalid_parameter_value_fails_the_load(box):
    h = begin(box(), component('a', parameters=parameters(n='0x1')))
    h.ready()
    ((label, reason),) = failed(h)
    assert label == 'a'
    assert "'n'" in reason
    assert '0x1' in reason


def test_missing_container_is_reported_ever_less_often(box):
    h = begin(box(), component('a'), component('b', '/far'))
    h.ready()
    h.after(4.9)
    assert warnings(h) == []
    h.after(0.2)
    near, far = warnings(h)
    assert '/box, to load a; box-1 runs' in near
    assert '/far, to load b; nothing in this launch provides it' in far
    h.after(9.0)
    assert len(warnings(h)) == 2
    h.after(60.0)
    assert len(warnings(h)) == 6
    h.after(3600.0)
    assert len(warnings(h)) < 24
    h.there('/box')
    h.loads(1)
    count = len(warnings(h))
    h.answer('load', full_name='/b', unique_id=1)
    h.after(3600.0)
    assert len(warnings(h)) == count


def test_launch_ends_despite_a_missing_container(process):
    h = begin(process('a'), component('lost', '/far'))
    h.ready()
    h.exit('a')
    assert not h.supervisor.done
    h.after(limits.WAIT_WARNING_DELAY + 0.1)
    assert h.supervisor.done
    assert [label for label, _ in failed(h)] == ['lost']


def test_open_load_is_finished_after_the_processes(process):
    h = begin(process('a'), component('late', '/far'))
    h.ready('/far')
    h.exit('a')
    h.after(60.0)
    assert not h.supervisor.done
    h.loads(1)
    assert h.supervisor.done
    assert not failed(h)


def test_launch_without_processes_waits_for_a_container():
    h = begin(component('a', '/far'))
    h.after(3600.0)
    assert not h.supervisor.done
    assert warnings(h)
    h.ready('/far')
    h.loads(7)
    assert h.supervisor.done


def test_ctrl_c_cancels_loads_silently(box):
    h = begin(box(), component('a'), component('b', '/far'))
    h.ready('/box')
    h.supervisor.stop('interrupted')
    h.exit('box-1', Outcome(signal=signal.SIGINT))
    assert h.supervisor.done
    assert not failed(h)
    assert not h.happened(events.Unloaded)


@pytest.mark.hostile
def test_container_that_dies_fails_its_open_loads(box, process):
    h = loaded(process('other'), box(), component('a'), component('b'))
    h.exit('box-1', CRASH)
    ((label, reason),) = failed(h)
    assert label == 'b'
    assert 'its container box-1 died by SIGSEGV' in reason
    assert phases(h) == ['unloaded', 'failed']
    assert h.open('load') == []
    # and so does one whose turn comes later
    h = begin(process('o'), box(), Timer(1.0, (component('a'),)))
    h.exit('box-1', CRASH)
    h.after(1.1)
    assert [label for label, _ in failed(h)] == ['a']


@pytest.mark.hostile
def test_a_container_that_cannot_be_started_fails_its_loads(box, process):
    h = History(process('other'), box(), component('a'))
    h.host.refused.add('box-1')
    h.turn()
    ((_, reason),) = failed(h)
    assert 'box-1 could not be started: refused' in reason


def test_respawn_brings_the_components_back_in_order(box):
    box = box(respawn=True, respawn_delay=1.0)
    h = loaded(box, *map(component, 'abcd'), ids=(1, 2, 3))
    h.composition.unload('b')
    h.answer('unload')
    h.exit('box-1', CRASH)
    ((label, _),) = failed(h)
    assert label == 'd'
    assert h.happened(events.LoadFailed)[0].again
    assert phases(h) == ['waiting', 'unloaded', 'waiting', 'waiting']
    assert h.open('load') == []
    h.after(1.1)
    assert [r['name'] for r in h.open('load')] == ['a', 'c', 'd']
    h.there('/box')
    h.loads(1, 2, 3)
    assert phases(h) == ['loaded', 'unloaded', 'loaded', 'loaded']
    # and one that was unloaded can be had again
    h.composition.reload('b')
    assert h.loads(4) == ['/b']


def test_unloaded_component_is_loaded_by_a_restart(box, process):
    h = loaded(process('other'), box(), component('a'))
    h.stop('box-1')
    h.exit('box-1', Outcome(signal=signal.SIGINT))
    assert phases(h) == ['unloaded']
    with pytest.raises(RefusedError, match='--restart box-1'):
        h.composition.reload('a')
    h.restart('box-1')
    assert h.loads(1) == ['/a']
    assert not failed(h)


def test_a_component_is_unloaded_and_loaded_anew(box):
    h = loaded(box(), component('a'), ids=(5,))
    h.composition.reload('a')
    assert phases(h) == ['unloading']
    assert h.answer('unload')['unique_id'] == 5
    assert h.loads(6) == ['/a']
    h.composition.unload('a')
    h.answer('unload')
    assert phases(h) == ['unloaded']
    assert [e.reason for e in h.happened(events.Unloaded)] == ['requested'] * 2
    with pytest.raises(RefusedError, match='a is not loaded'):
        h.composition.unload('a')
    with pytest.raises(RefusedError, match="no component 'b'"):
        h.composition.unload('b')


def test_failed_unload_keeps_the_component(box):
    h = loaded(box(), component('a'), ids=(5,))
    h.composition.unload('a')
    h.answer('unload', 'no node found with that id')
    assert phases(h) == ['loaded']
    assert 'a: could not be unloaded: no node found' in warnings(h)[0]


def test_failed_component_cannot_be_unloaded(box):
    h = begin(box(), component('a'))
    h.ready('/box')
    h.answer('load', 'no such class')
    with pytest.raises(RefusedError, match='a is not loaded'):
        h.composition.unload('a')
    h.stop('box-1')
    with pytest.raises(RefusedError, match='a is not loaded'):
        h.composition.unload('a')


def test_waiting_component_can_be_unloaded(box):
    h = begin(box(), component('a'), component('b'))
    h.ready()
    h.composition.unload('a')
    assert [r['name'] for r in h.open('load')] == ['b']
    assert phases(h) == ['unloaded', 'waiting']
    h.there('/box')
    # one that is being loaded is unloaded when it is
    h.composition.unload('b')
    h.loads(1)
    assert phases(h) == ['unloaded', 'unloading']
    h.answer('unload')
    assert phases(h) == ['unloaded', 'unloaded']
    assert not failed(h)


@pytest.mark.hostile
def test_new_client_lists_loaded_components(box):
    h = loaded(box(), *map(component, 'abc'))
    h.asked.clear()
    h.composition.client_died()
    h.ready()
    # nothing may be loaded twice
    assert h.open('load') == []
    h.answer('list', 'not there')
    h.there('/box')
    h.answer('list', nodes=[['/a', 1], ['/b', 2]])
    assert phases(h)[:2] == ['loaded', 'loaded']
    assert h.loads(3) == ['/c']
    assert len(h.happened(events.Loaded)) == 3
    assert not h.happened(events.Unloaded)


@pytest.mark.hostile
def test_client_that_dies_early_loses_no_load(box):
    h = begin(box(), component('a'))
    h.ready()
    h.asked.clear()
    h.composition.client_died()
    h.ready('/box')
    h.answer('list', nodes=[])
    assert h.loads(1) == ['/a']


@pytest.mark.hostile
def test_open_loads_fail_without_a_client(box):
    h = loaded(box(), component('a'), component('b'), Timer(9.0, ()))
    h.composition.client_given_up('it died')
    assert failed(h) == [('b', 'it died')]
    assert [e.reason for e in h.happened(events.RosLost)] == ['it died']
    h.exit('box-1')
    h.after(10.0)
    assert h.supervisor.done


def test_returning_container_gets_its_components(process):
    far = component('a', '/far')
    h = loaded(process('other'), far, container='/far')
    h.there('/far', there=False)
    h.there('/far')
    h.answer('list', nodes=[['/a', 1]])
    assert phases(h) == ['loaded']
    h.there('/far', there=False)
    h.there('/far')
    h.answer('list', nodes=[['/z', 1]])
    assert h.loads(2) == ['/a']
    assert len(h.happened(events.Unloaded)) == 1


def test_containers_do_not_wait_for_one_another(box):
    members = component('a'), component('b', '/other')
    h = begin(box(), box('other-2', '/other'), *members)
    h.ready('/other')
    assert [r['name'] for r in h.open('load')] == ['a', 'b']
    assert phases(h) == ['waiting', 'loading']


def test_node_with_the_name_of_a_container_is_it(process):
    h = begin(process('plain', node_name='/box'), component('a'))
    task = h.composition.task('a')
    assert h.composition.container_process(task).label == 'plain'
    h.exit('plain', CRASH)
    assert [label for label, _ in failed(h)] == ['a']


@pytest.mark.hostile
def test_lost_container_in_ros_waits_for_its_process(box):
    h = begin(box(respawn=True), component('a'))
    h.ready('/box')
    h.answer('load', 'the container has ended')
    assert not failed(h)
    h.exit('box-1', CRASH)
    ((_, reason),) = failed(h)
    assert 'box-1 died by SIGSEGV' in reason
    assert [r['container'] for r in h.open('gone')] == ['/box']
    assert h.loads(1) == ['/a']
