# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.process.restarts import Restarts
import pytest
from support.test_loop import TestLoop


@pytest.fixture
def loop():
    loop = TestLoop()
    yield loop
    loop.close()


@pytest.fixture
def restarts(loop):
    restarts = Restarts(loop, lambda: restarts.begin())
    restarts.begin()
    return restarts


def test_each_pause_is_twice_as_long_until_it_is_given_up(restarts, loop):
    pauses = []
    while restarts.plan():
        pauses.append(loop.next_due())
        loop.pass_time(pauses[-1])
        assert loop.next_due() is None
    assert pauses == pytest.approx(
        [
            limits.SHORTEST_PAUSE * 2.0**number
            for number in range(limits.CLIENT_RESTARTS)
        ]
    )
    assert restarts.ends == limits.CLIENT_RESTARTS + 1


def test_what_has_run_for_a_while_begins_a_new_row(restarts, loop):
    for _ in range(limits.CLIENT_RESTARTS):
        assert restarts.plan()
    restarts.begin()
    loop.now += limits.CLIENT_STEADY + 1
    assert restarts.plan()
    assert restarts.ends == 1
    pause = limits.SHORTEST_PAUSE
    assert loop.next_due() == pytest.approx(pause)


def test_another_one_is_started_at_once_and_counts_as_no_end(restarts, loop):
    restarts.plan_at_once()
    assert loop.next_due() == 0.0
    assert restarts.ends == 0


def test_nothing_is_due_after_it_is_begun_or_cancelled(restarts, loop):
    for leave in (restarts.begin, restarts.cancel):
        assert restarts.plan()
        leave()
        assert loop.next_due() is None
