# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What launch files in Python do later."""

from collections.abc import Callable

from support.talking_host import HEAD
from support.talking_host import in_short
from support.talking_host import Message
from support.talking_host import TalkingHost

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
    launch: Launch, talking_host: TalkingHost
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
    assert in_short(talking_host.ask('call', number=1)) == [
        'x was where it stands',
        'set',
    ]
    assert in_short(talking_host.ask('call', number=2)) == ['start own']


def test_timers_are_cancelled(
    launch: Launch, talking_host: TalkingHost
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
    assert in_short(talking_host.ask('call', number=1)) == ['early']
    talking_host.event('exit', process='a', returncode=0)
    assert in_short(talking_host.ask('call', number=2)) == []


def test_timers_are_done(launch: Launch, talking_host: TalkingHost) -> None:
    told = launch(
        """\
        def generate_launch_description():
            timer, log = after(1.0, say('a')), say('b')
            return LaunchDescription([
                RegisterEventHandler(OnExecutionComplete(
                    target_action=timer, on_completion=[say('timer')])),
                RegisterEventHandler(OnExecutionComplete(
                    target_action=log, on_completion=[say('log')])),
                timer, after(2.0, log),
            ])
        """
    )
    assert in_short(told) == [
        'begin timer',
        'a',
        'call 1: see to the timer',
        'end',
        'begin timer',
        'call 2: say "b"',
        'end',
    ]
    assert in_short(talking_host.ask('call', number=1)) == ['timer']
    assert in_short(talking_host.ask('call', number=2)) == ['b', 'log']


def test_what_fails_at_its_time_ends_the_launch(
    launch: Launch, talking_host: TalkingHost
) -> None:
    launch(
        """\
        def generate_launch_description():
            return LaunchDescription([after(
                1.0, OpaqueFunction(function=lambda context: 1 / 0))])
        """
    )
    told = talking_host.ask_to_end('call', number=1)
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


def test_handlers_start_timers(
    launch: Launch, talking_host: TalkingHost
) -> None:
    launch(
        """\
        def generate_launch_description():
            return LaunchDescription([run('a'), RegisterEventHandler(
                OnProcessExit(on_exit=[after(
                    1.0,
                    say(LocalSubstitution('event.name')),
                    EmitEvent(event=ShuttingDown(reason='timed out')),
                    OpaqueFunction(function=lambda context: [
                        say(str(context.locals.event.returncode))]),
                )]))])
        """
    )
    assert talking_host.ended('a')[:3] == [
        'begin timer',
        'launch.events.process.ProcessExited',
        'shutdown: timed out',
    ]
    assert in_short(talking_host.ask('call', number=1)) == ['0']
