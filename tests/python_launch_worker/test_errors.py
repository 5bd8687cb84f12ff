# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Errors are told with the user's own lines."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from colcon_yamllaunch.python_launch.worker import errors
from colcon_yamllaunch.python_launch.worker.positions import Positions
import pytest


class Packages:
    """Knows of no package."""

    def missing(self, _error: BaseException) -> None:
        """Return nothing."""


def told(
    path: Path,
    source: str,
    around: Callable[[Callable[[], object]], object] = lambda do: do(),
) -> dict[str, Any]:
    """Return what is told of the error that a launch file raises."""
    path.write_text(source)
    positions = Positions()
    positions.add_file(str(path))
    # these tests stand where `launch` does
    positions._users[__file__] = False

    def run() -> None:
        code = compile(source, str(path), 'exec')
        exec(code, {})

    with pytest.raises(BaseException) as info:
        around(run)
    return errors.described(info.value, positions, Packages())


def test_frames_are_those_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / 'a.launch.py'
    f = "def f():\n    return json.loads('{')\n"
    g = 'def g(call):\n    return call()\n'
    error = told(path, f'import json\n{f}{g}g(f)\n')
    assert error['text'].startswith('JSONDecodeError: ')
    assert [frame['position'][1] for frame in error['frames']] == [6, 5, 3]
    last = error['frames'][-1]
    assert last['position'][2] in (5, 12)
    assert last['end_column'] == 27


def test_a_syntax_error_is_where_it_is(tmp_path: Path) -> None:
    path = tmp_path / 'a.launch.py'
    error = told(path, 'x = 1\ny = (2]\n')
    (frame,) = error['frames']
    assert frame['position'] == [str(path), 2, 7]
    assert error['text'].startswith('SyntaxError: ')
    assert error['package'] is None


def test_what_launch_wraps_is_told_unwrapped(tmp_path: Path) -> None:
    def wrap(do: Callable[[], object]) -> None:
        try:
            do()
        except Exception as e:  # noqa: BLE001 - as launch does
            wrapping = RuntimeError('Caught multiple exceptions')
            setattr(wrapping, '_likely_errors', [e, ValueError('xml')])  # noqa: B010
            setattr(wrapping, '_extension', 'py')  # noqa: B010
        raise wrapping

    error = told(tmp_path / 'a.launch.py', "{}['a']\n", wrap)
    assert error['text'] == "KeyError: 'a'"
    assert len(error['frames']) == 1


def test_an_error_without_frames_is_where_the_entity_was_made() -> None:
    positions = Positions()
    positions.otherwise = ['/a.launch.py', 1, 1]
    error = ValueError('no')
    errors.note_entity(error, object())
    described = errors.described(error, positions, Packages())
    (frame,) = described['frames']
    assert frame['position'] == ['/a.launch.py', 1, 1]
    assert described['text'] == 'ValueError: no'


@pytest.mark.parametrize(
    ('error', 'argument'),
    [
        (errors.ArgumentError('a'), 'a'),
        (
            RuntimeError(
                'Included launch description missing required argument '
                "'a' (description: 'no description given'), given: []"
            ),
            'a',
        ),
        (
            RuntimeError('Required launch argument "a" was not provided.'),
            'a',
        ),
        (RuntimeError('something else'), None),
        (ValueError("missing required argument 'a'"), None),
    ],
)
def test_missing_arguments_are_named(
    error: Exception, argument: str | None
) -> None:
    described = errors.described(error, Positions(), Packages())
    assert described['argument'] == argument
    assert described['frames'] == []


def test_a_key_error_with_a_text_is_told_as_text() -> None:
    class PackageNotFoundError(KeyError):
        pass

    error = PackageNotFoundError("package 'a' not found")
    described = errors.described(error, Positions(), Packages())
    assert described['text'] == "PackageNotFoundError: package 'a' not found"


def test_what_led_to_an_error_is_gone_through_once() -> None:
    first, second = ValueError('1'), ValueError('2')
    first.__cause__, second.__cause__ = second, first
    assert list(errors.chain(first)) == [first, second]


@pytest.mark.parametrize(
    ('arguments', 'hint'),
    [
        (
            "node_executable='t', node_name='n', node_namespace='s'",
            "'node_executable', 'node_name', 'node_namespace' are now "
            "'executable', 'name', 'namespace'",
        ),
        ("executable='t', node_name='n'", "'node_name' is now 'name'"),
        ("executables='t'", None),
    ],
)
def test_old_arguments_of_a_node_have_their_new_names(
    tmp_path: Path, arguments: str, hint: str | None
) -> None:
    source = (
        'def Node(*, executable, name=None, namespace=None): pass\n'
        "node_plugin = 'a variable'\n"
        f'Node({arguments})\n'
    )
    error = told(tmp_path / 'a.launch.py', source)
    assert error['text'].startswith('TypeError: ')
    assert error['hint'] == hint


def test_what_may_be_meant_by_an_argument_of_another_name(
    tmp_path: Path,
) -> None:
    classes = """\
class Action:
    def __init__(self, *, condition=None): pass
class Execute(Action):
    def __init__(self, *, cmd, output='log', **kwargs):
        super().__init__(**kwargs)
class Node(Execute):
    def __init__(self, *, package, **kwargs):
        super().__init__(cmd=[package], **kwargs)
"""
    path = tmp_path / 'a.launch.py'
    for call, hint in (
        ("Node(package='p', ouput='screen')", "did you mean 'output'?"),
        ("Node(package='p', conditon=1)", "did you mean 'condition'?"),
        ("Node(package='p', colour='red')", None),
        ('dict.fromkeys([], valeu=1)', None),
    ):
        error = told(path, f'{classes}{call}\n')
        assert error['text'].startswith('TypeError: ')
        assert error['hint'] == hint
