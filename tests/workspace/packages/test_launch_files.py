# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Choosing a launch file."""

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.workspace.packages.launch_files import (
    choose_launch_file,
    find_launch_files,
    likely_ones,
)
import pytest

FILES = (
    'launch/demo.yaml',
    'launch/robot.launch.py',
    'launch/robot.launch.yaml',
    'launch/sim/world.yaml',
    'launch/two.launch.xml',
    'launch/two.launch.py',
    'config/demo.yaml',
    'config/only.yaml',
    'old/node.launch',
    'old/only.launch',
    'node.xml',
)


@pytest.mark.parametrize(
    ('wanted', 'expected'),
    [
        ('demo.yaml', 'launch/demo.yaml'),
        ('demo', 'launch/demo.yaml'),
        ('launch/demo.yaml', 'launch/demo.yaml'),
        ('./launch/demo', 'launch/demo.yaml'),
        ('config/demo.yaml', 'config/demo.yaml'),
        ('robot', 'launch/robot.launch.yaml'),
        ('robot.launch', 'launch/robot.launch.yaml'),
        ('robot.launch.py', 'launch/robot.launch.py'),
        ('sim/world', 'launch/sim/world.yaml'),
        ('world', 'launch/sim/world.yaml'),
        ('only', 'old/only.launch'),
        ('only.yaml', 'config/only.yaml'),
        ('node.launch', 'old/node.launch'),
        ('node', 'old/node.launch'),
    ],
)
def test_launch_file_is_chosen_by_name_or_path(wanted, expected):
    assert choose_launch_file('p', FILES, wanted) == expected


def test_more_than_one():
    with pytest.raises(UserError) as error:
        choose_launch_file('p', FILES, 'two')
    assert 'launch/two.launch.py' in str(error.value)
    assert 'launch/two.launch.xml' in str(error.value)


def test_none_lists_the_nearest_first():
    with pytest.raises(UserError) as error:
        choose_launch_file('p', FILES, 'wrold.yaml')
    lines = str(error.value).splitlines()
    assert lines[1] == '  launch/sim/world.yaml'
    assert 'config' not in str(error.value)


def test_parameter_files_are_not_offered():
    files = ('config/demo.yaml', 'params/x/y.yml', 'other.yaml')
    assert likely_ones(files) == ['other.yaml']
    with pytest.raises(UserError, match='has no launch files'):
        choose_launch_file('p', files[:2], 'demmo.yaml')


def test_no_launch_files():
    with pytest.raises(UserError, match='has no launch files'):
        choose_launch_file('p', (), 'demo.yaml')


def test_launch_files_of_a_package_are_found(tmp_path):
    for name in (
        'launch/demo.yaml',
        'launch/a.launch.py',
        'launch/helper.py',
        'nested/launch/x.xml',
        'config/a.yaml',
        'top.launch.yml',
        'package.xml',
        'script.py',
        'README.md',
        '.git/x.yaml',
        'build/y.yaml',
        'build/COLCON_IGNORE',
    ):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    assert find_launch_files(tmp_path) == (
        'launch/a.launch.py',
        'launch/demo.yaml',
        'launch/helper.py',
        'nested/launch/x.xml',
        'top.launch.yml',
        'config/a.yaml',
    )
