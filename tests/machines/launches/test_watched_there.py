# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`--watch` goes on with files whose programs run on another machine."""

import pytest
from support.deployer import Deployer
from support.sshd import Sshd

pytestmark = pytest.mark.full

LAUNCH = """\
launch:
  - executable: {cmd: $(find-pkg-prefix there)/lib/there/hello.sh, name: a}
  - executable: {cmd: $(find-pkg-prefix here)/lib/here/hello.sh, name: b}
"""
HELLO = '#!/bin/sh\necho {word}\nexec sleep 1000\n'
ROBOT = """\
machines: {arm: {ssh: arm, workspace: ~/ws}}
processes: [{match: {executable: a*, name: a-1}, machine: arm}]
"""


@pytest.fixture
def robot(deployer: Deployer) -> Deployer:
    for name, word in (('there', 'far'), ('here', 'near')):
        deployer.package(name, LAUNCH)
        says(deployer, name, f'{word} is old')
    deployer.write('robot.yaml', ROBOT.replace('executable: a*, ', ''))
    return deployer


def says(user: Deployer, package: str, word: str) -> None:
    """Edit the program of a package."""
    text = HELLO.format(word=word)
    user.write(f'src/{package}/scripts/hello.sh', text, 0o755)


def test_what_is_saved_here_runs_there(robot: Deployer, sshd: Sshd) -> None:
    launch = robot.start(
        *('colcon', 'launch', '--deploy', 'robot.yaml', '--watch'),
        *('here', 'here'),
    )
    launch.wait_for(r'\[arm│a-1\] +far is old')
    launch.wait_for(r'\[b-2\] +near is old')
    says(robot, 'there', 'far is new')
    launch.wait_for(r'\[arm│a-1\] +far is new')
    # and nothing else is started anew
    assert launch.output.count('near is old') == 1, launch.output
    says(robot, 'here', 'near is new')
    launch.wait_for(r'\[b-2\] +near is new')
    assert launch.output.count('far is new') == 1
    # the launch file has one more for there
    text = LAUNCH.replace('name: b}', 'name: b}\n') + (
        '  - executable: {cmd: sh -c "echo more; sleep 1000", name: a-1}\n'
    )
    robot.write('src/here/launch/here.yaml', text.replace('\n\n', '\n'))
    launch.wait_for(r'\[a-1-3\] +more')
    assert launch.interrupt() == 0, launch.output
    sshd.wait_until_empty()
    robot.wait_until_empty()


def test_another_deployment_begins_the_launch_anew(
    robot: Deployer, sshd: Sshd
) -> None:
    launch = robot.start(
        *('colcon', 'launch', '--deploy', 'robot.yaml', '--watch'),
        *('here', 'here'),
    )
    launch.wait_for(r'\[arm│a-1\] +far is old')
    robot.write('robot.yaml', ROBOT.replace('a*, name: a-1', 'none'))
    launch.wait_for('the launch begins anew, as it runs on other machines')
    launch.wait_for(r'\[a-1\] +far is old')
    sshd.wait_until_empty()
    assert launch.interrupt() == 0
    robot.wait_until_empty()
