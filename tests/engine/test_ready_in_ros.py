# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch asks the ROS client for, so as to know what is ready."""

from dataclasses import replace

from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    ReadyCondition,
)
from colcon_yamllaunch.plan.plan import AfterReady
from colcon_yamllaunch.plan.position import Position
import pytest
from support.history import component

FAILED = Outcome(code=1)
HERE = Position('/ws/robot.yaml', 3, 5)
SCAN = ReadyCondition('topic', 'scan')


@pytest.fixture
def deployed(process):
    """Return a function that makes an entry with settings."""

    def make(label, *after, settings=None, **fields):
        settings = MemberSettings(HERE, after=after, **(settings or {}))
        made = replace(process(label, **fields), settings=settings)
        return AfterReady(after, (made,)) if after else made

    return make


@pytest.fixture
def scanning(deployed):
    """Return a process that is ready when something publishes its scan."""

    def make(label='a', **fields):
        settings = {'ready': (SCAN,), 'ready_timeout': 10.0}
        known = {'node_name': '/front/lidar', **fields}
        return deployed(label, settings=settings, **known)

    return make


def test_a_condition_is_asked_for_with_full_names(history, scanning, deployed):
    h = history(scanning(), deployed('b', 'a'))
    assert h.open('await') == []
    h.ready()
    (request,) = h.open('await')
    assert {k: v for k, v in request.items() if k not in ('id', 'do')} == {
        'member': 'a',
        'kind': 'topic',
        'name': '/front/scan',
        'value': '',
        'message': False,
        'node': '/front/lidar',
        'namespace': '/front',
    }
    assert h.started() == ['a']
    h.answer('await')
    assert h.started() == ['a', 'b']


def test_the_next_client_is_asked_again(history, scanning):
    h = history(scanning())
    h.ready()
    h.composition.client_died()
    h.asked.clear()
    h.ready()
    assert len(h.open('await')) == 1
    h.answer('await')
    assert h.state('a').is_ready
    h.composition.client_died()
    h.asked.clear()
    h.ready()
    assert h.open('await') == []


def test_a_restarted_process_is_waited_for_again(history, scanning):
    h = history(scanning(respawn=True))
    h.ready()
    h.answer('await')
    h.exit('a', FAILED)
    assert [r['member'] for r in h.open('gone')] == ['a']
    assert h.asked[-1]['do'] == 'await'
    assert not h.state('a').is_ready
    h.exit('a', FAILED)
    # the first one was cancelled
    assert len(h.open('await')) == 1
    h.answer('await')
    assert h.state('a').is_ready


def test_what_is_there_instead_is_reported(history, scanning):
    h = history(scanning())
    h.ready()
    h.after(10.0)
    assert h.happened(events.NotReady) == []
    h.answer('explain', found='its node publishes scan_raw')
    (event,) = h.happened(events.NotReady)
    assert event.text == (
        'not ready after 10.0 s: waiting for a publisher of scan '
        '(its node publishes scan_raw)'
    )
    h.after(limits.EXPLANATION_TIMEOUT)
    assert len(h.happened(events.NotReady)) == 1
    h.answer('await')
    assert h.state('a').is_ready


@pytest.mark.parametrize('has_client', [False, True])
def test_a_report_does_not_wait_for_a_silent_client(
    history, scanning, has_client
):
    h = history(scanning())
    if has_client:
        h.ready()
    h.after(10.0 + limits.EXPLANATION_TIMEOUT)
    (event,) = h.happened(events.NotReady)
    assert event.found == ''


def test_what_is_ready_in_time_after_all_is_not_reported(history, scanning):
    h = history(scanning())
    h.ready()
    h.after(10.0)
    h.answer('await')
    h.answer('explain', found='')
    h.after(limits.EXPLANATION_TIMEOUT)
    assert h.happened(events.NotReady) == []


def test_a_refused_condition_is_reported(history, scanning):
    h = history(scanning())
    h.ready()
    h.answer('await', 'InvalidTopicNameException')
    (warning,) = h.happened(events.Warned)
    assert warning.text == (
        'a: cannot wait for a publisher of scan: InvalidTopicNameException'
    )


def test_a_node_is_ready_when_it_is_in_the_graph(
    history, process, deployed, scanning
):
    h = history(
        process('a', node_name='/a'),
        process('unawaited', node_name='/u'),
        process('nameless'),
        deployed('b', 'a', 'nameless'),
        scanning('c'),
    )
    h.ready()
    assert h.state('nameless').is_ready and h.state('unawaited').is_ready
    assert [(r['kind'], r['name']) for r in h.open('await')] == [
        ('node', '/a'),
        ('topic', '/front/scan'),
    ]
    h.answer('await')
    assert h.started()[-1] == 'b'


def test_without_ros_a_node_is_ready_when_it_runs(history, process, deployed):
    h = history(process('a', node_name='/a'), deployed('b', 'a'))
    assert h.started() == ['a', 'b']


def test_lifecycle_nodes_are_ready_when_active(history, process, deployed):
    node = {'is_lifecycle': True, 'autostart': True}
    h = history(process('a', node_name='/a', **node), deployed('b', 'a'))
    h.ready()
    assert h.open('await') == []
    h.says(event='state', node='/a', state='inactive')
    assert h.started() == ['a']
    h.says(event='state', node='/a', state='active')
    assert h.started() == ['a', 'b']


def test_other_lifecycle_nodes_are_asked_for_their_state(history, deployed):
    active = ReadyCondition('lifecycle', 'active')
    h = history(deployed('a', settings={'ready': (active,)}, node_name='/a'))
    h.ready()
    (request,) = h.open('await')
    assert (request['name'], request['node']) == ('active', '/a')


def test_a_component_has_the_name_that_its_container_gives(history, process):
    settings = MemberSettings(
        HERE, ready=(ReadyCondition('service', '~/map'),)
    )
    box = process('box', node_name='/box', is_container=True)
    h = history(box, component('a', name='', settings=settings))
    h.ready('/box')
    h.answer('load', full_name='/maps/server', unique_id=1)
    (request,) = h.open('await')
    assert request['name'] == '/maps/server/map'
    assert request['node'] == '/maps/server'
