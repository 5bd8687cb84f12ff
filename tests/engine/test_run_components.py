# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches with components, whose containers and client are made up."""

import json
import os
from pathlib import Path
import signal
import sys

import colcon_yamllaunch
import pytest

PACKAGE = Path(colcon_yamllaunch.__file__).parent


@pytest.fixture
def ros(tmp_path):
    """Return the folder that stands for what goes on in ROS."""
    folder = tmp_path / 'ros'
    folder.mkdir()
    return folder


@pytest.fixture
def start(launch, ros):
    """Return a function that starts a launch with the made up client."""

    def begin(*entries, **settings):
        environment = settings.pop('environment', {})
        environment['FAKE_ROS'] = str(ros)
        # no wrapper of it, which takes long
        environment['PATH'] = f'{Path(sys.executable).parent}:{os.defpath}'
        return launch(*entries, environment=environment, **settings)

    return begin


@pytest.fixture
def box(ros, sh):
    """Return a function that describes a container."""

    def describe(**more):
        script = (
            f'cd {ros}; rm -f box.loaded; echo $$ > box.there; '
            'echo up; exec sleep 99'
        )
        return sh('box-1', script, node_name='/box', is_container=True, **more)

    return describe


MISSING = {'FAKE_MISSING': 'composition_interfaces'}


def component(label, plugin='It', **more):
    known = {'kind': 'component', 'package': 'demo', 'container': '/box'}
    names = {'label': label, 'name': label, 'plugin': plugin}
    return {**known, **names, **more}


def client(ros, wait_until):
    return int(wait_until(lambda: read(ros / 'pid')))


def read(path):
    try:
        return path.read_text()
    except FileNotFoundError:
        return ''


def loaded(ros):
    lines = read(ros / 'box.loaded').splitlines()
    return [json.loads(line)[0] for line in lines]


def test_components_are_loaded_and_belong_to_the_launch(
    start, box, ros, is_running, wait_until
):
    running = start(box(), component('a'), component('b', namespace='/ns'))
    running.shows('b: loaded into /box')
    assert loaded(ros) == ['/a', '/ns/b']
    pid = client(ros, wait_until)
    assert is_running(pid)
    running.sends(signal.SIGINT)
    assert running.ends() == 0
    assert not is_running(pid)
    assert [e['label'] for e in running.events('loaded')] == ['a', 'b']
    assert 'left running' not in running.screen
    assert 'failed' not in running.screen


def test_a_failed_load_is_a_failure_and_the_rest_goes_on(start, box, ros):
    running = start(box(), component('a', 'Nope'), component('b'))
    running.shows('b: loaded into /box').sends(signal.SIGINT)
    assert running.ends() == 1
    reason = 'could not be loaded into /box: there is no such plugin (from /ws'
    assert f'a: {reason}/demo.yaml:7:9)' in running.screen
    assert 'failed: a could not be loaded into /box' in running.screen
    (event,) = running.events('load_failed')
    assert event['reason'] == 'there is no such plugin'


def test_what_the_environment_lacks_is_said_before_anything_starts(start, box):
    environment = {**MISSING, 'ROS_DISTRO': 'jazzy'}
    running = start(box(), component('a'), environment=environment)
    assert running.ends() == 1
    package = 'composition-interfaces'
    assert f'sudo apt install ros-jazzy-{package}' in running.screen
    depend = f'<exec_depend>{package.replace("-", "_")}</exec_depend>'
    assert depend in running.screen
    assert running.events('started') == []
    assert running.screen.count('\n') == 1


@pytest.mark.hostile
def test_what_only_seemed_to_be_there_is_a_failure_later(start, box, tmp_path):
    for name in ('rclpy', 'rcl_interfaces', 'composition_interfaces'):
        (tmp_path / 'seeming' / name).mkdir(parents=True)
        (tmp_path / 'seeming' / name / '__init__.py').touch()
    path = f'{PACKAGE.parent}:{tmp_path / "seeming"}'
    environment = {**MISSING, 'PYTHONPATH': path}
    running = start(box(), component('a'), environment=environment)
    running.shows('a: could not be loaded into /box: for components')
    running.sends(signal.SIGINT)
    assert running.ends() == 1
    assert 'build composition_interfaces in the workspace' in running.screen
    assert len(running.events('ros_lost')) == 1


def test_a_client_that_cannot_run_is_one_error(start, box, ros):
    (ros / 'broken').touch()
    running = start(box(), component('a'))
    assert running.ends() == 1
    assert 'it is broken' in running.screen
    assert running.events('started') == []


@pytest.mark.hostile
def test_a_killed_client_is_replaced_and_loads_nothing_twice(
    start, box, ros, wait_until, is_running
):
    running = start(box(), component('a'), component('b', 'Slow'))
    wait_until((ros / 'loading').exists)
    first = client(ros, wait_until)
    (ros / 'pid').unlink()
    os.kill(first, signal.SIGKILL)
    running.shows('is started again')
    second = client(ros, wait_until)
    assert second != first
    (ros / 'slow').touch()
    running.shows('b: loaded into /box')
    assert loaded(ros) == ['/a', '/b']
    running.sends(signal.SIGINT)
    assert running.ends() == 0
    assert not is_running(second)


@pytest.mark.hostile
def test_a_client_that_always_dies_is_given_up(start, box, ros):
    (ros / 'unready').touch()
    running = start(box(), component('a'))
    running.shows('a: could not be loaded into /box: the ROS client')
    running.sends(signal.SIGINT)
    assert running.ends() == 1
    assert 'it does not get ready; see ' in running.screen
    assert running.events('ros_lost')
    assert b'it does not get ready' in running.log('ros_client.log')


@pytest.mark.hostile
def test_nothing_is_left_of_a_killed_launcher(start, box, ros, wait_until):
    running = start(box(), component('a'))
    running.shows('a: loaded into /box')
    running.popen.kill()
    wait_until(lambda: not running.processes())


def test_lifecycle_nodes_are_activated_or_that_is_a_failure(start, sh, ros):
    script = f'echo $$ > {ros}/lc.there; exec sleep 99'
    lifecycle = {'is_lifecycle': True, 'autostart': True}
    node = sh('lc-1', script, node_name='/lc', **lifecycle)
    running = start(node)
    running.shows('lc-1: active')
    running.sends(signal.SIGINT)
    assert running.ends() == 0
    states = [e['state'] for e in running.events('state_changed')]
    assert states == ['unconfigured', 'inactive', 'active']
    (ros / 'bad').touch()
    running = start(node)
    running.shows("lc-1: the transition 'configure' of /lc failed: it is bad")
    running.sends(signal.SIGINT)
    assert running.ends() == 1


def test_the_client_starts_when_the_plan_first_needs_it(start, ros, box, sh):
    """A plan that grows may need nothing of ROS at its start."""
    entries = [box(), component('a'), component('b', container='/far')]
    first = {'when': 'exited first', 'entries': entries}
    then = {'when': 'loaded a', 'entries': [component('c')]}
    started = start(sh('first', ':'), source=[first, then])
    started.shows('c: loaded into /box')
    assert started.sends(signal.SIGINT).ends() == 0
    assert [e['label'] for e in started.events('loaded')] == ['a', 'c']
    assert started.processes() == []
