# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The tree of a plan that runs, from its members and what these stand in."""

from colcon_yamllaunch.engine.description import plan_tree
from colcon_yamllaunch.plan.plan import Block
from colcon_yamllaunch.plan.position import Position
from support.history import component

HERE = Position('/ws/demo.yaml', 3, 5)


def shown(branches):
    titles = {f'{b.kind} {b.title}': shown(b.children) for b in branches}
    return [(t, inner) if inner else t for t, inner in titles.items()]


def test_all_stands_where_the_launch_files_have_it(process):
    blocks = (
        Block('file', '/ws/more.yaml', HERE, None),
        Block('group', '/left', HERE, 0),
        Block('timer', '3 s', HERE, None),
        Block('group', '', HERE, 2),
        # one that is empty
        Block('group', '/right', HERE, 0),
    )
    box, late = process('box', block=1), process('late', block=3)
    tree = plan_tree(
        blocks,
        # a change may have dropped a block
        [process('first', block=7), box, late, process('last')],
        [
            (component('inner', block=2), box),
            (component('far', block=0), None),
        ],
    )
    group = ('group /left', [('process box', ['component inner'])])
    assert shown(tree) == [
        'process first',
        ('file /ws/more.yaml', [group, 'component far', 'group /right']),
        ('timer 3 s', [('group ', ['process late'])]),
        'process last',
    ]
    assert tree[1].position == '/ws/demo.yaml:3:5'
