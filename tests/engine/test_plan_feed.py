# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A source of more plan, played, and what it is told."""

import os

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.events import HostLost
from colcon_yamllaunch.engine.events import Output
from colcon_yamllaunch.engine.events import PlanFailed
from colcon_yamllaunch.engine.events import ShuttingDown
from colcon_yamllaunch.engine.events import Started
from colcon_yamllaunch.engine.plan_feed import PlanFeed
from colcon_yamllaunch.plan.plan import Block
from colcon_yamllaunch.plan.plan import Growth
from colcon_yamllaunch.plan.plan import Message
from colcon_yamllaunch.plan.plan import Shutdown
from colcon_yamllaunch.plan.position import Position
import pytest
from support.test_loop import TestLoop


class Source:
    """Takes note of what it is told, and answers when the test says so."""

    number = 1_000_000
    pid = 4711

    def __init__(self):
        self.descriptor, self.answers = os.pipe()
        self.wants_output = frozenset()
        self.told = []
        self.calls = []
        self.coming = []
        self.is_busy = False
        self.takes_all = True

    def handle(self, event):
        self.told.append(event)

    def output(self, process, stream, data):
        self.told.append((process, stream, data))

    def flush(self):
        return self.takes_all

    def call(self, number):
        self.calls.append(number)

    def take(self):
        os.read(self.descriptor, 1)
        coming, self.coming = self.coming, []
        return coming

    def ended(self, status):
        self.pid = 0
        return [Growth((Message('INFO', 'last words'),))]

    def close(self):
        self.told.append('close')


class Launch:
    """A feed, and what it has done to the launch."""

    def __init__(self):
        self.source = Source()
        self.loop = TestLoop()
        self.done = []
        self.feed = PlanFeed(
            self.source,
            self.loop,
            lambda entries: self.done.append(list(entries)),
            self.done.append,
        )
        self.feed.begin()

    def answers(self, *growths):
        self.source.coming.extend(growths)
        os.write(self.source.answers, b'.')
        self.loop.turn(1)

    def close(self):
        self.feed.close()
        self.loop.close()
        os.close(self.source.descriptor)
        os.close(self.source.answers)


@pytest.fixture
def launch():
    made = Launch()
    yield made
    made.close()


def test_the_blocks_of_the_plan_are_those_of_its_last_growth(launch):
    blocks = (
        Block('group', '/left', Position('/ws/a.launch.py', 7, 1), None),
    )
    launch.answers(Growth(blocks=blocks), Growth())
    assert launch.feed.blocks == blocks


def test_it_is_told_all_but_output_that_nobody_wants(launch, process):
    a, b = process('a', name='a-1'), process('b', name='b-2')
    launch.source.wants_output = frozenset(['b-2'])
    happened = [
        Started(a, 12),
        Output(a, 'stdout', b'one\n'),
        Output(b, 'stderr', b'two\n'),
        ShuttingDown('enough'),
    ]
    for event in happened:
        launch.feed.handle(event)
    launch.feed.call(3)
    assert launch.source.told == [
        happened[0],
        ('b-2', 'stderr', b'two\n'),
        happened[3],
    ]
    assert launch.source.calls == [3]


def test_what_it_has_not_taken_is_sent_soon(launch):
    launch.feed.flush()
    assert launch.loop.next_due() is None
    launch.source.takes_all = False
    for _ in range(3):
        launch.feed.flush()
    assert launch.loop.next_due() == pytest.approx(limits.SOURCE_PAUSE)


def test_who_writes_too_much_is_held_up_while_it_works(launch, process):
    a, b = process('a', name='a-1'), process('b', name='b-2')
    launch.source.wants_output = frozenset(['a-1'])
    launch.source.is_busy = True
    half = b'x' * (limits.STREAM_BACKLOG // 2)
    for one in (a, b, b):
        launch.feed.handle(Output(one, 'stdout', half))
    assert launch.feed.accepts('a')
    launch.feed.handle(Output(a, 'stdout', half))
    assert not launch.feed.accepts('a')
    assert launch.feed.accepts('b')
    launch.source.is_busy = False
    assert launch.feed.accepts('a')


def test_what_it_answers_comes_to_the_plan_in_order(launch):
    first, second = Message('INFO', '1'), Message('INFO', '2')
    launch.answers(Growth((first,)), Growth(), Growth((second,)))
    assert launch.done == [[first], [second]]


def test_a_problem_ends_the_launch(launch):
    said = Message('INFO', 'before')
    launch.answers(Growth((said,), problems=('error: oh\n  no', 'and')))
    failed, entries = launch.done
    assert failed == PlanFailed(('error: oh', '  no', 'and'))
    # after what went well
    assert entries == [said, Shutdown('a launch file in Python failed')]


def test_the_launch_goes_on_while_an_answer_is_to_come(launch):
    launch.source.is_busy = True
    assert launch.feed.is_waiting()
    launch.loop.now += 1000.0
    assert launch.feed.is_waiting()
    assert launch.loop.next_due() is None
    assert launch.source.told == []


def test_it_is_told_that_nothing_is_left_to_do(launch):
    assert not launch.feed.is_waiting()
    assert launch.source.told == [ShuttingDown('idle')]
    assert not launch.feed.is_waiting()
    assert launch.source.told == [ShuttingDown('idle')]


def test_what_it_says_to_the_end_is_not_awaited_for_ever(launch):
    launch.feed.handle(ShuttingDown('enough'))
    launch.source.is_busy = True
    assert launch.feed.is_waiting()
    assert launch.loop.next_due() == limits.SOURCE_PATIENCE
    launch.loop.now += limits.SOURCE_PATIENCE - 1.0
    assert launch.feed.is_waiting()
    launch.loop.now += 1.0
    assert not launch.feed.is_waiting()


def test_who_is_in_a_hurry_does_not_wait_for_it(launch):
    launch.feed.handle(ShuttingDown('interrupted', interactive=True))
    launch.source.is_busy = True
    launch.feed.hurry()
    assert not launch.feed.is_waiting()


def test_its_end_is_told_once(launch):
    launch.feed.ended(9)
    assert launch.done[0] == [Message('INFO', 'last words')]
    (lost,) = launch.done[1:]
    assert isinstance(lost, HostLost)
    assert 'SIGKILL' in lost.lines()[0]
    assert launch.feed.pid == 0
    launch.source.is_busy = True
    launch.feed.handle(ShuttingDown('enough'))
    assert not launch.feed.is_waiting()
    assert launch.source.told == []


def test_nothing_is_asked_of_one_that_was_closed(launch, process):
    launch.feed.close()
    launch.feed.handle(Started(process('a'), 12))
    launch.feed.call(3)
    assert not launch.feed.is_waiting()
    assert launch.source.told == ['close']
    assert launch.source.calls == []
