# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What launch files in Python do later."""

from collections.abc import Callable
import signal

import pytest
from support.ros_setup import RosSetup
from support.talking_worker import HEAD, in_short, Message, TalkingWorker

Launch = Callable[[str], list[Message]]


def test_timers_are_told_ahead(launch: Launch) -> None:
    told = launch(
        """\
        def generate_launch_description():
            return LaunchDescription([
                SetLaunchConfiguration('wait', '1.5'),
                SetLaunchConfiguration('x', 'outer'),
                after(LaunchConfiguration('wait'),
                      SetLaunchConfiguration('x', 'inner'),
                      say(LaunchConfiguration('x')),
                      after(2.0, run('a'), cancel_on_shutdown=False)),
                say(LaunchConfiguration('x')),
                after(3.0, Shutdown(reason='timed out')),
            ])
        """
    )
    assert in_short(told) == [
        'begin timer',
        'inner',
        'begin timer',
        'start a',
        'end',
        'end',
        'outer',
        'begin timer',
        'shutdown: timed out',
        'end',
    ]
    timers = [m for m in told if m['say'] == 'begin']
    assert [
        (t['period'], t['cancel_on_shutdown'], t['title']) for t in timers
    ] == [(1.5, True, '1.5 s'), (2.0, False, '2 s'), (3.0, True, '3 s')]
    assert [t['on_ros_time'] for t in timers] == [False] * 3


def test_what_needs_its_time_waits_for_it(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    told = launch(
        """\
        class Own(Action):
            def execute(self, context):
                return [run('own')]

        def at_its_time(context):
            context.launch_configurations['x'] = 'set'
            return [say('x was ', LaunchConfiguration('y'))]

        def generate_launch_description():
            return LaunchDescription([
                GroupAction([
                    SetLaunchConfiguration('y', 'where it stands'),
                    after(1.0,
                          say('ahead'),
                          GroupAction([OpaqueFunction(function=at_its_time),
                                       say(LaunchConfiguration('x'))]),
                          say('behind'),
                          Own()),
                ]),
                OpaqueFunction(function=lambda context: [run('now')]),
            ])
        """
    )
    line = HEAD.count('\n') + 5
    assert in_short(told) == [
        'begin group',
        'begin timer',
        'ahead',
        'begin group',
        f'call 1: call at_its_time (demo.launch.py:{line}), say "$(var x)"',
        'end',
        'behind',
        'call 2: Own',
        'end',
        'end',
        'start now',
    ]
    assert in_short(talking_worker.ask('call', number=1)) == [
        'x was where it stands',
        'set',
    ]
    assert in_short(talking_worker.ask('call', number=2)) == ['start own']


def test_timers_are_cancelled(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    told = launch(
        """\
        def generate_launch_description():
            early, late = after(1.0, say('early')), after(2.0, say('late'))
            other = after(3.0, say('other'))
            other.cancel()
            return LaunchDescription([
                early, late, other, run('a'),
                RegisterEventHandler(OnProcessExit(
                    on_exit=lambda event, context: late.cancel())),
            ])
        """
    )
    assert in_short(told) == [
        'begin timer',
        'call 1: say "early"',
        'end',
        'begin timer',
        'call 2: say "late"',
        'end',
        'start a',
    ]
    assert in_short(talking_worker.ask('call', number=1)) == ['early']
    talking_worker.event('exit', process='a', returncode=0)
    assert in_short(talking_worker.ask('call', number=2)) == []


def test_what_fails_at_its_time_ends_the_launch(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    launch(
        """\
        def generate_launch_description():
            return LaunchDescription([after(
                1.0, OpaqueFunction(function=lambda context: 1 / 0))])
        """
    )
    told = talking_worker.ask_to_end('call', number=1)
    assert in_short(told) == [
        'shutdown: a launch file raised ZeroDivisionError'
    ]
    assert told[-1]['error']['text'] == 'ZeroDivisionError: division by zero'


def test_a_timer_on_ros_time(launch: Launch) -> None:
    told = launch(
        """\
        from launch_ros.actions import RosTimer, SetUseSimTime

        def timer():
            return RosTimer(period=1.0, actions=[run('a')])

        def generate_launch_description():
            return LaunchDescription([timer(), SetUseSimTime(True), timer()])
        """
    )
    timers = [m for m in told if m['say'] == 'begin']
    assert [t['on_ros_time'] for t in timers] == [False, True]


def test_requests_in_timers_are_settled_when_all_is_read(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    told = launch(
        """\
        from launch_ros.actions import LifecycleNode
        from launch_ros.events.lifecycle import ChangeState

        def generate_launch_description():
            node = LifecycleNode(
                executable='/bin/true', name='a', namespace='/ns')
            b = run('b')
            return LaunchDescription([
                # it stands in front of what it is about
                after(1.0,
                      emit(ChangeState(
                          lifecycle_node_matcher=matches_action(node),
                          transition_id=1)),
                      say('behind')),
                node, b,
                after(2.0,
                      emit(SignalProcess(
                          signal_number=signal.SIGUSR1,
                          process_matcher=matches_action(b))),
                      emit(ShutdownProcess(
                          process_matcher=matches_action(node)))),
            ])
        """
    )
    assert in_short(told) == [
        'begin timer',
        'call 1: configure a',
        'behind',
        'end',
        'start true',
        'start b',
        'begin timer',
        'call 2: send SIGUSR1 to b',
        'call 3: stop a',
        'end',
        'begin settled',
        'configure /ns/a',
        'end',
        'begin settled',
        f'signal {signal.SIGUSR1:d} to b',
        'end',
        'begin settled',
        'signal 0 to true',
        'end',
    ]
    numbers = [m['number'] for m in told if m.get('kind') == 'settled']
    assert numbers == [1, 2, 3]
    (called, *_) = [m for m in told if m['say'] == 'call']
    (changed,) = [m for m in told if m['say'] == 'change_state']
    assert changed['position'] == called['position']


def test_transitions_in_a_timer_are_settled_in_their_order(
    launch: Launch, ros_setup: RosSetup
) -> None:
    if ros_setup.environment.get('ROS_DISTRO') == 'humble':
        pytest.skip('Humble has no LifecycleTransition')
    told = launch(
        """\
        from launch_ros.actions import LifecycleNode, LifecycleTransition

        def generate_launch_description():
            return LaunchDescription([
                LifecycleNode(
                    executable='/bin/true', name='a', namespace='/ns'),
                after(1.0, LifecycleTransition(
                    lifecycle_node_names=['/ns/a'], transition_ids=[1, 3])),
            ])
        """
    )
    assert [m['transition'] for m in told if m['say'] == 'change_state'] == [
        'configure',
        'activate',
    ]
    assert sum(m['say'] == 'begin' for m in told) == 3


@pytest.mark.parametrize(
    ('event', 'later'),
    [
        # what is started later may be meant
        ('SignalProcess(signal_number=USR1, process_matcher=all_of)', [10]),
        ('SignalProcess(signal_number=USR1, process_matcher=is_late)', []),
        # a handler may take another stop for this one
        ('ShutdownProcess(process_matcher=matches_action(a))', [0]),
    ],
)
def test_requests_that_may_come_to_something_else_wait(
    launch: Launch, talking_worker: TalkingWorker, event: str, later: list[int]
) -> None:
    told = launch(
        f"""\
        def generate_launch_description():
            USR1 = signal.Signals(10)
            a, late = run('a'), run('late')
            all_of, is_late = lambda one: True, matches_action(late)
            return LaunchDescription([
                a, when(OnProcessExit(target_action=a, on_exit=[late])),
                after(1.0, emit({event})),
            ])
        """
    )
    assert [line.split()[0] for line in in_short(told)] == [
        'start',
        'begin',
        'call',
        'end',
    ]
    told = talking_worker.ask('call', number=1)
    assert [m['signal'] for m in told if m['say'] == 'signal'] == later
