# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The exit codes that docs/files_and_variables.md has in its tables."""

import signal

import pytest
from support.user import User

LAUNCH_FILES = {
    'good.yaml': "launch: [executable: {cmd: 'true'}]\n",
    'bad.yaml': "launch: [executable: {cmd: 'false'}]\n",
    'long.yaml': "launch: [executable: {cmd: sh -c 'echo up; sleep 1000'}]\n",
    'mistake.yaml': "launch: [executable: {cmd: 'true', outptu: log}]\n",
}
SLOW_BUILD = """\
cmake_minimum_required(VERSION 3.16)
project(slow NONE)
execute_process(COMMAND sleep 1000)
"""
FAILING_BUILD = """\
cmake_minimum_required(VERSION 3.16)
project(failing NONE)
message(FATAL_ERROR "no")
"""


@pytest.fixture
def launcher(user: User) -> User:
    for name, text in LAUNCH_FILES.items():
        user.write(name, text)
    (user.root / 'src').mkdir()
    return user


@pytest.mark.parametrize(
    ('words', 'code'),
    [
        ('launch good.yaml', 0),
        ('launch bad.yaml', 1),
        ('launch mistake.yaml', 1),
        ('launch good.yaml --check', 0),
        ('launch mistake.yaml --check', 1),
        ('launch long.yaml --until up', 0),
        ('launch good.yaml --until up', 1),
        ('launch long.yaml --for 0.1', 0),
        ('launch long.yaml --timeout 0.1', 1),
        ('launch none.yaml', 1),
        ('launch --status', 1),
        ('run nothing at_all', 1),
        ('create 1st', 1),
        ('create my_pkg --build-type none', 2),
    ],
)
def test_code(launcher: User, words: str, code: int) -> None:
    command = launcher.start('colcon', *words.split())
    assert command.end() == code, command.output


@pytest.mark.parametrize('number', ['SIGINT', 'SIGTERM', 'SIGHUP'])
def test_a_stopped_launch(launcher: User, number: str) -> None:
    launch = launcher.start('colcon', 'launch', 'long.yaml')
    launch.wait_for(r'\] +up')
    launch.process.send_signal(signal.Signals[number])
    assert launch.end() == 0, launch.output


@pytest.mark.parametrize('verb', ['launch', 'run'])
def test_a_build(launcher: User, verb: str) -> None:
    for name, text in ('slow', SLOW_BUILD), ('failing', FAILING_BUILD):
        launcher.package(name)
        launcher.write(f'src/{name}/CMakeLists.txt', text)
    slow = launcher.start('colcon', verb, 'slow', 'slow')
    slow.wait_for('Starting >>> slow')
    assert slow.interrupt() == 130, slow.output
    failing = launcher.start('colcon', verb, 'failing', 'failing')
    assert failing.end() not in (0, 130), failing.output
    assert 'failing' in failing.output


def test_a_program_of_run(launcher: User) -> None:
    package = launcher.package('own')
    hello = package / 'scripts/hello.sh'
    for text, code in ('exit 7', 7), ('kill -9 $$', -9):
        hello.write_text(f'#!/bin/sh\n{text}\n')
        run = launcher.start('colcon', 'run', 'own', 'hello.sh')
        assert run.end() == code, run.output
