# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Names that packages and nodes may have."""

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.workspace.create.new_package import (
    advised_name,
    check_node_name,
    check_package_name,
    class_name,
    default_node_name,
    dislikes,
)
import pytest


@pytest.mark.parametrize('name', ['my_pkg', 'p2', 'json', 'launch'])
def test_good_names(name: str) -> None:
    check_package_name(name, 'ament_cmake')
    assert list(dislikes(name)) == []


@pytest.mark.parametrize(
    ('name', 'wish', 'advised'),
    [
        ('my-pkg', "underscores in place of '-'", 'my_pkg'),
        ('MyPkg', 'lower case letters only', 'my_pkg'),
        ('my__pkg', 'no underscores in a row', 'my_pkg'),
        ('x', 'at least two characters', 'x'),
    ],
)
def test_names_that_are_disliked(name: str, wish: str, advised: str) -> None:
    check_package_name(name, 'ament_python')
    assert list(dislikes(name)) == [wish]
    assert advised_name(name) == advised


@pytest.mark.parametrize(
    'name', ['', '2d', 'a.b', 'a/b', '..', 'a b', '_a', 'ä', 'class', 'a\n']
)
def test_names_that_no_package_can_have(name: str) -> None:
    with pytest.raises(UserError, match='is no name for a package'):
        check_package_name(name, 'cmake')


def test_python_package_that_would_hide_a_module_of_python() -> None:
    with pytest.raises(UserError, match='has a module of this name'):
        check_package_name('json', 'ament_python')


@pytest.mark.parametrize(
    'name', ['', '2d', 'a-b', 'a.py', 'class', 'none', 'signal', 'rclpy']
)
def test_names_that_no_script_can_have(name: str) -> None:
    with pytest.raises(UserError, match=f"'{name}' is no name for"):
        check_node_name(name, 'ament_cmake')


def test_module_of_a_package_hides_nothing() -> None:
    check_node_name('signal', 'ament_python')


def test_node_and_its_class() -> None:
    assert default_node_name('my-pkg') == 'my_pkg_node'
    assert default_node_name('my_node') == 'my_node'
    assert class_name('my_fast_node2') == 'MyFastNode2'
    assert class_name('myNode') == 'MyNode'
