# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch is to achieve, decided from replayed events."""

import signal

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.events import (
    Exited,
    LoadFailed,
    MemberChanged,
    Output,
    Planned,
    Ready,
    RosLost,
    ShuttingDown,
    Started,
    StartFailed,
    TransitionFailed,
    Waiting,
)
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.line_pattern import LinePattern
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.member_settings import MemberSettings
import pytest
from support.history import component, POSITION

KILLED = Outcome(signal=signal.SIGKILL)


class Replay:
    def __init__(self, *until, **settings):
        self.now = 100.0
        patterns = [LinePattern(text) for text in until]
        self.conditions = ExitConditions(
            patterns, clock=lambda: self.now, **settings
        )
        self.now = 200.0
        self.conditions.begin()

    def after(self, seconds):
        self.now += seconds
        return self

    def hears(self, *events):
        for event in events:
            self.conditions.handle(event)
        return self.conditions.reason_to_stop()

    @property
    def reason(self):
        return self.conditions.reason_to_stop()

    def ends(self):
        self.conditions.end()
        return self.conditions.failures()


@pytest.fixture
def says(process):
    def say(text, **more):
        return Output(process('a', **more), 'stdout', text.encode())

    return say


@pytest.fixture
def fails(process):
    def fail(respawn_delay=None, asked=False):
        outcome = Outcome(signal=signal.SIGSEGV)
        return Exited(
            process('a'), 9, outcome, 1.0, asked, True, respawn_delay
        )

    return fail


def test_nothing_to_achieve(says, fails):
    replay = Replay()
    assert replay.conditions.due() is None
    assert replay.hears(says('ready\n'), fails()) is None
    assert replay.ends() == ()
    assert replay.conditions.verdicts() == ()


def test_all_that_must_be_ready_ends_it(process, says):
    a, b, late = map(process, 'abl')
    replay = Replay('up', ready='ab')
    assert replay.hears(Started(a, 7), Ready(a, 0.5), says('up')) is None
    assert replay.after(2.0).hears(Planned((late,)), Ready(b, 1.0)) is None
    assert replay.after(1.0).hears(Ready(late, 1.0)) == 'all 3 are ready'
    replay.hears(ShuttingDown('enough'), Exited(a, 7, KILLED, 1.0, True, True))
    assert replay.ends() == ()
    seen = [(v.name, v.seconds) for v in replay.conditions.verdicts()]
    assert seen == [('--until up', 0.0), ('--until-ready', 3.0)]


def test_what_is_not_ready_in_time_is_named(process):
    a, b, c = map(process, 'abc')
    replay = Replay(ready='abc', timeout=5.0)
    unmet = ('a publisher of scan',)
    assert (
        replay.hears(
            Started(a, 7),
            MemberChanged(a, unmet=unmet),
            Waiting(b, ('a',)),
            Started(c, 8),
            Ready(c, 0.0),
        )
        is None
    )
    assert replay.after(5.0).reason == '5 s are over'
    assert replay.ends() == (
        '1 of 3 were ready after 5 s (--until-ready): a (waiting for a '
        'publisher of scan), b (waiting for a)',
    )


def test_failure_ends_waiting_for_readiness_unless_it_restarts(process, fails):
    a, b = map(process, 'ab')
    replay = Replay(ready='ab')
    replay.hears(Ready(a, 0.0))
    # it must become ready again
    assert replay.hears(fails(respawn_delay=1.0), Ready(b, 0.0)) is None
    assert replay.hears(Started(a, 9)) is None
    assert replay.hears(fails()) == 'a failed'
    assert replay.ends() == (
        '1 of 2 were ready after 0.0 s, when the launch ended '
        '(--until-ready): a (died by SIGSEGV (segmentation fault))',
    )


def test_a_line_ends_it_once(says):
    replay = Replay('read[y]')
    assert replay.hears(says('starting\n')) is None
    assert replay.conditions.due() is None
    assert replay.hears(says('now\nready\n')) == "'read[y]' was seen"
    assert replay.reason is None
    assert replay.ends() == ()


def test_colours_and_output_modes_do_not_matter(says):
    replay = Replay('which double is 8$')
    line = '\x1b[32mwhich double\x1b[0m is \x1b[1;31m8\x1b[0m\r\n'
    assert replay.hears(says(line, output='own_log')) is not None


def test_one_that_is_optional_is_searched_though_its_failure_is_none(process):
    settings = MemberSettings(POSITION, optional=True)
    pump = process('pump', settings=settings)
    failed = Exited(pump, 9, KILLED, 1.0, False, True)
    replay = Replay('on')
    assert replay.hears(failed) is None
    assert replay.hears(StartFailed(pump, 'no such file')) is None
    assert replay.hears(Output(pump, 'stdout', b'on\n')) is not None
    assert replay.ends() == ()


def test_all_must_match_in_any_order(says):
    replay = Replay('one', 'two', 'one')
    assert replay.hears(says('two\n')) is None
    assert replay.hears(says('one\n')) == (
        'all 2 that --until waits for were seen'
    )


def test_the_time_is_over_and_what_is_missing_is_named(says):
    replay = Replay('one', 'two', timeout=5)
    assert replay.conditions.due() == 205.0
    replay.after(4.9).hears(says('one\n'))
    assert replay.reason is None
    assert replay.after(0.1).reason == '5 s are over'
    # too late
    assert replay.hears(says('two\n')) is None
    assert replay.ends() == ("'two' was not seen in 5 s (--until)",)


def test_a_time_out_leaves_a_launch_alone_that_stops_already():
    replay = Replay(timeout=5)
    replay.hears(ShuttingDown('a ended'))
    assert replay.conditions.due() is None
    assert replay.after(9.0).reason is None
    assert replay.ends() == ()


def test_a_respawn_may_mend_a_failure_while_something_is_waited_for(
    says, fails
):
    replay = Replay('ready')
    assert replay.hears(fails(respawn_delay=0.0)) is None
    assert replay.hears(says('ready\n')) == "'ready' was seen"


def test_no_failure_is_mended_while_it_runs_for_a_time(says, fails):
    replay = Replay(duration=10)
    assert replay.hears(fails(respawn_delay=0.0)) == 'a failed'
    replay = Replay('ready', duration=10)
    assert replay.hears(fails(respawn_delay=0.0)) is None
    replay.hears(says('ready\n'))
    assert replay.hears(fails(respawn_delay=0.0)) == 'a failed'


def test_a_failure_leaves_a_time_out_alone(fails):
    replay = Replay(timeout=5)
    assert replay.hears(fails()) is None


def test_verdicts_say_when(says):
    replay = Replay('one', 'two', timeout=5)
    replay.after(1.5).hears(says('one\n'))
    assert replay.after(3.5).reason is not None
    replay.after(1.0).ends()
    one, two = replay.conditions.verdicts()
    assert (one.name, one.seconds, one.failure) == ('--until one', 1.5, None)
    assert (two.name, two.seconds) == ('--until two', 6.0)
    assert two.failure is not None


@pytest.mark.hostile
def test_an_expression_that_takes_too_long_is_given_up(says, monkeypatch):
    monkeypatch.setattr(limits, 'SLOW_SEARCH_COUNT', 2)
    replay = Replay('(a+)+$', 'one')
    slow = says('a' * 40 + 'b\n')
    assert replay.hears(slow) is None
    assert replay.hears(says('one\n')) is None
    assert replay.hears(slow) == "to search for '(a+)+$' takes too long"
    (failure,) = replay.ends()
    assert "'(a+)+$' was not seen" in failure
    assert 'use a simpler expression' in failure


@pytest.mark.hostile
def test_a_line_that_takes_too_long_is_passed_over(says):
    replay = Replay('[a-z]+ready')
    assert replay.hears(says('x' * 300_000 + '\n')) is None
    assert replay.hears(says('already\n')) == "'[a-z]+ready' was seen"
    assert replay.ends() == ()


@pytest.mark.parametrize(
    ('event', 'reason'),
    [
        (lambda p: StartFailed(p, 'no such file'), 'lc-1 failed'),
        (lambda _: LoadFailed(component(), 'reason'), 'a failed'),
        (lambda _: LoadFailed(component(), 'reason', again=True), None),
        (lambda p: TransitionFailed(p, '/lc', 'configure', ''), 'lc-1 failed'),
        (lambda _: RosLost('reason'), 'the ROS client failed'),
    ],
)
def test_failure_ends_a_launch_that_waits_for_something(
    process, event, reason
):
    failed = event(process('lc-1'))
    replay = Replay('ready')
    assert replay.hears(failed) == reason
    assert replay.ends() != ()
    assert Replay().hears(failed) is None
