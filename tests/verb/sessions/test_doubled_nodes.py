# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch says at once that its nodes run already."""

from collections.abc import Callable
from dataclasses import replace

from colcon_yamllaunch.control import doubled_nodes
from colcon_yamllaunch.engine.state import About, ProcessState
from colcon_yamllaunch.plan.plan import Plan, Process
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.plan.position import Position
import pytest
from support.launch_states import launch_state, process_state
from support.user import User

FILE = '/ws/demo.yaml'
NAMED = Process(
    'talker-1',
    ('/lib/p/talker', '--ros-args', '-r', '__ns:=/a'),
    '/',
    Position(FILE, 3, 5),
    package='p',
    node_name='/a/talker',
)
UNNAMED = replace(NAMED, node_name=None)
STATE = process_state('talker-1', pid=7, executable='talker', package='p')
NAMED_STATE = process_state('talker-1', pid=7, package='p', node='/a/talker')
OTHER = launch_state(about=About('p demo.yaml', 'p', FILE, '/ws'), pid=4711)
Find = Callable[..., list[str]]


@pytest.fixture
def find(monkeypatch: pytest.MonkeyPatch) -> Find:
    """Return a function that tells which nodes are doubled."""

    def doubled(
        process: Process,
        state: ProcessState,
        arguments: tuple[str, ...] = ('python3', '-r', '__ns:=/a'),
        file: str = FILE,
        domain: str = '',
        **domains: str,
    ) -> list[str]:
        scan = {'variable_of': lambda _pid, _name: domain or None}
        monkeypatch.setattr(doubled_nodes, 'variable_of', scan['variable_of'])
        monkeypatch.setattr(
            doubled_nodes, 'arguments_of', lambda _pid: list(arguments)
        )
        return doubled_nodes.doubled_nodes(
            Plan((process,)),
            domains,
            file,
            replace(OTHER, by_label={state.label: state}),
        )

    return doubled


def test_a_node_of_the_same_name_is_doubled(find: Find) -> None:
    assert find(NAMED, NAMED_STATE) == ['/a/talker']
    assert find(NAMED, NAMED_STATE, file='/ws/other.yaml') == ['/a/talker']
    assert find(NAMED, replace(NAMED_STATE, pid=None, phase='respawn'))
    assert find(NAMED, NAMED_STATE, domain='0') == ['/a/talker']


def test_another_name_or_domain_is_fine(find: Find) -> None:
    assert find(replace(NAMED, node_name='/b/talker'), NAMED_STATE) == []
    assert find(NAMED, NAMED_STATE, domain='5') == []
    assert find(NAMED, NAMED_STATE, ROS_DOMAIN_ID='5') == []
    assert find(NAMED, NAMED_STATE, domain='5', ROS_DOMAIN_ID='5')
    own = replace(NAMED, environment=(('ROS_DOMAIN_ID', '5'),))
    assert find(own, NAMED_STATE) == []
    assert find(NAMED, replace(NAMED_STATE, phase='ended')) == []


def test_a_node_that_names_itself(find: Find) -> None:
    assert find(UNNAMED, STATE) == ['talker-1']
    assert find(UNNAMED, STATE, file='/ws/other.yaml') == []
    assert find(UNNAMED, STATE, arguments=('x', '__ns:=/b')) == []
    assert find(UNNAMED, replace(STATE, executable='listener')) == []
    # what belongs to no package is no node
    program = replace(UNNAMED, package=None)
    assert find(program, replace(STATE, package=None)) == []


@pytest.mark.parametrize(
    ('nodes', 'text'),
    [
        (['/a'], 'so /a runs twice: '),
        (['/a', '/b'], 'so /a and /b run twice: '),
        (['/a', '/b', '/c'], 'so /a, /b and /c run twice: '),
        ([f'/{n}' for n in range(9)], 'so /0, /1, /2 and 6 more run twice: '),
    ],
)
def test_the_warning_names_nodes_and_the_way_out(
    nodes: list[str], text: str
) -> None:
    warning = doubled_nodes.warning(nodes, OTHER)
    assert text in warning
    assert 'runs already (pid 4711)' in warning
    assert 'colcon launch --stop --of 4711' in warning


def test_a_launch_says_that_its_nodes_run_already(user: User) -> None:
    user.environment.pop('ROS_DOMAIN_ID', None)
    plan = Plan(
        (replace(NAMED, argv=('sleep', '99'), cwd=str(user.root)),),
    )
    user.write('plan.json', plan_to_json(plan))
    first = user.start('colcon', 'launch', '--from-plan', 'plan.json')
    first.wait_for('started')
    output = user.launch('--from-plan', 'plan.json', '--for', '0.1')
    pid = first.process.pid
    assert f'warning: plan.json runs already (pid {pid}), so /a/talk' in output
    user.environment['ROS_DOMAIN_ID'] = '5'
    output = user.launch('--from-plan', 'plan.json', '--for', '0.1')
    assert 'runs already' not in output
    assert first.interrupt() == 0
    output = user.launch('--from-plan', 'plan.json', '--for', '0.1')
    assert 'runs already' not in output
