# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Stopping and restarting single processes, replayed without a process."""

import signal

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.common.escalation import WHOLE
from colcon_yamllaunch.engine.events import Exited
from colcon_yamllaunch.engine.events import LeftBehind
from colcon_yamllaunch.engine.events import Requested
from colcon_yamllaunch.engine.events import Started
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Timer
import pytest
from support.history import History

INT, TERM, KILL = signal.SIGINT, signal.SIGTERM, signal.SIGKILL
INTERRUPTED = Outcome(signal=INT)


@pytest.fixture
def course():
    def begin(*entries):
        made = History(*entries)
        made.turn()
        return made

    return begin


def test_a_single_stop_leaves_the_others_alone(course, process):
    c = course(process('a'), process('b'))
    c.stop('a')
    assert c.phases() == ['stopping', 'running']
    assert c.happened(Requested) == [Requested(process('a'), 'stop')]
    c.exit('a', INTERRUPTED)
    assert c.sent('a') == [INT]
    assert c.sent('b') == []
    assert not c.supervisor.is_stopping
    assert c.phases() == ['ended', 'running']
    assert c.state('a').ending == 'stopped'


def test_a_single_stop_takes_the_steps_with_the_processs_timeouts(
    course, process
):
    c = course(
        process('a', sigterm_timeout=1.0, sigkill_timeout=2.0), process('b')
    )
    c.stop('a')
    c.after(0.9)
    assert c.sent('a') == [INT]
    c.after(0.2)
    assert c.sent('a') == [INT, TERM]
    assert c.host.killed == []
    c.after(2.0)
    assert c.sent('a') == [INT, TERM, KILL]
    # and whatever it started since
    assert c.host.killed == [0]
    c.exit('a', Outcome(signal=KILL))
    assert [e.failed for e in c.happened(Exited)] == [False]
    assert c.sent('b') == []


def test_to_ask_again_takes_the_next_step(course, process):
    c = course(process('a'), process('b'))
    for _ in range(3):
        c.stop('a')
    assert c.sent('a') == [INT, TERM, KILL]


def test_what_follows_from_an_end_does_not_follow_from_a_single_stop(
    course, process
):
    c = course(
        process('a', respawn=True),
        process('b', on_exit_shutdown=True),
        process('c'),
    )
    for label in ('a', 'b'):
        c.stop(label)
        c.exit(label, Outcome(code=1))
    c.after(60.0)
    assert c.phases() == ['ended', 'ended', 'running']
    assert [e.failed for e in c.happened(Exited)] == [False, False]
    assert [e.asked for e in c.happened(Exited)] == [True, True]


def test_a_process_that_waits_for_its_respawn_can_be_stopped(course, process):
    c = course(process('a', respawn=True, respawn_delay=5.0), process('b'))
    c.exit('a', Outcome(code=3))
    assert c.phases() == ['respawn', 'running']
    c.stop('a')
    c.after(60.0)
    assert c.phases() == ['ended', 'running']
    assert len(c.happened(Started)) == 2


def test_a_restart_stops_first_and_starts_then(course, process):
    c = course(process('a'), process('b'))
    c.restart('a')
    assert c.sent('a') == [INT]
    assert len(c.happened(Started)) == 2
    c.exit('a', INTERRUPTED)
    assert c.started() == ['a', 'b', 'a']
    assert c.state('a').phase == 'running'
    assert c.state('a').restarts == 1


def test_a_restart_starts_what_has_ended_or_could_not_be_started(
    course, process
):
    c = course(process('a'), process('b'), process('c'))
    c.exit('a', Outcome(code=3))
    assert c.state('a').ending == 'exited with code 3'
    c.restart('a')
    assert c.state('a').phase == 'running'
    c.host.refused.add('b')
    c.restart('b')
    c.exit('b', INTERRUPTED)
    assert c.state('b').ending == 'could not be started: refused'
    c.host.refused.clear()
    c.restart('b')
    assert c.state('b').phase == 'running'


def test_a_restart_gives_all_respawns_back(course, process):
    c = course(process('a', respawn=True, respawn_max_retries=1), process('b'))
    for _ in range(2):
        c.exit('a', Outcome(code=3))
    assert c.state('a').phase == 'ended'
    c.restart('a')
    c.exit('a', Outcome(code=3))
    assert c.state('a').phase == 'running'
    assert c.state('a').restarts == 3


def test_a_stop_wins_over_a_restart_that_is_under_way(course, process):
    c = course(process('a'), process('b'))
    c.restart('a')
    c.stop('a')
    c.exit('a', INTERRUPTED)
    assert c.phases() == ['ended', 'running']


def test_a_restart_waits_until_nothing_of_the_process_is_left(course, process):
    c = course(process('a'), process('b'))
    orphan = Orphan(pid=7, birth=1, group=7, number=0)
    other = Orphan(pid=8, birth=1, group=8, number=1)
    c.host.left = [orphan, other]
    c.restart('a')
    c.exit('a', INTERRUPTED)
    c.after(0.2)
    assert c.state('a').phase == 'stopping'
    assert (7, INT) in c.host.sent
    c.host.left = [other]
    c.after(0.2)
    assert c.state('a').phase == 'running'
    assert 8 not in [pid for pid, _ in c.host.sent]


def test_whose_process_is_unknown_ends_with_the_launch(course, process):
    c = course(process('a', sigterm_timeout=1.0), process('b'))
    c.host.left = [Orphan(pid=7, birth=1, group=7, number=WHOLE)]
    c.stop('a')
    c.exit('a', INTERRUPTED)
    assert c.phases() == ['ended', 'running']
    assert 7 not in [pid for pid, _ in c.host.sent]
    c.supervisor.stop('enough')
    c.exit('b', INTERRUPTED)
    c.after(60.0)
    assert [n for pid, n in c.host.sent if pid == 7] == [INT, TERM, KILL]
    (left,) = c.happened(LeftBehind)
    assert left.process.label == 'unknown process'


def test_what_survives_sigkill_is_named_and_left(course, process):
    quick = {'sigterm_timeout': 0.1, 'sigkill_timeout': 0.1}
    c = course(process('a', **quick), process('b'))
    c.host.left = [Orphan(pid=7, birth=1, group=7, number=0)]
    c.stop('a')
    c.exit('a', INTERRUPTED)
    c.after(30.0)
    assert [(e.process.label, e.pid) for e in c.happened(LeftBehind)] == [
        ('a', 7)
    ]
    assert c.phases() == ['ended', 'running']


def test_a_shutdown_takes_over_a_single_stop(course, process):
    c = course(process('a', sigterm_timeout=1.0), process('b'))
    c.restart('a')
    c.supervisor.stop('enough')
    assert c.phases() == ['stopping', 'stopping']
    c.exit('a', INTERRUPTED)
    c.exit('b', INTERRUPTED)
    assert c.supervisor.done
    assert len(c.happened(Started)) == 2


def test_a_restart_that_fails_may_end_the_launch(course, process):
    c = course(process('a', on_exit_shutdown=True), process('b'), process('c'))
    for label in ('a', 'b'):
        c.supervisor.restart_process(label)
    c.host.refused.add('a')
    for label in ('a', 'b'):
        c.supervisor.exited(c.host.by_label[label], INTERRUPTED)
    c.turn()
    assert c.started() == ['a', 'b', 'c']
    assert c.sent('c') == [INT]
    assert c.phases() == ['ended', 'ended', 'stopping']


def test_the_launch_ends_when_its_last_process_is_stopped(course, process):
    c = course(process('a'))
    c.stop('a')
    assert not c.supervisor.done
    c.exit('a', INTERRUPTED)
    assert c.supervisor.done


def test_the_launch_goes_on_while_its_last_process_is_restarted(
    course, process
):
    c = course(process('a'))
    c.restart('a')
    c.exit('a', INTERRUPTED)
    assert not c.supervisor.done
    assert c.phases() == ['running']


@pytest.mark.parametrize('action', ['stop_process', 'restart_process'])
def test_requests_that_make_no_sense_are_refused(course, process, action):
    c = course(process('a'), Timer(9.0, (process('late'),)))
    ask = getattr(c.supervisor, action)
    with pytest.raises(RefusedError, match="no process 'x'"):
        ask('x')
    assert c.state('late').phase == 'waiting'
    with pytest.raises(RefusedError, match='late has not been started yet'):
        ask('late')
    c.supervisor.stop('enough')
    with pytest.raises(RefusedError, match='launch is being stopped'):
        ask('a')
    assert c.happened(Requested) == []


def test_states_tell_for_how_long(course, process):
    c = course(process('a'), process('b'))
    c.after(3.0)
    assert c.state('a').seconds == 3.0
    c.exit('a', Outcome(code=0))
    c.after(2.0)
    assert (c.state('a').seconds, c.state('a').pid) == (2.0, None)
    assert c.state('a').ending == 'finished'
    assert c.state('b').pid == c.host.by_label['b']
