# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches of a workspace whose parts run on other machines, by real ssh."""

import json
import re

import pytest
from support.deployer import Deployer
from support.sshd import Sshd
from support.user import built

pytestmark = pytest.mark.full

HELLO = """\
launch:
  - arg: {name: who, default: you}
  - executable:
      cmd: >-
        $(find-pkg-prefix {name})/lib/{name}/hello.sh $(var who)
        file:=$(find-pkg-share {name})/config/hello.txt
      name: {name}
"""
BOTH = """\
launch:
  - include: {file: $(find-pkg-share there)/launch/there.yaml}
  - executable: {cmd: $(find-pkg-prefix here)/lib/here/hello.sh, name: here}
"""
ROBOT = """\
machines:
  arm: {ssh: arm, workspace: ~/ws}
  gpu: {ssh: gpu, workspace: ~/ws}
processes:
  - {match: there, machine: arm}
"""
#: Packages whose build takes as long as somebody wants.
SLOW = """\
cmake_minimum_required(VERSION 3.16)
project({name} NONE)
execute_process(COMMAND sh -c "touch {folder}/began; sleep 60")
"""


@pytest.fixture
def robot(deployer: Deployer) -> Deployer:
    """Return a user with two packages, and a place for the one of them."""
    deployer.package('there', HELLO)
    deployer.package('here', BOTH)
    deployer.write('robot.yaml', ROBOT)
    return deployer


def transferred(output: str) -> bool:
    return 'bringing' in output


def test_all_of_it_on_another_machine(robot: Deployer, sshd: Sshd) -> None:
    home = sshd['arm'].home
    words = ('--deploy', 'robot.yaml', '--on', 'arm', 'there', 'there')
    output = robot.launch(*words, 'who:=me')
    share = home / 'ws/install/there/share/there'
    assert f'] hello from there me file:={share}/config/hello.txt' in output
    # labels are those that it has here
    assert '[there-1] ' in output
    # what is not needed here is not built here
    assert not (robot.root / 'install').exists()
    assert not (home / 'ws/src/here').exists()
    # and nothing is done twice
    output = robot.launch(*words)
    assert 'hello from there you' in output
    assert not transferred(output)
    assert 'Starting >>>' not in output
    # what is edited here runs there
    robot.write('src/there/scripts/hello.sh', '#!/bin/sh\necho new', 0o755)
    assert '[there-1] new' in robot.launch(*words)


def test_some_here_and_some_there(robot: Deployer, sshd: Sshd) -> None:
    output = robot.launch('--deploy', 'robot.yaml', 'here', 'here')
    assert re.search(r'^\[arm│there-1\] hello from there you', output, re.M)
    assert re.search(r'^\[here-2\] +hello from here', output, re.M)
    installed = {p.name for p in (robot.root / 'install').iterdir()}
    assert 'here' in installed
    assert 'there' not in installed
    there = sshd['arm'].home / 'ws/install'
    assert 'there' in {path.name for path in there.iterdir()}
    assert not (sshd['gpu'].home / 'ws').exists()
    sshd.wait_until_empty()


def test_a_saved_plan_runs_there_too(robot: Deployer) -> None:
    words = ('--deploy', 'robot.yaml')
    plan = robot.launch('here', 'here', *words, '--plan=json', '--no-build')
    robot.write('plan.json', plan)
    robot.launch('here', 'here', *words)
    output = robot.launch('--from-plan', 'plan.json', *words)
    assert '[arm│there-1] hello from there you' in output


def test_nothing_is_brought_if_nothing_is_to_be_built(
    robot: Deployer, sshd: Sshd
) -> None:
    words = ('--deploy', 'robot.yaml', 'here', 'here')
    robot.launch(*words)
    robot.write('src/there/scripts/hello.sh', '#!/bin/sh\necho new', 0o755)
    output = robot.launch(*words, '--no-build')
    assert 'hello from there' in output
    assert not transferred(output)


def test_a_quiet_launch_says_only_what_the_processes_do(
    robot: Deployer,
) -> None:
    words = ('--deploy', 'robot.yaml', 'here', 'here', '--quiet')
    output = robot.launch(*words)
    lines = {line.partition('] ')[2].strip() for line in output.splitlines()}
    assert {line.split(' file:=')[0] for line in lines} == {
        'hello from there you',
        'hello from here',
    }


def test_a_launch_ends_as_it_is_told(robot: Deployer, sshd: Sshd) -> None:
    robot.write(
        'src/there/launch/there.yaml',
        'launch: [{executable: {cmd: sh -c "echo ready; sleep 60", '
        'name: there}}]\n',
    )
    words = ('--deploy', 'robot.yaml', 'there', 'there')
    output = robot.launch(*words, '--until', '^ready$', '--timeout', '60')
    assert 'ready' in output
    output = robot.launch(*words, '--timeout', '1', code=1)
    assert 'timeout' in output.lower()
    sshd.wait_until_empty()


def test_a_file_of_this_computer_is_told(robot: Deployer) -> None:
    outside = robot.root.parent / 'map.yaml'
    outside.write_text('')
    words = ('--deploy', 'robot.yaml', 'there', 'there')
    # the machine of the test has the same disk
    output = robot.launch(*words, f'who:={outside}')
    assert 'warning' not in output
    missing = robot.root / 'install/there/share/there/none.yaml'
    output = robot.launch(*words, f'who:={missing}')
    assert 'warning: arm│there-1 runs on arm, and there is no ' in output


def test_a_program_that_is_not_there(robot: Deployer, sshd: Sshd) -> None:
    words = ('--deploy', 'robot.yaml', 'there', 'there')
    robot.launch(*words)
    lib = sshd['arm'].home / 'ws/install/there/lib/there'
    (lib / 'hello.sh').unlink()
    output = robot.launch(*words, '--no-build', code=1)
    assert (
        'error: arm│there-1 runs on arm, and there is no program '
        f"'{lib}/hello.sh' there"
    ) in output
    sshd.wait_until_empty()


def test_a_launch_without_a_workspace(deployer: Deployer) -> None:
    deployer.write(
        'a.yaml',
        'launch: [{executable: {cmd: pwd, name: a}}, '
        '{executable: {cmd: sh -c "echo at $HOME", name: b}}]\n',
    )
    output = deployer.launch('a.yaml', '--on', 'arm')
    assert f'[a-1]    {deployer.root}' in output
    assert '/homes/arm' in output


def test_command_that_only_a_machine_needs_is_looked_for_there(
    deployer: Deployer,
) -> None:
    deployer.write(
        'a.yaml',
        'launch: [{executable: {cmd: no_such_command, name: a}}, '
        '{executable: {cmd: echo all the rest, name: b}}]\n',
    )
    output = deployer.launch('a.yaml', '--on', 'arm', code=1)
    assert 'warning' not in output
    assert 'a-1: could not be started: there is no program' in output
    assert 'all the rest\n' in output
    output = deployer.launch('a.yaml', '--on', 'arm', '--check')
    assert 'no_such_command' not in output.partition('arm')[0]


@pytest.mark.parametrize('how', ['interrupt', 'kill'])
def test_a_build_is_ended_with_the_launch(
    robot: Deployer, sshd: Sshd, how: str
) -> None:
    folder = sshd['arm'].home
    slow = SLOW.format(name='there', folder=folder)
    robot.write('src/there/CMakeLists.txt', slow)
    launch = robot.start(
        *('colcon', 'launch', '--deploy', 'robot.yaml', 'there', 'there')
    )
    while not (folder / 'began').exists():
        assert launch.process.poll() is None, launch.output
    if how == 'kill':
        launch.process.kill()
        launch.end()
    else:
        assert launch.interrupt() == 130
    sshd.wait_until_empty()
    assert 'Traceback' not in launch.output


def test_a_machine_that_does_not_answer_can_be_interrupted(
    robot: Deployer, sshd: Sshd
) -> None:
    sshd['arm'].link.hold()
    launch = robot.start(
        *('colcon', 'launch', '--deploy', 'robot.yaml', 'there', 'there')
    )
    # it is connecting
    while not any('ssh' in c for c in robot.processes().values()):
        assert launch.process.poll() is None, launch.output
    assert launch.interrupt() == 130
    robot.wait_until_empty()
    assert launch.output == ''


def test_a_build_that_fails_there_is_told(robot: Deployer, sshd: Sshd) -> None:
    robot.write('src/there/CMakeLists.txt', 'message(FATAL_ERROR "no way")\n')
    words = ('--deploy', 'robot.yaml', 'here', 'here')
    output = robot.launch(*words, code=1)
    assert 'no way' in output
    assert re.search('error: arm: .*there', output)
    sshd.wait_until_empty()


def test_a_quiet_launch_tells_why_a_build_failed(robot: Deployer) -> None:
    robot.write('src/there/CMakeLists.txt', 'message(FATAL_ERROR "no way")\n')
    words = ('--deploy', 'robot.yaml', 'here', 'here', '--quiet')
    output = robot.launch(*words, code=1)
    assert 'arm│ ' in output
    assert 'no way' in output


def test_a_shared_workspace_is_built_here(robot: Deployer) -> None:
    machine = {'ssh': 'arm', 'workspace': str(robot.root), 'sync': 'none'}
    robot.write('robot.yaml', json.dumps({'machines': {'arm': machine}}))
    words = ('--deploy', 'robot.yaml', '--on', 'arm', 'there', 'there')
    output = robot.launch(*words)
    assert built(output) == ['there']
    share = robot.root / 'install/there/share/there'
    assert f'hello from there you file:={share}/config/hello.txt' in output
