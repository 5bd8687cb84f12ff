# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The attributes `if` and `unless`."""

import pytest

TRUE = ['true', '"true"', 'True', '" TRUE "', '1', '"1"', 'yes', 'on']
FALSE = ['false', '"false"', 'False', '0', '"0"', 'no', 'off']


def applies(launcher, condition):
    text = f'launch:\n- log:\n    message: x\n    {condition}\n'
    return len(launcher.good(text).plan.entries) == 1


@pytest.mark.parametrize(
    ('value', 'expected'),
    [*((v, True) for v in TRUE), *((v, False) for v in FALSE)],
)
def test_value(launcher, value, expected):
    assert applies(launcher, f'if: {value}') is expected
    assert applies(launcher, f'unless: {value}') is not expected


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        ('$(not false)', True),
        ('$(equals $(env SET) value)', True),
        ('$(equals $(env SET) other)', False),
        ('$(and true $(not true))', False),
        ("$(eval '1 < 2')", True),
    ],
)
def test_substitution(launcher, value, expected):
    assert applies(launcher, f'if: {value}') is expected


@pytest.mark.parametrize('name', ['if', 'unless'])
@pytest.mark.parametrize(
    'value', ["«''»", '«"yes"»', '«"on"»', '«2»', '«maybe»', '«$(env SET)»']
)
def test_no_condition(launcher, name, value):
    error = launcher.error(
        f'launch:\n- log:\n    message: x\n    {name}: {value}\n'
    )
    assert f"the condition '{name}'" in error.message
    assert error.hint == 'it must be true, 1, false or 0'


def test_nothing_of_an_action_that_does_not_apply_is_evaluated(launcher):
    text = (
        'launch:\n'
        '- log: {message: $(var nope), if: false}\n'
        '- include: {file: nowhere.yaml, unless: true}\n'
        '- node: {pkg: nowhere, exec: $(env NOPE), if: "0"}\n'
        '- executable: {cmd: echo}\n'
    )
    # and it does not count
    assert launcher.process(text).label == 'echo-1'
