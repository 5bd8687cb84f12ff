# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Components and lifecycle nodes on another machine."""

from collections.abc import Iterator
import json
from pathlib import Path
import re

import pytest
from support.deployer import Deployer
from support.ros_parts import source_for
from support.sshd import Sshd

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
def ros_deployer(
    tmp_path: Path, sshd: Sshd, ros_parts: Path, ros_domain_id: int
) -> Iterator[Deployer]:
    home = tmp_path / 'deployer'
    home.mkdir()
    somebody = Deployer(home)
    source_for(somebody, ros_parts, ros_domain_id)
    somebody.environment = sshd.environment(somebody.environment)
    somebody.write('nodes.yaml', LAUNCH)
    machine = {
        'ssh': 'arm',
        'sync': 'none',
        'workspace': str(ros_parts.parent),
    }
    deployment = {
        'machines': {'arm': machine},
        'processes': [{'match': '*', 'machine': 'arm'}],
    }
    somebody.write('robot.yaml', json.dumps(deployment))
    yield somebody
    somebody.leave()


def test_nodes_there_are_controlled(
    ros_deployer: Deployer, sshd: Sshd
) -> None:
    launch = ros_deployer.start(
        'colcon', 'launch', '--deploy', 'robot.yaml', 'nodes.yaml'
    )
    launch.wait_for(r'talker: loaded')
    launch.wait_for(r'wrong: could not be loaded')
    launch.wait_for(r"/talker: 'Hello World")
    asked = ros_deployer.launch('--lifecycle', 'camera', 'configure')
    assert asked.endswith('camera: inactive\n'), asked
    table = ros_deployer.launch('--status')
    assert re.search(
        r'^  arm│box +running .*\n    \S*talker +loaded .*\n'
        r'    \S*wrong +not loaded: .*\n  arm│camera +running, inactive ',
        table,
        re.M,
    ), table
    # no program of it runs here
    commands = list(ros_deployer.processes().values())
    assert not any('component_container' in one for one in commands)
    # one component could not be loaded
    assert launch.interrupt() == 1, launch.output
    sshd.wait_until_empty()
    ros_deployer.wait_until_empty()
