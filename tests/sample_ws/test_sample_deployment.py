# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The deployment file of sample_ws: its nodes wait for one another."""

import pytest

from .conftest import Environment
from .conftest import Start
from .conftest import Workspace

# One build serves all tests here when they run on one worker.
pytestmark = [pytest.mark.full, pytest.mark.xdist_group('sample_ws')]


def test_nodes_start_once_others_are_ready(
    workspace: Workspace, ros_environment: Environment, start: Start
) -> None:
    launch = start(
        ros_environment,
        *('env', '-C', workspace.root, 'colcon', 'launch', '--no-build'),
        *('my_pkg', 'demo.yaml', '--deploy', 'robot.yaml'),
        *('--until-ready', '--timeout', '100'),
    )
    assert launch.end() == 0, launch.lines
    lines = [line for line in launch.lines if line.startswith('[launch]')]

    def first(text: str) -> int:
        return next(n for n, line in enumerate(lines) if text in line)

    assert (
        first('my_counter: ready after')
        < first('my_double: started')
        < first('my_double: ready after')
        < first('pump-4: started')
        < first('stopping: all 4 are ready')
    )
    # the optional pump does not count; those that wait for others stop first
    ends = [n for n, line in enumerate(lines) if ' after ' in line]
    doubled, counted = (
        max(n for n in ends if f'{label}: ' in lines[n])
        for label in ('my_double', 'my_counter')
    )
    assert first('stopping: ') < doubled < counted
