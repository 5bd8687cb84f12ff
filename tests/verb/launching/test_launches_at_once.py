# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Several launches in one workspace at the same time."""

from pathlib import Path

import pytest
from support.user import User

pytestmark = pytest.mark.hostile

#: What is installed is read again when all is built.
READS = """\
launch:
- executable:
    cmd: echo $(var n) $(command 'cat $(find-pkg-share one)/config/hello.txt')
"""
CALLS = """\
launch:
- let: {name: inner, value: $(command 'colcon launch two two' ignore)}
- executable: {cmd: 'echo outer'}
"""
#: A step of a build that launches.
STEP = 'execute_process(COMMAND colcon launch two two)\n'


def test_three_with_different_build_arguments(user: User) -> None:
    user.package('one', READS)
    launches = [
        user.start(
            *('colcon', 'launch', 'one', 'one', f'n:={number}'),
            f'--build-args=--cmake-args -DNUMBER={number}',
        )
        for number in range(3)
    ]
    for number, launch in enumerate(launches):
        assert launch.end() == 0, launch.output
        assert f'{number} hello' in launch.output
        assert 'Traceback' not in launch.output
    others = [
        launch.output for launch in launches if 'waiting' in launch.output
    ]
    assert others
    for output in others:
        assert "waiting for 'colcon launch one one' (process " in output


def test_processes_that_run_hold_nobody_up(user: User) -> None:
    user.package('one', "launch: [executable: {cmd: 'sleep 600'}]\n")
    first = user.start('colcon', 'launch', 'one', 'one')
    first.wait_for('started, pid')
    second = user.start('colcon', 'launch', 'one', 'one')
    second.wait_for('started, pid')
    assert 'waiting for' not in second.output
    run = user.start('colcon', 'run', 'one', 'hello.sh')
    assert run.end() == 0, run.output
    assert 'waiting for' not in run.output
    assert 'killed' not in run.output
    assert (first.interrupt(), second.interrupt()) == (0, 0)


def test_a_launch_within_the_evaluation_of_another(user: User) -> None:
    user.package('one', CALLS)
    user.package('two')
    output = user.launch('one', 'one')
    assert 'outer' in output
    assert (user.root / 'install/two').is_dir()


def test_a_launch_within_a_build_says_so(user: User, tmp_path: Path) -> None:
    user.package('two')
    folder = user.package('one')
    cmake = folder / 'CMakeLists.txt'
    result = tmp_path / 'result'
    step = STEP.replace(
        ')', f' OUTPUT_FILE {result} ERROR_FILE {result} RESULT_VARIABLE x)'
    )
    cmake.write_text(cmake.read_text() + step)
    user.launch('one', 'one')
    said = result.read_text()
    assert "'colcon launch one one' (process " in said
    assert 'builds one in this workspace and has called this' in said
    assert '--no-build' in said
