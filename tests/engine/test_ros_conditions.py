# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Readiness conditions with real nodes, checked through the client's pipes."""

import ast
from collections.abc import Callable, Iterator
from pathlib import Path
import signal
import subprocess
import time
from typing import Any

from colcon_yamllaunch.engine import ros_conditions
import pytest
from support.ros_talk import DEADLINE, Environment, Talk, talking

OK = {'ok': True}


class Offering:
    """A node that offers what it is told to."""

    def __init__(
        self,
        program: Path,
        environment: Environment,
        orders: tuple[str, ...],
        node: str,
    ) -> None:
        namespace, _, name = node.rpartition('/')
        rules = ['-r', f'__node:={name}', '-r', f'__ns:={namespace or "/"}']
        self._process = subprocess.Popen(
            [program, *orders, '--ros-args', *rules],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def does(self, *orders: str) -> None:
        """Give orders, and wait until they are done."""
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None and stdout is not None
        for order in (*orders, 'done'):
            stdin.write(f'{order}\n')
        stdin.flush()
        assert stdout.readline() == 'done\n'

    def stop(self, number: int = signal.SIGKILL) -> None:
        """End it."""
        self._process.send_signal(number)
        self._process.communicate(timeout=DEADLINE)


class Waits:
    """Asks a client for conditions of a node `/drivers/lidar`."""

    def __init__(self, talk: Talk) -> None:
        self.talk = talk

    def ask(self, kind: str, name: str, do: str = 'await', **more: Any) -> int:
        fields = {
            'member': 'lidar-1',
            'node': '/drivers/lidar',
            'namespace': '/drivers',
            'value': None,
            **more,
        }
        return self.talk.ask(do, kind=kind, name=name, **fields)

    def found(self, kind: str, name: str, **more: Any) -> str:
        """Return what there is instead."""
        request = self.ask(kind, name, 'explain', **more)
        return str(self.talk.answer(request)['found'])

    def until_found(
        self, text: str, kind: str, name: str, **more: Any
    ) -> None:
        """Wait until something is there instead."""
        found = ''
        while text not in found:
            found = self.found(kind, name, **more)

    def holds(self, request: int) -> bool:
        """Wait until a condition holds."""
        return self.talk.answer(request) == OK

    def does_not_hold(self, request: int) -> bool:
        """Return whether a condition does not hold now."""
        time.sleep(5 * ros_conditions.LOOK_INTERVAL)
        # the answer of a later request comes after it
        self.talk.result('gone', member='nobody')
        return not any(line.get('id') == request for line in self.talk.lines)


Start = Callable[..., Offering]


@pytest.fixture
def waits(environment: Environment) -> Iterator[Waits]:
    with talking(environment, ('rclpy', 'tf2_msgs')) as talk:
        talk.event(event='ready')
        yield Waits(talk)


@pytest.fixture
def start(ros_parts: Path, environment: Environment) -> Iterator[Start]:
    started: list[Offering] = []

    def start_node(*orders: str, node: str = '/drivers/lidar') -> Offering:
        program = ros_parts / 'lib/composition/offering'
        started.append(Offering(program, environment, orders, node))
        return started[-1]

    yield start_node
    for one in started:
        one.stop()


def test_conditions_run_with_python_3_8_syntax() -> None:
    text = Path(ros_conditions.__file__).read_text(encoding='utf-8')
    ast.parse(text, feature_version=(3, 8))


def test_names_are_waited_for(waits: Waits, start: Start) -> None:
    topic = waits.ask('topic', '/drivers/scan')
    service = waits.ask('service', '/drivers/get_map')
    action = waits.ask('action', '/drivers/go')
    node = waits.ask('node', '/drivers/lidar')
    other = waits.ask('node', '/drivers/camera')
    assert waits.found('topic', '/drivers/scan') == (
        'there is no node /drivers/lidar'
    )
    lidar = start('topic:scan_raw', 'service:get_maps', 'action:goto')
    assert waits.holds(node)
    for kind, name, found in (
        ('topic', '/drivers/scan', 'its node publishes scan_raw'),
        ('service', '/drivers/get_map', 'its node offers get_maps'),
        ('action', '/drivers/go', 'its node has the actions goto'),
        ('node', '/drivers/camera', ''),
        ('node', '/drivers/lidar2', 'there is lidar'),
    ):
        waits.until_found(found, kind, name)
    assert waits.found('topic', '/drivers/scan', node='') == (
        'there is scan_raw'
    )
    for request in (topic, service, action):
        assert waits.does_not_hold(request)
    lidar.does('topic:scan', 'service:get_map', 'action:go')
    for request in (topic, service, action):
        assert waits.holds(request)
    # what is there already holds at once
    assert waits.holds(waits.ask('topic', '/drivers/scan'))
    assert waits.does_not_hold(other)
    waits.talk.ask('cancel', request=other)
    start(node='/drivers/camera')
    assert waits.holds(waits.ask('node', '/drivers/camera'))
    assert waits.does_not_hold(other)


@pytest.mark.parametrize('number', [signal.SIGKILL, signal.SIGINT])
def test_a_restarted_node_counts_again_once_it_is_back(
    waits: Waits, start: Start, number: int
) -> None:
    conditions = (
        ('topic', '/drivers/scan', {'message': True}),
        ('service', '/drivers/get_map', {}),
        ('node', '/drivers/lidar', {}),
        ('parameter', 'rate', {'value': 5}),
        ('lifecycle', 'active', {}),
    )
    orders = ('message:scan', 'service:get_map', 'parameter:rate=5')
    states = ('state:configure', 'state:activate')
    lidar = start('lifecycle', *orders, *states)
    for kind, name, more in conditions:
        assert waits.holds(waits.ask(kind, name, **more)), kind
    lidar.stop(number)
    # one that crashed is still visible for a while
    assert waits.talk.result('gone', member='lidar-1') == OK
    requests = [
        waits.ask(kind, name, **more) for kind, name, more in conditions
    ]
    for request in requests:
        assert waits.does_not_hold(request)
    lidar = start('lifecycle', *orders)
    for request in requests[:-1]:
        assert waits.holds(request)
    assert waits.does_not_hold(requests[-1])
    lidar.does(*states)
    assert waits.holds(requests[-1])


def test_a_message_is_waited_for(waits: Waits, start: Start) -> None:
    request = waits.ask('topic', '/drivers/scan', message=True)
    lidar = start('topic:scan')
    waits.until_found('no message', 'topic', '/drivers/scan', message=True)
    assert waits.does_not_hold(request)
    lidar.does('message:scan')
    assert waits.holds(request)
    # the last one is kept for those that subscribe later
    assert waits.holds(waits.ask('topic', '/drivers/scan', message=True))


def test_a_state_is_waited_for(waits: Waits, start: Start) -> None:
    request = waits.ask('lifecycle', 'active')
    assert 'no node' in waits.found('lifecycle', 'active')
    lidar = start('lifecycle', 'state:configure')
    waits.until_found('it is inactive', 'lifecycle', 'active')
    assert waits.does_not_hold(request)
    lidar.does('state:activate')
    assert waits.holds(request)
    start(node='/plain')
    without = 'its node has no lifecycle'
    waits.until_found(without, 'lifecycle', 'active', node='/plain')


def test_a_parameter_is_waited_for(waits: Waits, start: Start) -> None:
    values = {
        'rate': (1.0, '2.0', 'it is 2.0'),
        'name': ('a b', '"a c"', 'it is "a c"'),
        'count': (1, '2', 'it is 2'),
        'is_on': (True, 'false', 'it is false'),
    }
    requests = {
        name: waits.ask('parameter', name, value=value)
        for name, (value, _, _) in values.items()
    }
    lidar = start(*(f'parameter:{n}={v[1]}' for n, v in values.items()))
    for name, (value, _, found) in values.items():
        waits.until_found(found, 'parameter', name, value=value)
        assert waits.does_not_hold(requests[name])
    number = waits.ask('parameter', 'count', value=True)
    other = waits.ask('parameter', 'rat', value=1)
    waits.until_found('its node has rate, ', 'parameter', 'rat', value=1)
    lidar.does(
        'parameter:rate=1.0',
        'parameter:name="a b"',
        'parameter:count=1',
        'parameter:is_on=true',
    )
    for request in requests.values():
        assert waits.holds(request)
    assert waits.does_not_hold(number)
    assert waits.does_not_hold(other)


def test_a_transform_is_composed_of_others(waits: Waits, start: Start) -> None:
    frames = {'name': 'map', 'value': 'laser'}
    request = waits.ask('transform', **frames)
    assert waits.found('transform', **frames) == 'no transforms arrive'
    static = start('static:base_link=laser', 'static:world=mat')
    waits.until_found('no frame map, but mat', 'transform', **frames)
    static.does('static:world=map')
    waits.until_found(
        'separate trees, below world and base_link', 'transform', **frames
    )
    assert waits.does_not_hold(request)
    odom = start('moving:odom=base_link', 'static:world=odom', node='/odom')
    assert waits.holds(request)
    odom.stop()
    waits.talk.result('gone', member='lidar-1')
    # those of the process that crashed do not come again
    again = waits.ask('transform', **frames)
    waits.until_found('separate trees', 'transform', **frames)
    assert waits.does_not_hold(again)
    start('moving:odom=base_link', 'static:world=odom', node='/odom')
    assert waits.holds(again)


def test_a_type_that_is_not_installed_is_named(
    waits: Waits, start: Start, environment: Environment
) -> None:
    start('static:a=b')
    without = dict(environment)
    without['PYTHONPATH'] = ''
    with talking(without, ('rclpy',)) as talk:
        talk.event(event='ready')
        other = Waits(talk)
        other.ask('topic', '/tf_static', message=True)
        other.until_found(
            'tf2_msgs/msg/TFMessage cannot be imported',
            'topic',
            '/tf_static',
            message=True,
        )
