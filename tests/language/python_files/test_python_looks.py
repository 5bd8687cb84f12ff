# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Looking at launch files in Python: --check, --show-args, completion."""

from dataclasses import replace

from colcon_yamllaunch.language.evaluation.findings import DeclaredArgument
from colcon_yamllaunch.language.evaluation.request import NoWorkerError
from colcon_yamllaunch.language.policies.check import find_declarations
from colcon_yamllaunch.language.python_files.python_source import (
    named_packages,
    written_arguments,
)
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.plan.position import Position
import pytest
from support.played_worker import Message, Play, position, process

from tests.language.python_files.conftest import Played

ROBOT = """def generate_launch_description():
    Node(
        package='alpha',
        executable='talker')
"""
ARGUMENTS = """DeclareLaunchArgument('rate', '5', description='Fast')
launch.actions.DeclareLaunchArgument(
    name='mode', default_value=share + '/x', choices=['a', "b"])
DeclareLaunchArgument('robot')
DeclareLaunchArgument(name, 'x')
Node(package='alpha', executable='rate')
FindPackageShare('beta'), get_package_share_directory(name)
ParameterFile('rates.yaml')
"""


def test_a_check_visits_with_what_is_known(played: Played) -> None:
    played.file('robot.launch.py', ROBOT)

    def play(request: Message) -> Play:
        assert request['scope']['configurations'] == {'rate': '5'}
        at = position(played.path, 2, 5)
        yield {'say': 'package', 'name': 'alpha', 'position': at}
        yield {
            'say': 'executable',
            'package': 'alpha',
            'name': 'talker',
            'path': '/x',
            'position': at,
        }
        yield process(1, node='/n', position=at)
        return None

    played.does(play)
    checked = played.check(
        'launch:\n- arg: {name: rate, default: 5}\n'
        '- include: {file: robot.launch.py}\n'
        '- node: {pkg: alpha, exec: talker, args: $(var set) $(var rate)}'
    )
    assert checked.diagnostics == ()
    (use,) = {u for u in checked.executables if u.position.path != ''} - {
        u for u in checked.executables if u.position.path.endswith('.yaml')
    }
    assert use.position == Position(played.path, 4, 21)
    assert checked.packages['alpha'] == Position(played.path, 3, 18)
    assert [source.path for source in checked.files][-1] == played.path


def test_a_check_tells_what_is_wrong(played: Played) -> None:
    played.says(end={'error': {'text': 'ValueError: no', 'frames': []}})
    (error,) = played.check().diagnostics
    assert (error.severity, error.message) == ('error', 'ValueError: no')
    assert len(error.includes) == 1
    text = (
        'launch:\n- arg: {name: a, default: false}\n'
        '- include: {file: robot.launch.py, if: $(var a)}'
    )
    (warning,) = played.check(text).diagnostics
    assert warning.severity == 'warning'
    text = 'launch: [include: {file: robot.launch.py, if: false}]'
    assert played.check(text).diagnostics == ()


def test_a_check_without_a_required_argument(played: Played) -> None:
    played.says(end={'error': {'text': 'no', 'argument': 'robot'}})
    (warning,) = played.check_itself().diagnostics
    assert warning.severity == 'warning'
    assert "'robot' is required" in warning.message
    (error,) = played.check().diagnostics
    assert error.severity == 'error'


def test_a_check_of_what_cannot_be_visited(played: Played) -> None:
    played.says(
        process(1, node='/n'), end={'refused': 'it needs the event loop'}
    )
    (warning,) = played.check_itself().diagnostics
    assert warning.message == (
        'a launch file in Python cannot be checked: it needs the event loop'
    )


def test_looks_without_launch_tell_what_is_needed(played: Played) -> None:
    def send(_message: Message) -> None:
        raise NoWorkerError('there is no launch')

    played.worker.send = send  # type: ignore[method-assign, assignment]
    (warning,) = played.check_itself().diagnostics
    assert warning.message == 'a launch file in Python cannot be checked'
    assert warning.hint == 'source a ROS 2 that has launch_ros'
    request = played.launcher.request('launch: []')
    request = replace(request, name=played.path, path=played.path)
    with pytest.raises(LaunchError) as caught:
        find_declarations(replace(request, open_worker=lambda: played.worker))
    (error,) = caught.value.diagnostics
    assert error.hint is not None
    assert error.hint.startswith('source a ROS 2 that has launch_ros; ')


def test_arguments_are_listed(played: Played) -> None:
    at = position(played.path, 2, 5)

    def play(request: Message) -> Play:
        assert request['do'] == 'arguments'
        yield {
            'say': 'argument',
            'name': 'rate',
            'default': '5',
            'description': 'Fast',
            'choices': ['5', '6'],
            'conditional': False,
            'position': at,
            'file': played.path,
        }
        yield {
            'say': 'argument',
            'name': 'mode',
            'default': None,
            'description': '',
            'choices': None,
            'conditional': True,
            'position': at,
        }

    played.does(play)
    declared = played.declared(
        'launch:\n- arg: {name: own}\n- include:\n    file: robot.launch.py\n'
        '    arg: [{name: mode, value: x}]\n'
    )
    place = Position(played.path, 2, 5)
    _, rate, mode = declared.arguments
    assert rate == DeclaredArgument('rate', place, 'Fast', '5', ('5', '6'))
    assert (mode.is_conditional, mode.default) == (True, None)
    assert mode.set_at is not None
    assert mode.set_at.line == 5
    assert declared.not_followed == {}


def test_a_listing_of_what_cannot_be_read(played: Played) -> None:
    played.says(end={'error': {'text': 'ValueError: no', 'frames': []}})
    declared = played.declared(
        'launch:\n- arg: {name: a}\n'
        '- include: {file: robot.launch.py, if: $(var a)}'
    )
    (reason,) = declared.not_followed.values()
    assert 'ValueError: no' in reason


def test_what_stands_in_a_file_is_known_without_a_worker(
    played: Played,
) -> None:
    played.file('robot.launch.py', ARGUMENTS)
    rate, mode, robot = written_arguments(played.path)
    place = Position(played.path, 1, 1)
    assert rate == DeclaredArgument('rate', place, 'Fast', '5')
    assert (mode.name, mode.default, mode.choices) == ('mode', '…', ('a', 'b'))
    assert (robot.name, robot.default) == ('robot', None)
    packages = [name for name, _ in named_packages(played.path)]
    assert sorted(packages) == ['alpha', 'beta']
    request = played.launcher.request(
        'launch: [include: {file: robot.launch.py}]'
    )
    declared = find_declarations(request)
    assert [a.name for a in declared.arguments] == ['rate', 'mode', 'robot']


def test_a_file_that_is_no_python_has_nothing(played: Played) -> None:
    played.file('robot.launch.py', 'def (')
    assert list(written_arguments(played.path)) == []
