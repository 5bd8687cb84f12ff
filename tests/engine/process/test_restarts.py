# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.process.restarts import Restarts
import pytest


class Time:
    """A clock that is put forward."""

    def __init__(self):
        self.now = 1000.0

    def __call__(self):
        return self.now


@pytest.fixture
def time():
    return Time()


@pytest.fixture
def restarts(time):
    restarts = Restarts(time)
    restarts.begin()
    return restarts


def test_each_pause_is_twice_as_long_until_it_is_given_up(restarts, time):
    pauses = []
    while restarts.plan():
        pauses.append(restarts.seconds_to_wait())
        assert not restarts.is_due
        time.now += pauses[-1]
        assert restarts.is_due
        restarts.begin()
    assert pauses == pytest.approx(
        [
            limits.SHORTEST_PAUSE * 2.0**number
            for number in range(limits.CLIENT_RESTARTS)
        ]
    )
    assert restarts.ends == limits.CLIENT_RESTARTS + 1


def test_what_has_run_for_a_while_begins_a_new_row(restarts, time):
    for _ in range(limits.CLIENT_RESTARTS):
        assert restarts.plan()
    restarts.begin()
    time.now += limits.CLIENT_STEADY + 1
    assert restarts.plan()
    assert restarts.ends == 1
    pause = limits.SHORTEST_PAUSE
    assert restarts.seconds_to_wait() == pytest.approx(pause)


def test_another_one_is_started_at_once_and_counts_as_no_end(restarts):
    restarts.plan_at_once()
    assert restarts.is_due
    assert restarts.ends == 0


def test_nothing_is_due_after_it_is_begun_or_cancelled(restarts, time):
    for leave in (restarts.begin, restarts.cancel):
        restarts.plan_at_once()
        leave()
        time.now += 100
        assert not restarts.is_due
        assert restarts.seconds_to_wait() is None
