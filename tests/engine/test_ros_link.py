# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What launches need of the ROS environment."""

from dataclasses import replace

from colcon_yamllaunch.engine.ros_link import (
    are_beside,
    missing_packages,
    needed_packages,
)
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    ReadyCondition,
)
from colcon_yamllaunch.plan.plan import ChangeState, Component, Plan, Timer
from colcon_yamllaunch.plan.position import Position
import pytest

COMPONENT = Component('a', 'p', 'P', '/box', Position('/ws/demo.yaml', 1, 1))


def test_only_used_packages_are_needed(process):
    plain = process('plain')
    assert not Plan((plain, Timer(1.0, (plain,)))).needs_ros
    node = process('lc', is_lifecycle=True)
    change = ChangeState('/lc', 'cleanup', node.position)
    for entry, name in (
        (COMPONENT, 'composition_interfaces'),
        (node, 'lifecycle_msgs'),
        (change, 'lifecycle_msgs'),
        (Timer(1.0, (), on_ros_time=True), 'rosgraph_msgs'),
    ):
        for entries in ((entry,), (plain, Timer(1.0, (entry,)))):
            plan = Plan(entries)
            assert plan.needs_ros
            needed = needed_packages(plan)
            assert needed[:2] == ['rclpy', name]
            assert set(needed[2:]) <= {'rcl_interfaces'}


@pytest.mark.parametrize(
    ('kind', 'packages'),
    [
        ('topic', ['rclpy']),
        ('node', ['rclpy']),
        ('lifecycle', ['rclpy', 'lifecycle_msgs']),
        ('parameter', ['rclpy', 'rcl_interfaces']),
        ('transform', ['rclpy', 'tf2_msgs']),
    ],
)
def test_readiness_conditions_need_packages(process, kind, packages):
    node = process('plain')
    settings = MemberSettings(
        node.position, ready=(ReadyCondition(kind, 'a'),)
    )
    for entry in (node, COMPONENT):
        plan = Plan((replace(entry, settings=settings),))
        assert plan.needs_ros
        assert {*packages} <= {*needed_packages(plan)}
    settings = MemberSettings(
        node.position, ready=(ReadyCondition('log', 'a'),)
    )
    assert not Plan((replace(node, settings=settings),)).needs_ros


def test_fix_for_missing_packages_fits_the_installation():
    missing = ['lifecycle_msgs']
    text = missing_packages(missing, '/py', {'ROS_DISTRO': 'jazzy'})
    assert 'sudo apt install ros-jazzy-lifecycle-msgs' in text
    assert '<exec_depend>lifecycle_msgs</exec_depend>' in text
    assert '/py' in text
    text = missing_packages(missing, '/py', {})
    assert 'pip install ros-lifecycle-msgs' in text
    text = missing_packages(['composition_interfaces'], '/py', {})
    assert 'build composition_interfaces in the workspace' in text
    assert 'pip' not in text


def test_packages_found_by_files(tmp_path):
    python = str(tmp_path / 'venv/bin/python3')
    own = tmp_path / 'venv/lib/python3.12/site-packages'
    (sourced := tmp_path / 'ros').mkdir()
    environment = {'PYTHONPATH': f':{sourced}'}
    for folder, name in ((own, 'rclpy'), (sourced, 'lifecycle_msgs')):
        assert not are_beside(['rclpy', 'lifecycle_msgs'], python, environment)
        (folder / name).mkdir(parents=True)
        (folder / name / '__init__.py').touch()
    assert are_beside(['rclpy', 'lifecycle_msgs'], python, environment)
    assert not are_beside(['rclpy', 'lifecycle_msgs'], python, {})
    (tmp_path / 'venv/lib/python3.11/site-packages').mkdir(parents=True)
    assert not are_beside(['rclpy'], python, {})
