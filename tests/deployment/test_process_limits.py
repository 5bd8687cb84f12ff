# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Limits and users of processes, as a deployment file sets them."""

from colcon_yamllaunch.deployment.deployment_file import deployment_of
from colcon_yamllaunch.deployment.placement import place
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.source_text import Source
from colcon_yamllaunch.plan.member_settings import ResourceLimits
from colcon_yamllaunch.plan.plan import Component, Plan, Process
from colcon_yamllaunch.plan.position import Position
import pytest

AT = Position('a.yaml', 1, 1)
BOX = Process(
    'box-1',
    ('box',),
    '/work',
    AT,
    name='box-1',
    node_name='/box',
    is_container=True,
)
FILTER = Component('filter', 'pkg', 'pkg::Filter', '/box', AT, name='filter')


def applied(text):
    """Return the box and the filter with the settings of a file."""
    source = Source('robot.yaml', 'robot.yaml', text, 'deployment file')
    return place(Plan((BOX, FILTER)), deployment_of(source)).local.entries


def test_first_rule_with_a_limit_decides_and_is_named():
    text = (
        'processes:\n'
        '- {match: box-1, memory: 2G, nice: 5}\n'
        '- {match: {executable: box}, memory: 1G, cpu: 150%, user: robot}\n'
    )
    box, _ = applied(text)
    assert box.settings.limits == ResourceLimits(
        memory=2 << 30, nice=5, cpu=1.5
    )
    assert box.settings.user == 'robot'
    places = {p.key: str(p.position) for p in box.settings.places}
    assert places == {
        'memory': 'robot.yaml:2:18',
        'nice': 'robot.yaml:2:30',
        'cpu': 'robot.yaml:3:42',
        'user': 'robot.yaml:3:53',
    }


def test_limits_of_a_container_are_not_those_of_its_components():
    text = "processes: [{match: '*', memory: 1G}]"
    box, component = applied(text)
    assert box.settings.limits == ResourceLimits(memory=1 << 30)
    assert component.settings is None


@pytest.mark.parametrize('key', ['memory: 1G', 'user: me', 'output: log'])
def test_limit_of_a_component_alone_is_an_error(key):
    with pytest.raises(LaunchError) as caught:
        applied(f'processes: [{{match: filter, {key}}}]')
    (problem,) = caught.value.diagnostics
    assert problem.message.endswith("and 'filter' matches only components")
    assert problem.hint.endswith('share: /box')
    assert str(problem.position) == 'robot.yaml:1:29'


def test_environment_folder_and_output_replace_those_of_the_plan(monkeypatch):
    monkeypatch.setenv('HOME', '/home/me')
    text = (
        'processes: [{match: box*, env: {A: 1}, directory: ~/data, '
        'output: both}]'
    )
    box, _ = applied(text)
    assert (box.environment, box.cwd, box.output) == (
        (('A', '1'),),
        '/home/me/data',
        'both',
    )


def test_home_folder_is_that_of_the_user():
    text = 'processes: [{match: box*, directory: ~/data, user: root}]'
    box, _ = applied(text)
    assert box.cwd == '/root/data'
