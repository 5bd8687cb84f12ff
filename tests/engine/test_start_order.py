# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What waits for others, how it restarts and stops; see `History`."""

from dataclasses import replace
from itertools import chain, pairwise
import signal

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    ReadyCondition,
    Restart,
)
from colcon_yamllaunch.plan.plan import AfterReady, Timer
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.start_order import cycle_in, stages_of
from hypothesis import given
from hypothesis import strategies as st
import pytest

INT, TERM = signal.SIGINT, signal.SIGTERM
FAILED = Outcome(code=1)
NEVER = (ReadyCondition('log', 'never'),)
HERE = Position('/ws/robot.yaml', 3, 5)


@pytest.fixture
def deployed(process):
    """Return a function that makes an entry with settings."""

    def make(label, *after, inside=None, **fields):
        settings = MemberSettings(HERE, after=after, **fields)
        made = replace(process(label), settings=settings)
        entry = made if inside is None else replace(inside, entries=(made,))
        return AfterReady(after, (entry,)) if after else entry

    return make


def output(label, h, line):
    process = h.supervisor.task(label).process
    h.readiness.handle_output(events.Output(process, 'stdout', line))
    h.turn()


def test_it_starts_once_all_that_it_waits_for_is_ready(history, deployed):
    h = history(
        deployed('a', ready=(ReadyCondition('log', 'up$'),)),
        deployed('b', ready=(ReadyCondition('after', seconds=2.0),)),
        deployed('c', 'a', 'b'),
        deployed('d', 'c'),
    )
    assert h.started() == ['a', 'b']
    assert h.state('c').waits_for == ('a', 'b')
    h.after(2.0)
    assert h.state('c').waits_for == ('a',)
    output('a', h, b'not up yet\n')
    assert h.started() == ['a', 'b']
    output('a', h, b'up\n')
    # without conditions, it is ready when it runs
    assert h.started() == ['a', 'b', 'c', 'd']
    assert [e.member.label for e in h.happened(events.Ready)] == [*'bacd']


def test_a_timer_counts_from_then_on(history, deployed):
    h = history(
        deployed('a', ready=(ReadyCondition('after', seconds=5.0),)),
        deployed('b', 'a', inside=Timer(1.0, ())),
    )
    h.after(5.5)
    assert h.started() == ['a']
    h.after(0.6)
    assert h.started() == ['a', 'b']


@pytest.mark.parametrize(
    ('action', 'started', 'stopped'),
    [('warn', ['a'], []), ('start', ['a', 'b'], []), ('fail', ['a'], [INT])],
)
def test_what_follows_when_it_is_not_ready_in_time(
    history, deployed, action, started, stopped
):
    h = history(
        deployed('a', ready=NEVER, ready_timeout=3.0, on_timeout=action),
        deployed('b', 'a'),
    )
    h.after(10.0)
    (event,) = h.happened(events.NotReady)
    assert "waiting for a line that matches 'never'" in event.text
    assert event.waiting == ('b',)
    assert h.started() == started
    assert h.sent('a') == [INT, TERM][: 2 * len(stopped)]
    assert h.launch.has_failed == (action == 'fail')


def test_without_its_dependency_it_never_starts(history, deployed):
    h = history(deployed('a', ready=NEVER), deployed('b', 'a'))
    h.exit('a')
    assert h.happened(events.NotReady)[0].conditions == ()
    assert [e.member.label for e in h.happened(events.NotStarted)] == ['b']
    assert h.supervisor.done
    assert h.launch.has_failed


def test_one_that_has_done_its_work_stays_ready(history, deployed):
    h = history(
        deployed('setup', ready=(ReadyCondition('log', 'done'),)),
        deployed('slow', ready=(ReadyCondition('after', seconds=9.0),)),
        deployed('b', 'setup', 'slow'),
    )
    output('setup', h, b'done\n')
    h.exit('setup')
    h.after(9.0)
    assert h.started() == ['setup', 'slow', 'b']


def test_it_must_become_ready_again_after_a_restart(history, deployed):
    h = history(
        deployed('a', ready=(ReadyCondition('after', seconds=1.0),)),
        deployed('b', 'a'),
    )
    h.after(1.0)
    h.restart('a')
    h.exit('a')
    assert not h.state('a').is_ready
    h.restart('b')
    h.exit('b')
    assert h.started() == ['a', 'b', 'a']
    h.after(1.0)
    assert h.started() == ['a', 'b', 'a', 'b']


def test_one_that_is_stopped_meanwhile_does_not_start(history, deployed):
    h = history(
        deployed('a', ready=(ReadyCondition('after', seconds=1.0),)),
        deployed('b', 'a'),
    )
    h.after(1.0)
    for label in 'ab':
        h.restart(label)
        h.exit(label)
    h.stop('b')
    h.after(5.0)
    assert h.started() == ['a', 'b', 'a']


def test_dependents_stop_first(history, deployed):
    h = history(deployed('a'), deployed('b', 'a'), deployed('c', 'b'))
    h.supervisor.stop('enough')
    h.turn()
    assert [h.sent(label) for label in 'abc'] == [[], [], [INT]]
    # each stage has its own time
    h.after(5.0)
    assert [h.sent(label) for label in 'abc'] == [[], [], [INT, TERM]]
    h.exit('c')
    assert [h.sent(label) for label in 'ab'] == [[], [INT]]
    h.exit('b')
    h.exit('a')
    assert h.sent('a') == [INT]
    assert h.supervisor.done


def test_a_second_request_stops_all_at_once(history, deployed):
    h = history(deployed('a'), deployed('b', 'a'))
    h.supervisor.stop('enough')
    h.turn()
    h.supervisor.escalate()
    h.turn()
    assert [h.sent(label) for label in 'ab'] == [[TERM], [INT, TERM]]


def test_the_delay_doubles_and_the_restarts_are_limited(history, deployed):
    restart = Restart('failure', 3, 60.0, 0.5, 1.5)
    h = history(deployed('a', restart=restart), deployed('b'))
    delays = []
    for _ in range(4):
        h.exit('a', FAILED)
        delays.append(h.happened(events.Exited)[-1].respawn_delay)
        h.after(delays[-1] or 0.0)
    assert delays == [0.5, 1.0, 1.5, None]
    assert h.happened(events.RestartLimit)[0].restarts == 3
    assert h.sent('b') == [INT]
    assert h.launch.has_failed


def test_restarts_that_are_long_ago_do_not_count(history, deployed):
    restart = Restart('always', 1, 10.0, 0.5, 4.0, 'leave')
    h = history(deployed('a', restart=restart), deployed('b'))
    for _ in range(5):
        h.exit('a')
        h.after(11.0)
    assert len(h.started()) == 7
    # nor is the delay doubled any more
    assert {e.respawn_delay for e in h.happened(events.Exited)} == {0.5}
    h.exit('a')
    h.after(0.5)
    h.exit('a')
    assert len(h.happened(events.RestartLimit)) == 1
    assert not h.supervisor.is_stopping


def test_one_that_ends_the_launch_does_not_start_those_that_are_due(
    history, deployed
):
    once = Restart('always', 1, None, 1.0, 1.0)
    h = history(deployed('a', restart=once), deployed('b', restart=once))
    h.exit('a')
    h.exit('b')
    h.host.refused.add('a')
    h.after(1.0)
    assert h.happened(events.RestartLimit)[0].process.label == 'a'
    assert h.started() == ['a', 'b']
    assert h.supervisor.done


def test_the_end_of_one_that_is_required_is_no_limit(history, deployed):
    restart = Restart('always', 5, 60.0)
    a = replace(deployed('a', restart=restart), on_exit_shutdown=True)
    h = history(a, deployed('b'))
    h.exit('a')
    assert not h.happened(events.RestartLimit)
    assert h.happened(events.ShuttingDown)[0].reason == 'a ended'


@pytest.mark.parametrize(
    ('when', 'outcome', 'starts'),
    [
        ('never', FAILED, 1),
        ('failure', Outcome(code=0), 1),
        ('failure', FAILED, 2),
        ('always', Outcome(code=0), 2),
    ],
)
def test_which_ends_are_followed_by_a_restart(
    history, process, when, outcome, starts
):
    # what the launch file says is replaced
    respawning = process('a', respawn=True, respawn_delay=9.0)
    settings = MemberSettings(HERE, restart=Restart(when, first_delay=1.0))
    h = history(replace(respawning, settings=settings), process('b'))
    h.exit('a', outcome)
    h.after(2.0)
    assert h.started().count('a') == starts
    assert not h.happened(events.RestartLimit)


def test_others_are_restarted_with_it(history, deployed):
    restart = Restart('failure', together=('b',))
    h = history(
        deployed('a', restart=restart, ready=(ReadyCondition('log', 'up'),)),
        deployed('b', 'a'),
        deployed('c'),
    )
    output('a', h, b'up\n')
    h.exit('a', FAILED)
    assert h.started() == ['a', 'c', 'b', 'a']
    assert [h.sent(label) for label in 'bc'] == [[INT], []]
    h.exit('b')
    assert h.started() == ['a', 'c', 'b', 'a']
    output('a', h, b'up\n')
    assert h.started() == ['a', 'c', 'b', 'a', 'b']


def test_a_command_must_succeed_before_a_restart(history, deployed):
    restart = Restart('failure', 2, 60.0, 1.0, 1.0, command=('cycle', 'usb'))
    h = history(deployed('a', restart=restart))
    h.exit('a', FAILED)
    h.after(1.0)
    assert h.started() == ['a']
    ((argv, label, ended),) = h.host.commands
    assert (argv, label) == (('cycle', 'usb'), 'a')
    ended(1)
    h.after(1.0)
    h.host.commands[-1][2](0)
    h.turn()
    assert h.started() == ['a', 'a']
    # the command that failed counts
    h.exit('a', FAILED)
    assert len(h.happened(events.RestartLimit)) == 1


def test_the_failure_of_one_that_is_critical_ends_the_launch(
    history, deployed
):
    h = history(deployed('a', critical=True), deployed('b'))
    h.exit('a', FAILED)
    assert h.sent('b') == [INT]
    assert h.launch.has_failed


def test_the_end_of_one_that_is_critical_is_no_failure(history, deployed):
    h = history(deployed('a', critical=True), deployed('b'))
    h.exit('a')
    assert h.sent('b') == []


def test_the_failure_of_one_that_is_optional_does_not_count(history, deployed):
    h = history(deployed('a', optional=True), deployed('b'))
    h.exit('a', FAILED)
    h.exit('b')
    assert not h.launch.has_failed


def test_other_conditions_apply_to_one_that_is_not_ready(history, deployed):
    h = history(deployed('a', ready=NEVER), deployed('b', 'a'))
    h.after(2.0)
    _, b = (h.supervisor.task(label).process for label in 'ab')
    other = ReadyCondition('after', seconds=1.0)
    settings = MemberSettings(HERE, ready=(other,))
    a = replace(h.supervisor.task('a').process, settings=settings)
    h.supervisor.revise(a, at_once=True)
    h.after(1.0)
    assert h.started() == ['a', 'b']
    (event,) = h.happened(events.Ready)[:1]
    assert event.seconds == pytest.approx(3.0)
    assert h.launch.after == {'a': (), 'b': ('a',)}
    # where it stands does not matter
    count = len(h.happened(events.Planned))
    moved = replace(b.settings, position=Position('/ws/robot.yaml', 9, 9))
    h.supervisor.revise(replace(b, settings=moved), at_once=True)
    assert len(h.happened(events.Planned)) == count


@pytest.mark.parametrize('others', [(), ('c',)])
def test_one_that_waits_may_wait_for_others_instead(history, deployed, others):
    h = history(
        deployed('a', ready=NEVER),
        deployed('b', 'a'),
        deployed('c', ready=(ReadyCondition('after', seconds=5.0),)),
    )
    h.after(1.0)
    b = h.supervisor.task('b').process
    b = replace(b, settings=replace(b.settings, after=others))
    h.supervisor.revise(b, at_once=True)
    h.turn()
    assert h.started() == ['a', 'c', 'b'][: 3 - len(others)]
    assert h.state('b').waits_for == others
    h.after(5.0)
    assert h.started() == ['a', 'c', 'b']


LABELS = st.sampled_from('abcdef')
GRAPHS = st.dictionaries(LABELS, st.lists(LABELS, max_size=3), min_size=1)


@given(GRAPHS)
def test_there_are_stages_unless_there_is_a_cycle(after):
    known = {
        label: [other for other in others if other in after]
        for label, others in after.items()
    }
    cycle = cycle_in(known)
    if cycle:
        assert cycle[0] == cycle[-1]
        for label, other in pairwise(cycle):
            assert other in known[label]
        return
    stages = stages_of(known)
    assert sorted(chain.from_iterable(stages)) == sorted(known)
    place = {label: n for n, stage in enumerate(stages) for label in stage}
    for label, others in known.items():
        assert place[label] == max((place[o] + 1 for o in others), default=0)
