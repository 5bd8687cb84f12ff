# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files in Python, with the `launch` of a ROS 2."""

from collections.abc import Iterator
import os
from pathlib import Path
import re
import signal
import time

import pytest
from support.user import Launch, User

#: Seconds; a loaded machine needs some.
DEADLINE = 60
#: By it, all that a launch started is found.
MARK = 'T_MARK'

ROBOT = """\
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.actions import IncludeLaunchDescription
from launch.actions import RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare


def node(name, program='stay.sh'):
    return Node(
        package='robot', executable=program, name=name, output='screen'
    )


def generate_launch_description():
    base = node('base', 'hello.sh')
    hello = PathJoinSubstitution(
        [FindPackageShare('other'), 'launch', 'other.yaml']
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument('prefix', default_value='default'),
            base,
            node('eye'),
            IncludeLaunchDescription(hello),
            RegisterEventHandler(
                OnProcessExit(target_action=base, on_exit=[node('second')])
            ),
        ]
    )
"""
ABOVE = """\
launch:
  - push_ros_namespace: {namespace: farm}
  - include:
      file: $(find-pkg-share robot)/launch/robot.launch.py
      arg: [{name: prefix, value: ''}]
"""
HELLO = """\
launch:
  - executable:
      cmd: $(find-pkg-prefix {name})/lib/{name}/hello.sh [$(var prefix)]
      output: screen
"""
STAY = """\
#!/bin/sh
echo "there: $*"
exec sleep 1000
"""
COMPONENTS = """\
from launch import LaunchDescription
from launch_ros.actions import ComposableNodeContainer
from launch_ros.descriptions import ComposableNode


def generate_launch_description():
    return LaunchDescription(
        [
            ComposableNodeContainer(
                package='rclcpp_components',
                executable='component_container',
                name='box',
                namespace='',
                output='screen',
                composable_node_descriptions=[
                    ComposableNode(
                        package='composition',
                        plugin=f'composition::{name}',
                        name=name.lower(),
                    )
                    for name in ('Talker', 'Listener')
                ],
            ),
        ]
    )
"""


@pytest.fixture
def robot(ros_user: User) -> Iterator[User]:
    """Return a user with a package whose launch file is in Python."""
    ros_user.environment[MARK] = str(ros_user.root)
    folder = ros_user.package('robot', ABOVE)
    ros_user.package('other', HELLO)
    ros_user.write('src/robot/launch/robot.launch.py', ROBOT)
    ros_user.write('src/robot/scripts/stay.sh', STAY, 0o755)
    cmake = folder / 'CMakeLists.txt'
    text = cmake.read_text(encoding='utf-8')
    more = 'scripts/hello.sh scripts/stay.sh'
    cmake.write_text(text.replace('scripts/hello.sh', more), encoding='utf-8')
    yield ros_user
    ros_user.leave()
    assert not processes(ros_user)


def processes(user: User) -> list[str]:
    """Wait until nothing of a launch runs, and return what goes on."""
    wanted = f'{MARK}={user.root}\0'.encode()
    deadline = time.monotonic() + DEADLINE
    while True:
        found = []
        for path in Path('/proc').glob('[0-9]*'):
            try:
                if wanted in (path / 'environ').read_bytes():
                    found.append((path / 'comm').read_text())
            except OSError:
                continue
        if not found or time.monotonic() > deadline:
            return found
        time.sleep(0.05)


def start(robot: User) -> Launch:
    """Start a launch, and wait until its processes are there."""
    launch = robot.start('colcon', 'launch', 'robot', 'robot.yaml')
    launch.wait_for(r'eye\W+there: --ros-args .*__ns:=/farm')
    launch.wait_for(r'second\W+there: --ros-args .*__ns:=/farm')
    return launch


def test_what_it_needs_is_built_and_one_node_is_stopped(robot: User) -> None:
    launch = start(robot)
    # the package of the YAML file that the one in Python includes, too
    launch.wait_for(r'2 packages built')
    launch.wait_for(r'hello from other \[\]')
    robot.launch('--stop', 'second')
    status = robot.launch('--status')
    assert re.search(r'second +stopped', status)
    assert re.search(r'eye +running', status)
    assert launch.interrupt() == 0, launch.output
    assert 'Traceback' not in launch.output
    assert not processes(robot)


def test_a_killed_launch_leaves_nothing(robot: User) -> None:
    launch = start(robot)
    os.kill(launch.process.pid, signal.SIGKILL)
    assert not processes(robot)


def test_looking_shows_what_happens_when(robot: User) -> None:
    robot.launch('robot', 'robot.yaml', '--check')
    assert robot.launch('robot', 'robot.yaml', '--show-args')
    plan = robot.launch('robot', 'robot.yaml', '--plan')
    assert 'eye, process stay.sh-2, node /farm/eye' in plan
    assert 'when hello.sh-1 ends: start second' in plan
    assert not (robot.root / 'install').exists()


def test_components_of_ros(ros_user: User) -> None:
    index = 'share/ament_index/resource_index/packages/composition'
    prefixes = ros_user.environment['AMENT_PREFIX_PATH'].split(os.pathsep)
    if not any(Path(prefix, index).exists() for prefix in prefixes):
        pytest.skip('needs the package `composition` of ROS 2')
    ros_user.write('talk.launch.py', COMPONENTS)
    launch = ros_user.start('colcon', 'launch', 'talk.launch.py')
    launch.wait_for(r'I heard: \[Hello World')
    assert launch.interrupt() == 0, launch.output
