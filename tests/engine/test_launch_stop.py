# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Stopping and restarting single processes, replayed without a process."""

import signal

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.common.escalation import Orphan, WHOLE
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Timer
import pytest

INT, TERM, KILL = signal.SIGINT, signal.SIGTERM, signal.SIGKILL
INTERRUPTED = Outcome(signal=INT)


def test_a_single_stop_leaves_the_others_alone(history, process):
    h = history(process('a'), process('b'))
    h.stop('a')
    assert h.phases() == ['stopping', 'running']
    assert h.happened(events.Requested) == [
        events.Requested(process('a'), 'stop')
    ]
    h.exit('a', INTERRUPTED)
    assert h.sent('a') == [INT]
    assert h.sent('b') == []
    assert not h.supervisor.is_stopping
    assert h.phases() == ['ended', 'running']
    assert h.state('a').ending == 'stopped'


def test_a_single_stop_takes_the_steps_with_the_processs_timeouts(
    history, process
):
    timeouts = {'sigterm_timeout': 1.0, 'sigkill_timeout': 2.0}
    h = history(process('a', **timeouts), process('b'))
    h.stop('a')
    h.after(0.9)
    assert h.sent('a') == [INT]
    h.after(0.2)
    assert h.sent('a') == [INT, TERM]
    assert h.host.killed == []
    h.after(2.0)
    assert h.sent('a') == [INT, TERM, KILL]
    # and whatever it started since
    assert h.host.killed == [0]
    h.exit('a', Outcome(signal=KILL))
    assert [e.failed for e in h.happened(events.Exited)] == [False]
    assert h.sent('b') == []


def test_to_ask_again_takes_the_next_step(history, process):
    h = history(process('a'), process('b'))
    for _ in range(3):
        h.stop('a')
    assert h.sent('a') == [INT, TERM, KILL]


def test_what_follows_from_an_end_does_not_follow_from_a_single_stop(
    history, process
):
    required = process('b', on_exit_shutdown=True)
    h = history(process('a', respawn=True), required, process('c'))
    for label in ('a', 'b'):
        h.stop(label)
        h.exit(label, Outcome(code=1))
    h.after(60.0)
    assert h.phases() == ['ended', 'ended', 'running']
    assert [e.failed for e in h.happened(events.Exited)] == [False, False]
    assert [e.asked for e in h.happened(events.Exited)] == [True, True]


def test_a_process_that_waits_for_its_respawn_can_be_stopped(history, process):
    h = history(process('a', respawn=True, respawn_delay=5.0), process('b'))
    h.exit('a', Outcome(code=3))
    assert h.phases() == ['respawn', 'running']
    h.stop('a')
    h.after(60.0)
    assert h.phases() == ['ended', 'running']
    assert len(h.happened(events.Started)) == 2


def test_a_restart_stops_first_and_starts_then(history, process):
    h = history(process('a'), process('b'))
    h.restart('a')
    assert h.sent('a') == [INT]
    assert len(h.happened(events.Started)) == 2
    h.exit('a', INTERRUPTED)
    assert h.started() == ['a', 'b', 'a']
    assert h.state('a').phase == 'running'
    assert h.state('a').restarts == 1


def test_a_restart_starts_what_has_ended_or_could_not_be_started(
    history, process
):
    h = history(process('a'), process('b'), process('c'))
    h.exit('a', Outcome(code=3))
    assert h.state('a').ending == 'exited with code 3'
    h.restart('a')
    assert h.state('a').phase == 'running'
    h.host.refused.add('b')
    h.restart('b')
    h.exit('b', INTERRUPTED)
    assert h.state('b').ending == 'could not be started: refused'
    h.host.refused.clear()
    h.restart('b')
    assert h.state('b').phase == 'running'


def test_a_restart_gives_all_respawns_back(history, process):
    h = history(
        process('a', respawn=True, respawn_max_retries=1), process('b')
    )
    for _ in range(2):
        h.exit('a', Outcome(code=3))
    assert h.state('a').phase == 'ended'
    h.restart('a')
    h.exit('a', Outcome(code=3))
    assert h.state('a').phase == 'running'
    assert h.state('a').restarts == 3


def test_a_stop_wins_over_a_restart_that_is_under_way(history, process):
    h = history(process('a'), process('b'))
    h.restart('a')
    h.stop('a')
    h.exit('a', INTERRUPTED)
    assert h.phases() == ['ended', 'running']


def test_a_restart_waits_until_nothing_of_the_process_is_left(
    history, process
):
    h = history(process('a'), process('b'))
    orphan = Orphan(pid=7, birth=1, group=7, number=0)
    other = Orphan(pid=8, birth=1, group=8, number=1)
    h.host.left = [orphan, other]
    h.restart('a')
    h.exit('a', INTERRUPTED)
    h.after(0.2)
    assert h.state('a').phase == 'stopping'
    assert (7, INT) in h.host.sent
    h.host.left = [other]
    h.after(0.2)
    assert h.state('a').phase == 'running'
    assert 8 not in [pid for pid, _ in h.host.sent]


def test_whose_process_is_unknown_ends_with_the_launch(history, process):
    h = history(process('a', sigterm_timeout=1.0), process('b'))
    h.host.left = [Orphan(pid=7, birth=1, group=7, number=WHOLE)]
    h.stop('a')
    h.exit('a', INTERRUPTED)
    assert h.phases() == ['ended', 'running']
    assert 7 not in [pid for pid, _ in h.host.sent]
    h.supervisor.stop('enough')
    h.exit('b', INTERRUPTED)
    h.after(60.0)
    assert [n for pid, n in h.host.sent if pid == 7] == [INT, TERM, KILL]
    (left,) = h.happened(events.LeftBehind)
    assert left.process.label == 'unknown process'


def test_what_survives_sigkill_is_named_and_left(history, process):
    quick = {'sigterm_timeout': 0.1, 'sigkill_timeout': 0.1}
    h = history(process('a', **quick), process('b'))
    h.host.left = [Orphan(pid=7, birth=1, group=7, number=0)]
    h.stop('a')
    h.exit('a', INTERRUPTED)
    h.after(30.0)
    (left,) = h.happened(events.LeftBehind)
    assert (left.process.label, left.pid) == ('a', 7)
    assert h.phases() == ['ended', 'running']


def test_a_shutdown_takes_over_a_single_stop(history, process):
    h = history(process('a', sigterm_timeout=1.0), process('b'))
    h.restart('a')
    h.supervisor.stop('enough')
    assert h.phases() == ['stopping', 'stopping']
    h.exit('a', INTERRUPTED)
    h.exit('b', INTERRUPTED)
    assert h.supervisor.done
    assert len(h.happened(events.Started)) == 2


def test_a_restart_that_fails_may_end_the_launch(history, process):
    required = process('a', on_exit_shutdown=True)
    h = history(required, process('b'), process('c'))
    for label in ('a', 'b'):
        h.supervisor.restart_process(label)
    h.host.refused.add('a')
    for label in ('a', 'b'):
        h.supervisor.exited(h.host.by_label[label], INTERRUPTED)
    h.turn()
    assert h.started() == ['a', 'b', 'c']
    assert h.sent('c') == [INT]
    assert h.phases() == ['ended', 'ended', 'stopping']


def test_the_launch_goes_on_while_its_last_process_is_restarted(
    history, process
):
    h = history(process('a'))
    h.restart('a')
    h.exit('a', INTERRUPTED)
    assert not h.supervisor.done
    assert h.phases() == ['running']


@pytest.mark.parametrize('action', ['stop_process', 'restart_process'])
def test_requests_that_make_no_sense_are_refused(history, process, action):
    h = history(process('a'), Timer(9.0, (process('late'),)))
    ask = getattr(h.supervisor, action)
    with pytest.raises(RefusedError, match="no process 'x'"):
        ask('x')
    assert h.state('late').phase == 'waiting'
    with pytest.raises(RefusedError, match='late has not been started yet'):
        ask('late')
    h.supervisor.stop('enough')
    with pytest.raises(RefusedError, match='launch is being stopped'):
        ask('a')
    assert h.happened(events.Requested) == []


def test_states_tell_for_how_long(history, process):
    h = history(process('a'), process('b'))
    h.after(3.0)
    assert h.state('a').seconds == 3.0
    h.exit('a', Outcome(code=0))
    h.after(2.0)
    assert (h.state('a').seconds, h.state('a').pid) == (2.0, None)
    assert h.state('a').ending == 'finished'
    assert h.state('b').pid == h.host.by_label['b']
