# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import math
import signal

from colcon_yamllaunch.common.process_scan import Member
from colcon_yamllaunch.runtime.stopping.escalation import Order
from colcon_yamllaunch.runtime.stopping.escalation import Stopping
from colcon_yamllaunch.runtime.stopping.escalation import Timeouts

INT, TERM, KILL = signal.SIGINT, signal.SIGTERM, signal.SIGKILL


def test_each_group_gets_each_signal_once_at_its_time():
    stopping = Stopping({0: Timeouts(5, 5), 1: Timeouts(1, 2)}, 100.0)
    groups = {10: 0, 11: 1}
    assert stopping.orders(groups, ()) == [
        Order(0, 10, INT),
        Order(1, 11, INT),
    ]
    assert stopping.orders(groups, ()) == []
    assert stopping.next_deadline((0, 1)) == 101.0
    stopping.advance(101.0)
    assert stopping.orders(groups, ()) == [Order(1, 11, TERM)]
    stopping.advance(103.0)
    assert stopping.orders(groups, ()) == [Order(1, 11, KILL)]
    assert stopping.next_deadline((1,)) == math.inf
    assert stopping.next_deadline((0, 1)) == 105.0
    assert stopping.is_final((1,))
    assert not stopping.is_final((0, 1))


def test_a_stray_takes_the_steps_of_the_process_that_it_comes_from():
    stray = Member(pid=50, birth=1, group=50, number=1)
    stopping = Stopping({0: Timeouts(5, 5), 1: Timeouts(1, 2)}, 0.0)
    assert stopping.orders({}, [stray]) == [Order(1, stray, INT)]
    stopping.advance(1.0)
    assert stopping.orders({}, [stray]) == [Order(1, stray, TERM)]


def test_what_a_group_was_sent_its_members_are_not_sent_again():
    left = Member(pid=51, birth=1, group=10, number=0)
    stopping = Stopping({0: Timeouts(5, 5)}, 0.0)
    stopping.orders({10: 0}, ())
    assert stopping.orders({}, [left]) == []
    stopping.advance(5.0)
    assert stopping.orders({}, [left]) == [Order(0, left, TERM)]


def test_a_reused_process_id_is_another_process():
    stopping = Stopping({0: Timeouts(5, 5)}, 0.0)
    first = Member(pid=50, birth=1, group=50, number=0)
    second = Member(pid=50, birth=2, group=51, number=0)
    stopping.orders({}, [first])
    assert stopping.orders({}, [second]) == [Order(0, second, INT)]


def test_to_hurry_takes_one_step_at_once_and_moves_the_next():
    stopping = Stopping({0: Timeouts(5, 3)}, 0.0)
    stopping.orders({10: 0}, ())
    stopping.hurry((0,), 1.0)
    assert stopping.orders({10: 0}, ()) == [Order(0, 10, TERM)]
    assert stopping.next_deadline((0,)) == 4.0
    stopping.hurry((0,), 2.0)
    assert stopping.orders({10: 0}, ()) == [Order(0, 10, KILL)]
    stopping.hurry((0,), 2.0)
    assert stopping.orders({10: 0}, ()) == []
    assert stopping.latest_signal((0,)) == KILL


def test_a_process_of_unknown_origin_has_the_longest_time_outs():
    stray = Member(pid=50, birth=1, group=50, number=-1)
    stopping = Stopping({0: Timeouts(5, 1), 1: Timeouts(1, 7)}, 0.0)
    stopping.orders({}, [stray])
    stopping.advance(4.9)
    assert stopping.orders({}, [stray]) == []
    stopping.advance(5.0)
    assert stopping.orders({}, [stray]) == [Order(-1, stray, TERM)]
    assert stopping.next_deadline((-1,)) == 12.0
