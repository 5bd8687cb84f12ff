# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the tests of the host of launch files in Python share."""

from collections.abc import Iterator

import pytest
from support.ros_setup import RosSetup
from support.talking_host import TalkingHost


@pytest.fixture(scope='module')
def _running_host(ros_setup: RosSetup) -> Iterator[TalkingHost]:
    host = TalkingHost(ros_setup.python, ros_setup.environment)
    yield host
    host.close()


@pytest.fixture
def talking_host(
    ros_setup: RosSetup,
    _running_host: TalkingHost,
) -> TalkingHost:
    """Return the host, which knows nothing of tests before."""
    _running_host.begin()
    return _running_host
