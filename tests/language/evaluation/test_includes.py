# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files that include others."""

from colcon_yamllaunch.language.evaluation.budget import MAXIMUM_INCLUDE_DEPTH
from colcon_yamllaunch.language.syntax.diagnostics import render
import pytest


def said(launcher, text, **arguments):
    entries = launcher.good(text, **arguments).plan.entries
    return [entry.text for entry in entries]


@pytest.mark.parametrize(
    'file', ['sub/in.yaml', '$(dirname)/sub/in.yaml', '$(var a)/in.yaml']
)
def test_where_a_file_is_looked_for(launcher, file):
    launcher.write('sub/in.yaml', 'launch: [log: {message: in}]')
    text = 'launch:\n- let: {name: a, value: sub}\n'
    text += f'- include: {{file: {file}}}\n'
    assert said(launcher, text) == ['in']


def test_a_file_beside_the_one_that_includes_it(launcher):
    launcher.write('sub/a.yaml', 'launch: [include: {file: b.yaml}]')
    launcher.write('sub/b.yaml', 'launch: [log: {message: beside}]')
    text = 'launch: [include: {file: sub/a.yaml}]'
    assert said(launcher, text) == ['beside']
    # the working directory comes first, as in ROS 2
    launcher.write('b.yaml', 'launch: [log: {message: here}]')
    assert said(launcher, text) == ['here']


def test_arguments(launcher):
    launcher.write(
        'in.yaml',
        'launch:\n- arg: {name: a, default: x}\n- arg: {name: b}\n'
        '- log: {message: $(var a) $(var b)}\n',
    )
    text = (
        'launch:\n- include:\n    file: in.yaml\n'
        '    arg: [{name: a, value: 1}, {name: b, value: $(var a)2}]\n'
        '- group:\n  - include: {file: in.yaml, let: [{name: b, value: 3}]}\n'
    )
    assert said(launcher, text) == ['1 12', '1 3']


def test_names_of_the_file_before_in_and_after_an_include(launcher):
    log = '- log: {message: $(filename) $(dirname)}\n'
    launcher.write('sub/in.yaml', f'launch:\n{log}')
    text = f'launch:\n{log}- include: {{file: sub/in.yaml}}\n{log}'
    folder = launcher.folder
    outer = f'{folder}/main.yaml {folder}'
    inner = f'{folder}/sub/in.yaml {folder}/sub'
    assert said(launcher, text) == [outer, inner, outer]


def test_files_that_were_read(launcher):
    launcher.write('in.yaml', 'launch: []')
    text = 'launch: [include: {file: in.yaml}, include: {file: ./in.yaml}]'
    files = launcher.good(text).files
    names = ['main.yaml', 'in.yaml']
    assert [f.path for f in files] == [str(launcher.folder / n) for n in names]


def test_deprecated(launcher):
    launcher.write('in.yaml', 'launch: {deprecated: use b, children: []}')
    (warning,) = launcher.evaluate(
        'launch: [include: {file: in.yaml}]'
    ).diagnostics
    assert warning.message == 'this launch file is deprecated: use b'
    assert warning.position.path.endswith('in.yaml')
    assert [i.column for i in warning.includes] == [26]


@pytest.mark.parametrize(
    ('file', 'message', 'hint'),
    [
        ('«nowhere.yaml»', "'nowhere.yaml' does not exist", None),
        ('«mian.yaml»', 'does not exist', "did you mean 'main.yaml'?"),
        ('«.»', 'does not exist', None),
    ],
)
def test_wrong_file(launcher, file, message, hint):
    error = launcher.error(f'launch:\n- include: {{file: {file}}}\n')
    assert message in error.message
    if hint is not None:
        assert hint in error.hint


def test_mistakes_in_an_included_file_name_the_way_there(launcher):
    launcher.write('a.yaml', 'launch:\n- include: {file: b.yaml}\n')
    launcher.write('b.yaml', 'launch:\n- nod: {}\n- lgo: {}\n')
    errors = launcher.errors('launch:\n\n- include: {file: a.yaml}\n')
    assert len(errors) == 2
    for error in errors:
        assert [i.line for i in error.includes] == [2, 3]
    shown = render(errors[:1], str(launcher.folder)).splitlines()
    assert shown[0].startswith('b.yaml:2:3: error: unknown action')
    assert shown[-2:] == [
        '  included from a.yaml:2:19',
        '  included from main.yaml:3:19',
    ]


def test_errors_of_an_evaluation_name_the_way_there(launcher):
    launcher.write('a.yaml', 'launch:\n- log: {message: $(var no)}\n')
    (error,) = launcher.errors('launch:\n- include: {file: a.yaml}\n')
    assert error.position.path.endswith('a.yaml')
    assert [i.line for i in error.includes] == [2]


def test_a_file_that_includes_itself(launcher):
    (error,) = launcher.errors('launch:\n- include: {file: main.yaml}\n')
    assert 'include one another' in error.message
    assert 'include itself' in error.hint
    assert len(error.includes) == MAXIMUM_INCLUDE_DEPTH - 1


def test_a_file_that_includes_itself_until_a_condition(launcher):
    text = (
        'launch:\n- arg: {name: n, default: 5}\n'
        '- log: {message: $(var n)}\n'
        '- include:\n    file: $(filename)\n'
        "    if: $(eval '$(var n) > 1')\n"
        "    arg: [{name: n, value: $(eval '$(var n) - 1')}]\n"
    )
    assert said(launcher, text) == list('54321')


def test_a_file_that_includes_itself_twice_ends(launcher):
    text = 'launch:\n' + '- include: {file: main.yaml}\n' * 2
    # two to the power of the depth would never end
    (error,) = launcher.errors(text)
    assert 'include one another' in error.message


@pytest.mark.full
def test_actions_have_a_limit(launcher):
    loop = 'for: {len: 1000, name: i, children: [%s]}'
    text = f'launch: [{loop % (loop % "reset: {}")}]'
    (error,) = launcher.errors(text)
    assert 'more than 200000 actions' in error.message


def test_the_deepest_launch_file_is_no_recursion_error(launcher):
    depth = 90
    text = 'launch: [' + 'group: [' * depth + 'include: {file: main.yaml}'
    errors = launcher.errors(text + ']' * (depth + 1))
    assert len(errors) == 1
