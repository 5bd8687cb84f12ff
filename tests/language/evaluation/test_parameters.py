# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The parameters that a node of a launch file gets."""

from itertools import pairwise

from colcon_yamllaunch.plan.plan import ParameterFile
import pytest
from support.language_fixtures import Marked
import yaml


def node(*entries, before='', attributes=''):
    """Return a launch file with a node that has these parameters."""
    lines = [f'- {entry}' for entry in entries]
    return (
        f'launch:\n{before}- node:\n    pkg: alpha\n    exec: talker\n'
        f'{attributes}    param:\n'
        + ''.join(f'    {line}\n' for line in lines)
    )


def files(process):
    """Return what follows each --params-file, read."""
    argv = process.argv
    return [
        yaml.safe_load(after.content)
        if isinstance(after, ParameterFile)
        else after
        for before, after in pairwise(argv)
        if before == '--params-file'
    ]


def parameters(launcher, *entries, **settings):
    (file,) = files(launcher.process(node(*entries, **settings)))
    (found,) = file.values()
    return found['ros__parameters']


def is_exactly(found, expected):
    if isinstance(expected, list):
        return all(map(is_exactly, found, expected))
    return type(found) is type(expected) and found == expected


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        # a literal is what YAML takes it for
        ('5', 5),
        ('"5"', '5'),
        ('1.5', 1.5),
        ('true', True),
        ('"true"', 'true'),
        ('text', 'text'),
        ("''", ''),
        ('1e-3', '1e-3'),
        ('[1, 2]', [1, 2]),
        ('[1.0, 2.5]', [1.0, 2.5]),
        ('[true, false]', [True, False]),
        ('[a, "1"]', ['a', '1']),
        # a text with substitutions is what YAML takes the result for
        ('$(var n)', 5),
        ('"$(var n)"', 5),
        ('$(var n).5', 5.5),
        ('$(var t)', True),
        ('x$(var n)', 'x5'),
        ("'[$(var n), 6]'", [5, 6]),
        ('[$(var n), 6]', [5, 6]),
        ('["$(var t)", false]', [True, False]),
        ('[$(var s), b]', ['text', 'b']),
        ('\\$(var n)', '$(var n)'),
        # a type
        ('5\n      type: int', 5),
        ('text\n      type: str', 'text'),
        ('$(var n)\n      type: str', '5'),
        ('$(var n)\n      type: float', 5.0),
        ('$(var n)\n      type: int', 5),
        ('$(var one)\n      type: bool', True),
        ('$(var n)\n      type: yaml', 5),
        ('"5"\n      type: yaml', '5'),
        ('[$(var n), "6"]\n      type: list_of_str', ['5', '6']),
        ('[$(var n), 6.0]\n      type: list_of_float', [5.0, 6.0]),
        ('[1, 2]\n      type: list_of_int', [1, 2]),
        ('[$(var one), true]\n      type: list_of_bool', [True, True]),
        ('$(var colon)\n      type: str', 'a: b'),
    ],
)
def test_value(launcher, value, expected):
    before = (
        '- let: {name: n, value: 5}\n- let: {name: t, value: "true"}\n'
        '- let: {name: s, value: text}\n- let: {name: one, value: 1}\n'
        "- let: {name: colon, value: 'a: b'}\n"
    )
    found = parameters(
        launcher, f'name: p\n      value: {value}', before=before
    )
    assert list(found) == ['p']
    assert is_exactly(found['p'], expected)


@pytest.mark.parametrize(
    ('entry', 'message', 'hint'),
    [
        ('{name: p, value: «5», type: str}', 'of type int, not str', "'5'"),
        ('{name: p, value: «"5"», type: int}', 'of type str, not int', ''),
        ('{name: p, value: «5», type: float}', 'int, not float', '5.0'),
        ('{name: p, value: «5», type: list_of_int}', 'no list', '[first'),
        ('{name: p, value: «[5], type: int}', 'a list, not of type int', ''),
        ('{name: p, value: [1, «a»], type: list_of_int}', 'str, not int', ''),
        ('{name: p, value: «[1, a]}', 'int and str', 'quote'),
        ('{name: p, value: «[1, 2.5]}', 'float and int', '1.0'),
        ('{name: p, value: «$(env COLON)»}', 'a mapping', 'type: str'),
        ('{name: p, value: «$(env DATE)»}', 'a date', 'type: str'),
        ('{name: p, value: «$(env NONE)»}', 'nothing', 'type: str'),
        ('{name: p, value: «$(env SET)», type: int}', 'no int', ''),
        ('{name: p, value: «$(env SET)», type: list_of_int}', 'no list', ''),
        ('{name: p, value: [a, «"$(env LIST)"»]}', 'a list in it', ''),
        ('{name: p, param: [{«from: x}]}', "'from' cannot stand within", ''),
    ],
)
def test_error(launcher, entry, message, hint):
    launcher.environment |= {
        'COLON': 'a: b',
        'DATE': '2020-01-01',
        'NONE': '~',
        'LIST': '[1]',
    }
    entry = entry.replace('{«from', '«{from')
    error = launcher.error(node(entry))
    assert message in error.message
    assert hint in (error.hint or '') + error.message


def test_an_empty_list_is_a_warning(launcher):
    warning = launcher.warning(node('{name: p, value: «[]}'))
    assert 'empty list' in warning.message


def test_nested_parameters(launcher):
    found = parameters(
        launcher,
        '{name: a, param: [{name: b, value: 1},'
        ' {name: c, param: [{name: d, value: x}, {name: "e.f", value: y}]}]}',
        '{name: $(env SET), value: z}',
    )
    assert found == {'a.b': 1, 'a.c.d': 'x', 'a.c.e.f': 'y', 'value': 'z'}


@pytest.mark.parametrize(
    ('attributes', 'pattern'),
    [
        ('', '/**'),
        ('    name: n\n', '/**'),
        ('    namespace: ns\n', '/**'),
        ('    name: n\n    namespace: ns\n', '/ns/n'),
        ('    name: n\n    namespace: /\n', '/n'),
    ],
)
def test_whom_a_file_is_for(launcher, attributes, pattern):
    text = node('{name: a, value: 1}', attributes=attributes)
    (file,) = files(launcher.process(text))
    assert list(file) == [pattern]


def test_files_and_values_keep_their_order(launcher):
    launcher.write('one.yaml', 'x: {ros__parameters: {a: 1}}\n')
    launcher.write('two.yaml', 'x: {ros__parameters: {a: $(env SET)}}\n')
    text = node(
        '{name: a, value: 1}',
        '{name: b, value: 2}',
        '{from: one.yaml}',
        '{name: c, value: 3}',
        '{from: $(dirname)/two.yaml, allow_substs: true}',
        '{from: two.yaml, allow_substs: "$(not true)"}',
    )
    assert files(launcher.process(text)) == [
        {'/**': {'ros__parameters': {'a': 1, 'b': 2}}},
        'one.yaml',
        {'/**': {'ros__parameters': {'c': 3}}},
        {'x': {'ros__parameters': {'a': 'value'}}},
        'two.yaml',
    ]


def test_a_missing_file_is_skipped_with_a_warning(launcher):
    warning = launcher.warning(node('{from: «nowhere.yaml»}'))
    assert "'nowhere.yaml' does not exist; it is skipped" in warning.message


def test_unknown_substitution_in_a_file(launcher):
    mark = Marked.of('$(env SET): 1\na: aa $(env SET) «$(env NOPE)»\n')
    launcher.write('p.yaml', mark.text)
    text = node('{from: p.yaml, allow_substs: true}')
    (error,) = launcher.errors(text)
    mark.check(error)
    assert error.position.path.endswith('p.yaml')
    assert [include.line for include in error.includes] == [6]


def test_syntax_error_at_the_start_of_a_file(launcher):
    mark = Marked.of('«$(env')
    launcher.write('p.yaml', mark.text)
    (error,) = launcher.errors(node('{from: p.yaml, allow_substs: true}'))
    mark.check(error)


@pytest.mark.parametrize('content', ['a: [\n', 'text\n', '', '[a]\n'])
def test_a_file_that_is_none_once_its_substitutions_are_made(
    launcher, content
):
    launcher.write('p.yaml', content)
    error = launcher.error(node('{from: «p.yaml», allow_substs: true}'))
    assert 'once its substitutions are made' in error.message


NODE = '- node: {pkg: alpha, exec: talker}\n'


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        ('1', '1'),
        ('"1"', '"1"'),
        ('true', 'true'),
        ('1.5', '1.5'),
        ('text', '"text"'),
        ('1e-3', '"1e-3"'),
        ('[1, 2]', '[1, 2]'),
        ("'[1, 2]'", '[1, 2]'),
        ('$(env SET)', '"value"'),
    ],
)
def test_set_parameter(launcher, value, expected):
    text = f'launch:\n- set_parameter: {{name: p, value: {value}}}\n{NODE}'
    if value == '"1"':
        # ROS 2 infers the type of every text here
        expected = '1'
    assert launcher.process(text).argv[-2:] == ('-p', f'p:={expected}')


def test_set_parameters_from_a_missing_file(launcher):
    error = launcher.error(
        'launch:\n- set_parameters_from_file: {filename: «man.yaml»}\n'
    )
    assert 'man.yaml' in error.message
    assert not error.may_pass_after_build


def test_set_parameters_from_a_file_that_a_build_may_bring(launcher):
    (error,) = launcher.errors(
        'launch:\n- set_parameters_from_file:'
        ' {filename: $(find-pkg-share alpha)/p.yaml}\n'
    )
    assert error.may_pass_after_build


@pytest.mark.parametrize(
    ('value', 'expected'),
    [('true', 'true'), ('"0"', 'false'), ('$(not on)', 'false')],
)
def test_set_use_sim_time(launcher, value, expected):
    text = f'launch:\n- set_use_sim_time: {{value: {value}}}\n{NODE}'
    argv = launcher.process(text).argv
    assert argv[-2:] == ('-p', f'use_sim_time:={expected}')
