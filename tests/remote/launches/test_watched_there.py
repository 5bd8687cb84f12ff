# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`--watch` goes on with files whose programs run on another machine."""

import re

import pytest
from support.deployer import Deployer
from support.manifest import manifest
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

#: The same processes on a machine that builds, on one that gets what is built
#: here, and a script on one that gets nothing.
THREE = """\
machines:
  arm: {ssh: arm, workspace: ~/ws}
  gpu: {ssh: gpu, workspace: ~/ws, sync: install}
  edge: {ssh: edge, workspace: ~/ws, sync: none}
processes:
- {match: arm_*, machine: arm}
- {match: gpu_*, machine: gpu}
- {match: edge_*, machine: edge}
"""
READ = '#!/bin/sh\necho {word} $(cat "$1")\nexec sleep 1000\n'
SETUP = """\
from setuptools import setup
setup(name='maths', version='0.1.0', packages=['maths'],
      entry_points={'console_scripts': ['run = maths.main:main']})
"""
MAIN = """\
import signal
from maths.word import WORD
def main():
    print(WORD, flush=True)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.pause()
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


def make_maths(user: Deployer) -> None:
    """Write a package in Python."""
    user.write('src/maths/package.xml', manifest('maths', 'ament_python'))
    user.write('src/maths/setup.py', SETUP)
    place = '$base/lib/maths'
    text = f'[develop]\nscript_dir={place}\n[install]\ninstall_scripts={place}'
    user.write('src/maths/setup.cfg', text)
    user.write('src/maths/maths/__init__.py', '')
    user.write('src/maths/maths/main.py', MAIN)
    user.write('src/maths/maths/word.py', "WORD = 'module 1'\n")


def test_each_machine_runs_what_is_saved_as_far_as_it_gets_code(
    deployer: Deployer, sshd: Sshd
) -> None:
    install = sshd['edge'].home / 'ws/install'
    cmds = {}
    for machine in ('arm', 'gpu', 'edge'):
        script = '$(find-pkg-prefix there)/lib/there/hello.sh'
        file = '$(find-pkg-share there)/config/hello.txt'
        cmds[f'{machine}_script'] = f'{script} {file}'
        cmds[f'{machine}_module'] = '$(find-pkg-prefix maths)/lib/maths/run'
    del cmds['edge_module']
    lines = [
        f'- executable: {{cmd: {cmd}, name: {name}}}\n'
        for name, cmd in cmds.items()
    ]
    deployer.package('there', 'launch:\n' + ''.join(lines))
    make_maths(deployer)
    deployer.write('robot.yaml', THREE)

    read = READ.format(word='script 1')
    deployer.write('src/there/scripts/hello.sh', read, 0o755)
    # what it has was brought by somebody else
    for place, text in (
        ('setup.bash', ''),
        ('there/lib/there/hello.sh', read),
        ('there/share/there/config/hello.txt', 'hello'),
        ('there/share/colcon-core/packages/there', ''),
    ):
        file = install / place
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        file.chmod(0o755)
    launch = deployer.start(
        *('colcon', 'launch', '--deploy', 'robot.yaml', '--watch'),
        *('there', 'there'),
    )
    for machine in ('arm', 'gpu', 'edge'):
        launch.wait_for(rf'{machine}_script\S*\] +script 1 hello')
    for machine in ('arm', 'gpu'):
        launch.wait_for(rf'{machine}_module\S*\] +module 1')
    # it is linked here, and a file of its own on each machine
    read = READ.format(word='script 2')
    deployer.write('src/there/scripts/hello.sh', read, 0o755)
    launch.wait_for(
        r'\[watch\] +hello.sh changed: restarted arm│arm_script\S*, '
        r'gpu│gpu_script\S*, not sent to edge \(sync: none\)'
    )
    deployer.write('src/there/config/hello.txt', 'bye')
    launch.wait_for('hello.txt changed: restarted .*, not sent to edge')
    deployer.write('src/maths/maths/word.py', "WORD = 'module 2'\n")
    launch.wait_for(r'word.py changed: restarted arm│arm_module\S*, gpu│gpu_m')
    for machine in ('arm', 'gpu'):
        launch.wait_for(rf'{machine}_script\S*\] +script 2 hello')
        launch.wait_for(rf'{machine}_script\S*\] +script 2 bye')
        launch.wait_for(rf'{machine}_module\S*\] +module 2')
    assert len(re.findall(r'edge_script\S*\] +script', launch.output)) == 1
    assert launch.interrupt() == 0, launch.output
    sshd.wait_until_empty()
    deployer.wait_until_empty()


def test_what_is_installed_here_is_sent_on(
    robot: Deployer, sshd: Sshd
) -> None:
    # it is linked into the install space here by that
    robot.launch('here', 'here', '--until', 'near is old')
    words = ('--deploy', 'robot.yaml', '--on', 'arm', '--watch')
    launch = robot.start('colcon', 'launch', *words, 'here', 'here')
    launch.wait_for(r'\[a-1\] +far is old')
    says(robot, 'there', 'far is new')
    launch.wait_for(r'\[a-1\] +far is new')
    assert launch.output.count('near is old') == 1, launch.output
    assert launch.interrupt() == 0
    sshd.wait_until_empty()
    robot.wait_until_empty()
