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


@pytest.mark.parametrize(
    ('pattern', 'meant'),
    [
        ('camera', [0]),
        ('driver-2', [1]),
        ('left/camera', [1]),
        ('/left/camera', [1]),
        ('/left', [1]),
        ('driver', [0, 1]),
        ('*camera', [0, 1]),
    ],
)
def test_label_matches_one_process_only(pattern, meant):
    known = [
        ProcessNames('camera', 'driver-1', 'driver', '/camera'),
        ProcessNames('left/camera', 'driver-2', 'driver', '/left/camera'),
    ]
    assert meant_by(pattern, known) == meant


@pytest.mark.parametrize(
    ('pattern', 'meant'),
    [
        ('driver', [0, 2]),
        ('arm│driver', [0]),
        ('arm/driver', [0]),
        ('gpu/driver', [2]),
        ('gpu/*', [1, 2]),
        ('arm│*', [0]),
        ('d*r', [0, 2]),
        ('planner', [1]),
    ],
)
def test_names_match_with_and_without_machine(pattern, meant):
    known = [
        ProcessNames('arm│driver', 'cam.py-1', 'cam.py', None),
        ProcessNames('gpu│planner', 'planner-2', 'planner', None),
        ProcessNames('gpu│driver', 'cam.py-3', 'cam.py', None),
    ]
    assert meant_by(pattern, known) == meant


def test_state_has_the_names_of_its_part():
    process = process_state(
        'driver', name='cam.py-2', executable='cam', node='/a/cam'
    )
    assert {'driver', 'cam.py-2', '/a/cam', '/a'} <= set(
        ProcessNames.of_state(process)
    )
    component = component_state('talker', node='/b/talker')
    assert {'talker', 'demo::Talker', 'b/talker'} <= set(
        ProcessNames.of_state(component)
    )
