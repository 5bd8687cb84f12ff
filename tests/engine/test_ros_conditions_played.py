# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What counts as ready after the end of a process, in a played graph."""

from types import SimpleNamespace
from typing import Any

from colcon_yamllaunch.engine.ros_conditions import (
    Conditions,
    FORGET_DELAY,
    LOOK_INTERVAL,
)
import pytest

LIDAR = '/drivers/lidar'


class Ros:
    """A ROS node that sees what a test says, and a clock."""

    def __init__(self) -> None:
        self.node = self
        self.publishers: dict[str, list[bytes]] = {}
        self.services: list[str] = []
        self.nodes: list[str] = []
        self.looks = 0
        self.answers: dict[int, dict[str, Any]] = {}
        self.now = 100.0
        self._last = 0
        self.conditions = Conditions(self)  # type: ignore[arg-type]

    def answer(self, request: int, **fields: Any) -> None:
        self.answers[request] = fields

    def get_publishers_info_by_topic(self, topic: str, **_: bool) -> list[Any]:
        self.looks += 1
        return [
            SimpleNamespace(
                endpoint_gid=gid, node_name='lidar', node_namespace='/drivers'
            )
            for gid in self.publishers.get(topic, [])
        ]

    def get_service_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [(name, []) for name in self.services]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return [
            (n.rpartition('/')[2], n.rpartition('/')[0]) for n in self.nodes
        ]

    def ask(self, kind: str, name: str) -> int:
        self._last += 1
        self.conditions.begin(
            {'id': self._last, 'kind': kind, 'name': name, 'member': 'a'}
        )
        self.passes(LOOK_INTERVAL)
        return self._last

    def passes(self, seconds: float) -> None:
        """Let time pass, and look where that is due."""
        self.now += seconds
        self.conditions.look(self.now)

    def changes(self) -> None:
        """Let the graph have changed."""
        self.conditions.look_soon()
        self.passes(LOOK_INTERVAL)


@pytest.fixture
def ros(monkeypatch: pytest.MonkeyPatch) -> Ros:
    made = Ros()
    clock = SimpleNamespace(monotonic=lambda: made.now)
    name = 'colcon_yamllaunch.engine.ros_conditions.time'
    monkeypatch.setattr(name, clock)
    return made


def test_a_publisher_of_another_process_counts_after_a_while(ros: Ros) -> None:
    ros.publishers['/scan'] = [b'other']
    assert ros.ask('topic', '/scan') in ros.answers
    ros.conditions.lose('a')
    request = ros.ask('topic', '/scan')
    ros.passes(FORGET_DELAY - 1)
    assert request not in ros.answers
    assert ros.conditions.due == 100.0 + LOOK_INTERVAL + FORGET_DELAY
    ros.passes(1)
    assert request in ros.answers


def test_a_new_publisher_counts_at_once(ros: Ros) -> None:
    ros.publishers['/scan'] = [b'crashed']
    ros.ask('topic', '/scan')
    ros.conditions.lose('a')
    request = ros.ask('topic', '/scan')
    assert request not in ros.answers
    ros.publishers['/scan'].append(b'new')
    ros.changes()
    assert request in ros.answers


def test_a_publisher_that_left_and_comes_back_counts(ros: Ros) -> None:
    ros.publishers['/scan'] = [b'same']
    ros.ask('topic', '/scan')
    ros.conditions.lose('a')
    request = ros.ask('topic', '/scan')
    ros.publishers.clear()
    ros.changes()
    ros.publishers['/scan'] = [b'same']
    ros.changes()
    assert request in ros.answers


def test_the_end_of_another_member_does_not_matter(ros: Ros) -> None:
    ros.publishers['/scan'] = [b'x']
    ros.ask('topic', '/scan')
    ros.conditions.lose('b')
    assert ros.ask('topic', '/scan') in ros.answers


def test_a_node_that_vanishes_bit_by_bit_does_not_count(ros: Ros) -> None:
    ros.nodes = [LIDAR]
    ros.publishers = {'/rosout': [b'1'], '/parameter_events': [b'2']}
    assert ros.ask('node', LIDAR) in ros.answers
    ros.conditions.lose('a')
    request = ros.ask('node', LIDAR)
    ros.publishers = {'/rosout': [b'1']}
    ros.changes()
    ros.publishers = {}
    ros.changes()
    assert request not in ros.answers
    ros.nodes = []
    ros.changes()
    ros.nodes = [LIDAR]
    ros.changes()
    assert request in ros.answers


@pytest.mark.parametrize(
    ('kind', 'name'),
    [('node', LIDAR), ('service', '/map'), ('action', '/go')],
)
def test_without_identities_what_crashed_has_to_vanish(
    ros: Ros, kind: str, name: str
) -> None:
    ros.nodes = [LIDAR]
    ros.services = ['/map', '/go/_action/send_goal']
    assert ros.ask(kind, name) in ros.answers
    ros.conditions.lose('a')
    request = ros.ask(kind, name)
    assert request not in ros.answers
    services, ros.nodes, ros.services = ros.services, [], []
    ros.changes()
    ros.nodes, ros.services = [LIDAR], services
    ros.changes()
    assert request in ros.answers


def test_looks_are_limited(ros: Ros) -> None:
    ros.ask('topic', '/scan')
    ros.looks = 0
    for _ in range(100):
        ros.conditions.look_soon()
        ros.passes(LOOK_INTERVAL / 10)
    assert 9 <= ros.looks <= 11
    ros.passes(1.0)
    assert ros.conditions.due is None
