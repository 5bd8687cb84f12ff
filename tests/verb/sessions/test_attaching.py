# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which process of a plan gets the keyboard."""

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.plan.labels import with_labels
from colcon_yamllaunch.plan.plan import Plan, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.terminal.attachment import with_terminal
import pytest


def plan_of(*nodes: str) -> Plan:
    """Return a plan with nodes of one program."""
    here = Position('/ws/demo.yaml', 1, 1)
    names = [f'asks.py-{number}' for number in range(1, len(nodes) + 1)]
    return with_labels(
        Plan(
            tuple(
                Process(name, ('/ws/asks.py',), '/', here, name, node_name=n)
                for name, n in zip(names, nodes, strict=True)
            )
        )
    )


@pytest.mark.parametrize(
    ('name', 'label'),
    [
        ('kitchen', 'kitchen'),
        ('asks.py-1', 'kitchen'),
        ('/kitchen', 'kitchen'),
        ('left/camera', 'left/camera'),
        ('/left/camera', 'left/camera'),
        ('/right', 'right/camera'),
        ('r*', 'right/camera'),
    ],
)
def test_each_name_leads_there(name: str, label: str) -> None:
    plan = plan_of('/kitchen', '/left/camera', '/right/camera')
    changed, meant = with_terminal(plan, name)
    assert meant == label
    assert [p.label for p in changed.processes() if p.emulate_tty] == [label]


@pytest.mark.parametrize('name', ['camera', 'asks', '*'])
def test_a_name_of_several_is_refused(name: str) -> None:
    plan = plan_of('/left/camera', '/right/camera')
    with pytest.raises(UserError, match='means left/camera, right/camera'):
        with_terminal(plan, name)
