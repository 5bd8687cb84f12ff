# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What becomes of a call whose answer does not come."""

import sys
from types import SimpleNamespace
from typing import Any

from colcon_yamllaunch.engine import ros_client
import pytest
from support.played_graph import Graph

#: What stands for the modules of messages.
KIND = SimpleNamespace(
    Request=lambda: SimpleNamespace(transition=SimpleNamespace()),
    Response=SimpleNamespace,
)
SERVICES = ('ChangeState', 'GetState', 'ListNodes', 'LoadNode', 'UnloadNode')
MODULES = ('composition_interfaces.srv', 'lifecycle_msgs.srv')


class Played:
    """The client, with all that is ROS played, and a clock for it."""

    call = ros_client.Ros.call
    answer = ros_client.Ros.answer

    def __init__(self) -> None:
        self.node = Graph()
        self.node.servers = [7]
        self.output = SimpleNamespace(write=self._write)
        self.answers: dict[int, dict[str, Any]] = {}
        self.now = 100.0

    def look_soon(self) -> None:
        """Do nothing: the test looks."""

    def waits(self, peer: ros_client.Peer, seconds: float) -> None:
        """Let time go by."""
        end = self.now + seconds
        while peer.due and min(peer.due) <= end:
            self.now = max(self.now, min(peer.due))
            peer.ask_again(self.now)
        self.now = end

    @property
    def sent(self) -> list[str]:
        """The services that were called."""
        return [service for service, _ in self.node.calls]

    def respond(self, service: str, **fields: Any) -> None:
        """Answer the last call of a service."""
        calls = [one for name, one in self.node.calls if name == service]
        calls[-1].respond(SimpleNamespace(**fields))

    def _write(self, **fields: Any) -> None:
        if 'id' in fields:
            self.answers[fields.pop('id')] = fields


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Played:
    made = Played()
    clock = SimpleNamespace(monotonic=lambda: made.now)
    monkeypatch.setattr(ros_client, 'time', clock)
    kinds = SimpleNamespace(**dict.fromkeys(SERVICES, KIND))
    for module in MODULES:
        monkeypatch.setitem(sys.modules, module, kinds)
    messages = SimpleNamespace()
    monkeypatch.setitem(sys.modules, 'rcl_interfaces.msg', messages)
    return made


@pytest.fixture
def node(played: Played) -> ros_client.LifecycleNode:
    made = ros_client.LifecycleNode(played, '/lc')
    made.check(played.now)
    return made


@pytest.fixture
def box(played: Played) -> ros_client.Container:
    made = ros_client.Container(played, '/box')
    made.check(played.now)
    return made


def _change(node: ros_client.LifecycleNode, transition: str) -> None:
    node.change_state({'id': 1, 'node': '/lc', 'transition': transition})


def _state(played: Played, label: str) -> None:
    state = SimpleNamespace(label=label)
    played.respond('get_state', current_state=state)


def _load(box: ros_client.Container, number: int = 1, **fields: str) -> None:
    request = {'container': '/box', 'package': 'p', 'plugin': 'a::B'}
    box.load({'id': number, **request, **fields})


def _list(played: Played, **nodes: int) -> None:
    names = [f'/{name}' for name in nodes]
    ids = list(nodes.values())
    played.respond('list_nodes', full_node_names=names, unique_ids=ids)


def test_state_confirms_a_change(
    played: Played, node: ros_client.LifecycleNode
) -> None:
    _change(node, 'configure')
    played.waits(node, ros_client.ANSWER_TIMEOUT - 1)
    assert played.sent == ['change_state']
    played.waits(node, 1)
    assert played.sent == ['change_state', 'get_state']
    _state(played, 'inactive')
    assert played.answers == {1: {'ok': True}}
    played.waits(node, 1000)
    assert len(played.sent) == 2


def test_unfinished_change_is_waited_for(
    played: Played, node: ros_client.LifecycleNode
) -> None:
    _change(node, 'configure')
    for n in range(2 * ros_client.MAXIMUM_CHECKS):
        played.waits(node, ros_client.ANSWER_TIMEOUT * 2**n)
        _state(played, 'configuring')
    assert not played.answers
    played.respond('change_state', success=True)
    assert played.answers == {1: {'ok': True}}


def test_change_without_effect_is_given_up(
    played: Played, node: ros_client.LifecycleNode
) -> None:
    _change(node, 'configure')
    for n in range(ros_client.MAXIMUM_CHECKS):
        assert not played.answers
        played.waits(node, ros_client.ANSWER_TIMEOUT * 2**n)
        _state(played, 'unconfigured')
    reason = "there was no answer, and the node is 'unconfigured'"
    assert played.answers == {1: {'ok': False, 'reason': reason}}
    assert played.sent.count('change_state') == 1
    # the next one is not held up
    _change(node, 'configure')
    played.respond('change_state', success=True)
    assert played.answers == {1: {'ok': True}}


@pytest.mark.parametrize('name', ['b', ''])
def test_load_whose_answer_is_lost_is_found_in_the_list(
    played: Played, box: ros_client.Container, name: str
) -> None:
    _load(box, 1)
    played.respond('load_node', success=True, full_node_name='/a', unique_id=4)
    _load(box, 2, name=name)
    _load(box, 3)
    played.waits(box, ros_client.ANSWER_TIMEOUT)
    _list(played, a=4, b=5, **({'c': 6} if name else {}))
    loaded = {'ok': True, 'full_name': '/b', 'unique_id': 5}
    assert played.answers[2] == loaded
    sent = ['load_node', 'load_node', 'list_nodes', 'load_node']
    assert played.sent == sent
    # that one is not the next one
    played.waits(box, ros_client.ANSWER_TIMEOUT)
    _list(played, a=4, b=5)
    assert 3 not in played.answers


def test_load_without_effect_is_given_up_not_repeated(
    played: Played, box: ros_client.Container
) -> None:
    _load(box, 1)
    _load(box, 2)
    for n in range(ros_client.MAXIMUM_CHECKS):
        assert not played.answers
        played.waits(box, ros_client.ANSWER_TIMEOUT * 2**n)
        _list(played)
    reason = 'there was no answer, and the container does not list it'
    assert played.answers == {1: {'ok': False, 'reason': reason}}
    assert played.sent.count('load_node') == 2
    # nobody waits for it any more: what comes of it is unloaded
    late = SimpleNamespace(success=True, full_node_name='/a', unique_id=1)
    played.node.sent[0].respond(late)
    assert played.sent[-1] == 'unload_node'
    assert list(played.answers) == [1]


def test_abandoned_load_is_not_sent_to_the_next_container(
    played: Played, box: ros_client.Container
) -> None:
    _load(box, 1)
    assert box.cancel(1)
    played.node.servers = [7, 8]
    for _ in range(2):
        played.now += 1
        box.check(played.now)
    assert played.sent == ['load_node']


def test_list_confirms_an_unload(
    played: Played, box: ros_client.Container
) -> None:
    box.unload({'id': 1, 'unique_id': 3})
    box.unload({'id': 2, 'unique_id': 4})
    for n in range(ros_client.MAXIMUM_CHECKS):
        played.waits(box, ros_client.ANSWER_TIMEOUT * 2**n)
        for service, future in played.node.calls:
            if service == 'list_nodes':
                listed = {'full_node_names': ['/b'], 'unique_ids': [4]}
                future.respond(SimpleNamespace(**listed))
    reason = 'there was no answer, and the container still lists it'
    assert played.answers == {
        1: {'ok': True},
        2: {'ok': False, 'reason': reason},
    }
    assert played.sent.count('unload_node') == 2
