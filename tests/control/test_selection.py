# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which of several running launches is meant."""

from pathlib import Path
from typing import Any, cast

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control.selection import (
    Candidate,
    choose_launch,
    is_selected,
    nearest_first,
)
from colcon_yamllaunch.engine.state import About
import pytest
from support.launch_states import launch_state, process_state


def launch(pid: int, file: str, folder: str, *labels: str) -> Candidate:
    about = About(Path(file).name, 'pkg', file, folder)
    state = launch_state(*map(process_state, labels), about=about, pid=pid)
    return Candidate(cast(Any, None), state)


A = launch(1, '/a/src/p/demo.yaml', '/home', 'talker', 'camera')
B = launch(2, '/b/src/p/demo.yaml', '/b', 'talker')
C = launch(3, '/opt/ros/bringup.yaml', '/b/src', 'lidar')


@pytest.mark.parametrize(
    ('root', 'names', 'pid'),
    [
        ('/a', (), 1),
        ('/a', ('talker',), 1),
        # nobody else has it
        ('/a', ('lidar',), 3),
        ('/b', ('talker',), 2),
        ('/b', ('camera',), 1),
        # an error that names the processes of the launch here
        ('/a', ('taker',), 1),
        (None, ('lidar',), 3),
    ],
)
def test_launches_of_the_workspace_come_first(
    root: str | None, names: tuple[str, ...], pid: int
) -> None:
    folder = None if root is None else Path(root)
    assert choose_launch([A, B, C], names, folder).state.pid == pid


@pytest.mark.parametrize(
    ('root', 'names', 'listed'),
    [
        ('/b', (), [2, 3]),
        (None, (), [1, 2, 3]),
        ('/c', (), [1, 2, 3]),
        ('/c', ('talker',), [1, 2]),
    ],
)
def test_what_is_not_clear_is_listed(
    root: str | None, names: tuple[str, ...], listed: list[int]
) -> None:
    folder = None if root is None else Path(root)
    with pytest.raises(UserError, match=r"--of '\*' to stop all") as raised:
        choose_launch([A, B, C], names, folder, ends=True)
    found = [n for n in (1, 2, 3) if f'(pid {n})' in str(raised.value)]
    assert found == listed
    # nothing else is done to all
    with pytest.raises(UserError, match=r'--of LAUNCH, such as --of \d; '):
        choose_launch([A, B, C], names, folder)


def test_the_only_launch_is_meant_from_everywhere() -> None:
    assert choose_launch([A], (), Path('/b')) is A


def test_status_lists_the_workspace_first() -> None:
    assert nearest_first([A, B, C], Path('/b')) == [B, C, A]
    assert nearest_first([A, B, C], None) == [A, B, C]


@pytest.mark.parametrize(
    ('selector', 'pids'),
    [('*', [1, 2, 3]), ('demo*', [1, 2]), ('[12]', [1, 2]), ('x*', [])],
)
def test_a_glob_may_mean_several(selector: str, pids: list[int]) -> None:
    found = [c.state for c in (A, B, C) if is_selected(c.state, selector)]
    assert [state.pid for state in found] == pids
