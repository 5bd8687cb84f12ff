# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.engine.schedule import Schedule


def test_what_is_due_is_done_in_order_of_time_then_of_entry():
    schedule = Schedule()
    done = []
    for due, name in ((2.0, 'c'), (1.0, 'a'), (1.0, 'b'), (3.0, 'd')):
        schedule.add(due, lambda name=name: done.append(name))
    schedule.run_due(2.0)
    assert done == ['a', 'b', 'c']
    assert schedule.next_due() == 3.0


def test_what_is_cancelled_is_not_done_and_not_waited_for():
    schedule = Schedule()
    done = []
    schedule.add(1.0, lambda: done.append('cancelled')).cancel()
    assert schedule.next_due() is None
    schedule.run_due(5.0)
    assert done == []


def test_an_action_may_add_another_that_is_due_at_once():
    schedule = Schedule()
    done = []
    schedule.add(1.0, lambda: schedule.add(1.0, lambda: done.append('second')))
    schedule.run_due(1.0)
    assert done == ['second']
