# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the tests of the worker for Python launch files share."""

from collections.abc import Callable, Iterator
from pathlib import Path
import textwrap

import pytest
from support.ros_setup import RosSetup
from support.talking_host import HEAD, Message, TalkingHost


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
    """Return the worker, which knows nothing of tests before."""
    _running_host.begin()
    return _running_host


@pytest.fixture
def launch(
    talking_host: TalkingHost, tmp_path: Path
) -> Callable[[str], list[Message]]:
    """Return what visits a launch file, given what makes its description."""
    path = tmp_path / 'demo.launch.py'

    def launch(text: str) -> list[Message]:
        path.write_text(HEAD + textwrap.dedent(text))
        told = talking_host.visit(path)
        told += talking_host.ask('finish')
        return told

    return launch
