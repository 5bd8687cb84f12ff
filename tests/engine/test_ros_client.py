# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The client with real containers and nodes, through its pipes and DDS."""

import ast
from collections.abc import Callable, Iterator
from pathlib import Path
import signal
import subprocess
import threading
import time

from colcon_yamllaunch.engine import ros_client
import pytest
from support.ros_talk import DEADLINE, Environment, Talk, talking

CONTAINER = 'lib/rclcpp_components/component_container'


class Container:
    """A container that runs."""

    def __init__(self, install: Path, environment: Environment, *more: str):
        self._process = subprocess.Popen(
            [install / CONTAINER, '--ros-args', '-r', '__node:=box', *more],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self.lines: list[str] = []
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def ends(self) -> int:
        """Wait for its end, and return its exit code."""
        code = self._process.wait(DEADLINE)
        self._reader.join()
        return code

    def stop(self, number: int = signal.SIGINT) -> int:
        """End it."""
        self._process.send_signal(number)
        return self.ends()

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stdout:
            self.lines += (line.rstrip('\n') for line in stdout)


Start = Callable[..., Container]


@pytest.fixture
def talk(environment: Environment) -> Iterator[Talk]:
    with talking(environment) as one:
        yield one


@pytest.fixture
def start(ros_parts: Path, environment: Environment) -> Iterator[Start]:
    containers: list[Container] = []

    def start_container(*parameters: str) -> Container:
        more = [word for one in parameters for word in ('-p', one)]
        containers.append(Container(ros_parts, environment, *more))
        return containers[-1]

    yield start_container
    for container in containers:
        container.stop(signal.SIGKILL)


def test_client_runs_with_python_3_8_syntax() -> None:
    # those of Humble and before
    text = Path(ros_client.__file__).read_text(encoding='utf-8')
    ast.parse(text, feature_version=(3, 8))


@pytest.mark.full
def test_client_reports_missing_packages_and_ends() -> None:
    with talking({}, ('json', 'no_such_module')) as talk:
        missing = talk.event(event='found')['missing']
        assert missing == ['no_such_module']
        assert talk.process.wait(DEADLINE) == 0
        assert talk.lines == []


def test_client_reports_a_failed_start(environment: Environment) -> None:
    strange = environment | {'ROS_DOMAIN_ID': 'mine'}
    with talking(strange, ('rclpy',)) as talk:
        text = talk.event(event='trouble')['text']
        assert text.startswith('ROS does not start: ')
        assert talk.process.wait(DEADLINE) == 1


def test_components_are_loaded_refused_listed_and_unloaded(
    talk: Talk, start: Start, environment: Environment
) -> None:
    requests = [
        talk.load('Talker', name=f'talker{n}', namespace='/a', remaps=['x:=y'])
        for n in range(10)
    ]
    container = start()
    assert talk.event(event='found')['missing'] == []
    answers = [talk.answer(request) for request in requests]
    assert answers == [
        {'ok': True, 'full_name': f'/a/talker{n}', 'unique_id': n + 1}
        for n in range(10)
    ]
    for plugin, package, reason in (
        ('Nope', 'composition', 'Failed to find class with the requested'),
        ('Talker', 'nope', 'Could not find requested resource in ament index'),
        ('Missing', 'composition', 'Failed to load library'),
        ('Throwing', 'composition', 'Component constructor threw an exc'),
    ):
        answer = talk.answer(talk.load(plugin, package=package))
        assert answer['ok'] is False
        assert answer['reason'].startswith(reason)
    box = {'container': '/box'}
    assert talk.result('unload', **box, unique_id=3) == {'ok': True}
    refused = talk.result('unload', **box, unique_id=3)
    assert refused['reason'] == 'No node found with unique_id: 3'
    # another launch loads into the same one, and dies
    with talking(environment) as other:
        answer = other.answer(other.load('Listener'))
        assert answer['full_name'] == '/listener'
    nodes = dict(talk.result('list', **box)['nodes'])
    assert len(nodes) == 10
    assert nodes['/listener'] == 11
    assert talk.answer(talk.load('Listener', name='last'))['unique_id'] == 12
    # as by Ctrl-C in the terminal that it has in common with the launcher
    talk.process.send_signal(signal.SIGINT)
    assert talk.result('list', **box)['ok']
    assert container.stop() == 0
    talk.event(event='container', there=False)
    gone = talk.result('list', **box)
    assert gone == {'ok': False, 'reason': 'not there'}
    assert talk.end() == 0
    assert 'Traceback' not in talk.errors


#: Parameters as they are sent, and as the node prints them.
VALUES = {
    'a': (True, 'BOOL True'),
    'b': (1, 'INTEGER 1'),
    'c': (1.0, 'DOUBLE 1.0'),
    'd': ('x', 'STRING x'),
    'e': ([True, False], 'BOOL_ARRAY [True, False]'),
    'f': ([1, 2], "INTEGER_ARRAY array('q', [1, 2])"),
    'g': ([1, 2.5], "DOUBLE_ARRAY array('d', [1.0, 2.5])"),
    'h': (['x', ''], "STRING_ARRAY ['x', '']"),
    'i': (float('-inf'), 'DOUBLE -inf'),
    'j': ([1.0, float('nan')], "DOUBLE_ARRAY array('d', [1.0, nan])"),
    'n.d': ('', 'STRING '),
}


def test_parameters_have_the_types_of_their_values(
    talk: Talk, start: Start
) -> None:
    container = start()
    parameters = [[name, value] for name, (value, _) in VALUES.items()]
    request = talk.load('Parameters', parameters=parameters)
    assert talk.answer(request)['ok']
    for value in (None, [], [1, 'x'], [[1]], 1 << 70):
        request = talk.load('Parameters', parameters=[['p', value]])
        assert not talk.answer(request)['ok'], value
    talk.write('{"id": 50, "do": "dance"}\nnonsense\n')
    for _ in range(2):
        text = talk.event(event='trouble')['text']
        assert text.startswith('strange request: ')
    request = talk.load('Talker', 'no container')
    assert 'no container' in talk.answer(request)['reason']
    container.stop()
    printed = [one for one in container.lines if 'use_sim_time' not in one]
    assert [one for one in printed if 'start_type' not in one] == [
        f'{name}: {text}' for name, (_, text) in VALUES.items()
    ]


def test_container_that_is_late_dies_and_comes_back(
    talk: Talk, start: Start
) -> None:
    request = talk.load('Talker')
    never = talk.load('Talker', '/never')
    talk.event(event='ready')
    container = start('delay:=0.2')
    assert talk.answer(request)['unique_id'] == 1
    # during a load, with more of them to come
    slow = talk.load('Slow', parameters=[['seconds', 0.1]])
    crash = talk.load('Crashing')
    later = talk.load('Talker', name='later')
    assert talk.answer(slow)['unique_id'] == 2
    assert container.ends() == 7
    assert talk.result('gone', container='/box') == {'ok': True}
    ended = {'ok': False, 'reason': 'the container has ended'}
    assert talk.answer(crash) == ended
    # those wait for the next one, though this one is still visible
    container = start()
    assert talk.answer(later)['unique_id'] == 1
    container.stop(signal.SIGKILL)
    # and this one was not told: it may be lost, and is sent again
    request = talk.load('Talker')
    container = start('refuse_unload:=true')
    assert talk.answer(request)['unique_id'] == 1
    unload = talk.result('unload', container='/box', unique_id=1)
    assert unload == {'ok': False, 'reason': 'It stays'}
    there = [line['there'] for line in talk.lines if 'there' in line]
    assert there == [True, False, True, False, True]
    talk.ask('cancel', request=never)
    cancelled = {'ok': False, 'reason': 'cancelled'}
    assert talk.answer(never) == cancelled
    # one that says good-bye needs no more
    slow = talk.load('Slow', parameters=[['seconds', 60.0]])
    container.stop(signal.SIGTERM)
    assert talk.answer(slow) == ended


def test_component_of_a_cancelled_load_is_unloaded(
    talk: Talk, start: Start
) -> None:
    start()
    slow = talk.load('Slow', parameters=[['seconds', 1.0]])
    talk.event(event='container', there=True)
    second = talk.load('Talker')
    talk.ask('cancel', request=slow)
    assert talk.answer(slow) == {'ok': False, 'reason': 'cancelled'}
    assert talk.answer(second)['unique_id'] == 2
    nodes = [['/talker', 2]]
    while talk.result('list', container='/box')['nodes'] != nodes:
        time.sleep(0.01)


def test_states_are_followed_and_changed(talk: Talk, start: Start) -> None:
    node = {'node': '/lc'}

    def change(transition: str) -> str:
        answer = talk.result('change_state', **node, transition=transition)
        return str(answer.get('reason', ''))

    assert talk.result('follow', **node) == {'ok': True}
    first = talk.ask('change_state', **node, transition='configure')
    second = talk.ask('change_state', **node, transition='activate')
    container = start()
    parameters = [['fails', 'deactivate'], ['throws', 'cleanup']]
    talk.load('Lifecycle', name='lc', parameters=parameters)
    assert talk.answer(first) == {'ok': True}
    assert talk.answer(second) == {'ok': True}
    assert talk.event(state='active')['node'] == '/lc'
    assert change('activate') == "'activate' is not possible in 'active'"
    assert change('deactivate') == "'deactivate' failed, the node is 'active'"
    assert change('dance') == "there is no transition 'dance'"
    assert change('shutdown') == ''
    assert talk.event(state='finalized')['node'] == '/lc'
    assert "not possible in 'finalized'" in change('configure')
    container.stop(signal.SIGKILL)
    talk.result('gone', node='/lc')
    talk.result('gone', container='/box')
    waiting = talk.ask('change_state', **node, transition='configure')
    talk.load('Lifecycle', name='lc', parameters=parameters)
    start()
    assert talk.answer(waiting) == {'ok': True}
    talk.event(state='inactive')
    assert change('cleanup').startswith("'cleanup' failed, the node is ")
    unfollowed = {'node': '/other', 'transition': 'configure'}
    talk.load('Lifecycle', name='other', parameters=[['fails', 'configure']])
    assert talk.result('change_state', **unfollowed)['reason'] == (
        "'configure' failed, the node is 'unconfigured'"
    )
    assert not any(one.get('node') == '/other' for one in talk.lines)


def test_outcome_of_a_lost_answer_is_found(talk: Talk, start: Start) -> None:
    start('loses:=load_node')
    for number, loses in enumerate(['change_state', 'get_state'], 1):
        name = f'lc{number}'
        parameters = [['loses', loses]]
        request = talk.load('Lifecycle', name=name, parameters=parameters)
        loaded = {'ok': True, 'full_name': f'/{name}', 'unique_id': number}
        assert talk.answer(request) == loaded
    done = talk.ask('change_state', node='/lc1', transition='configure')
    refused = talk.ask('change_state', node='/lc2', transition='activate')
    assert talk.answer(done) == {'ok': True}
    reason = "'activate' is not possible in 'unconfigured'"
    assert talk.answer(refused) == {'ok': False, 'reason': reason}
    nodes = [['/lc1', 1], ['/lc2', 2]]
    assert talk.result('list', container='/box')['nodes'] == nodes


def test_clock_events_are_limited(talk: Talk, start: Start) -> None:
    assert talk.result('clock') == {'ok': True}
    start()
    assert talk.answer(talk.load('Ticking'))['ok']
    begin = time.monotonic()
    seconds = [talk.event(event='clock')['seconds'] for _ in range(10)]
    elapsed = time.monotonic() - begin
    assert seconds == sorted(set(seconds))
    assert seconds[0] > 10
    # one may have come before
    assert elapsed >= 8 * ros_client.CLOCK_PERIOD
