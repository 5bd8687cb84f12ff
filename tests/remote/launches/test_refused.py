# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A machine that cannot be used is told in one message, with the way out."""

from pathlib import Path
import sys

import pytest
from support.deployer import Deployer, HERE
from support.sshd import (
    ASKING,
    IMPOSTOR,
    LOCKED,
    OFF,
    PASSPHRASE,
    Sshd,
    STRANGER,
)

#: A Python that passes for an old one, for a program that follows `-c`.
OLD = """\
import sys
sys.version_info, sys.version = (3, 8, 18), "3.8.18 (default)"
sys.argv = sys.argv[sys.argv.index("-c", 1) :]
exec(sys.argv.pop(1))
"""

pytestmark = pytest.mark.xdist_group('refused')


def _refused(deployer: Deployer, *names: str, code: int = 1) -> str:
    """Return what a launch says that cannot begin."""
    marker = deployer.root / 'started'
    processes = {name: (name, deployer.talker) for name in names}
    deployer.places(
        {**processes, 'here': (HERE, ('touch', str(marker)))}, sync='none'
    )
    launch = deployer.deploys()
    assert launch.end() == code, launch.output
    assert 'Traceback' not in launch.output
    # nothing has been started anywhere
    assert not marker.exists()
    return launch.output


@pytest.mark.parametrize(
    'name, reason, way_out',
    [
        (OFF, 'nothing listens for ssh', 'start its ssh server'),
        (STRANGER, 'its host key is not known', f'accept it: ssh {STRANGER}'),
        (IMPOSTOR, 'is another one than before', 'ssh-keygen -R impostor'),
        (LOCKED, 'does not let us in', 'ssh-add'),
        (ASKING, 'does not let us in', 'ssh-copy-id'),
        ('nowhere.invalid', 'its name is not known', '~/.ssh/config'),
    ],
)
def test_a_machine_cannot_be_reached(
    deployer: Deployer, sshd: Sshd, name: str, reason: str, way_out: str
) -> None:
    output = _refused(deployer, 'arm', name)
    assert reason in output
    assert way_out in output
    assert output.count(f'{name} (ssh') == 1, output
    sshd.wait_until_empty()


def test_there_is_no_python(deployer: Deployer, sshd: Sshd) -> None:
    sshd['arm'].lacks_all_but('sh', 'cat', 'uname', 'mkdir')
    assert 'there is no python3' in _refused(deployer, 'arm')


def test_the_python_is_too_old(deployer: Deployer, sshd: Sshd) -> None:
    sshd['arm'].lacks_all_but('sh', 'cat', 'uname', 'mkdir')
    fake = sshd['arm'].home / 'bin/python3'
    fake.write_text(f'#!/bin/sh\nexec {sys.executable} -c \'{OLD}\' "$@"\n')
    fake.chmod(0o755)
    output = _refused(deployer, 'arm')
    assert 'its Python is 3.8.18, but 3.10' in output


def test_limits_that_the_machine_cannot_set_are_errors(
    deployer: Deployer, sshd: Sshd
) -> None:
    marker = deployer.root / 'started'
    deployer.places(
        {
            'there': ('arm', deployer.talker),
            'here': (HERE, ('touch', str(marker))),
        },
        sync='none',
        rules=[
            {'match': 'there', 'cpus': '1000', 'user': 'nobdy'},
        ],
    )
    launch = deployer.deploys()
    assert launch.end() == 1, launch.output
    text = 'runs on arm: the launch has no processor 1000'
    assert f'arm│there-1 {text}' in launch.output
    assert "runs on arm: there is no user 'nobdy'" in launch.output
    assert 'robot.yaml:1:' in launch.output
    assert not marker.exists()


def test_a_process_there_has_its_priority(
    deployer: Deployer, sshd: Sshd
) -> None:
    deployer.places(
        {'there': ('arm', ('nice',))},
        sync='none',
        rules=[{'match': 'there', 'nice': 8}],
    )
    launch = deployer.deploys()
    assert launch.end() == 0, launch.output
    assert '] 8\n' in launch.output


def test_a_passphrase_is_asked_for_before_the_launch(
    deployer: Deployer, sshd: Sshd
) -> None:
    deployer.places({'there': (LOCKED, deployer.talker)}, sync='none')
    terminal = deployer.in_terminal('--deploy', 'robot.yaml', 'plain.yaml')
    terminal.shows('passphrase for key').types(f'{PASSPHRASE}\n')
    terminal.shows('up []').types('\x03')
    assert terminal.ends() == 0
    sshd.wait_until_empty()


def test_a_host_key_is_asked_for_before_the_launch(
    deployer: Deployer, sshd: Sshd
) -> None:
    deployer.places({'there': (STRANGER, deployer.talker)}, sync='none')
    terminal = deployer.in_terminal('--deploy', 'robot.yaml', 'plain.yaml')
    terminal.shows('(yes/no').types('no\n')
    assert terminal.ends() == 1
    assert 'host key' in terminal.screen
    again = deployer.in_terminal('--deploy', 'robot.yaml', 'plain.yaml')
    again.shows('(yes/no').types('yes\n').shows('up []').types('\x03')
    assert again.ends() == 0
    sshd.wait_until_empty()


def test_a_workspace_is_missing(deployer: Deployer, sshd: Sshd) -> None:
    deployer.package('robot')
    deployer.manifest('robot')
    deployment = (
        'machines: {arm: {ssh: arm, sync: none, workspace: ~/nowhere}}\n'
        "processes: [{match: '*', machine: arm}]\n"
    )
    deployer.write('robot.yaml', deployment)
    words = ('--deploy', 'robot.yaml', 'robot', 'robot.yaml')
    output = deployer.launch(*words, code=1)
    assert 'nowhere' in output
    assert not Path(sshd['arm'].home, 'nowhere').exists()
