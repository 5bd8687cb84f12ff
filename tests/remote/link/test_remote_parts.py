# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from dataclasses import replace
import signal
import termios

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.deployment.placement import PlacedPlan
from colcon_yamllaunch.engine import commands, events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.state import from_json, to_json
from colcon_yamllaunch.plan.plan import Component, Plan, Timer
from colcon_yamllaunch.plan.plan_json import plan_from_json
from colcon_yamllaunch.remote.part_protocol import LINK_LOST
from colcon_yamllaunch.remote.remote_part import END_TIMEOUT
from colcon_yamllaunch.remote.remote_parts import MEASURING, RemoteParts
import pytest
from support.played_machine import (
    plan,
    PlayedLaunch,
    PlayedLink,
    POSITION,
    process,
)

LABEL = 'arm│driver'
DRIVER = process(LABEL, name='driver-1', node_name='/driver')
HELPER = process('arm│helper', emulate_tty=True)
TALKER = Component('arm│talker', 'demo', 'demo::Talker', '/box', POSITION)


class Played:
    """Parts on one machine, or several, with both ends played."""

    def __init__(self, *links, entries=(DRIVER, HELPER, TALKER), **fields):
        self.link, *self.others = links or (PlayedLink(),)
        whole = Plan(entries)
        parts = {
            self.link.machine.name: whole,
            **{
                one.machine.name: plan(one.machine.name + '│x')
                for one in self.others
            },
        }
        self.parts = RemoteParts(
            (self.link, *self.others),
            PlacedPlan(whole, Plan(), parts),
            **fields,
        )
        self.launch = PlayedLaunch(self.parts)
        self.launch.parts = self.parts
        self.parts.begin()
        # what is left for this machine
        self.rest = []

    @property
    def now(self):
        """The time; setting it lets time pass."""
        return self.launch.loop.now

    @now.setter
    def now(self, now):
        self.launch.loop.pass_time(now - self.now)

    def do(self, command):
        """Execute a command, of which this machine has its share."""

        def proceed(rest, _):
            self.rest.append(rest)
            if isinstance(rest, commands.RestartChanged):
                return commands.Restarted(())
            return commands.DONE

        return self.parts.execute(command, bool, proceed)

    def states(self):
        state = to_json(self.launch.state)
        return from_json(state, lambda: self.now).by_label


@pytest.fixture
def played():
    return Played()


def act(parts, name, label, done):
    """Send a command about a part, and pass on why it is refused."""
    kind = {
        'stop': commands.Stop,
        'restart': commands.Restart,
        'debug': commands.Debug,
    }[name]
    parts.execute(
        kind(label),
        lambda answer: done(getattr(answer, 'error', None)),
        lambda *_: pytest.fail('it runs on a machine'),
    )


def test_event_of_a_machine_is_emitted_here(played):
    event = events.Started(DRIVER, 77)
    played.link.tells(event)
    assert played.launch.told == [event]
    assert played.link.sent == [
        {'request': 'resize', 'lines': 40, 'columns': 120}
    ]


def test_output_comes_before_the_exit(played):
    played.link.tells(events.Started(DRIVER, 77))
    played.link.handler.output(LABEL, 'stderr', b'half a li', 0.0)
    played.link.tells(events.Exited(DRIVER, 77, Outcome(0), 1.0, False, False))
    assert played.launch.output == [
        (LABEL, 'stderr', b'half a li'),
        (LABEL, 'end', b''),
    ]


def test_failure_is_judged_before_the_next_event(played):
    failed = events.Exited(DRIVER, 77, Outcome(3), 1.0, False, True, 0.0)
    judged = []
    played.launch.check_conditions = lambda: judged.append(
        played.launch.told[-1]
    )
    played.link.tells(failed)
    played.link.tells(events.Started(DRIVER, 78))
    assert failed in judged


def test_late_output_and_events_keep_their_time(played):
    played.link.handler.output(LABEL, 'stdout', b'line\n', 500.0)
    played.link.handler.message(
        {
            'time': 501.0,
            'event': {'event': 'warning', 'text': 'oh'},
        }
    )
    assert played.launch.times == [500.0, 501.0]
    assert played.launch.event_time() == 1000.0
    assert played.launch.told == [events.Warned('arm: oh')]


def test_full_screen_pauses_the_link_until_it_accepts_more(played):
    played.launch.full.add(LABEL)
    played.link.handler.output(LABEL, 'stdout', b'line\n', 0.0)
    assert played.link.is_paused
    played.parts.end_turn()
    assert played.link.is_paused
    played.launch.full.clear()
    played.parts.end_turn()
    assert not played.link.is_paused


def test_full_screen_does_not_pause_the_link_while_stopping(played):
    played.launch.full.add(LABEL)
    played.link.handler.output(LABEL, 'stdout', b'line\n', 0.0)
    played.launch.is_stopping = True
    played.parts.end_turn()
    assert not played.link.is_paused


def test_stop_requests_are_sent_in_order(played):
    played.launch.is_stopping = True
    played.launch.emit(events.ShuttingDown('interrupted', True))
    played.do(commands.Escalate())
    played.do(commands.Shutdown(drop_timers=True))
    assert played.link.sent[1:] == [
        {
            'request': 'shutdown',
            'reason': 'interrupted',
            'interactive': True,
            'drop_timers': False,
        },
        {'request': 'escalate'},
        {
            'request': 'shutdown',
            'reason': '',
            'interactive': False,
            'drop_timers': True,
        },
    ]


def test_shutdown_of_a_machine_stops_the_launch_once(played):
    played.link.tells(events.ShuttingDown('arm│driver ended'))
    played.link.tells(events.ShuttingDown('arm│driver ended'))
    assert played.launch.told == [events.ShuttingDown('arm│driver ended')]
    assert len(played.link.asked('shutdown')) == 1


def test_the_launch_waits_until_each_machine_is_done(played):
    assert played.parts.prepare_end()
    played.link.tells(events.IdleChanged(True))
    assert not played.parts.prepare_end()
    assert not played.link.asked('finish')
    played.launch.is_stopping = True
    assert played.parts.prepare_end()
    assert played.parts.prepare_end()
    assert len(played.link.asked('finish')) == 1
    played.link.tells(events.Ended(0))
    assert not played.parts.prepare_end()
    # the end of its link is no loss
    played.link.handler.gone('it has ended')
    assert played.launch.told == []


def test_launch_waits_for_the_answer_to_a_command(played):
    played.link.tells(events.IdleChanged(True))
    act(played.parts, 'restart', 'driver-1', lambda _: None)
    assert played.parts.prepare_end()
    played.link.answers('restart')
    assert not played.parts.prepare_end()


def test_commands_are_answered_or_refused(played):
    answers = []
    act(played.parts, 'stop', LABEL, answers.append)
    assert played.link.asked('stop') == [{'request': 'stop', 'member': LABEL}]
    played.link.answers('stop', error='it has \x1b[1mnot been started yet')
    assert answers == ['it has not been started yet']
    # another one is this machine's
    played.do(commands.Stop('other'))
    assert played.rest == [commands.Stop('other')]
    played.launch.is_stopping = True
    with pytest.raises(RefusedError, match='being stopped'):
        act(played.parts, 'stop', LABEL, answers.append)


def test_state_follows_the_events_of_a_machine(played):
    assert played.states()[LABEL].phase == 'waiting'
    played.link.tells(events.Started(DRIVER, 77))
    played.now += 2.0
    state = played.states()[LABEL]
    assert (state.phase, state.pid, state.seconds) == ('running', 77, 2.0)
    assert (state.machine, state.local_pid) == ('arm', None)
    played.link.tells(
        events.Exited(DRIVER, 77, Outcome(3), 2.0, False, True, 1.0)
    )
    state = played.states()[LABEL]
    assert (state.phase, state.pid) == ('respawn', None)
    assert state.ending == 'exited with code 3'
    played.link.tells(events.Started(DRIVER, 78))
    assert played.states()[LABEL].restarts == 1
    played.link.tells(events.Loaded(TALKER, '/box/talker', 1, 0.1))
    component = played.states()[TALKER.label]
    assert (component.phase, component.node) == ('loaded', '/box/talker')
    assert played.parts.find('/box/talker') is not None


@pytest.mark.parametrize(
    'message',
    [
        {'event': {'event': 'started', 'label': 'nobody', 'pid': 1}},
        {'event': 7},
        {'event': {'event': 'ended', 'exit_code': 'none'}},
        {'modes': {'process': LABEL}},
        {'shown': {'process': 'nobody', 'stream': 'stdout', 'data': b'x'}},
        {'missed': 'much'},
        {'something': 'else'},
        {},
    ],
)
def test_machine_that_sends_nonsense_is_dropped_once(played, message):
    played.link.handler.message(message)
    played.link.handler.message(message)
    (event,) = played.launch.told
    assert isinstance(event, events.MachineGone)
    assert 'makes no sense' in event.reason
    assert played.link.is_closed


def test_output_of_an_unknown_process_drops_the_machine(played):
    played.link.handler.output('nobody', 'stdout', b'text', 0.0)
    (event,) = played.launch.told
    assert isinstance(event, events.MachineGone)


def test_processes_of_a_gone_machine_are_lost(played):
    played.link.tells(events.Started(DRIVER, 77))
    played.now += 3.0
    played.launch.told.clear()
    played.link.handler.gone('it was started anew')
    gone, exited = played.launch.told
    assert gone == events.MachineGone('arm', 'it was started anew', (LABEL,))
    assert exited == events.Exited(
        DRIVER, 77, Outcome(lost='arm'), 3.0, False, True
    )
    assert exited.lines() == ()
    assert played.states()[LABEL].ending == 'lost with arm'
    assert not played.parts.prepare_end()
    with pytest.raises(RefusedError, match='arm is gone: it was started'):
        act(played.parts, 'stop', LABEL, lambda _: None)


def test_lost_required_process_stops_the_launch():
    must_run = process('arm│must', on_exit_shutdown=True)
    played = Played(entries=(must_run,))
    played.link.tells(events.Started(must_run, 77))
    played.link.handler.gone('no connection')
    assert played.launch.is_stopping


def test_lost_link_and_its_return_are_reported(played):
    answers = []
    act(played.parts, 'restart', LABEL, answers.append)
    played.link.handler.lost('nothing was heard of it')
    assert answers == ['the link to arm is lost: nothing was heard of it']
    assert played.states()[LABEL].phase == 'waiting'
    (state,) = played.launch.state.machines.values()
    assert (state.link, state.reason) == ('lost', 'nothing was heard of it')
    with pytest.raises(RefusedError, match='is lost'):
        act(played.parts, 'stop', LABEL, answers.append)
    played.link.handler.back(2.5)
    assert played.launch.told == [
        events.LinkLost('arm', 'nothing was heard of it', False),
        events.LinkBack('arm', 2.5),
    ]
    act(played.parts, 'stop', LABEL, answers.append)


def test_processes_of_a_lost_machine_are_unknown(played):
    played.link.tells(events.Started(DRIVER, 77))
    played.link.tells(events.Loaded(TALKER, '/box/talker', 1, 0.1))
    played.link.handler.lost('nothing was heard of it')
    assert played.states()[LABEL].phase == 'unknown'
    assert played.states()[TALKER.label].phase == 'unknown'
    played.link.handler.back(2.5)
    assert played.states()[LABEL].phase == 'running'


@pytest.mark.parametrize('is_stopping', [False, True])
def test_part_that_stopped_for_a_lost_link_is_gone(played, is_stopping):
    played.launch.is_stopping = is_stopping
    played.link.tells(events.ShuttingDown(f'{LINK_LOST}: silence'))
    played.link.tells(events.Ended(0))
    played.link.handler.gone('it has ended')
    gone = [e for e in played.launch.told if isinstance(e, events.MachineGone)]
    assert bool(gone) == (not is_stopping)
    assert played.parts.parts and not any(
        p.is_busy for p in played.parts.parts
    )


def again(played):
    """Return the labels that a new part begins with, and start it."""
    plan = plan_from_json(played.link.plan_again())
    played.link.handler.back(1.0)
    return [part.label for part in (*plan.processes(), *plan.components())]


def test_restart_brings_back_a_machine_that_is_gone(played):
    played.link.tells(events.Started(DRIVER, 77))
    played.link.handler.gone('it was started anew')
    answers = []
    act(played.parts, 'restart', LABEL, answers.append)
    assert played.parts.prepare_end()
    assert answers == []
    assert again(played) == [LABEL]
    assert answers == [None]
    played.link.tells(events.Started(DRIVER, 5))
    state = played.states()[LABEL]
    assert (state.phase, state.pid, state.restarts) == ('running', 5, 1)
    # what it was not asked for follows when that is
    with pytest.raises(RefusedError, match='does not run'):
        act(played.parts, 'stop', HELPER.label, answers.append)
    act(played.parts, 'restart', HELPER.label, answers.append)
    (asked,) = played.link.asked('extend')
    assert [part['label'] for part in asked['entries']] == [HELPER.label]
    assert answers == [None, None]


def test_restart_of_a_container_brings_back_its_components():
    box = process('arm│box', node_name='/box', is_container=True)
    played = Played(entries=(box, TALKER, HELPER))
    played.link.handler.gone('it was started anew')
    act(played.parts, 'restart', box.label, lambda _: None)
    assert again(played) == [box.label, TALKER.label]


def test_failed_restart_is_answered_and_reported_once(played):
    played.link.handler.gone('it was started anew')
    answers = []
    for label in (LABEL, HELPER.label):
        act(played.parts, 'restart', label, answers.append)
    played.link.handler.gone('it cannot be reached')
    assert answers == ['arm is gone: it cannot be reached'] * 2
    gone = [e for e in played.launch.told if isinstance(e, events.MachineGone)]
    assert len(gone) == 1
    assert not played.parts.prepare_end()


def test_machine_that_cannot_come_back_is_not_restarted(played):
    played.link.can_start_again = False
    played.link.handler.gone('its allocation has ended')
    with pytest.raises(RefusedError, match='its allocation has ended'):
        act(played.parts, 'restart', LABEL, lambda _: None)


@pytest.fixture
def restarting():
    timer = Timer(9.0, (process('arm│late'),))
    must = process('arm│must', on_exit_shutdown=True)
    played = Played(
        PlayedLink(on_lost='restart'), entries=(DRIVER, HELPER, must, timer)
    )
    for one in (DRIVER, HELPER, must):
        played.link.tells(events.Started(one, 77))
    played.link.tells(events.Requested(HELPER, 'stop'))
    played.link.handler.gone('it was started anew')
    return played


def test_on_lost_restart_begins_anew_without_what_was_stopped(restarting):
    lost = [e for e in restarting.launch.told if isinstance(e, events.Exited)]
    assert [e.respawn_delay for e in lost] == [0.0, 0.0, 0.0]
    assert not restarting.launch.is_stopping
    assert restarting.parts.prepare_end()
    # the machine is still down
    restarting.link.handler.gone('it cannot be reached')
    assert restarting.parts.prepare_end()
    assert again(restarting) == [LABEL, 'arm│must', 'arm│late']
    assert restarting.launch.told[-1] == events.LinkBack('arm', 1.0)


def test_stop_does_not_wait_for_a_machine_that_is_gone(restarting):
    restarting.launch.emit(events.ShuttingDown('interrupted', True))
    restarting.launch.is_stopping = True
    assert not restarting.parts.prepare_end()
    assert restarting.link.is_closed


def test_escalating_does_not_wait_for_a_lost_machine(played):
    played.link.handler.lost('nothing was heard of it')
    played.launch.is_stopping = True
    assert played.parts.prepare_end()
    played.do(commands.Escalate())
    assert not played.parts.prepare_end()
    assert isinstance(played.launch.told[-1], events.MachineGone)


@pytest.mark.parametrize(
    ('on_lost', 'told'),
    [
        ('stop', 'have stopped there by themselves'),
        ('keep', 'be told to stop'),
    ],
)
def test_stopping_launch_says_why_it_waits_for_a_lost_link(on_lost, told):
    played = Played()
    played.link.machine = replace(played.link.machine, on_lost=on_lost)
    played.link.handler.lost('nothing was heard of it')
    played.launch.emit(events.ShuttingDown('interrupted', True))
    played.do(commands.Shutdown(drop_timers=True))
    told_here = played.launch.told
    (warning,) = (e for e in told_here if isinstance(e, events.Warned))
    assert told in warning.text
    played.do(commands.Escalate())
    gone = played.launch.told[-1]
    assert ('its processes run on there' in gone.reason) == (on_lost == 'keep')


def test_measuring_waits_for_a_limited_time():
    played = Played(PlayedLink(), PlayedLink('gpu'))
    known = []
    played.link.tells(events.Started(DRIVER, 77))
    played.parts.measure(lambda: known.append(True))
    played.link.answers('measure', usage={LABEL: [0.5, 1000]})
    assert not known
    played.now += MEASURING
    played.parts.end_turn()
    assert known == [True]
    state = played.states()[LABEL]
    assert (state.cpu, state.memory) == (0.5, 1000)
    assert played.parts.cpu_shares() == {LABEL: 0.5}


def test_keys_and_modes(played):
    label = HELPER.label
    assert not played.parts.has_keyboard(label)
    played.link.tells(events.Started(HELPER, 77))
    assert played.parts.has_keyboard(label)
    assert played.parts.input_modes(label) is None
    played.link.says(modes={'process': label, 'lines': False, 'echo': True})
    assert played.parts.input_modes(label) == termios.ECHO
    played.parts.type(label, b'\x1b[A')
    (typed,) = played.link.asked('type')
    assert typed['keys'] == '\x1b[A'
    played.parts.attach(label)
    played.parts.detach(label)
    assert played.link.asked('show') == [
        {'request': 'show', 'member': label, 'is_shown': is_shown}
        for is_shown in (True, False)
    ]


def test_suspend_and_size_go_to_all():
    played = Played(PlayedLink(), PlayedLink('gpu'))
    played.do(commands.Hold(True))
    played.do(commands.Hold(False))
    played.do(commands.Resize(80, 24))
    for link in (played.link, *played.others):
        assert [m['request'] for m in link.sent[1:]] == [
            'hold',
            'hold',
            'resize',
        ]
        assert [m.get('is_held') for m in link.sent[1:]] == [True, False, None]


def test_suspending_the_launch_reports_no_single_process(played):
    held = events.Suspended(DRIVER, 77, signal.SIGSTOP)
    on = events.Suspended(DRIVER, 77, None)
    played.link.tells(events.Started(DRIVER, 77))
    played.launch.told.clear()
    played.do(commands.Hold(True))
    played.do(commands.Hold(False))
    played.link.tells(held)
    played.link.tells(on)
    assert played.launch.told == []
    # somebody else holds it
    played.link.tells(held)
    played.link.tells(on)
    assert played.launch.told == [held, on]


def test_added_entries_are_sent_to_their_machine():
    more = process('arm│more')
    here = process('here')

    def place_more(entries):
        return PlacedPlan(
            Plan(tuple(entries)), Plan((here,)), {'arm': Plan((more,))}
        )

    played = Played(place_more=place_more)
    played.do(commands.Extend((more, here)))
    assert played.rest == [commands.Extend((here,))]
    (asked,) = played.link.asked('extend')
    assert [part['label'] for part in asked['entries']] == [more.label]
    assert played.parts.find('arm│more') == more
    with pytest.raises(RefusedError, match='already'):
        played.do(commands.Extend((more,)))


def test_changes_of_the_plan_are_routed_by_label(played):
    changed = process(LABEL, name='driver-1', respawn=True)
    played.do(commands.Revise(changed))
    (asked,) = played.link.asked('revise')
    assert asked['member']['respawn'] is True
    assert played.parts.find(LABEL) == changed
    restart = commands.RestartChanged((LABEL, 'here'))
    assert played.do(restart).labels == ()
    played.link.tells(events.Started(DRIVER, 77))
    assert played.do(restart).labels == (LABEL,)
    # it is another one when it starts
    played.link.tells(events.Planned((DRIVER,)))
    assert played.launch.told[-1] == events.Planned((changed,))
    played.do(commands.Drop(LABEL))
    played.link.tells(events.Dropped(DRIVER))
    assert played.parts.find(LABEL) is None
    assert played.rest == [restart, restart]


def test_change_does_not_restart_a_stopped_process(played):
    played.link.tells(events.Started(DRIVER, 77))
    played.link.tells(events.Requested(DRIVER, 'stop'))
    assert played.do(commands.RestartChanged((LABEL,))).labels == ()


def test_missing_output_is_a_warning(played):
    played.link.says(missed={'events': 0, 'bytes': 3_000_000})
    (event,) = played.launch.told
    assert 'arm: 3 MB of output are missing' in event.text


@pytest.mark.hostile
def test_machine_that_does_not_end_is_dropped(played):
    played.link.tells(events.Started(DRIVER, 77))
    played.launch.shut_down('interrupted')
    # whatever it says meanwhile
    played.now += 5 + 5 + END_TIMEOUT - 1
    played.link.tells(events.IdleChanged(False))
    played.parts.end_turn()
    assert played.parts.prepare_end()
    played.now += 2
    played.parts.end_turn()
    assert not played.parts.prepare_end()
    gone = [e for e in played.launch.told if isinstance(e, events.MachineGone)]
    assert [e.reason for e in gone] == [
        'it does not end, though it was told to'
    ]


@pytest.mark.hostile
def test_machine_with_nothing_to_stop_is_dropped_at_the_end():
    played = Played(entries=())
    played.launch.is_stopping = True
    assert played.parts.prepare_end()
    played.now += END_TIMEOUT + 1
    played.parts.end_turn()
    assert not played.parts.prepare_end()


def test_machine_with_a_lasting_timer_is_waited_for():
    timer = Timer(600, (DRIVER,), cancel_on_shutdown=False)
    played = Played(entries=(timer,))
    played.launch.shut_down('interrupted')
    played.now += 590
    played.parts.end_turn()
    assert played.parts.prepare_end()
    # Ctrl-C again
    played.do(commands.Escalate())
    played.now += 5 + 5 + END_TIMEOUT + 1
    played.parts.end_turn()
    assert not played.parts.prepare_end()
