# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The command line of a ROS node, in the order of ROS 2."""

from colcon_yamllaunch.language.actions.node_names import (
    join_namespace,
    namespace_problem,
    node_name_problem,
)
from colcon_yamllaunch.plan.plan import ParameterFile
import pytest

PROGRAM = '/install/alpha/lib/alpha/talker'


def argv(launcher, attributes, before=''):
    text = f'launch:\n{before}- node:\n    pkg: alpha\n    exec: talker\n'
    text += ''.join(f'    {line}\n' for line in attributes)
    return [
        '<file>' if isinstance(argument, ParameterFile) else argument
        for argument in launcher.process(text).argv
    ]


def test_everything_in_order(launcher):
    launcher.write('p.yaml', '/**: {ros__parameters: {}}')
    before = (
        '- push_ros_namespace: {namespace: outer}\n'
        '- set_parameter: {name: g, value: 1}\n'
        '- set_parameters_from_file: {filename: p.yaml}\n'
        '- set_remap: {from: ga, to: gb}\n'
    )
    attributes = [
        'name: me',
        'namespace: inner',
        "args: -x 'a b' $(env SET)",
        'ros_args: --log-level debug',
        'launch-prefix: env -u "A B"',
        'remap: [{from: a, to: $(env SET)}, {from: c, to: d}]',
        'param: [{name: p, value: 1}, {from: p.yaml}, {name: q, value: 2}]',
    ]
    expected = f"""
        env -u A_B {PROGRAM} -x a_b value
        --ros-args --log-level debug
        --ros-args -r __node:=me -r __ns:=/outer/inner
        -p g:=1 --params-file {launcher.folder}/p.yaml
        --params-file <file> --params-file p.yaml --params-file <file>
        -r ga:=gb -r a:=value -r c:=d
    """
    found = [a.replace(' ', '_') for a in argv(launcher, attributes, before)]
    assert found == expected.split()


def test_least(launcher):
    assert argv(launcher, []) == [PROGRAM, '--ros-args']


@pytest.mark.parametrize(
    ('args', 'expected'),
    [
        ("''", []),
        ("'  '", []),
        ("a $(env EMPTY) ''", ['a', '', '']),
        ('5', ['5']),
        ('true', ['true']),
        ('[a b, c, $(env SET)]', ['a b', 'c', 'value']),
        ('[]', []),
        ('"$(env EMPTY)"', ['']),
        ('$(env WORDS)', ['two words']),
    ],
)
def test_arguments(launcher, args, expected):
    launcher.environment |= {'EMPTY': '', 'WORDS': 'two words'}
    found = argv(launcher, [f'args: {args}'])
    assert found == [PROGRAM, *expected, '--ros-args']


@pytest.mark.parametrize(
    ('pushed', 'own', 'expected'),
    [
        ([], None, None),
        ([], 'a', '/a'),
        ([], '/a', '/a'),
        ([], 'a/b/', '/a/b'),
        ([], "''", '/'),
        ([], '/', '/'),
        (['x'], None, '/x'),
        (['x'], 'a', '/x/a'),
        (['x'], '/a', '/a'),
        (['x'], "''", '/x'),
        (['x', 'y'], 'a', '/x/y/a'),
        (['x', '/y'], None, '/y'),
        (['x', "''"], None, '/x'),
        (['x/', 'y/'], None, '/x/y'),
        (['/'], 'a', '/a'),
        (['$(env SET)'], None, '/value'),
    ],
)
def test_namespace(launcher, pushed, own, expected):
    before = ''.join(
        f'- push_ros_namespace: {{namespace: {n}}}\n' for n in pushed
    )
    attributes = [] if own is None else [f'namespace: {own}']
    wanted = [] if expected is None else ['-r', f'__ns:={expected}']
    assert argv(launcher, attributes, before)[2:] == wanted


@pytest.mark.parametrize(
    ('attribute', 'message'),
    [
        ("name: «''»", 'cannot be empty'),
        ('name: «2»', 'start with a digit'),
        ('name: «my-node»', 'letters, digits and underscores'),
        ('name: «a/b»', 'letters, digits and underscores'),
        ('name: «é»', 'letters, digits and underscores'),
        ('namespace: «a-b»', 'letters, digits, '),
        ('namespace: «a/2b»', 'start with a digit'),
        ('namespace: «a//b»', 'can be empty'),
        ('namespace: «//»', ''),
    ],
)
def test_wrong_name(launcher, attribute, message):
    text = f'launch:\n- node:\n    exec: echo\n    {attribute}\n'
    if attribute == 'namespace: «//»':
        # slashes at the end do not count
        launcher.good(text.replace('«', '').replace('»', ''))
        return
    assert message in launcher.error(text).message


def test_wrong_namespace_is_not_pushed(launcher):
    error = launcher.error(
        'launch:\n- push_ros_namespace: {namespace: «a b»}\n'
        '- node: {exec: echo}\n'
    )
    assert "'/a b'" in error.message


@pytest.mark.parametrize(
    ('node', 'message', 'hint'),
    [
        ('{pkg: «alhpa», exec: talker}', "package 'alhpa'", "'alpha'?"),
        ('{pkg: alpha, exec: «walker»}', "'walker'", 'alpha has listener'),
        ('{pkg: alpha, exec: talker, args: «"\'a"»}', 'not closed', 'close'),
    ],
)
def test_wrong_program(launcher, node, message, hint):
    error = launcher.error(f'launch:\n- node: {node}\n')
    assert message in error.message
    assert hint in (error.hint or '')


def test_two_nodes_with_one_name(launcher):
    warning = launcher.warning(
        'launch:\n'
        '- node: {pkg: alpha, exec: talker, name: a, namespace: b}\n'
        '- node: {pkg: alpha, exec: listener, name: a}\n'
        '- node: {pkg: alpha, exec: listener, name: «a», namespace: /b}\n'
    )
    assert "'/b/a'" in warning.message


def test_names_count_all_processes(launcher):
    text = (
        'launch:\n- node: {pkg: alpha, exec: talker, name: node}\n'
        '- timer: {period: 1, children: [executable: {cmd: echo}]}\n'
        '- node: {pkg: alpha, exec: talker, exec_name: nice}\n'
        '- executable: {cmd: /bin/echo, name: $(env SET)}\n'
    )
    names = [process.name for process in launcher.processes(text)]
    assert names == ['talker-1', 'echo-2', 'nice-3', 'value-4']


def test_what_the_plan_knows_of_a_node(launcher):
    text = (
        'launch:\n- node: {pkg: alpha, exec: talker, name: a, namespace: b}\n'
        '- node_container: {pkg: alpha, exec: talker, name: c}\n'
        '- executable: {cmd: echo}\n'
    )
    node, container, echo = launcher.processes(text)
    assert (node.package, node.node_name) == ('alpha', '/b/a')
    assert (container.package, container.node_name) == ('alpha', '/c')
    assert (echo.package, echo.node_name) == (None, None)
    assert [p.position.line for p in (node, container, echo)] == [2, 3, 4]


@pytest.mark.parametrize('name', ['a', '_', 'A_1'])
def test_node_names(name):
    assert node_name_problem(name) is None


@pytest.mark.parametrize('namespace', ['/', '/a', '/_/b1', '/~/{node}'])
def test_namespaces(namespace):
    assert namespace_problem(namespace) is None


@pytest.mark.parametrize(
    ('base', 'namespace', 'expected'),
    [
        (None, '', '/'),
        (None, 'a', '/a'),
        ('/', 'a', '/a'),
        ('/a', 'b', '/a/b'),
        ('/a', '/b/', '/b'),
        ('/a', '', '/a'),
    ],
)
def test_join_namespace(base, namespace, expected):
    assert join_namespace(base, namespace) == expected
