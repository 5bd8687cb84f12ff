# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A container and a lifecycle node, from a user's second terminal."""

import json
from pathlib import Path
import re

import pytest
from support.ros_parts import source_for
from support.user import User

LAUNCH = """\
launch:
  - node_container:
      pkg: rclcpp_components
      exec: component_container
      name: box
      namespace: ''
      composable_node:
        - {pkg: composition, plugin: 'composition::Talker', name: talker}
        - {pkg: composition, plugin: 'composition::Missing', name: wrong}
  - lifecycle_node:
      pkg: composition
      exec: lifecycle_demo
      name: camera
      namespace: /demo
"""


@pytest.fixture
def second(user: User, ros_parts: Path, ros_domain_id: int) -> User:
    """Return a user who sees no launches but those of this test."""
    source_for(user, ros_parts, ros_domain_id)
    user.write('robot.yaml', LAUNCH)
    return user


def test_components_and_lifecycle_nodes_are_controlled(second: User) -> None:
    launch = second.start('colcon', 'launch', 'robot.yaml')
    launch.wait_for(r'talker: loaded')
    launch.wait_for(r'wrong: could not be loaded')
    launch.wait_for(r"/talker: 'Hello World")
    asked = second.launch('--lifecycle', 'camera', 'configure')
    # whatever it says while it waits
    assert asked.endswith('camera: inactive\n'), asked
    table = second.launch('--status')
    assert re.search(
        r'^  box +running .*\n    talker +loaded .*\n'
        r'    wrong +not loaded: .*\n  camera +running, inactive ',
        table,
        re.M,
    ), table
    (state,) = json.loads(second.launch('--status=json'))['launches']
    assert [p['lifecycle'] for p in state['processes']] == [None, 'inactive']
    talker, wrong = state['components']
    assert (talker['node'], talker['process']) == ('/talker', 'box')
    assert (wrong['phase'], wrong['lifecycle']) == ('failed', None)
    refused = second.launch('--lifecycle', '/demo', 'configure', code=1)
    assert 'camera: configure failed: ' in refused
    assert refused.endswith('; it could activate or cleanup or shutdown\n')
    assert 'talker: unloaded\n' in second.launch('--stop', '/talker')
    again = second.launch('--restart', 'talker')
    assert 'talker: loaded anew into box\n' in again
    again = second.launch('--restart', 'box', code=1)
    assert re.search(r'^box: started anew, pid \d+$', again, re.M), again
    assert 'talker: loaded anew into box\n' in again
    assert 'wrong: could not be loaded: ' in again
    assert "/talker: 'Hello World" in second.launch('--logs', 'talker')
    assert launch.interrupt() == 1, launch.output
