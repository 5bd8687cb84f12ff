# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What launch files in Python do when something happens."""

import os
from pathlib import Path
import signal

from support.user import User

FILE = """\
from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch.actions import LogInfo
from launch.actions import OpaqueFunction
from launch.actions import RegisterEventHandler
from launch.actions import TimerAction
from launch.event_handlers import OnProcessExit
from launch.event_handlers import OnProcessIO
from launch.event_handlers import OnProcessStart
from launch.event_handlers import OnShutdown


def sleeping(name):
    return ExecuteProcess(cmd=['sleep', '99'], name=name)


def ended(event, context):
    return [LogInfo(msg=f'returned {event.returncode}'), sleeping('late')]


def heard(event):
    if b'ready' in event.text:
        return TimerAction(period=0.0, actions=[
            OpaqueFunction(function=lambda context: [sleeping('called')]),
        ])


def generate_launch_description():
    a = ExecuteProcess(cmd=['sh', '-c', 'echo ready; exit 3'], name='a')
    return LaunchDescription([
        a,
        RegisterEventHandler(OnProcessStart(on_start=[LogInfo(msg='one up')])),
        RegisterEventHandler(OnProcessIO(target_action=a, on_stdout=heard)),
        RegisterEventHandler(OnProcessExit(target_action=a, on_exit=ended)),
        RegisterEventHandler(OnShutdown(
            on_shutdown=lambda event, context: LogInfo(msg=event.reason),
        )),
    ])
"""


def host_of(pid: int) -> int:
    """Return the process that reads launch files for a launch."""
    tasks = Path(f'/proc/{pid}/task/{pid}/children').read_text().split()
    for child in map(int, tasks):
        if (
            b'python_launch/worker'
            in Path(f'/proc/{child}/cmdline').read_bytes()
        ):
            return child
    raise AssertionError


def test_a_launch_grows_as_its_event_handlers_say(ros_user: User) -> None:
    ros_user.write('demo.launch.py', FILE)
    ros_user.write('demo.yaml', 'launch: [include: {file: demo.launch.py}]\n')
    plan = ros_user.launch('./demo.yaml', '--plan')
    assert 'when a-1 ends: call ended (demo.launch.py:17)' in plan
    assert 'when the launch ends: call lambda' in plan
    launch = ros_user.start('colcon', 'launch', './demo.yaml')
    launch.wait_for('returned 3')
    launch.wait_for('late-[23]: started')
    launch.wait_for('called-[23]: started')
    status = ros_user.launch('--status')
    assert 'late' in status
    assert 'called' in status
    ros_user.launch('--stop', 'late')
    assert launch.interrupt() == 1
    assert launch.output.count('one up') == 3
    assert launch.output.count('late-') >= 2
    assert '[launch.user]: ctrl-c (SIGINT)' in launch.output


def test_the_rest_goes_on_without_the_host(ros_user: User) -> None:
    ros_user.write('demo.launch.py', FILE)
    launch = ros_user.start('colcon', 'launch', './demo.launch.py')
    launch.wait_for('called-[23]: started')
    launch.wait_for('late-[23]: started')
    os.kill(host_of(launch.process.pid), signal.SIGKILL)
    launch.wait_for('worker for Python launch files died by SIGKILL')
    assert 'late' in ros_user.launch('--status')
    assert launch.interrupt() == 1
    assert 'failed: the worker for Python launch files' in launch.output
    assert '[launch.user]: ctrl-c (SIGINT)' not in launch.output
