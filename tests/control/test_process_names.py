# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which processes of a launch a name means."""

from colcon_yamllaunch.control.process_names import meant_by, ProcessNames
import pytest
from support.launch_states import component_state, process_state


def test_pattern_matches_the_names_of_a_process():
    node = '/demo/inner/my_counter'
    names = ProcessNames('my_counter', 'counter.py-1', 'python3', node)
    for pattern in (
        *('counter.py-1', 'counter.py', 'counter', 'python3', 'my_counter'),
        *(node, 'demo/inner/my_counter', '/demo/inner', '/demo'),
        *('count*', 'my_counter*', 'demo/*', '/demo/*', '*'),
        '?ounter.py-[12]',
    ):
        assert meant_by(pattern, [names]) == [0], pattern
    for pattern in ('count', '/dem', 'Counter*'):
        assert meant_by(pattern, [names]) == [], pattern


BOTH = [
    ProcessNames('camera', 'driver-1', 'driver', '/camera'),
    ProcessNames('left/camera', 'driver-2', 'driver', '/left/camera'),
]
ON_MACHINES = [
    ProcessNames('arm│driver', 'cam.py-1', 'cam.py', None),
    ProcessNames('gpu│planner', 'planner-2', 'planner', None),
    ProcessNames('gpu│driver', 'cam.py-3', 'cam.py', None),
]


@pytest.mark.parametrize(
    ('known', 'pattern', 'meant'),
    [
        # a label means one process only
        (BOTH, 'camera', [0]),
        (BOTH, 'driver-2', [1]),
        (BOTH, 'left/camera', [1]),
        (BOTH, '/left/camera', [1]),
        (BOTH, '/left', [1]),
        (BOTH, 'driver', [0, 1]),
        (BOTH, '*camera', [0, 1]),
        # names match with and without their machine
        (ON_MACHINES, 'driver', [0, 2]),
        (ON_MACHINES, 'arm│driver', [0]),
        (ON_MACHINES, 'arm/driver', [0]),
        (ON_MACHINES, 'gpu/driver', [2]),
        (ON_MACHINES, 'gpu/*', [1, 2]),
        (ON_MACHINES, 'arm│*', [0]),
        (ON_MACHINES, 'd*r', [0, 2]),
        (ON_MACHINES, 'planner', [1]),
    ],
)
def test_pattern_means_processes(known, pattern, meant):
    assert meant_by(pattern, known) == meant


def test_state_has_the_names_of_its_part():
    names = {'name': 'cam.py-2', 'executable': 'cam', 'node': '/a/cam'}
    process = process_state('driver', **names)
    found = set(ProcessNames.of_state(process))
    assert {'driver', 'cam.py-2', '/a/cam', '/a'} <= found
    component = component_state('talker', node='/b/talker')
    found = set(ProcessNames.of_state(component))
    assert {'talker', 'demo::Talker', 'b/talker'} <= found
