# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Histories of launches, replayed without a process and without waiting."""

import signal

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Message, Shutdown, Timer
import pytest
from support.history import History

INT, TERM, KILL = signal.SIGINT, signal.SIGTERM, signal.SIGKILL


def test_an_empty_plan_ends_at_once(history):
    assert history().supervisor.done


def test_entries_take_their_turn_in_order(history, process):
    h = history(process('a'), Message('INFO', 'between'), process('b'))
    kinds = [type(e) for e in h.host.events]
    assert kinds == [events.Started, events.MessageShown, events.Started]
    assert h.started() == ['a', 'b']


def test_many_starts_leave_turns_for_others(history, process):
    h = History(*(process(f'p{n}') for n in range(50)))
    h.turn(1)
    assert 0 < len(h.started()) < 10
    assert h.loop.next_due() == 0.0
    assert h.supervisor.is_starting
    h.turn()
    assert not h.supervisor.is_starting


def test_a_required_process_that_cannot_be_started_ends_the_launch(
    history, process
):
    bad = process('bad', on_exit_shutdown=True)
    h = history(process('good'), bad, process('never'), refused=['bad'])
    assert h.started() == ['good']
    assert h.sent('good') == [INT]


def test_a_process_is_respawned_after_its_delay(history, process):
    h = history(process('a', respawn=True, respawn_delay=2.0))
    h.exit('a')
    assert h.happened(events.Exited)[0].respawn_delay == 2.0
    h.after(1.9)
    assert h.started() == ['a']
    assert not h.supervisor.done
    h.after(0.2)
    assert h.started() == ['a', 'a']
    assert h.happened(events.Respawned)[0].attempt == 1


@pytest.mark.parametrize(('retries', 'starts'), [(0, 1), (2, 3), (-1, 6)])
def test_respawns_are_limited(history, process, retries, starts):
    respawn = {'respawn': True, 'respawn_delay': 1.0}
    h = history(process('a', respawn_max_retries=retries, **respawn))
    for _ in range(5):
        if not h.supervisor.done:
            h.exit('a')
            h.after(1.0)
    assert len(h.started()) == starts
    assert h.supervisor.done == (retries >= 0)


@pytest.mark.hostile
def test_a_failed_start_counts_as_an_end(history, process):
    h = history(
        process('a', respawn=True, respawn_delay=2.0, respawn_max_retries=3)
    )
    h.host.refused.add('a')
    h.exit('a')
    h.after(2.0)
    assert [e.respawn_delay for e in h.happened(events.StartFailed)] == [2.0]
    assert not h.supervisor.done
    assert h.state('a').phase == 'respawn'
    h.host.refused.clear()
    h.after(2.0)
    assert h.started() == ['a', 'a']
    assert h.state('a').restarts == 2
    h.host.refused.add('a')
    h.exit('a')
    assert h.happened(events.Exited)[-1].respawn_delay == 2.0
    h.after(2.0)
    assert h.happened(events.StartFailed)[-1].respawn_delay is None
    assert h.supervisor.done


@pytest.mark.hostile
def test_a_first_start_that_fails_is_tried_again(history, process):
    h = history(process('a', respawn=True, respawn_delay=1.0), refused=['a'])
    h.after(2.5)
    assert len(h.happened(events.StartFailed)) == 3
    h.host.refused.clear()
    h.after(1.0)
    assert h.started() == ['a']
    h.supervisor.stop('enough')
    h.exit('a')
    assert h.supervisor.done


@pytest.mark.hostile
def test_without_a_delay_quick_ends_cost_a_pause_that_grows(history, process):
    h = history(process('a', respawn=True))
    for _ in range(10):
        h.exit('a', Outcome(code=1))
    assert len(h.started()) == 11
    delays = []
    for _ in range(9):
        h.exit('a', Outcome(code=1))
        delays.append(h.happened(events.Exited)[-1].respawn_delay)
        h.after(delays[-1])
    assert delays == [0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 5.0, 5.0, 5.0]
    assert len(h.started()) == 20
    assert len(h.happened(events.Warned)) == 1
    # a run that lasts makes all good
    h.after(1.0)
    for _ in range(11):
        h.exit('a', Outcome(code=1))
    assert len(h.started()) == 31
    h.exit('a', Outcome(code=1))
    assert h.happened(events.Exited)[-1].respawn_delay == 0.1
    assert len(h.happened(events.Warned)) == 1


@pytest.mark.hostile
def test_starts_that_fail_for_ever_cost_a_pause_too(history, process):
    h = history(process('a', respawn=True), refused=['a'])
    h.after(600.0)
    assert 100 < len(h.happened(events.StartFailed)) < 150


def test_the_delay_of_the_launch_file_is_kept_to(history, process):
    h = history(process('a', respawn=True, respawn_delay=0.01))
    for _ in range(30):
        h.exit('a', Outcome(code=1))
        h.after(0.02)
    assert len(h.started()) == 31
    assert h.happened(events.Warned) == []


@pytest.mark.hostile
def test_what_the_former_one_left_is_stopped_before_the_next(history, process):
    h = history(
        process('a', respawn=True, respawn_delay=2.0, sigterm_timeout=5.0),
        process('b'),
    )
    child = Orphan(pid=7, birth=1, group=7, number=0)
    other = Orphan(pid=8, birth=1, group=8, number=1)
    h.host.left = [child, other]
    h.exit('a')
    assert h.host.sent == [(7, INT)]
    h.after(4.9)
    assert h.started() == ['a', 'b']
    assert h.state('a').phase == 'respawn'
    h.after(0.2)
    assert h.host.sent == [(7, INT), (7, TERM)]
    h.host.left = [other]
    h.after(0.1)
    assert h.started() == ['a', 'b', 'a']
    assert not h.happened(events.LeftBehind)


@pytest.mark.hostile
def test_what_the_former_one_left_costs_no_more_than_the_delay(
    history, process
):
    h = history(process('a', respawn=True, respawn_delay=2.0))
    h.host.left = [Orphan(pid=7, birth=1, group=7, number=0)]
    h.exit('a')
    h.host.left = []
    h.after(1.9)
    assert h.started() == ['a']
    h.after(0.1)
    assert h.started() == ['a', 'a']


@pytest.mark.hostile
def test_what_cannot_be_stopped_does_not_keep_the_next_for_ever(
    history, process
):
    h = history(
        process('a', respawn=True, sigterm_timeout=1.0, sigkill_timeout=1.0)
    )
    h.host.left = [Orphan(pid=7, birth=1, group=7, number=0)]
    h.exit('a')
    h.after(7.1)
    assert h.host.sent == [(7, INT), (7, TERM), (7, KILL)]
    assert [e.pid for e in h.happened(events.LeftBehind)] == [7]
    assert h.started() == ['a', 'a']


@pytest.mark.hostile
def test_many_respawns_do_not_search_all_the_time(history, process):
    h = history(*(process(f'p{n}', respawn=True) for n in range(3)))
    searches = []

    def orphans(groups, led):
        searches.append(h.now)
        h.loop.now += 0.01
        return []

    h.host.orphans = orphans
    begin = h.now
    while h.now < begin + 1.0:
        for n in range(3):
            if h.state(f'p{n}').pid is not None:
                h.exit(f'p{n}')
        h.after(0.01)
    assert 5 < len(searches) < 15
    assert len(h.started()) > 20


@pytest.mark.parametrize('way', ['stop', 'restart'])
def test_a_request_takes_over_what_the_former_one_left(history, process, way):
    h = history(process('a', respawn=True), process('b'))
    h.host.left = [Orphan(pid=7, birth=1, group=7, number=0)]
    h.exit('a')
    getattr(h, way)('a')
    assert h.started() == ['a', 'b']
    h.host.left = []
    h.after(0.1)
    assert h.started() == ['a', 'b', *(['a'] if way == 'restart' else [])]


@pytest.mark.parametrize('left', [(), (7,)])
def test_stopping_wins_over_a_respawn_that_is_due(history, process, left):
    h = history(process('a', respawn=True, respawn_delay=2.0))
    h.host.left = [Orphan(pid, birth=1, group=7, number=0) for pid in left]
    h.exit('a')
    h.supervisor.stop('enough')
    h.host.left = []
    h.after(9.0)
    assert h.supervisor.done
    assert h.started() == ['a']


def test_a_slow_stop_is_told_with_its_next_step(history, process):
    h = history(process('a'), process('b', sigterm_timeout=3.0))
    h.supervisor.stop('enough')
    h.after(2.5)
    assert h.happened(events.StillRunning) == [
        events.StillRunning(('a', 'b'), 0, INT, TERM, 2.0)
    ]
    h.exit('b')
    h.after(3.5)
    assert h.happened(events.StillRunning)[1:] == [
        events.StillRunning(('a',), 0, INT, TERM, 2.0),
        events.StillRunning(('a',), 0, TERM, KILL, 5.0),
    ]
    h.after(5.0)
    assert h.happened(events.StillRunning)[3:] == [
        events.StillRunning(('a',), 0, KILL)
    ]


def test_a_very_slow_stop_is_told_again(history, process):
    h = history(process('a', sigterm_timeout=100.0))
    h.supervisor.stop('enough')
    h.after(25.0)
    seconds = [e.seconds for e in h.happened(events.StillRunning)]
    assert seconds == [99.0, 89.0, 79.0]


def test_escalating_is_reported_at_once(history, process):
    h = history(process('a'))
    h.supervisor.stop('enough')
    h.supervisor.escalate()
    (told,) = h.happened(events.StillRunning)
    assert told == events.StillRunning(('a',), 0, TERM, KILL, 5.0)


def test_what_a_running_process_left_its_group_is_stopped_with_it(
    history, process
):
    h = history(process('a'))
    pid = h.host.by_label['a']
    inside = Orphan(pid=pid + 1, birth=1, group=pid, number=0)
    outside = Orphan(pid=7, birth=1, group=7, number=0)
    h.host.left = [inside, outside]
    h.supervisor.stop('enough')
    assert h.host.sent == [(pid, INT), (7, INT)]


def test_a_nested_timer_counts_from_its_own_turn(history, process):
    h = history(Timer(1.0, (Timer(1.0, (process('late'),)),)))
    h.after(1.9)
    assert h.started() == []
    h.after(0.2)
    assert h.started() == ['late']


def test_the_same_timer_may_occur_twice(history):
    timer = Timer(1.0, (Message('INFO', 'tick'),))
    h = history(timer, timer)
    h.after(1.0)
    assert len(h.happened(events.MessageShown)) == 2
    assert h.supervisor.done


def test_a_shutdown_drops_timers(history, process):
    h = history(Timer(9.0, (process('late'),)), process('a'))
    h.supervisor.stop('enough')
    h.exit('a')
    assert h.supervisor.done


def test_a_timer_that_outlasts_a_shutdown_speaks_but_starts_nothing(
    history, process
):
    entries = (process('late'), Message('INFO', 'fired'), Shutdown(''))
    h = history(Timer(9.0, entries, cancel_on_shutdown=False))
    h.supervisor.stop('enough')
    h.after(8.0)
    assert not h.supervisor.done
    assert h.happened(events.StillRunning)[-1].timers == 1
    h.after(1.0)
    assert h.supervisor.done
    assert h.started() == []
    assert h.happened(events.MessageShown) == [
        events.MessageShown('INFO', 'fired')
    ]
    assert len(h.happened(events.ShuttingDown)) == 1


@pytest.mark.parametrize('way', ['escalate', 'drop_timers'])
def test_a_timer_that_outlasts_a_shutdown_can_be_dropped(history, way):
    h = history(Timer(900.0, (), cancel_on_shutdown=False))
    h.supervisor.stop('enough', drop_timers=way == 'drop_timers')
    if way == 'escalate':
        h.supervisor.escalate()
    h.turn()
    assert h.supervisor.done


def test_a_launch_that_ends_by_itself_is_searched_once(history, process):
    h = history(process('a'))
    looks = []
    h.host.orphans = lambda groups, led: looks.append(1) or []
    h.exit('a')
    assert h.supervisor.done
    assert len(looks) == 1


def test_a_stop_costs_in_proportion_to_the_processes(history, process):
    h = history(*(process(f'p{n}') for n in range(500)))
    while len(h.started()) < 500:
        h.turn()
    looks = []
    orphans = h.host.orphans
    h.host.orphans = lambda *args: looks.append(1) or orphans(*args)
    h.supervisor.stop('enough')
    for pid in list(h.host.by_label.values()):
        h.supervisor.exited(pid, Outcome(signal=INT))
        h.turn(1)
    assert h.supervisor.done
    assert len(h.host.sent) == 500
    assert len(looks) == 2


def test_a_process_is_asked_for_by_each_of_its_names(history, process):
    h = history(process('kitchen', name='talker-1'))
    tasks = [h.supervisor.task(name) for name in ('kitchen', 'talker-1')]
    assert tasks[0] is tasks[1]
    h.stop('talker-1')
    h.exit('kitchen')
    assert [e.asked for e in h.happened(events.Exited)] == [True]


def test_a_process_is_killed_at_once_and_did_not_fail(history, process):
    h = history(
        process('a', respawn=True, on_exit_shutdown=True), process('b')
    )
    h.turn()
    h.supervisor.kill_process('a')
    assert h.sent('a') == [KILL]
    # and all that it started
    assert h.host.killed == [0]
    assert h.state('a').phase == 'stopping'
    h.exit('a', Outcome(signal=KILL))
    assert h.phases() == ['ended', 'running']
    (exited,) = h.happened(events.Exited)
    assert exited.asked
    assert not exited.failed


def test_a_stop_that_takes_long_ends_by_a_kill(history, process):
    h = history(process('a'), process('b'))
    h.restart('a')
    h.supervisor.kill_process('a')
    assert h.sent('a') == [INT, KILL]
    h.exit('a', Outcome(signal=KILL))
    assert h.started() == ['a', 'b']
    with pytest.raises(RefusedError, match="no process 'x'"):
        h.supervisor.kill_process('x')


def test_a_process_is_started_as_something_else_once(history, process):
    h = history(process('a'), process('b'))
    h.turn()
    begun = []
    start = h.host.start
    h.host.start = lambda n, p: begun.append(p.argv) or start(n, p)
    h.supervisor.restart_process('a', once=process('a', 'gdb'))
    h.exit('a')
    assert begun == [('gdb',)]
    assert h.state('a').restarts == 1
    h.restart('a')
    h.exit('a')
    assert begun == [('gdb',), ('true',)]
    # who stops it instead wants it as ever afterwards
    h.supervisor.restart_process('a', once=process('a', 'gdb'))
    h.stop('a')
    h.exit('a')
    h.restart('a')
    assert begun[-1] == ('true',)
