# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Who gets a call, when containers end and others take their places."""

from types import SimpleNamespace
from typing import Any

from colcon_yamllaunch.engine.ros_client import Call, CONNECTING, Peer
import pytest
from support.played_graph import Graph


class Box(Peer):
    """A peer that keeps in mind what it told, and a clock for it."""

    def __init__(self) -> None:
        self.graph = Graph()
        self.told: list[bool] = []
        self.answers: dict[int, object] = {}
        self.now = 100.0
        ros: Any = SimpleNamespace(node=self.graph, look_soon=bool)
        services = {'load': None, 'list': None}
        super().__init__(ros, '/box', 'container', services)

    def on_presence(self) -> None:
        self.told.append(self.is_present)

    def has(self, *servers: int) -> None:
        """Let these be visible."""
        self.graph.servers = list(servers)
        self.check(self.now)

    def later(self) -> None:
        """Let those that are visible be connected."""
        self.now += 2 * CONNECTING
        self.check(self.now)

    def asked(self, number: int) -> None:
        def answered(response: object) -> None:
            self.answers[number] = response

        message = f'load {number}'
        self.call_in_order(Call(number, 'load', message, answered, answered))

    @property
    def sent(self) -> list[str]:
        return [future.message for future in self.graph.sent]


ENDED = 'the container has ended'


@pytest.fixture
def box(monkeypatch: pytest.MonkeyPatch) -> Box:
    made = Box()
    clock = SimpleNamespace(monotonic=lambda: made.now)
    name = 'colcon_yamllaunch.engine.ros_client.time'
    monkeypatch.setattr(name, clock)
    return made


def test_ordered_calls_are_sent_one_by_one(box: Box) -> None:
    box.asked(1)
    box.asked(2)
    assert box.is_unsettled
    box.has(7)
    assert box.told == [True]
    assert not box.is_unsettled
    assert box.sent == ['load 1']
    box.graph.sent[0].respond('one')
    assert box.sent == ['load 1', 'load 2']
    box.graph.sent[1].respond('two')
    assert box.answers == {1: 'one', 2: 'two'}
    box.has(7)
    assert len(box.sent) == 2


def test_unconnected_server_is_checked_again(box: Box) -> None:
    box.graph.is_ready = False
    box.has(7)
    assert not box.told
    assert box.is_unsettled
    box.graph.is_ready = True
    box.later()
    assert box.told == [True]


def test_server_named_late_gets_a_call_once(box: Box) -> None:
    box.asked(1)
    box.graph.tells_servers = False
    box.has(7)
    assert box.sent == ['load 1']
    box.graph.tells_servers = True
    box.has(7)
    box.later()
    assert (box.sent, box.told) == (['load 1'], [True])
    box.has()
    assert box.answers == {1: ENDED}


def test_server_that_leaves_fails_its_own_call_only(box: Box) -> None:
    box.asked(1)
    box.asked(2)
    box.has(7)
    box.has()
    assert box.told == [True, False]
    assert box.answers == {1: ENDED}
    box.has(8)
    assert box.sent == ['load 1', 'load 2']


def test_ended_server_is_ignored_while_visible(box: Box) -> None:
    box.asked(1)
    box.has(7)
    box.lose()
    assert box.answers == {1: ENDED}
    box.asked(2)
    box.has(7)
    assert box.told == [True, False]
    box.has(7, 8)
    # the connections that are counted may be those of the other one
    assert box.told == [True, False]
    assert box.is_unsettled
    box.later()
    assert box.told == [True, False, True]
    assert box.sent == ['load 1', 'load 2']
    box.has(8)
    assert box.told == [True, False, True]


def test_call_to_an_ended_server_is_sent_again_once(box: Box) -> None:
    box.has(7)
    box.asked(1)
    box.has(7, 8)
    box.later()
    assert box.told == [True, False, True]
    assert box.sent == ['load 1', 'load 1']
    box.has(7, 8, 9)
    box.later()
    assert box.answers == {1: ENDED}
    assert box.sent == ['load 1', 'load 1']


def test_late_response_to_a_repeated_call_counts_once(box: Box) -> None:
    box.has(7)
    box.asked(1)
    box.has(7, 8)
    box.later()
    box.graph.sent[0].respond('too late')
    assert not box.answers
    box.graph.sent[1].respond('one')
    assert box.answers == {1: 'one'}


def test_running_call_is_cancelled_and_makes_room(box: Box) -> None:
    box.asked(1)
    box.asked(2)
    box.has(7)
    assert box.cancel(1)
    assert box.sent == ['load 1', 'load 2']
    box.graph.sent[1].respond('two')
    box.has()
    assert box.answers == {1: 'cancelled', 2: 'two'}


def test_middleware_without_server_identities(box: Box) -> None:
    box.graph.tells_servers = False
    box.asked(1)
    box.has(7)
    assert box.sent == ['load 1']
    box.lose()
    assert box.answers == {1: ENDED}
    box.asked(2)
    box.has(7)
    assert box.told == [True, False]
    box.has()
    box.has(8)
    assert box.told == [True, False, True]
    assert box.sent == ['load 1', 'load 2']


def test_immediate_call_of_a_missing_server_is_refused(box: Box) -> None:
    reasons: list[str] = []
    box.call(Call(1, 'load', 'list', reasons.append, reasons.append))
    assert reasons == ['not there']


def test_each_service_has_its_own_connection(box: Box) -> None:
    reasons: list[str] = []
    box.graph.unconnected = {'list'}
    box.has(7)
    box.call(Call(1, 'list', 'list', reasons.append, reasons.append))
    assert not box.sent
    assert box.is_unsettled
    box.graph.unconnected = set()
    box.later()
    box.later()
    assert (box.sent, box.is_unsettled) == (['list'], False)
    box.graph.sent[0].respond('nothing')
    assert reasons == ['nothing']


def test_call_in_order_waits_for_its_own_service(box: Box) -> None:
    box.graph.unconnected = {'list'}
    box.has(7)
    answers: list[str] = []
    box.call_in_order(Call(1, 'list', 'list', answers.append, answers.append))
    assert not box.sent
    assert box.is_unsettled
    # and for the next one, if that one goes
    box.has()
    assert not answers
    box.graph.unconnected = set()
    box.has(8)
    assert box.sent == ['list']


def test_call_for_one_server_is_not_sent_to_another(box: Box) -> None:
    reasons: list[str] = []
    box.has(7)
    box.call(Call(1, 'load', 'unload 3', reasons.append, reasons.append))
    box.has(7, 8)
    box.later()
    assert reasons == [ENDED]
    assert box.sent == ['unload 3']
