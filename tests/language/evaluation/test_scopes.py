# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What an action leaves to those behind it, and where that ends."""

import pytest


def said(launcher, text, **arguments):
    """Return the arguments of each `echo`, in order."""
    return [
        ' '.join(process.argv[1:])
        for process in launcher.processes(text, **arguments)
    ]


ECHO = '- executable: {cmd: [echo, $(var a none), $(env E none)]}\n'
SET = '- let: {name: a, value: inner}\n- set_env: {name: E, value: inner}\n'


def indented(text, by):
    return ''.join(f'{" " * by}{line}\n' for line in text.splitlines())


@pytest.mark.parametrize(
    ('attributes', 'expected'),
    [
        ('', ['inner inner', 'none none']),
        ('scoped: true', ['inner inner', 'none none']),
        ('scoped: false', ['inner inner', 'inner inner']),
        ('scoped: "false"', ['inner inner', 'inner inner']),
        ('scoped: $(not true)', ['inner inner', 'inner inner']),
        ('forwarding: false', ['inner inner', 'none none']),
    ],
)
def test_a_group_ends_what_is_set_in_it(launcher, attributes, expected):
    text = f'launch:\n- group:\n    {attributes}\n    children:\n'
    text += indented(SET + ECHO, 4) + ECHO
    assert said(launcher, text) == expected


@pytest.mark.parametrize(
    ('attributes', 'expected'),
    [
        ('{}', 'outer outer'),
        ('{forwarding: true}', 'outer outer'),
        ('{forwarding: false}', 'none none'),
        ('{forwarding: "0"}', 'none none'),
        # without a scope of its own, there is nothing to forward
        ('{scoped: false, forwarding: false}', 'outer outer'),
        ('{keep: [{name: a, value: k}]}', 'k outer'),
        ('{forwarding: false, keep: [{name: a, value: k}]}', 'k none'),
        # what is kept is evaluated before the rest is forgotten
        (
            '{forwarding: false, keep: [{name: a, value: k-$(var a)}]}',
            'k-outer none',
        ),
    ],
)
def test_what_a_group_sees(launcher, attributes, expected):
    text = (
        'launch:\n- let: {name: a, value: outer}\n'
        '- set_env: {name: E, value: outer}\n'
        f'- group:\n    <<: {attributes}\n    children:\n'
    )
    assert said(launcher, text + indented(ECHO, 4)) == [expected]


def test_what_an_unscoped_group_keeps_stays(launcher):
    text = (
        'launch:\n- group: {scoped: false, keep: [{name: a, value: k}],'
        ' children: []}\n'
    )
    assert said(launcher, text + ECHO) == ['k none']


def test_a_group_that_does_not_apply_does_nothing(launcher):
    text = 'launch:\n- group:\n    if: false\n    children:\n'
    assert said(launcher, text + indented(SET + ECHO, 4) + ECHO) == [
        'none none'
    ]


def test_a_timer_sees_what_was_set_before_it(launcher):
    text = (
        'launch:\n- let: {name: a, value: before}\n'
        '- group:\n'
        '  - let: {name: a, value: group}\n'
        '  - timer:\n      period: 1\n      children:\n'
        + indented(ECHO + SET, 6)
        + indented(ECHO, 2)
        + '- let: {name: a, value: after}\n'
        + ECHO
    )
    assert said(launcher, text) == ['group none', 'group none', 'after none']


def test_an_include_leaves_what_it_sets(launcher):
    launcher.write('inner.yaml', 'launch:\n' + SET + ECHO)
    text = (
        'launch:\n- include: {file: inner.yaml, arg: [{name: b, value: c}]}\n'
        '- executable: {cmd: [echo, $(var b)]}\n'
    )
    assert said(launcher, text + ECHO) == ['inner inner', 'c', 'inner inner']


def test_an_include_in_a_group_leaves_nothing(launcher):
    launcher.write('inner.yaml', 'launch:\n' + SET + ECHO)
    text = 'launch:\n- group:\n  - include: {file: inner.yaml}\n'
    assert said(launcher, text + ECHO) == ['inner inner', 'none none']


NODE = '- node: {pkg: alpha, exec: talker}\n'


def own_arguments(process):
    return list(process.argv[2:])


@pytest.mark.parametrize(
    ('action', 'first', 'second'),
    [
        ('set_remap: {from: F, to: t}', ['-r', 'a:=t'], ['-r', 'b:=t']),
        (
            'set_parameter: {name: F, value: 1}',
            ['-p', 'a:=1'],
            ['-p', 'b:=1'],
        ),
        (
            'set_use_sim_time: {value: true}',
            ['-p', 'use_sim_time:=true'],
            ['-p', 'use_sim_time:=true'],
        ),
        (
            'set_parameters_from_file: {filename: main.yaml}',
            ['--params-file', 'FILE'],
            ['--params-file', 'FILE'],
        ),
    ],
)
def test_what_is_set_for_nodes_ends_with_its_group(
    launcher, action, first, second
):
    text = (
        f'launch:\n- {action.replace("F", "a")}\n'
        f'- group:\n  - {action.replace("F", "b")}\n  {NODE}{NODE}'
    )
    file = str(launcher.folder / 'main.yaml')
    first = [a.replace('FILE', file) for a in first]
    second = [a.replace('FILE', file) for a in second]
    inner, outer = launcher.processes(text)
    assert own_arguments(inner) == [*first, *second]
    assert own_arguments(outer) == first


def test_a_namespace_ends_with_its_group(launcher):
    text = (
        'launch:\n- push_ros_namespace: {namespace: a}\n'
        '- group:\n  - push_ros_namespace: {namespace: b}\n'
        f'  {NODE}{NODE}'
    )
    inner, outer = launcher.processes(text)
    assert own_arguments(inner) == ['-r', '__ns:=/a/b']
    assert own_arguments(outer) == ['-r', '__ns:=/a']


def test_a_group_without_forwarding_forgets_what_is_set_for_nodes(launcher):
    text = (
        'launch:\n- push_ros_namespace: {namespace: a}\n'
        '- set_remap: {from: a, to: b}\n'
        '- set_parameter: {name: a, value: 1}\n'
        f'- group:\n    forwarding: false\n    children:\n    {NODE}{NODE}'
    )
    inner, outer = launcher.processes(text)
    assert own_arguments(inner) == []
    assert len(own_arguments(outer)) == 6


def test_reset(launcher):
    text = (
        'launch:\n- let: {name: a, value: old}\n'
        '- set_env: {name: E, value: env}\n'
        '- push_ros_namespace: {namespace: a}\n'
        '- set_remap: {from: a, to: b}\n'
        '- set_parameter: {name: a, value: 1}\n'
        '- reset: {keep: [{name: b, value: $(var a)}]}\n'
        f'- executable: {{cmd: [echo, $(var b)]}}\n{ECHO}{NODE}'
    )
    *echoes, node = launcher.processes(text)
    assert [e.argv[1:] for e in echoes] == [('old',), ('none', 'env')]
    assert own_arguments(node) == []


def test_reset_also_undoes_launch_arguments(launcher):
    text = 'launch:\n- arg: {name: a}\n- reset: {}\n' + ECHO
    assert said(launcher, text, a='given') == ['none none']
