# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from pathlib import Path

import pytest
from support.history import History
from support.ros_parts import sourced
from support.ros_talk import Environment


@pytest.fixture
def history():
    """Return a function that begins a launch without a process."""

    def begin(*entries, refused=()):
        made = History(*entries)
        made.host.refused.update(refused)
        made.turn()
        return made

    return begin


@pytest.fixture(scope='module')
def underlay(ros_parts: Path) -> Environment:
    """Return the environment with the packages of `ros_parts` sourced."""
    return sourced(ros_parts)


@pytest.fixture
def environment(underlay: Environment, ros_domain_id: int) -> Environment:
    """Return the environment for nodes of one test."""
    return underlay | {
        'PYTHONUNBUFFERED': '1',
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_DOMAIN_ID': str(ros_domain_id),
    }
