# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The tree of a plan that runs, from its parts and what these stand in."""

from colcon_yamllaunch.engine.description import plan_tree
from colcon_yamllaunch.plan.plan import Block, Component
from colcon_yamllaunch.plan.position import Position

HERE = Position('/ws/demo.yaml', 3, 5)


def component(label, block=None):
    return Component(label, 'demo', 'demo::T', '/box', HERE, block=block)


def shown(branches):
    return [
        f'{b.kind} {b.title}'
        if not b.children
        else (f'{b.kind} {b.title}', shown(b.children))
        for b in branches
    ]


def test_all_stands_where_the_launch_files_have_it(process):
    blocks = (
        Block('file', '/ws/more.yaml', HERE, None),
        Block('group', '/left', HERE, 0),
        Block('timer', '3 s', HERE, None),
        Block('group', '', HERE, 2),
    )
    box = process('box', block=1)
    tree = plan_tree(
        blocks,
        [process('first'), box, process('late', block=3), process('last')],
        [
            (component('inner', block=2), box),
            (component('far', block=0), None),
        ],
    )
    assert shown(tree) == [
        'process first',
        (
            'file /ws/more.yaml',
            [
                ('group /left', [('process box', ['component inner'])]),
                'component far',
            ],
        ),
        ('timer 3 s', [('group ', ['process late'])]),
        'process last',
    ]
    assert tree[1].position == '/ws/demo.yaml:3:5'


def test_what_a_change_has_dropped_may_stand_anywhere(process):
    tree = plan_tree((), [process('gone', block=7)], ())
    assert shown(tree) == ['process gone']


def test_empty_blocks_are_there(process):
    blocks = (
        Block('file', '/ws/a.yaml', HERE, None),
        Block('group', '/b', HERE, 0),
    )
    assert shown(plan_tree(blocks, (), ())) == [
        ('file /ws/a.yaml', ['group /b'])
    ]
