# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon launch --watch` with a container and a lifecycle node."""

from pathlib import Path

import pytest
from support.manifest import manifest
from support.ros_parts import source_for
from support.user import User

CMAKE = """\
cmake_minimum_required(VERSION 3.16)
project(robot NONE)
install(PROGRAMS camera.py DESTINATION lib/robot)
"""
CAMERA = """\
#!/usr/bin/env python3
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode


class Camera(LifecycleNode):
    def on_activate(self, state):
        print('camera one active', flush=True)
        return super().on_activate(state)


rclpy.init()
try:
    rclpy.spin(Camera('camera'))
except (KeyboardInterrupt, ExternalShutdownException):
    pass
"""
LAUNCH = """\
launch:
  - lifecycle_node:
      pkg: robot
      exec: camera.py
      name: camera
      namespace: ''
      output: screen
  - node_container:
      pkg: rclcpp_components
      exec: component_container
      name: box
      namespace: ''
      composable_node:
        - pkg: composition
          plugin: composition::Talker
          name: talker
          param: [{from: talker.yaml}]
        - {pkg: composition, plugin: 'composition::Listener', name: listener}
"""
PARAMETERS = 'talker:\n  ros__parameters: {period: 99.0}\n'


@pytest.fixture
def robot(user: User, ros_parts: Path, ros_domain_id: int) -> User:
    """Return a user with a robot, whose launches nobody else sees."""
    source_for(user, ros_parts, ros_domain_id)
    user.write('src/robot/package.xml', manifest('robot', 'cmake'))
    user.write('src/robot/CMakeLists.txt', CMAKE)
    user.write('src/robot/camera.py', CAMERA, 0o755)
    user.write('talker.yaml', PARAMETERS)
    user.write('robot.yaml', LAUNCH)
    return user


def test_components_and_states_are_restored(robot: User) -> None:
    launch = robot.start('colcon', 'launch', './robot.yaml', '--watch')
    launch.wait_for('listener: loaded')
    robot.launch('--lifecycle', 'camera', 'configure')
    robot.launch('--lifecycle', 'camera', 'activate')
    launch.wait_for('camera one active')
    # a lifecycle node gets its state back
    robot.write('src/robot/camera.py', CAMERA.replace('one', 'two'), 0o755)
    launch.wait_for(r'\[watch\] +camera.py changed: restarted camera')
    launch.wait_for('camera two active')
    # a component is loaded anew, and its container runs on
    robot.write('talker.yaml', PARAMETERS.replace('99.0', '0.1'))
    launch.wait_for(r'\[watch\] +talker.yaml changed: restarted talker')
    launch.wait_for("/talker: 'Hello World")
    # one that has another name is another one
    other = LAUNCH.replace('name: listener', 'name: ear')
    robot.write('robot.yaml', other)
    launch.wait_for('robot.yaml changed: stopped listener, started ear')
    launch.wait_for('/ear: I heard')
    assert launch.interrupt() == 0
    assert launch.output.count('box: started') == 1
    assert 'Traceback' not in launch.output
