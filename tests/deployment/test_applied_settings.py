# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a deployment file does to the processes of a plan."""

from pathlib import Path
import textwrap

from colcon_yamllaunch.deployment.deployment import Deployment
from colcon_yamllaunch.deployment.deployment_file import read_deployment
from colcon_yamllaunch.deployment.placement import place, Placer
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError, render
from colcon_yamllaunch.plan.member_settings import ReadyCondition, Restart
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    Component,
    Message,
    Plan,
    Process,
    Timer,
    WorkerCall,
)
from colcon_yamllaunch.plan.position import Position
from hypothesis import given
from hypothesis import strategies as st
import pytest

AT = Position('/ws/a.launch.yaml', 1, 1)


def node(label, package='drivers', **fields):
    known = {'package': package, 'node_name': f'/{package}/{label}', **fields}
    return Process(label, (f'/bin/{label}',), '/', AT, **known)


LIDAR, CAMERA = node('lidar'), node('camera')
MAP = node('map_server', 'nav2_map_server')
PLANNER = node('planner', 'nav2_planner')
FILTER = Component('filter', 'scan', 'scan::Filter', '/box', AT, 'filter')
ALL = (LIDAR, CAMERA, MAP, PLANNER, FILTER)


@pytest.fixture
def deploy(tmp_path: Path):
    """Return a function that reads a deployment file, and applies it."""

    def apply(text, *entries, profile=None):
        path = tmp_path / 'robot.yaml'
        path.write_text(textwrap.dedent(text))
        deployment = read_deployment(str(path), profile)
        return place(Plan(entries or ALL), deployment).whole

    return apply


def settings_of(plan, label):
    (found,) = (m for m in plan.members() if m.label == label)
    assert found.settings is not None
    return found.settings


def error_of(deploy, text, *entries):
    with pytest.raises(LaunchError) as caught:
        deploy(text, *entries)
    return render(caught.value.diagnostics, '/nowhere')


def test_the_example_of_the_documentation(deploy):
    plan = deploy("""\
        processes:
          - match: /drivers/*
            ready: {topic: scan}
            restart: {when: failure, max: 5, window: 60, delay: [0.5, 30]}
          - match: map_server
            ready: {lifecycle: active}
          - match: {package: nav2_*}
            after: [/drivers/*, map_server]
            ready_timeout: 30
          - match: camera
            memory: 2G
            cpus: 2-3
            nice: 5
            critical: true
    """)
    camera = settings_of(plan, 'camera')
    assert camera.ready == (ReadyCondition('topic', 'scan'),)
    assert camera.restart == Restart('failure', 5, 60.0, 0.5, 30.0)
    assert camera.limits is not None
    assert camera.limits.memory == 2 << 30
    assert (camera.limits.cpus, camera.limits.nice) == ((2, 3), 5)
    assert camera.critical
    # one of those that a rule matches may be named by it
    assert settings_of(plan, 'map_server').after == ('lidar', 'camera')
    planner = settings_of(plan, 'planner')
    assert planner.after == ('lidar', 'camera', 'map_server')
    assert planner.ready_timeout == 30.0
    held = [e for e in plan.entries if isinstance(e, AfterReady)]
    assert [e.labels for e in held] == [
        ('lidar', 'camera'),
        ('lidar', 'camera', 'map_server'),
    ]


def test_the_first_rule_that_says_something_decides(deploy):
    plan = deploy("""\
        processes:
          - {match: lidar, nice: 1, after: []}
          - {match: camera, nice: 2}
          - {match: /drivers/*, nice: 3, oom: 4, after: map_server}
    """)
    lidar, camera = (settings_of(plan, n).limits for n in ('lidar', 'camera'))
    assert lidar is not None
    assert camera is not None
    assert (lidar.nice, lidar.oom) == (1, 4)
    assert (camera.nice, camera.oom) == (2, 4)
    assert settings_of(plan, 'lidar').after == ()
    assert settings_of(plan, 'camera').after == ('map_server',)


def test_what_waits_takes_its_timers_along(deploy):
    said = Message('INFO', 'started')
    inner = Timer(2.0, (PLANNER, said))
    plan = deploy(
        'processes: [{match: planner, after: lidar}]',
        *(LIDAR, Timer(1.0, (inner, CAMERA))),
    )
    _, held, rest = plan.entries
    assert isinstance(held, AfterReady)
    (outer,) = held.entries
    assert isinstance(outer, Timer)
    (moved,) = outer.entries
    assert isinstance(moved, Timer)
    assert (outer.period, moved.period) == (1.0, 2.0)
    assert [e.label for e in moved.entries] == ['planner']
    assert rest == Timer(1.0, (Timer(2.0, (said,)), CAMERA))


def test_other_settings_change_the_process(deploy):
    plan = deploy(
        """\
        processes:
          - match: lidar
            env: {A: 1, B: two}
            directory: /data
            output: log
        """,
        node('lidar', environment=(('A', '0'), ('C', None))),
    )
    (lidar,) = plan.processes()
    assert lidar.environment == (('A', '1'), ('B', 'two'), ('C', None))
    assert (lidar.cwd, lidar.output) == ('/data', 'log')


def test_layers_come_in_their_order(deploy, tmp_path):
    (tmp_path / 'base.yaml').write_text(
        'args: {a: base, b: base, c: base}\n'
        'profiles: {sim: {processes: [{match: lidar, oom: 7}]}}\n'
        'processes: [{match: lidar, nice: 3, oom: 3, io: 3}]\n'
    )
    text = """\
        include: base.yaml
        args: {a: own, b: own}
        profiles:
          sim: {args: {a: sim}, processes: [{match: lidar, nice: 1}]}
          real: {}
        processes: [{match: lidar, nice: 2}]
    """
    path = tmp_path / 'robot.yaml'
    path.write_text(textwrap.dedent(text))
    given = {
        profile: read_deployment(str(path), profile).arguments
        for profile in ('sim', 'real')
    }
    assert given['sim'] == {'a': 'sim', 'b': 'own', 'c': 'base'}
    assert given['real'] == {'a': 'own', 'b': 'own', 'c': 'base'}
    for profile, expected in (('sim', (1, 7, 3)), ('real', (2, 3, 3))):
        limits = settings_of(deploy(text, profile=profile), 'lidar').limits
        assert limits is not None
        assert (limits.nice, limits.oom, limits.io) == expected


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        (
            'processes: [{match: planner, after: lidr}]',
            'robot.yaml:1:37: error: no process or component of the launch '
            "is called 'lidr'|did you mean 'lidar'?",
        ),
        (
            'processes: [{match: lidar, after: "/drivers/*"}]',
            "'/drivers/*' includes lidar itself|name the others: camera",
        ),
        (
            'processes:\n'
            '- {match: lidar, after: camera}\n'
            '- {match: camera, after: planner}\n'
            '- {match: planner, after: lidar}\n',
            'these wait for one another: lidar → camera → planner → lidar|'
            '^^^^^',
        ),
        (
            'processes: [{match: filter, ready: {log: up}}]',
            "filter is a component: 'log' is a condition of processes|"
            'the container',
        ),
        (
            'processes: [{match: filter, nice: 5}]',
            'nice|/box',
        ),
    ],
)
def test_wrong_settings_are_one_error(deploy, text, expected):
    shown = error_of(deploy, text)
    assert shown.count('error:') == 1
    for part in expected.split('|'):
        assert part in shown


def test_all_mistakes_of_a_rule_are_reported_at_once(deploy):
    shown = error_of(
        deploy,
        'processes: [{match: lidar, ncie: 5, ready: {topci: a}, oom: high}]',
    )
    assert shown.count('error:') == 3
    for wrong in ("'ncie'", "'topci'", "'high'"):
        assert wrong in shown


@pytest.mark.parametrize(
    ('files', 'expected'),
    [
        (
            {'robot.yaml': 'include: robot.yaml'},
            "robot.yaml:1:10: error: 'robot.yaml' includes itself",
        ),
        (
            {'robot.yaml': 'include: a.yaml', 'a.yaml': 'include: robot.yaml'},
            "a.yaml:1:10: error: 'robot.yaml' includes itself",
        ),
        ({'robot.yaml': 'include: missing.yaml'}, 'robot.yaml:1:10: error: '),
        (
            {'robot.yaml': 'include: a.yaml', 'a.yaml': 'processes: [{}]'},
            "a.yaml:1:13: error: this rule has no 'match'",
        ),
        (
            {'robot.yaml': 'profiles: {real: {}, slim: {}}'},
            "has no profile 'sim'",
        ),
        ({'robot.yaml': 'args: {a: 1}'}, 'it has no profiles'),
    ],
)
def test_wrong_layers_are_one_error(files, expected, tmp_path):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(LaunchError) as caught:
        read_deployment(str(tmp_path / 'robot.yaml'), 'sim')
    shown = render(caught.value.diagnostics, str(tmp_path))
    assert expected in shown
    assert shown.count('error:') == 1


def test_processes_that_come_later_have_settings(tmp_path):
    path = tmp_path / 'robot.yaml'
    path.write_text('processes: [{match: planner, after: lidar, nice: 1}]')
    placer = Placer(read_deployment(str(path)))
    # a name may be that of a process that comes later
    placer.place(Plan((WorkerCall(1, 'call more', AT), LIDAR)))
    more = placer.place_more((PLANNER,)).whole
    assert settings_of(more, 'planner').after == ('lidar',)
    (held,) = more.entries
    assert isinstance(held, AfterReady)


def test_without_rules_a_plan_is_as_it_was():
    plan = Plan(ALL)
    assert place(plan, Deployment({})).whole == plan


LABELS = st.sampled_from([member.label for member in ALL])


@given(st.dictionaries(LABELS, st.lists(LABELS, min_size=1, max_size=3)))
def test_each_member_is_there_once_whatever_waits(after):
    from colcon_yamllaunch.deployment.deployment_file import deployment_of
    from colcon_yamllaunch.language.syntax.source_text import Source

    rules = [
        {'match': name, 'after': others} for name, others in after.items()
    ]
    text = f'processes: {rules}' if rules else 'args: {a: 1}'
    source = Source('robot.yaml', 'robot.yaml', text, 'deployment file')
    try:
        plan = place(Plan(ALL), deployment_of(source)).whole
    except LaunchError as e:
        assert 'wait for one another' in e.diagnostics[0].message
        return
    assert sorted(m.label for m in plan.members()) == sorted(
        m.label for m in ALL
    )
