# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What launch files in Python do when something happens."""

from collections.abc import Callable
from pathlib import Path
import textwrap
from typing import Any

import pytest
from support.ros_setup import RosSetup
from support.talking_worker import (
    HEAD,
    in_short,
    lines_of,
    Message,
    TalkingWorker,
)

Launch = Callable[[str], list[Message]]


def handlers_of(told: list[Message]) -> list[dict[str, Any]]:
    """Return the event handlers that were told last."""
    found = [m['handlers'] for m in told if m['say'] == 'handlers']
    return list(found[-1]) if found else []


def outputs_of(told: list[Message]) -> list[object]:
    """Return the processes whose output is to be told."""
    found = [m['output'] for m in told if m['say'] == 'handlers']
    return list(found[-1]) if found else []


def test_handlers_are_told_before_anything_happens(launch: Launch) -> None:
    told = launch(
        """\
        def on_exit(event, context):
            return None

        def generate_launch_description():
            first, second = run('first'), run('second')
            return LaunchDescription([
                first,
                when(OnProcessExit(target_action=first, on_exit=[
                    second, say('on'), emit(ShuttingDown(reason='done'))])),
                when(OnProcessExit(on_exit=on_exit)),
                when(OnProcessStart(
                    target_action=second, on_start=[GroupAction([run('x')])])),
                when(OnProcessIO(
                    target_action=lambda action: action is first,
                    on_stdout=on_exit)),
                when(OnShutdown(on_shutdown=[say('bye')], handle_once=True)),
                when(OnExecutionComplete(target_action=second, on_completion=[
                    TimerAction(period=2.0, actions=[run('y')])])),
            ])
        """
    )
    line = HEAD.count('\n') + 2
    first = ['[first]']
    call = f'call on_exit (demo.launch.py:{line - 1})'
    assert [
        (h['event'], h['processes'], h['condition'], h['actions'])
        for h in handlers_of(told)
    ] == [
        (
            'exit',
            ['[first]'],
            '',
            ['start second', 'say "on"', 'shut down: done'],
        ),
        ('exit', None, '', [call]),
        ('start', ['second'], '', ['start x']),
        ('output', first, '', [call]),
        ('shutdown', None, 'once', ['say "bye"']),
        ('complete', ['second'], '', ['after 2.0 s: start y']),
    ]
    assert [h['position'][1] for h in handlers_of(told)] == [
        line + offset for offset in (6, 8, 9, 11, 14, 15)
    ]
    assert [m['output'] for m in told if m['say'] == 'handlers'] == [
        ['[first]']
    ]


def test_packages_that_handlers_need_are_told(launch: Launch) -> None:
    told = launch(
        """\
        from launch.launch_description_sources import *
        from launch_ros.actions import *
        from launch_ros.descriptions import *
        from launch_ros.substitutions import *

        def generate_launch_description():
            b = Node(package='later_b', executable='b', parameters=[
                [FindPackageShare('later_d'), '/b.yaml']])
            return LaunchDescription([
                SetLaunchConfiguration('which', 'later_a'),
                when(OnProcessExit(on_exit=[
                    Node(package=LaunchConfiguration('which'), executable='a'),
                    when(OnProcessExit(on_exit=[GroupAction([b])])),
                    TimerAction(period=1.0, actions=[LoadComposableNodes(
                        target_container='box', composable_node_descriptions=[
                            ComposableNode(package='later_c', plugin='C')])]),
                    IncludeLaunchDescription(PythonLaunchDescriptionSource([
                        FindPackageShare('later_e'), '/e.launch.py'])),
                ])),
            ])
        """
    )
    named = {m['name']: m['position'] for m in told if m['say'] == 'package'}
    assert sorted(named) == [f'later_{letter}' for letter in 'abcde']
    first = HEAD.count('\n') + 1
    assert named['later_b'][1] == first + 6
    assert named['later_c'][1] == first + 15


def test_output_is_told_and_kept(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    told = launch(
        """\
        def heard(event):
            stream = 'stdout' if event.from_stdout else 'stderr'
            return say(stream + ': ' + event.text.decode(errors='replace'))

        def generate_launch_description():
            a, b = run('a', cached_output=True), run('b')
            return LaunchDescription([
                a, b, run('c'),
                when(OnProcessIO(
                    target_action=b, on_stdout=heard, on_stderr=heard)),
                when(OnProcessExit(target_action=a, on_exit=lambda e, c:
                    say(a.get_stdout() + a.get_stderr()))),
            ])
        """
    )
    assert [m['output'] for m in told if m['say'] == 'handlers'] == [
        ['[a]', '[b]']
    ]

    def wrote(process: str, stream: str, text: str) -> list[str]:
        told = talking_worker.event(
            'output', process=process, stream=stream, text=text
        )
        return in_short(told)

    for number, name in enumerate('abc', 10):
        talking_worker.event('start', process=name, pid=number)
    assert wrote('b', 'stdout', 'hello') == ['stdout: hello']
    assert wrote('b', 'stderr', 'bad \udcff') == ['stderr: bad \ufffd']
    assert wrote('a', 'stdout', 'one ') == []
    assert wrote('a', 'stdout', 'two ') == []
    assert wrote('a', 'stderr', 'three') == []
    assert talking_worker.ended('a') == ['one two three']


def test_an_action_that_is_started_twice(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    launch(
        """\
        def ended(event, context):
            return say(f'{event.pid}')

        def generate_launch_description():
            a, b = run('a'), run('b')
            return LaunchDescription([
                a,
                b,
                when(OnProcessExit(target_action=a, on_exit=ended)),
                when(OnProcessStart(target_action=b, on_start=[a])),
            ])
        """
    )
    talking_worker.event('start', process='a', pid=10)
    talking_worker.event('start', process='b', pid=11)
    # that of the second time, which has not begun
    assert talking_worker.ended('a') == ['None']


def test_a_launch_file_ends_the_launch(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    launch(
        """\
        def down(event, context):
            return say(f'{event.reason} {context.is_shutdown}')

        def generate_launch_description():
            a = run('a')
            return LaunchDescription([
                a,
                when(OnProcessExit(target_action=a, on_exit=[
                    emit(ShuttingDown(reason='enough')), say('bye')])),
                when(OnShutdown(on_shutdown=down)),
                when(OnShutdown(on_shutdown=[
                    say('because ', LocalSubstitution('event.reason'))])),
            ])
        """
    )
    assert talking_worker.ended('a') == ['bye', 'shutdown: enough']
    told = talking_worker.event('shutdown', reason='enough', by_sigint=False)
    assert in_short(told) == ['because enough', 'enough False']


def test_someone_else_ends_the_launch(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    launch(
        """\
        def down(event, context):
            return [say(f'{event.due_to_sigint} {context.is_shutdown}'),
                    run('late')]

        def generate_launch_description():
            a = run('a')
            return LaunchDescription([
                a, when(OnShutdown(on_shutdown=down)),
                when(OnProcessExit(on_exit=[say('ended'), run('later')])),
            ])
        """
    )
    told = talking_worker.event('shutdown', reason='Ctrl-C', by_sigint=True)
    assert in_short(told) == ['True True']
    told = talking_worker.event('exit', process='a', returncode=-2)
    # nothing is started any more
    assert in_short(told) == ['ended']


def test_the_end_of_a_process_gives_the_reason(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    told = launch(
        """\
        def generate_launch_description():
            return LaunchDescription([
                run('a', on_exit=Shutdown(reason='a is needed')),
                when(OnShutdown(on_shutdown=lambda e, c: say(e.reason))),
            ])
        """
    )
    processes = [m for m in told if m['say'] == 'process']
    assert [p['on_exit_shutdown'] for p in processes] == [True]
    assert len(handlers_of(told)) == 1
    assert talking_worker.ended('a') == []
    told = talking_worker.event('shutdown', reason='a ended', by_sigint=False)
    assert in_short(told) == ['a is needed']


def test_processes_are_signalled(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    launch(
        """\
        def generate_launch_description():
            a, b, c = run('a'), run('b'), run('c')
            return LaunchDescription([
                a, b, c,
                when(OnProcessStart(target_action=a, on_start=[
                    emit(SignalProcess(signal_number=signal.SIGUSR1,
                                       process_matcher=matches_action(b))),
                    emit(ShutdownProcess(process_matcher=lambda one: True)),
                ])),
                when(OnProcessStart(target_action=b, on_start=[
                    emit(SignalProcess(signal_number='SIGKILL',
                                       process_matcher=matches_pid(6)))])),
            ])
        """
    )
    assert in_short(talking_worker.event('start', process='b', pid=6)) == [
        'signal 9 to b'
    ]
    talking_worker.event('exit', process='c', returncode=0)
    # not the one that has ended
    assert in_short(talking_worker.event('start', process='a', pid=5)) == [
        'signal 10 to b',
        'signal 0 to a',
        'signal 0 to b',
    ]


def test_an_end_that_was_asked_for_is_none(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    launch(
        """\
        def generate_launch_description():
            a, b = run('a'), run('b')
            return LaunchDescription([
                a, b,
                when(OnProcessStart(on_start=[say('started')])),
                when(OnProcessExit(on_exit=[say('ended')])),
                when(OnProcessExit(target_action=b, on_exit=[
                    emit(ShutdownProcess(process_matcher=matches_action(a)))
                ])),
            ])
        """
    )

    def ended(process: str, *, asked: bool) -> list[str]:
        told = talking_worker.event(
            'exit', process=process, returncode=0, asked=asked
        )
        return in_short(told)

    assert ended('a', asked=True) == []
    # by --restart
    told = talking_worker.event('start', process='a', pid=5)
    assert in_short(told) == ['started']
    assert ended('b', asked=False) == ['ended', 'signal 0 to a']
    # but a launch file may ask for it
    assert ended('a', asked=True) == ['ended']
    told = talking_worker.event('start', process='a', pid=6)
    talking_worker.event('shutdown', reason='x', by_sigint=False)
    assert ended('a', asked=True) == ['ended']


def test_events_of_ones_own(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    told = launch(
        """\
        class Ping(Event):
            def __init__(self, number):
                self.number = number

        def ping(context):
            number = context.locals.event.number
            more = [emit(Ping(number + 1))] if number < 2 else []
            return [say(f'ping {number}'), *more]

        def generate_launch_description():
            return LaunchDescription([
                emit(Ping(1)), say('read'), run('a'),
                when(EventHandler(
                    matcher=lambda event: isinstance(event, Ping),
                    entities=[OpaqueFunction(function=ping)])),
                when(OnProcessExit(on_exit=[emit(Ping(2)), say('ended')])),
            ])
        """
    )
    # what is emitted while the files are read is handled when they are read
    assert in_short(told) == ['read', 'start a', 'ping 1', 'ping 2']
    assert [h['event'] for h in handlers_of(told)] == ['other', 'exit']
    assert talking_worker.ended('a') == ['ended', 'ping 2']


def test_actions_are_done(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    told = launch(
        """\
        def generate_launch_description():
            a, log = run('a', respawn=True), say('log')
            return LaunchDescription([
                when(OnExecutionComplete(
                    target_action=log, on_completion=[say('logged')])),
                when(OnExecutionComplete(
                    target_action=a, on_completion=[say('done')])),
                when(OnProcessExit(target_action=a, on_exit=[say('ended')])),
                log, a,
            ])
        """
    )
    assert in_short(told) == ['log', 'start a', 'logged']

    def ended(**more: bool) -> list[str]:
        told = talking_worker.event('exit', process='a', returncode=0, **more)
        return in_short(told)

    assert ended(respawns=True) == ['ended']
    assert ended(respawns=False) == ['ended', 'done']


def test_an_exception_ends_the_launch(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    told = launch(
        """\
        def bad(event, context):
            return [say('x'), {}['nothing']]

        def generate_launch_description():
            a = run('a')
            return LaunchDescription([
                a, when(OnProcessExit(on_exit=bad)),
                when(OnProcessExit(target_action=a, on_exit=[
                    say('told'), when(OnProcessExit(on_exit=[run('b')]))])),
                when(OnShutdown(on_shutdown=lambda e, c:
                    say(f'{e.reason} {c.is_shutdown}'))),
            ])
        """
    )
    told = talking_worker.event_to_end('exit', process='a', returncode=0)
    assert in_short(told) == [
        'told',
        'shutdown: a launch file raised KeyError',
    ]
    error = told[-1]['error']
    assert error['text'] == "KeyError: 'nothing'"
    assert lines_of(error['frames']) == ["return [say('x'), {}['nothing']]"]
    # what happened before is not undone
    assert [m['handlers'] for m in told if m['say'] == 'handlers'] == [True]
    told = talking_worker.event('shutdown', reason='x', by_sigint=False)
    assert in_short(told) == [
        "Caught exception in launch (see debug for traceback): 'nothing' True"
    ]


def test_what_needs_the_event_loop_comes_too_late(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    launch(
        """\
        async def wait(context):
            pass

        def generate_launch_description():
            return LaunchDescription([run('a'), when(OnProcessExit(on_exit=[
                say('told'), OpaqueCoroutine(coroutine=wait)]))])
        """
    )
    told = talking_worker.event_to_end('exit', process='a', returncode=0)
    assert in_short(told) == [
        'told',
        'shutdown: a launch file raised RuntimeError',
    ]
    error = told[-1]['error']
    assert error['text'].startswith(
        "RuntimeError: OpaqueCoroutine needs the event loop of 'ros2 launch'"
    )
    assert error['frames'][-1]['position'][1] == HEAD.count('\n') + 6


def test_lifecycle_nodes_change_their_states(
    launch: Launch, talking_worker: TalkingWorker, ros_setup: RosSetup
) -> None:
    if ros_setup.environment.get('ROS_DISTRO') == 'humble':
        pytest.skip('Humble has no LifecycleTransition')
    told = launch(
        """\
        from launch_ros.actions import LifecycleNode, LifecycleTransition
        from launch_ros.event_handlers import OnStateTransition
        from launch_ros.events.lifecycle import ChangeState
        from launch_ros.events.lifecycle import matches_node_name
        from launch.events import matches_action

        def node(name):
            return LifecycleNode(
                executable='/bin/' + name, name=name, namespace='/ns')

        def generate_launch_description():
            a, b = node('a'), node('b')
            return LaunchDescription([
                a, b,
                LifecycleTransition(
                    lifecycle_node_names=['/ns/a'], transition_ids=[1, 3]),
                when(OnStateTransition(
                    target_lifecycle_node=a, start_state='activating',
                    goal_state='active', entities=[
                        emit(ChangeState(
                            lifecycle_node_matcher=matches_action(b),
                            transition_id=1)),
                        emit(ChangeState(
                            lifecycle_node_matcher=lambda node: True,
                            transition_id=6))])),
            ])
        """
    )
    assert in_short(told) == [
        'start a',
        'start b',
        'configure /ns/a',
    ]
    a = ['[a]']
    assert [
        (h['event'], h['processes'], h['condition'], h['actions'])
        for h in handlers_of(told)
    ] == [
        (
            'state',
            ['[a]'],
            'configuring to inactive, once',
            ['activate /ns/a'],
        ),
        (
            'state',
            a,
            'activating to active',
            ['configure b', 'shutdown a, b'],
        ),
    ]

    def became(node: str, before: str, after: str) -> list[str]:
        told = talking_worker.event(
            'state',
            process=None,
            node=node,
            to=after,
            **{'from': before},
        )
        return in_short(told)

    assert became('/ns/b', 'configuring', 'inactive') == []
    assert became('/ns/a', 'unconfigured', 'configuring') == []
    assert became('/ns/a', 'configuring', 'inactive') == ['activate /ns/a']
    assert became('/ns/a', 'configuring', 'inactive') == []
    assert became('/ns/a', 'activating', 'active') == [
        'configure /ns/b',
        'shutdown /ns/b',
        'shutdown /ns/a',
    ]


def test_processes_are_counted_with_those_of_others(
    talking_worker: TalkingWorker, tmp_path: Path
) -> None:
    path = tmp_path / 'demo.launch.py'
    path.write_text(
        HEAD
        + textwrap.dedent(
            """\
            def generate_launch_description():
                return LaunchDescription([
                    run('a'), when(OnProcessExit(
                        on_exit=lambda e, c: say(e.process_name)))])
            """
        )
    )
    scope = {'configurations': {}, 'processes': 4}
    talking_worker.ask('visit', path=str(path), scope=scope)
    assert talking_worker.ended('a') == ['a-5']


def test_a_file_that_fails_leaves_no_handlers(
    launch: Launch, talking_worker: TalkingWorker
) -> None:
    told = launch(
        """\
        def generate_launch_description():
            return LaunchDescription([
                run('a', on_exit=[say('x')]), emit(ShuttingDown()),
                OpaqueFunction(function=lambda context: 1 / 0),
            ])
        """
    )
    assert in_short(told) == ['start a']
    assert handlers_of(told) == []
    assert talking_worker.ended('a') == []
