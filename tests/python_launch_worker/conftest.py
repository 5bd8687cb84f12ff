# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the tests of the worker for Python launch files share."""

from collections.abc import Callable, Iterator
from pathlib import Path
import textwrap

import pytest
from support.ros_setup import RosSetup
from support.talking_worker import HEAD, Message, TalkingWorker


@pytest.fixture(scope='module')
def _running_worker(ros_setup: RosSetup) -> Iterator[TalkingWorker]:
    worker = TalkingWorker(ros_setup.python, ros_setup.environment)
    yield worker
    worker.close()


@pytest.fixture
def talking_worker(
    ros_setup: RosSetup,
    _running_worker: TalkingWorker,
) -> TalkingWorker:
    """Return the worker, which knows nothing of tests before."""
    _running_worker.begin()
    return _running_worker


@pytest.fixture
def launch(
    talking_worker: TalkingWorker, tmp_path: Path
) -> Callable[[str], list[Message]]:
    """Return what visits a launch file, given what makes its description."""
    path = tmp_path / 'demo.launch.py'

    def launch(text: str) -> list[Message]:
        path.write_text(HEAD + textwrap.dedent(text))
        told = talking_worker.visit(path)
        told += talking_worker.ask('finish')
        return told

    return launch
