# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files in Python are run by ROS 2's own launcher."""

import os
import subprocess

from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.policies.evaluate import evaluate
import pytest

FAKE_LAUNCHER = """\
#!/bin/sh
printf '%s\\n' "$PWD" "$SET" "$@"
"""


@pytest.fixture
def ros2(launcher):
    program = launcher.write('bin/ros2', FAKE_LAUNCHER)
    program.chmod(0o755)
    path = launcher.environment['PATH']
    launcher.environment['PATH'] = f'{program.parent}:{path}'
    return program


@pytest.fixture
def file(launcher):
    return str(launcher.write('sub/robot.launch.py', 'raise SystemExit(1)'))


def warnings(evaluation):
    assert evaluation.errors == ()
    return [d.message for d in evaluation.diagnostics]


def test_what_it_is_given(launcher, ros2, file):
    process = launcher.process(
        """launch:
- arg: {name: rate, default: '5'}
- set_env: {name: SET, value: other}
- push_ros_namespace: {namespace: robot}
- include:
    file: sub/robot.launch.py
    arg: [{name: name, value: a b}]
    let: [{name: mode, value: 'x:=y'}]
"""
    )
    assert process.argv == (
        'ros2',
        'launch',
        file,
        'rate:=5',
        'name:=a b',
        'mode:=x:=y',
        'ros_namespace:=/robot',
    )
    assert process.label == 'robot.launch.py-1'
    assert process.environment == (('SET', 'other'),)
    assert process.cwd == str(launcher.folder)
    assert (process.position.line, process.position.column) == (6, 11)


def test_that_the_launcher_is_run_with_that(launcher, ros2, file):
    process = launcher.process(
        'launch:\n- set_env: {name: SET, value: other}\n'
        '- include: {file: sub/robot.launch.py, '
        'arg: [{name: a, value: "$(anon x) \'"}]}\n'
    )
    done = subprocess.run(
        process.argv,
        cwd=process.cwd,
        env={**launcher.environment, **dict(process.environment)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    cwd, variable, *words = done.stdout.splitlines()
    assert (cwd, variable) == (str(launcher.folder), 'other')
    assert words == list(process.argv[1:])


def test_it_sees_the_scope_that_it_stands_in(launcher, ros2, file):
    first, second = launcher.processes(
        """launch:
- group:
  - let: {name: a, value: '1'}
  - push_ros_namespace: {namespace: robot}
  - include: {file: sub/robot.launch.py}
- include: {file: sub/robot.launch.py}
"""
    )
    assert first.argv[3:] == ('a:=1', 'ros_namespace:=/robot')
    assert second.argv[3:] == ()
    assert second.label == 'robot.launch.py-2'


def test_conditions_and_timers(launcher, ros2, file):
    text = """launch:
- include: {file: sub/robot.launch.py, if: 'false'}
- timer:
    period: 2
    children: [include: {file: sub/robot.launch.py}]
"""
    (timer,) = launcher.good(text).plan.entries
    assert [p.label for p in timer.entries] == ['robot.launch.py-1']


def test_an_include_in_xml(launcher, ros2, file):
    process = launcher.process(
        '<launch><include file="sub/robot.launch.py">'
        '<arg name="a" value="1"/></include></launch>'
    )
    assert process.argv[3:] == ('a:=1',)


def test_timeouts_of_the_launch_hold_for_it(launcher, ros2, file):
    process = launcher.process(
        'launch: [include: {file: sub/robot.launch.py}]', sigterm_timeout='20'
    )
    assert process.sigterm_timeout == 20
    assert process.argv[3:] == ('sigterm_timeout:=20',)


def launched(launcher, file, **arguments):
    return evaluate(
        Request(
            file,
            file,
            packages=launcher.packages,
            environment=launcher.environment,
            arguments=arguments,
            cwd=str(launcher.folder),
            log_folder='/logs',
        ),
    )


def test_a_file_given_on_the_command_line(launcher, ros2, file):
    evaluation = launched(launcher, file, a='1', b='2')
    assert evaluation.diagnostics == ()
    (process,) = evaluation.plan.processes()
    assert process.argv == ('ros2', 'launch', file, 'a:=1', 'b:=2')
    assert process.position.path == file


def test_what_is_installed_is_run_rather_than_the_source(launcher, ros2):
    source = launcher.write('src/a.launch.py', '')
    installed = launcher.write('share/a.launch.py', '')

    def argument():
        evaluation = evaluate(
            Request(
                str(installed),
                str(source),
                packages=launcher.packages,
                environment=launcher.environment,
                arguments={},
                cwd=str(launcher.folder),
                log_folder='/logs',
            ),
        )
        (process,) = evaluation.plan.processes()
        return process.argv[2]

    assert argument() == str(installed)
    os.remove(installed)
    assert argument() == str(source)


def test_without_a_launcher(launcher, file):
    launcher.environment['PATH'] = str(launcher.folder)
    text = '- include: {file: sub/robot.launch.py}\n'
    (error,) = launcher.errors(text)
    assert "there is no 'ros2' on the PATH" in error.message
    assert 'YAML or XML' in error.hint
    assert not error.may_pass_after_build
    launcher.packages.programs['ros2cli'] = {'ros2'}
    (error,) = launcher.errors(text)
    assert error.may_pass_after_build
    (error,) = launched(launcher, file).errors
    assert "there is no 'ros2'" in error.message


def test_the_path_is_that_of_the_scope(launcher, file):
    program = launcher.write('bin/ros2', FAKE_LAUNCHER)
    program.chmod(0o755)
    launcher.environment['PATH'] = str(launcher.folder)
    process = launcher.process(
        'launch:\n- append_env: {name: PATH, value: '
        f'{program.parent}}}\n- include: {{file: sub/robot.launch.py}}\n'
    )
    assert process.argv[0] == 'ros2'


def test_empty_values_cannot_be_passed(launcher, ros2, file):
    evaluation = launcher.evaluate(
        'launch: [include: {file: sub/robot.launch.py, '
        "arg: [{name: a, value: ''}, {name: b, value: c}]}]"
    )
    (message,) = warnings(evaluation)
    assert "'a' is empty" in message
    (process,) = evaluation.plan.processes()
    assert process.argv[3:] == ('b:=c',)


def test_settings_of_nodes_do_not_reach_it(launcher, ros2, file):
    evaluation = launcher.evaluate(
        """launch:
- set_parameter: {name: a, value: 1}
- set_remap: {from: a, to: b}
- include: {file: sub/robot.launch.py}
"""
    )
    first, second = warnings(evaluation)
    assert "'set_parameter'" in first
    assert "'set_remap'" in second


def test_its_arguments_are_not_known(launcher, ros2, file):
    text = 'launch: [include: {file: sub/robot.launch.py}]'
    assert launcher.good(text, anything='1')
    (warning,) = launcher.evaluate('launch: []', anything='1').diagnostics
    assert "'anything'" in warning.message


def test_a_file_that_is_not_there(launcher, ros2):
    error = launcher.error('launch: [include: {file: «robot.launch.py»}]')
    assert 'does not exist' in error.message
