# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch arguments: given, missing, unknown, one of several."""

from colcon_yamllaunch.language.policies.check import check
from colcon_yamllaunch.language.policies.evaluate import evaluate
import pytest
from support.language_fixtures import Marked


def said(launcher, text, **arguments):
    return launcher.process(text, **arguments).argv[1]


ECHO = '- executable: {cmd: [echo, $(var a)]}\n'


@pytest.mark.parametrize(
    ('arg', 'arguments', 'expected'),
    [
        ('{name: a, default: b}', {}, 'b'),
        ('{name: a, default: b}', {'a': 'given'}, 'given'),
        ('{name: a, default: b}', {'a': ''}, ''),
        ("{name: a, default: ''}", {}, ''),
        ('{name: a}', {'a': 'given'}, 'given'),
        ('{name: a, default: 5}', {}, '5'),
        ('{name: a, default: 2.50}', {}, '2.50'),
        ('{name: a, default: true}', {}, 'true'),
        ('{name: a, default: x$(env SET)}', {}, 'xvalue'),
        ('{name: a, description: $(nope)}', {'a': '$(var b)'}, '$(var b)'),
        ('{name: a, choice: [{value: x}, {value: 1}]}', {'a': '1'}, '1'),
        ('{name: a, default: x, choice: [{value: x}]}', {}, 'x'),
    ],
)
def test_value(launcher, arg, arguments, expected):
    text = f'launch:\n- arg: {arg}\n{ECHO}'
    assert said(launcher, text, **arguments) == expected


def test_the_default_of_an_argument_may_use_those_before_it(launcher):
    text = 'launch:\n- arg: {name: b, default: 1}\n'
    text += f'- arg: {{name: a, default: $(var b)2}}\n{ECHO}'
    assert said(launcher, text) == '12'
    assert said(launcher, text, b='x') == 'x2'


def test_an_argument_that_is_set_already_keeps_its_value(launcher):
    text = 'launch:\n- let: {name: a, value: set}\n'
    text += f'- arg: {{name: a, default: b}}\n{ECHO}'
    assert said(launcher, text) == 'set'


def test_let_is_stronger_than_what_was_given(launcher):
    text = 'launch:\n- arg: {name: a}\n- let: {name: a, value: set}\n' + ECHO
    (process,) = launcher.evaluate(text, a='given').plan.processes()
    assert process.argv[1] == 'set'


def test_required(launcher):
    (error,) = launcher.errors('launch:\n- arg: {name: must}\n')
    assert error.message == (
        "launch argument 'must' is required, and was not given"
    )
    assert 'must:=' in error.hint


def test_required_by_an_include(launcher):
    launcher.write('inner.yaml', 'launch: [arg: {name: must}]')
    (error,) = launcher.errors('launch:\n- include: {file: inner.yaml}\n')
    assert 'name: must, value:' in error.hint
    (include,) = error.includes
    assert (include.line, include.column) == (2, 19)


def test_a_required_argument_is_missed_once(launcher):
    text = 'launch:\n- arg: {name: a}\n' + ECHO + ECHO
    (error,) = launcher.errors(text)
    assert 'required' in error.message


def test_an_argument_of_an_action_that_does_not_apply_is_not_required(
    launcher,
):
    launcher.good('launch:\n- arg: {name: must, if: false}\n')


@pytest.mark.parametrize(
    ('value', 'hint'),
    [('fastt', "did you mean 'fast'?"), ('9', 'it is one of fast, slow')],
)
def test_choices(launcher, value, hint):
    text = (
        'launch:\n'
        '- arg: {name: a, default: fast, choice: [{value: fast}, '
        '{value: slow}]}\n'
    )
    # no launch file says what the command line does
    (error,) = launcher.errors(text, a=value)
    assert error.position is None
    assert error.message == (
        f"launch argument 'a' cannot be '{value}', as 'a:={value}' of the "
        'command line says'
    )
    assert error.hint == hint
    launcher.write('in.yaml', text)
    include = '- include: {file: in.yaml, arg: [{name: a, value: «$(var b)»}]}'
    outer = f'launch:\n- arg: {{name: b, default: {value}}}\n{include}\n'
    error = launcher.error(outer)
    assert error.message == f"launch argument 'a' cannot be '{value}'"
    assert [origin.line for origin in error.origins] == [2]


def test_a_default_has_to_be_one_of_the_choices(launcher):
    text = 'launch:\n- arg: {name: a, default: «c», choice: [{value: b}]}\n'
    assert "cannot be 'c'" in launcher.error(text).message


def test_an_argument_that_is_written_as_in_a_shell(launcher):
    text = (
        'launch:\n- arg: {name: a, default: b}\n'
        '- log: {message: «"${a} $(var a)", level: INFO}\n'
    )
    mark = Marked.of(text)
    request = launcher.request(mark.text)
    for found in (check(request, portable=False), evaluate(request)):
        (warning,) = found.diagnostics
        mark.check(warning)
        assert warning.severity == 'warning'
        assert warning.message.startswith("'${a}' is no substitution")
        assert warning.hint == 'write $(var a)'


def test_an_argument_that_the_launch_file_sets_itself(launcher):
    text = (
        'launch:\n- arg: {name: a, default: b}\n'
        '- let: {name: «a», value: c}\n'
        '- log: {message: $(var a), level: INFO}\n'
    )
    mark = Marked.of(text)
    (warning,) = launcher.evaluate(mark.text, a='d').diagnostics
    mark.check(warning)
    assert warning.severity == 'warning'
    assert "'a:=d' of the command line has no effect" in warning.message
    assert not launcher.evaluate(mark.text).diagnostics


def test_an_argument_that_only_an_include_is_given_anew(launcher):
    launcher.write('in.yaml', 'launch:\n- arg: {name: a}\n' + ECHO)
    include = '- include: {file: in.yaml, arg: [{name: «a», value: c}]}\n'
    mark = Marked.of('launch:\n' + include)
    (warning,) = launcher.evaluate(mark.text, a='d').diagnostics
    mark.check(warning)
    text = 'launch:\n' + ECHO + include.replace('«a»', 'a')
    assert not launcher.evaluate(text, a='d').diagnostics


def test_an_argument_that_is_set_to_what_was_made_of_it(launcher):
    text = 'launch:\n- let: {name: a, value: $(var a)-2}\n' + ECHO
    assert not launcher.evaluate(text, a='d').diagnostics


def test_a_shell_has_variables_of_its_own(launcher):
    text = (
        'launch:\n- arg: {name: a, default: b}\n'
        '- executable: {cmd: "echo ${a} $(var a)", shell: true}\n'
        '- executable: {cmd: "echo ${HOME}"}\n'
    )
    assert not launcher.evaluate(text).diagnostics


@pytest.mark.parametrize('value', ['true', 'False', 'TRUE'])
def test_boolean_argument(launcher, value):
    text = f'launch:\n- bool_arg: {{name: a, default: "{value}"}}\n{ECHO}'
    assert said(launcher, text) == value


def test_boolean_argument_that_is_none(launcher):
    text = 'launch:\n- bool_arg: {name: a}\n'
    (error,) = launcher.errors(text, a='yes')
    assert "cannot be 'yes'" in error.message


@pytest.mark.parametrize(
    ('declared', 'given', 'hint'),
    [
        ('frame_id', 'frameid', "did you mean 'frame_id'?"),
        ('rate', 'zzz', 'it declares rate'),
    ],
)
def test_unknown_argument(launcher, declared, given, hint):
    text = f'launch:\n- arg: {{name: {declared}, default: x}}\n'
    evaluation = launcher.evaluate(text, **{given: '1'})
    (warning,) = evaluation.diagnostics
    assert warning.severity == 'warning'
    assert warning.position is None
    assert f"'{given}'" in warning.message
    assert warning.hint == hint


def test_argument_that_is_read_without_a_declaration(launcher):
    assert said(launcher, 'launch:\n' + ECHO, a='x') == 'x'


def test_argument_that_only_another_branch_declares(launcher):
    text = (
        'launch:\n- group: {if: false, children: [arg: {name: a}]}\n'
        '- include: {file: inner.yaml}\n'
    )
    launcher.write('inner.yaml', 'launch: [arg: {name: b, default: c}]')
    launcher.good(text, a='1', b='2')


@pytest.mark.parametrize(
    'name',
    ['launch__prefix', 'emulate_tty', 'sigterm_timeout', 'sigkill_timeout'],
)
def test_arguments_that_every_launch_file_has(launcher, name):
    launcher.good('launch: []', **{name: '1'})
