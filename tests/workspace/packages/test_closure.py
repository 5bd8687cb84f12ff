# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which packages are needed, and in which order."""

from pathlib import Path

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.packages.package import (
    build_closure,
    closure,
    index,
    Package,
)
import pytest


def package(name, build=(), run=(), path=None):
    return Package(
        name,
        Path(path or f'/ws/src/{name}'),
        'cmake',
        frozenset(build),
        frozenset(run),
    )


def test_dependencies_come_first_and_others_are_left_out():
    packages = [
        package('app', build=['lib'], run=['tool', 'rclpy']),
        package('lib', build=['base']),
        package('tool', run=['base']),
        package('base'),
        package('unused', run=['app']),
    ]
    assert closure(packages, ['app']) == ['base', 'lib', 'tool', 'app']


def test_names_of_underlays_are_left_out():
    assert closure([package('a')], ['rviz2', 'a']) == ['a']


def test_package_may_name_itself():
    assert closure([package('a', run=['a'])], ['a']) == ['a']


def test_long_chain():
    count = 3000
    packages = [package(f'p{i}', run=[f'p{i + 1}']) for i in range(count)]
    assert len(closure(packages, ['p0'])) == count


def test_circle_is_named():
    packages = [
        package('app', run=['a']),
        package('a', run=['b']),
        package('b', build=['c']),
        package('c', run=['a']),
    ]
    with pytest.raises(WorkspaceError, match='a -> b -> c -> a'):
        closure(packages, ['app'])


def test_circle_elsewhere_does_not_matter():
    packages = [package('a', run=['b']), package('b', run=['a'])]
    assert closure([*packages, package('c')], ['c']) == ['c']


def test_duplicates_are_named_only_when_needed():
    packages = [
        package('a', path='/ws/x/a'),
        package('a', path='/ws/y/a'),
        package('b'),
        package('c', run=['a']),
    ]
    assert closure(packages, ['b']) == ['b']
    with pytest.raises(WorkspaceError, match='/ws/x/a\n  /ws/y/a'):
        closure(packages, ['c'])


def test_build_closure_follows_what_build_dependencies_export():
    packages = [
        package('app', build=['lib'], run=['tool']),
        package('lib', run=['base', 'rclcpp']),
        package('base'),
        package('tool'),
    ]
    assert build_closure(index(packages), 'app') == (
        {'lib', 'base'},
        {'rclcpp'},
    )
