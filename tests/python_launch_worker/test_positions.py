# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Positions are those of calls in the user's files."""

import ast
from collections.abc import Callable
import inspect
from pathlib import Path
import sys
from typing import Any

from colcon_yamllaunch.python_launch.worker.positions import Positions
import pytest

HAS_COLUMNS = sys.version_info >= (3, 11)


class Made:
    """Something whose place is noted."""


@pytest.fixture
def positions() -> Positions:
    positions = Positions()
    # these tests stand where `launch` does
    positions._users[__file__] = False
    return positions


def run(path: Path, source: str, note: Callable[[object], None]) -> Any:
    """Run a launch file, which has `make`, and return its `made`."""
    path.write_text(source)

    def make(**_: object) -> Made:
        made = Made()
        note(made)
        return made

    scope: dict[str, Any] = {'make': make}
    exec(compile(source, str(path), 'exec'), scope)
    return scope['made']


def test_the_call_is_the_position(
    tmp_path: Path, positions: Positions
) -> None:
    path = tmp_path / 'a.launch.py'
    positions.add_file(str(path))
    helper = "def helper():\n    return ['é', make(\n        x=1)]\n"
    made = run(path, f'{helper}made = helper()[1]\n', positions.note)
    column = 18 if HAS_COLUMNS else 5
    assert positions.of(made) == [str(path), 2, column]


@pytest.mark.parametrize(
    ('path', 'is_users'),
    [
        ('/ws/src/p/p/helpers.py', True),
        ('/ws/install/p/lib/python3.12/site-packages/p/helpers.py', True),
        ('/opt/ros/jazzy/lib/python3.12/site-packages/nav2/a.py', False),
        ('/usr/lib/python3/dist-packages/yaml/__init__.py', False),
        (inspect.getfile(Positions), False),
        (ast.__file__, False),
        ('<frozen importlib._bootstrap>', False),
        ('<string>', False),
    ],
)
def test_what_is_installed_is_not_the_users(
    positions: Positions, path: str, is_users: bool
) -> None:
    positions.set_prefixes(['/ws/install/p'])
    assert positions.is_users(path) is is_users


def test_a_launch_file_is_the_users_wherever_it_is(
    positions: Positions,
) -> None:
    path = '/usr/lib/python3/dist-packages/a.launch.py'
    assert not positions.is_users(path)
    positions.add_file(path)
    assert positions.is_users(path)
