# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Users with workspaces."""

from collections.abc import Callable, Iterator
from pathlib import Path
import shutil

import pytest
from support.ros_setup import RosSetup
from support.user import User

SAMPLE_WS = Path(__file__).parents[2] / 'sample_ws'


@pytest.fixture
def make_user(tmp_path: Path) -> Iterator[Callable[[], User]]:
    """Make users with a workspace of their own."""
    users: list[User] = []

    def make() -> User:
        home = tmp_path / f'user{len(users)}'
        home.mkdir()
        users.append(User(home))
        return users[-1]

    yield make
    for somebody in users:
        somebody.leave()


@pytest.fixture
def user(make_user: Callable[[], User]) -> User:
    return make_user()


@pytest.fixture
def ros_user(user: User, ros_setup: RosSetup, ros_domain_id: int) -> User:
    """Return a user who has sourced a ROS 2 that has `launch`."""
    own = ('HOME', 'XDG_RUNTIME_DIR')
    user.environment = {
        **ros_setup.environment,
        **{name: user.environment[name] for name in own},
        'ROS_DOMAIN_ID': str(ros_domain_id),
    }
    return user


@pytest.fixture
def copy_sample_ws(user: User) -> Callable[[], Path]:
    """Copy the sample workspace, without what somebody built there."""

    def copy() -> Path:
        products = [SAMPLE_WS / name for name in ('build', 'install', 'log')]

        def ignored(folder: str, names: list[str]) -> list[str]:
            return [
                name
                for name in names
                if name == '__pycache__' or Path(folder, name) in products
            ]

        user.root.rmdir()
        shutil.copytree(SAMPLE_WS, user.root, ignore=ignored)
        return user.root

    return copy
