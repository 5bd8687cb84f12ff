# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What goes in as scope comes out again."""

from collections.abc import Iterator
import os
from typing import Any

from colcon_yamllaunch.python_launch.worker.visit import Scopes
import pytest


class Context:
    """What is used of the launch context."""

    def __init__(self) -> None:
        self.launch_configurations: dict[str, Any] = {}


@pytest.fixture
def scopes(monkeypatch: pytest.MonkeyPatch) -> Iterator[Scopes]:
    monkeypatch.setenv('SCOPE_KEPT', 'before')
    scopes = Scopes(Context())
    yield scopes
    scopes.restore()


def current(scopes: Scopes) -> dict[str, Any]:
    """Return the scope, without what pytest changes for each test."""
    scope = scopes.current()
    scope['environment'].pop('PYTEST_CURRENT_TEST', None)
    return scope


FULL = {
    'configurations': {'a': '', 'b': 'x'},
    'environment': {'SCOPE_KEPT': None, 'SCOPE_NEW': 'new'},
    'namespace': '/n',
    'parameters': [
        {'name': 'x.y', 'value': 1.5},
        {'file': '/p.yaml'},
        {'name': 'l', 'value': ['1', 'two']},
    ],
    'remaps': [['from', 'to']],
    'uses_sim_time': True,
}


def test_a_scope_goes_in_and_out(scopes: Scopes) -> None:
    scopes.enter(FULL)
    assert os.environ['SCOPE_NEW'] == 'new'
    assert 'SCOPE_KEPT' not in os.environ
    assert current(scopes) == FULL


def test_the_next_scope_has_nothing_of_the_one_before(scopes: Scopes) -> None:
    empty = current(scopes)
    scopes.enter(FULL)
    scopes.enter({})
    assert current(scopes) == empty
    assert os.environ['SCOPE_KEPT'] == 'before'


def test_what_is_no_text_stays_inside(scopes: Scopes) -> None:
    context = scopes._context
    context.launch_configurations['mine'] = held = object()
    scopes.enter(FULL)
    assert current(scopes) == FULL
    assert context.launch_configurations['mine'] is held


def test_a_file_with_parameters_has_a_full_path(scopes: Scopes) -> None:
    scopes._context.launch_configurations['global_params'] = [
        'p.yaml',
        ('inf', float('-inf')),
    ]
    assert scopes.current()['parameters'] == [
        {'file': os.path.abspath('p.yaml')},
        {'name': 'inf', 'value': '-.inf'},
    ]


def test_variables_are_told_as_changes(scopes: Scopes) -> None:
    variables = {**os.environ, 'SCOPE_NEW': 'new'}
    del variables['SCOPE_KEPT']
    changed = scopes.changes(variables)
    changed.pop('PYTEST_CURRENT_TEST', None)
    assert changed == {'SCOPE_NEW': 'new', 'SCOPE_KEPT': None}
