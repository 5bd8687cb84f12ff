# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches whose processes wait for real nodes of ROS."""

import json
import os
from pathlib import Path
import re
import signal
import sys

import pytest
from support.ros_parts import source_for
from support.user import Launch, User

LAUNCH = """\
launch:
  - group:
    - push_ros_namespace: {namespace: drivers}
    - node:
        pkg: composition
        exec: offering
        name: lidar
        args: 'wait:0.3 message:scan static:map=laser parameter:rate=5'
        remap: [{from: scan, to: front_scan}]
        respawn: true
  - node: {pkg: composition, exec: offering, name: plain, args: 'wait:0.3'}
  - node: {pkg: composition, exec: offering, name: maps,
           args: 'lifecycle wait:0.3 state:configure state:activate'}
  - executable: {cmd: 'echo planning', name: planner}
"""
ROBOT = """\
processes:
  - match: /drivers/*
    ready:
      - {topic: scan, message: true}
      - node: lidar
      - parameter: {name: rate, equals: 5}
      - transform: [map, laser]
  - match: maps
    ready: {lifecycle: active}
    after: /drivers/lidar
  - match: {executable: planner*}
    after: [maps, plain]
"""


@pytest.fixture
def second(user: User, ros_parts: Path, ros_domain_id: int) -> User:
    """Return a user who sees no nodes but those of this test."""
    source_for(user, ros_parts, ros_domain_id)
    user.write('robot.launch.yaml', LAUNCH)
    user.write('robot.yaml', ROBOT)
    return user


def start(user: User) -> Launch:
    return user.start(
        'colcon', 'launch', 'robot.launch.yaml', '--deploy', 'robot.yaml'
    )


def pid_of(user: User, name: str) -> int:
    (launch,) = json.loads(user.launch('--status=json'))['launches']
    return next(
        int(p['pid']) for p in launch['processes'] if name in p['label']
    )


def test_processes_start_when_nodes_are_ready(second: User) -> None:
    launch = start(second)
    launch.wait_for(r'lidar.*: ready after')
    launch.wait_for(r'maps.*: ready after')
    launch.wait_for(r'planning')
    # one that crashes and comes back is waited for again
    os.kill(pid_of(second, 'lidar'), signal.SIGKILL)
    launch.wait_for(r'(?s)lidar.*: ready after.*lidar.*: ready after')
    assert launch.interrupt() == 0, launch.output


@pytest.mark.parametrize('has_ros', [True, False])
def test_a_node_is_ready_in_the_graph_if_there_is_ros(
    second: User, has_ros: bool
) -> None:
    second.write(
        'robot.launch.yaml',
        'launch:\n'
        '  - node: {pkg: composition, exec: offering, name: plain}\n'
        "  - executable: {cmd: 'echo planning', name: planner}\n",
    )
    second.write('robot.yaml', 'processes: [{match: planner, after: plain}]\n')
    if not has_ros:
        # nothing beside it shows that it finds rclpy
        script = f'#!/bin/sh\nexec {sys.executable} "$@"\n'
        program = second.write('other/bin/python3', script, 0o755)
        path = f'{program.parent}:{second.environment["PATH"]}'
        second.environment['PATH'] = path
    launch = start(second)
    launch.wait_for('planning')
    assert launch.interrupt() == 0, launch.output
    (log,) = {
        path.parent.resolve()
        for path in second.root.parent.rglob('events.jsonl')
    }
    assert (log / 'ros_client.log').exists() == has_ros
    lines = (log / 'events.jsonl').read_text().splitlines()
    ready = next(
        event
        for event in map(json.loads, lines)
        if (event['event'], event['label']) == ('ready', 'plain')
    )
    # a node takes a while to appear
    assert (ready['seconds'] > 0.05) == has_ros


def test_what_a_node_offers_instead_is_reported(second: User) -> None:
    second.write(
        'robot.yaml',
        'processes:\n'
        '  - match: /drivers/lidar\n'
        '    ready: {topic: scans}\n'
        '    ready_timeout: 6\n'
        '    on_timeout: fail\n',
    )
    launch = start(second)
    assert launch.end() == 1
    assert re.search(
        r'not ready after \d\.\d s: waiting for a publisher of scans '
        r'\(its node publishes front_scan, ',
        launch.output,
    ), launch.output


@pytest.mark.full
def test_what_is_missing_for_conditions_is_one_error(user: User) -> None:
    user.write('l.yaml', 'launch: [executable: {cmd: echo started}]\n')
    user.write(
        'robot.yaml', 'processes: [{match: "*", ready: {transform: [a, b]}}]\n'
    )
    output = user.launch('l.yaml', '--deploy', 'robot.yaml', code=1)
    assert output.startswith(
        'colcon launch: error: for transforms this launch needs the Python '
        "package 'tf2_msgs', which "
    )
    assert '<exec_depend>tf2_msgs</exec_depend>' in output
    assert output.count('\n') == 1


@pytest.mark.parametrize(
    'condition',
    ['lifecycle: active', 'parameter: {name: a, equals: 1}', 'topic: ~/scan'],
)
def test_a_node_without_a_name_is_an_error(
    second: User, condition: str
) -> None:
    second.write(
        'robot.launch.yaml',
        'launch: [node: {pkg: composition, exec: offering}]\n',
    )
    second.write(
        'robot.yaml', f'processes: [{{match: "*", ready: {{{condition}}}}}]\n'
    )
    launch = start(second)
    assert launch.end() == 1
    assert 'robot.yaml:1:' in launch.output
    assert 'as the launch file does not name its node' in launch.output
