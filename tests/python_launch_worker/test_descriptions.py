# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Objects of `launch` as text and as JSON."""

import array
import json
from typing import Any

from colcon_yamllaunch.python_launch.worker.descriptions import (
    as_json,
    as_written,
    condition_text,
)
from colcon_yamllaunch.python_launch.worker.entries import (
    is_shutdown,
    nearest_mode,
)
import pytest


def made(kind: str, **fields: Any) -> Any:
    """Return an object of a class of that name."""
    one = type(kind, (), {})()
    for name, value in fields.items():
        setattr(one, name, value)
    return one


def text(value: str) -> Any:
    return made('TextSubstitution', text=value)


NAME = made('LaunchConfiguration', variable_name=[text('rate')])
SUM = made('PythonExpression', expression=[text('1 + '), NAME])
SHARE = made('FindPackageShare', package=[text('p')])
PATH = made('PathJoinSubstitution', substitutions=[[SHARE], [text('a.yaml')]])
EQUALS = made('EqualsSubstitution', left=[NAME], right=[text('1')])


@pytest.mark.parametrize(
    ('substitutions', 'expected'),
    [
        ('plain', 'plain'),
        ([text('a'), text('b')], 'ab'),
        (NAME, '$(var rate)'),
        ([made('EnvironmentVariable', name=[text('HOME')])], '$(env HOME)'),
        ([SUM], "$(eval '1 + $(var rate)')"),
        ([PATH], '$(find-pkg-share p)/a.yaml'),
        ([EQUALS], '$(equals $(var rate) 1)'),
        ([made('Theirs', describe=lambda: 'Theirs()')], 'Theirs()'),
        ([made('Theirs')], '$(Theirs)'),
    ],
)
def test_substitutions_are_written_as_in_yaml(
    substitutions: Any, expected: str
) -> None:
    assert as_written(substitutions) == expected


def test_conditions_are_written_as_in_yaml() -> None:
    name = '_IfCondition__predicate_expression'
    basis = type('IfCondition', (), {name: [NAME]})
    assert condition_text(basis()) == 'if: $(var rate)'
    unless = type('UnlessCondition', (basis,), {})
    assert condition_text(unless()) == 'unless: $(var rate)'
    kind = 'LaunchConfigurationNotEquals'
    given = {
        'launch_configuration_name': 'rate',
        'expected_value': [text('2')],
    }
    unequal = made(kind, **{f'_{kind}__{n}': v for n, v in given.items()})
    assert condition_text(unequal) == 'if: $(var rate) != 2'
    assert condition_text(made('MyCondition')) == 'if: MyCondition'


@pytest.mark.parametrize(
    ('value', 'expected'),
    [
        (True, True),
        (1, 1),
        (0.5, 0.5),
        (float('inf'), '.inf'),
        (float('nan'), '.nan'),
        ((1.5, float('-inf')), [1.5, '-.inf']),
        (array.array('q', [1, 2]), [1, 2]),
        (b'\x01\xff', [1, 255]),
        ([b'\x01', b'\xff'], [1, 255]),
        ({'a': (True,)}, {'a': [True]}),
        (None, None),
        (3j, '3j'),
    ],
)
def test_values_are_json(value: Any, expected: Any) -> None:
    found = as_json(value)
    assert json.loads(json.dumps(found)) == expected


@pytest.mark.parametrize(
    ('destinations', 'mode'),
    [
        ({'both': {'screen'}}, 'screen'),
        ({'both': {'screen', 'log'}}, 'both'),
        ({'both': {'log'}, 'stderr': {'screen'}}, 'log'),
        ({'stdout': {'screen'}, 'stderr': {'log'}}, 'both'),
        ({'stdout': {'log'}, 'stderr': {'screen'}}, 'log'),
        ({'both': {'own_log'}}, 'own_log'),
        ({'both': {'screen', 'own_log', 'log'}}, 'full'),
        ({'both': {'log'}}, 'own_log'),
        ({}, 'own_log'),
    ],
)
def test_the_nearest_mode_of_output(
    destinations: dict[str, set[str]], mode: str
) -> None:
    assert nearest_mode(destinations) == mode


def test_a_shutdown_at_the_end_and_no_more() -> None:
    shutdown = made('Shutdown', condition=None)
    emits = made('EmitEvent', condition=None, event=made('Shutdown'))
    assert is_shutdown(shutdown)
    assert is_shutdown([shutdown, emits])
    assert not is_shutdown(None)
    assert not is_shutdown([])
    assert not is_shutdown([shutdown, made('LogInfo', condition=None)])
    assert not is_shutdown(made('Shutdown', condition=made('IfCondition')))
    assert not is_shutdown(print)
