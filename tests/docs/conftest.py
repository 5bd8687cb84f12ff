# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Somebody who reads the documentation."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from support.transcript import Reader
from support.user import User

IDENTITY = '[user]\nname = Ada\nemail = ada@example.com\n'


@pytest.fixture
def user(tmp_path: Path) -> Iterator[User]:
    """Return a user whom git knows."""
    made = User(tmp_path)
    (tmp_path / '.gitconfig').write_text(IDENTITY, encoding='utf-8')
    made.environment |= {
        'GIT_CONFIG_NOSYSTEM': '1',
        'TERM': 'xterm',
        'TMPDIR': str(tmp_path),
        'XDG_CONFIG_HOME': str(tmp_path),
    }
    yield made
    made.leave()


@pytest.fixture
def make_reader(
    user: User, ros_domain_id: int
) -> Iterator[Callable[[Path], Reader]]:
    """Make a reader who begins in a folder."""
    pytest.importorskip('rclpy', reason='needs the ROS wheels')
    environment = user.environment | {
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_DOMAIN_ID': str(ros_domain_id),
    }
    readers: list[Reader] = []

    def make(folder: Path) -> Reader:
        readers.append(Reader(folder, environment))
        return readers[-1]

    yield make
    for reader in readers:
        reader.leave()
