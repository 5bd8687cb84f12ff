# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon launch --watch` with launch files in Python."""

from support.manifest import manifest
from support.user import User
from support.watched import wait_until

CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(flow NONE)
install(PROGRAMS talk.sh DESTINATION lib/flow)
"""
TALK = '#!/bin/sh\necho talk one; exec sleep 999\n'
PLAIN = """\
import helper
from launch import LaunchDescription
from launch.actions import ExecuteProcess


def generate_launch_description():
    return LaunchDescription([
        ExecuteProcess(cmd=['sleep', helper.SECONDS], name='a'),
        ExecuteProcess(cmd=['sleep', '998'], name='b'),
    ])
"""
GROWING = """\
from launch import LaunchDescription
from launch.actions import ExecuteProcess
from launch.actions import RegisterEventHandler
from launch.actions import Shutdown
from launch.event_handlers import OnProcessExit
from launch.event_handlers import OnProcessStart
from launch_ros.actions import Node


def generate_launch_description():
    talk = Node(package='flow', executable='talk.sh', output='screen')
    late = ExecuteProcess(cmd=['sleep', '997'], name='late')
    return LaunchDescription([
        talk,
        RegisterEventHandler(
            OnProcessStart(target_action=talk, on_start=[late])
        ),
        RegisterEventHandler(
            OnProcessExit(target_action=talk, on_exit=[Shutdown()])
        ),
    ])
"""


def test_python_launch_file_is_read_again(ros_user: User) -> None:
    ros_user.environment['PYTHONPATH'] += f':{ros_user.root}'
    ros_user.write('helper.py', "SECONDS = '999'\n")
    ros_user.write('plain.launch.py', PLAIN)
    launch = ros_user.start('colcon', 'launch', './plain.launch.py', '--watch')
    launch.wait_for('b-2: started')
    ros_user.write('helper.py', "SECONDS = '1996'\n")
    launch.wait_for('helper.py changed: restarted a-1')
    broken = PLAIN.replace("'998'", "'998")
    ros_user.write('plain.launch.py', broken)
    launch.wait_for('plain.launch.py changed: it cannot be launched so')
    assert 'SyntaxError' in launch.output
    ros_user.write('plain.launch.py', PLAIN.replace('998', '1995'))
    launch.wait_for('plain.launch.py changed: restarted b-2')
    assert launch.interrupt() == 0
    assert 'begins anew' not in launch.output


def test_launch_with_event_handlers_restarts(ros_user: User) -> None:
    ros_user.write('src/flow/package.xml', manifest('flow', 'cmake'))
    ros_user.write('src/flow/CMakeLists.txt', CMAKE)
    ros_user.write('src/flow/talk.sh', TALK, 0o755)
    ros_user.write('demo.launch.py', GROWING)
    launch = ros_user.start('colcon', 'launch', './demo.launch.py', '--watch')
    launch.wait_for('late-2: started')
    # a restart is no end that its handlers are told of
    ros_user.write('src/flow/talk.sh', TALK.replace('one', 'two'), 0o755)
    launch.wait_for(r'talk.sh changed: restarted talk')
    launch.wait_for('talk two')
    assert launch.output.count('late-2: started') == 1
    ros_user.write('demo.launch.py', GROWING.replace("'997'", "'1994'"))
    launch.wait_for('demo.launch.py changed: the launch begins anew')
    wait_until(lambda: launch.output.count('late-2: started') == 2)
    assert 'late-2: stopped' in launch.output
    assert launch.process.poll() is None
    assert launch.interrupt() == 0
