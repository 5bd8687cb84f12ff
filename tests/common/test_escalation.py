# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import math
import os
import signal

from colcon_yamllaunch.common.escalation import (
    CHECK_INTERVAL,
    Escalation,
    KILL_TIMEOUT,
    Orphan,
    send,
    Targets,
    Timeouts,
)
import pytest

INT, TERM, KILL = signal.SIGINT, signal.SIGTERM, signal.SIGKILL


class FakeTargets(Targets):
    """Processes that exist as long as the test says."""

    def __init__(self, groups=None, *left):
        self.led = groups or {}
        self.left = list(left)
        self.sent = []
        self.searches = 0

    def groups(self):
        return self.led

    def search(self, groups):
        self.searches += 1
        return list(self.left)

    def recheck(self, orphans):
        return [o for o in orphans if o in self.left]

    def send(self, target, step):
        self.sent.append((target, step))

    def taken(self):
        sent, self.sent = self.sent, []
        return sent


def begin(targets, *timeouts, now=0.0):
    """Begin to stop targets, whose process numbers count from 0."""
    escalation = Escalation(targets, dict(enumerate(timeouts)), now)
    escalation.advance(now)
    return escalation


def test_each_group_gets_each_signal_once_at_its_time():
    targets = FakeTargets({10: 0, 11: 1})
    escalation = begin(targets, Timeouts(5, 5), Timeouts(1, 2), now=100.0)
    assert targets.taken() == [(10, INT), (11, INT)]
    escalation.advance(100.5)
    assert targets.taken() == []
    assert escalation.due() == 101.0
    escalation.advance(101.0)
    assert targets.taken() == [(11, TERM)]
    escalation.advance(103.0)
    assert targets.taken() == [(11, KILL)]
    assert escalation.due() == 105.0
    assert escalation.alive() == {0, 1}
    assert escalation.latest_signal() == KILL
    assert not escalation.is_over


@pytest.mark.parametrize(
    ('number', 'timeouts', 'times'),
    [
        # the steps are those of the process that it comes from
        (1, (Timeouts(5, 5), Timeouts(1, 2)), (0.0, 1.0, 3.0)),
        # without time-outs, it has the longest
        (7, (Timeouts(5, 1), Timeouts(1, 7)), (0.0, 5.0, 12.0)),
    ],
)
def test_an_orphan_has_the_time_of_its_process(number, timeouts, times):
    orphan = Orphan(pid=50, birth=1, group=50, number=number)
    targets = FakeTargets({}, orphan)
    escalation = begin(targets, *timeouts)
    for now, step in zip(times, (INT, TERM, KILL), strict=True):
        escalation.advance(now - 0.1)
        assert targets.taken() == ([(orphan, INT)] if step == INT else [])
        escalation.advance(now)
        assert targets.taken() == ([] if step == INT else [(orphan, step)])


def test_what_a_group_was_sent_its_processes_are_not_sent_again():
    targets = FakeTargets({10: 0})
    escalation = begin(targets, Timeouts(5, 5))
    left = Orphan(pid=51, birth=1, group=10, number=0)
    targets.led, targets.left = {}, [left]
    escalation.advance(1.0)
    assert targets.taken() == [(10, INT)]
    escalation.advance(5.0)
    assert targets.taken() == [(left, TERM)]


def test_a_reused_process_id_is_another_process():
    first = Orphan(pid=50, birth=1, group=50, number=0)
    second = Orphan(pid=50, birth=2, group=51, number=0)
    targets = FakeTargets({}, first)
    escalation = begin(targets, Timeouts(5, 5))
    targets.left = [second]
    escalation.advance(1.0)
    assert targets.taken() == [(first, INT), (second, INT)]


def test_escalating_takes_one_step_and_moves_the_next():
    targets = FakeTargets({10: 0})
    escalation = begin(targets, Timeouts(5, 3))
    escalation.escalate(1.0)
    assert targets.taken() == [(10, INT), (10, TERM)]
    assert escalation.due() == 4.0
    escalation.escalate(2.0)
    assert targets.taken() == [(10, KILL)]
    escalation.escalate(2.0)
    assert targets.taken() == []
    assert escalation.latest_signal() == KILL


def test_it_is_over_when_a_search_finds_nothing():
    targets = FakeTargets({}, Orphan(pid=50, birth=1, group=50, number=0))
    escalation = begin(targets, Timeouts(5, 5))
    assert escalation.due() == CHECK_INTERVAL
    targets.left = [Orphan(pid=51, birth=2, group=51, number=0)]
    escalation.advance(1.0)
    assert not escalation.is_over
    assert targets.searches == 2
    targets.left = []
    escalation.advance(1.1)
    assert escalation.is_over
    assert escalation.due() == math.inf


def test_what_survives_sigkill_is_given_up():
    targets = FakeTargets({10: 0})
    escalation = begin(targets, Timeouts(1, 1))
    for now in (1.0, 2.0, 1.9 + KILL_TIMEOUT):
        escalation.advance(now)
        assert not escalation.is_over
    escalation.advance(2.0 + KILL_TIMEOUT)
    assert escalation.is_over
    assert [step for _, step in targets.taken()] == [INT, TERM, KILL]
    assert escalation.alive() == {0}


def test_no_step_is_left_out_where_there_is_no_time():
    targets = FakeTargets({10: 0})
    escalation = Escalation(targets, {0: Timeouts(0, 0)}, 0.0)
    for _ in range(3):
        escalation.advance(1.0)
    assert [step for _, step in targets.taken()] == [INT, TERM, KILL]


def test_it_may_begin_with_a_later_step():
    targets = FakeTargets({10: 0})
    escalation = Escalation(targets, {0: Timeouts(9, 1)}, 0.0, first=TERM)
    escalation.advance(0.0)
    escalation.advance(1.0)
    assert targets.taken() == [(10, TERM), (10, KILL)]


def test_it_runs_to_its_end_by_itself():
    targets = FakeTargets({10: 0})
    time = [0.0]

    def sleep(seconds):
        time[0] += seconds
        if time[0] > 2.0:
            targets.led = {}

    escalation = Escalation(targets, {0: Timeouts(1, 5)}, 0.0)
    escalation.run(lambda: time[0], sleep)
    assert targets.taken() == [(10, INT), (10, TERM)]
    assert time[0] < 2.0 + 2 * CHECK_INTERVAL


@pytest.mark.parametrize('target', [2**22 + 1, Orphan(2**22 + 1, 1, 1, 0)])
def test_a_signal_to_nobody_is_not_sent(target):
    assert not send(target, TERM)


def test_a_stopped_process_gets_its_signal_at_once():
    pid = os.posix_spawn('/bin/sleep', ['sleep', '99'], {}, setpgroup=0)
    os.kill(pid, signal.SIGSTOP)
    assert send(pid, TERM)
    assert os.WTERMSIG(os.waitpid(pid, 0)[1]) == TERM


@pytest.mark.hostile
def test_others_are_looked_for_before_the_first_signal():
    # its parent, which tells whose it is, ends by the signal
    child = Orphan(pid=51, birth=1, group=51, number=0)

    class Family(FakeTargets):
        def send(self, target, step):
            super().send(target, step)
            self.found, self.led = [], {}

        def search(self, groups):
            return list(self.found)

    targets = Family({10: 0}, child)
    targets.found = [child]
    escalation = Escalation(targets, {0: Timeouts(5, 5)}, 0.0)
    escalation.advance(0.0)
    assert targets.taken() == [(10, INT), (child, INT)]
    escalation.advance(5.0)
    assert targets.taken() == [(child, TERM)]
    targets.left = []
    escalation.advance(5.1)
    assert escalation.is_over
