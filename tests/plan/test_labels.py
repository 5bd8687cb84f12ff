# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What processes are called."""

from dataclasses import replace

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.plan.labels import RESERVED, with_labels
from colcon_yamllaunch.plan.plan import Component, Plan, Process, Timer
from colcon_yamllaunch.plan.position import Position
from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.language_fixtures import Launcher

HERE = Position('/ws/demo.yaml', 14, 9)


def labels(*nodes: str | None, taken: tuple[str, ...] = ()) -> list[str]:
    """Return the labels of nodes of one program."""
    processes = tuple(
        Process(f'a.py-{number}', (), '/', HERE, node_name=node)
        for number, node in enumerate(nodes, 1)
    )
    labelled = with_labels(Plan(processes), taken)
    return [process.label for process in labelled.processes()]


@pytest.mark.parametrize(
    ('nodes', 'expected'),
    [
        (['/kitchen', '/cellar'], ['kitchen', 'cellar']),
        (['/home/kitchen', '/cellar'], ['kitchen', 'cellar']),
        (['/kitchen', None], ['kitchen', 'a.py-2']),
        (['/left/camera', '/right/camera'], ['left/camera', 'right/camera']),
        (['/left/camera', '/camera'], ['left/camera', 'camera']),
        (['/camera', '/camera'], ['a.py-1', 'a.py-2']),
        (
            ['/l/camera', '/camera', '/camera'],
            ['l/camera', 'a.py-2', 'a.py-3'],
        ),
        (['/launch'], ['a.py-1']),
        (['/up/launch'], ['up/launch']),
        ([], []),
    ],
)
def test_labels_are_names_of_nodes(nodes, expected) -> None:
    assert labels(*nodes) == expected


def test_what_runs_already_keeps_its_label() -> None:
    running = tuple(labels('/camera'))
    assert running == ('camera',)
    assert labels('/right/camera', taken=running) == ['right/camera']
    assert labels('/camera', taken=running) == ['a.py-1']


def test_a_node_is_not_taken_for_another_process() -> None:
    talker = Process('talker', (), '/', HERE)
    echo = Process('echo', (), '/', HERE, node_name='/talker')
    labelled = with_labels(Plan((talker, echo)))
    assert [p.label for p in labelled.processes()] == ['talker', 'echo']


def test_no_node_is_taken_for_the_launcher() -> None:
    assert events.LAUNCHER in RESERVED


parts = st.sampled_from(['', '/a', '/b', '/a/b', '/launch'])
nodes = st.none() | st.builds('{}{}'.format, parts, parts.filter(bool))


@given(st.lists(nodes))
def test_labels_are_unique(nodes: list[str | None]) -> None:
    found = labels(*nodes)
    assert len(set(found)) == len(nodes)
    assert '' not in found


def test_processes_behind_timers_have_labels_too(launcher: Launcher) -> None:
    text = (
        'launch:\n- node: {pkg: alpha, exec: talker, name: kitchen}\n'
        '- timer:\n    period: 1\n    children:\n'
        '    - node: {pkg: alpha, exec: talker, name: cellar}\n'
        '    - timer: {period: 1, children: [executable: {cmd: echo}]}\n'
    )
    found = [(p.label, p.name) for p in launcher.processes(text)]
    assert found == [
        ('kitchen', 'talker-1'),
        ('cellar', 'talker-2'),
        ('echo-3', 'echo-3'),
    ]


def test_nothing_but_labels_changes() -> None:
    a = Process('a-1', ('a',), '/', HERE, 'a-1', node_name='/one')
    b = Process('b-2', ('b',), '/', HERE, 'b-2')
    late = Timer(1.0, (b,), cancel_on_shutdown=False)
    labelled = with_labels(Plan((late, a)))
    assert labelled == Plan((late, replace(a, label='one')))
    assert with_labels(Plan()) == Plan()


@pytest.mark.parametrize(
    ('taken', 'label'),
    [([], 'talker'), (['talker', 'a.py-1'], 'talker-2')],
)
def test_a_component_keeps_its_label_if_it_is_free(taken, label) -> None:
    talker = Process('a.py-3', (), '/', HERE, node_name='/talker')
    component = Component('talker', 'demo', 'demo::T', '/box', HERE)
    plan = with_labels(Plan((talker, component)), taken)
    assert [p.label for p in plan.processes()] == ['a.py-3']
    assert [c.label for c in plan.components()] == [label]
