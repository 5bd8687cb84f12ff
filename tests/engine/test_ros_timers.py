# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Timers on ROS time, in launches that are replayed without ROS."""

from colcon_yamllaunch.engine.events import Warned
from colcon_yamllaunch.plan.plan import Timer
import pytest
from support.history import History


@pytest.fixture
def history(process):
    """Return a function that begins a launch whose second entry is a timer."""

    def begin(timer=None):
        timer = timer or Timer(3.0, (process('b'),), on_ros_time=True)
        made = History(process('a'), timer)
        made.turn()
        return made

    return begin


@pytest.fixture
def clocked(history):
    """Return a launch with a timer on ROS time, and a client."""
    made = history()
    made.ready()
    return made


def clock(history, seconds):
    history.says(event='clock', seconds=seconds)


def test_a_timer_runs_on_the_clock(clocked):
    h = clocked
    assert len(h.open('clock')) == 1
    clock(h, 1000.0)
    h.after(60.0)
    clock(h, 1002.9)
    assert h.started() == ['a']
    clock(h, 1003)
    assert h.started() == ['a', 'b']
    assert not h.happened(Warned)


def test_clock_set_back_keeps_passed_time(clocked):
    h = clocked
    clock(h, 50.0)
    clock(h, 52.0)
    clock(h, 0.0)
    clock(h, 0.9)
    assert h.started() == ['a']
    clock(h, 1.0)
    assert h.started() == ['a', 'b']


def test_missing_clock_is_reported(clocked):
    h = clocked
    h.after(5.1)
    (warned,) = h.happened(Warned)
    assert '/clock' in warned.text
    h.after(5.0)
    assert len(h.happened(Warned)) == 1
    clock(h, 1.0)
    h.after(1000.0)
    assert len(h.happened(Warned)) == 1


def test_new_client_follows_the_clock(clocked):
    h = clocked
    clock(h, 10.0)
    clock(h, 12.0)
    h.composition.client_died()
    h.ready()
    assert len(h.open('clock')) == 2
    clock(h, 13.0)
    assert h.started() == ['a', 'b']


def test_launch_with_timers_ends_without_a_client(history):
    h = history()
    h.composition.client_given_up('it died')
    h.exit('a')
    assert h.supervisor.done


def test_a_shutdown_does_not_wait_for_the_clock(history):
    h = history(Timer(3.0, (), cancel_on_shutdown=False, on_ros_time=True))
    h.supervisor.stop('interrupted')
    h.exit('a')
    assert h.supervisor.done


def test_a_timer_after_the_last_client_is_dropped(history, process):
    later = Timer(3.0, (process('b'),), on_ros_time=True)
    h = history(Timer(1.0, (later,)))
    h.composition.client_given_up('it died')
    h.after(1.1)
    h.exit('a')
    assert h.supervisor.done
