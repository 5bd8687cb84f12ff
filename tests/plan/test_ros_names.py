# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How the names of a node are expanded and remapped."""

from colcon_yamllaunch.plan.plan import Component, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.ros_names import names_of
import pytest

HERE = Position('/ws/demo.yaml', 1, 1)


def process(*words: str, node: str | None = '/drivers/lidar') -> Process:
    argv = ('driver', '-r', 'scan:=no', '--ros-args', *words)
    return Process('lidar-1', argv, '/', HERE, node_name=node)


@pytest.mark.parametrize(
    ('words', 'name', 'full'),
    [
        ('', 'scan', '/drivers/scan'),
        ('', '/scan', '/scan'),
        ('', '~/scan', '/drivers/lidar/scan'),
        ('', '{node}/scan', '/drivers/lidar/scan'),
        ('-r scan:=front_scan', 'scan', '/drivers/front_scan'),
        ('-r scan:=/scan', 'scan', '/scan'),
        ('--remap ~/scan:=~/front', '~/scan', '/drivers/lidar/front'),
        ('-r /drivers/scan:=a -r scan:=b', 'scan', '/drivers/a'),
        ('-r lidar:scan:=a', 'scan', '/drivers/a'),
        ('-r camera:scan:=a', 'scan', '/drivers/scan'),
        ('-r rostopic://scan:=a', 'scan', '/drivers/a'),
        ('-r rosservice://scan:=a', 'scan', '/drivers/scan'),
        ('-r __ns:=/arm -r __node:=l', '~/scan', '/arm/l/scan'),
        ('-p scan:=a -- -r scan:=b', 'scan', '/drivers/scan'),
        ('-r', 'scan', '/drivers/scan'),
    ],
)
def test_topics_are_expanded_and_remapped(
    words: str, name: str, full: str
) -> None:
    assert names_of(process(*words.split())).topic(name) == full


def test_services_and_actions_have_rules_of_their_own() -> None:
    names = names_of(
        process(
            *['-r', 'rosservice://map:=get_map', '-r', 'go:=goto'],
            *['-r', 'turn/_action/send_goal:=spin/_action/send_goal'],
        )
    )
    assert names.service('map') == '/drivers/get_map'
    assert names.topic('map') == '/drivers/map'
    assert names.action('go') == '/drivers/goto'
    assert names.action('turn') == '/drivers/spin'
    assert names.expanded('go') == '/drivers/go'


def test_names_of_nodes_that_the_launch_does_not_name() -> None:
    unnamed = names_of(process('-r', '__ns:=/arm', node=None))
    assert (unnamed.node, unnamed.topic('scan')) == ('', '/arm/scan')
    assert names_of(process(node=None)).topic('scan') == '/scan'


def test_names_of_components() -> None:
    component = Component(
        'lidar', 'p', 'p::Lidar', '/box', HERE, remaps=('scan:=front',)
    )
    assert names_of(component).topic('scan') == '/front'
    loaded = names_of(component, '/drivers/lidar')
    assert loaded.topic('scan') == '/drivers/front'
    assert loaded.node == '/drivers/lidar'
