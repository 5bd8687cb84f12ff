# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The code gets to the machine, and what was edited is restarted there."""

import json
import re

import pytest
from support.deployer import Deployer
from support.sshd import Sshd
from support.user import Launch

#: A program of a package that tells where it runs.
PROGRAM = '#!/bin/sh\necho "{word} in $HOME from $0"\nexec sleep 1000\n'


def _packaged(deployer: Deployer, sync: str) -> None:
    deployer.package('robot')
    deployer.manifest('robot')
    _edit(deployer, 'first')
    deployment = {
        'machines': {'arm': {'ssh': 'arm', 'sync': sync, 'workspace': '~/ws'}},
        'processes': [{'match': '*', 'machine': 'arm'}],
    }
    deployer.write('robot.yaml', json.dumps(deployment))


def _edit(deployer: Deployer, word: str) -> None:
    path = 'src/robot/scripts/hello.sh'
    deployer.write(path, PROGRAM.format(word=word), 0o755)


def _launch(deployer: Deployer, *options: str) -> Launch:
    words = ('--deploy', 'robot.yaml', *options, 'robot', 'robot.yaml')
    return deployer.start('colcon', 'launch', *words)


@pytest.mark.parametrize('sync', ['build', 'install'])
def test_a_package_is_brought_there(
    deployer: Deployer, sshd: Sshd, sync: str
) -> None:
    _packaged(deployer, sync)
    arm = sshd['arm']
    launch = _launch(deployer)
    said = launch.wait_for(r'first in (\S+) from (\S+)')
    assert said[1] == str(arm.home)
    assert said[2].startswith(str(arm.home / 'ws/install'))
    # nothing to build here that only runs there
    assert (deployer.root / 'install').exists() == (sync == 'install')
    assert launch.interrupt() == 0
    before = arm.link.there
    again = _launch(deployer)
    again.wait_for(r'first in')
    assert again.interrupt() == 0
    assert not re.search(r'Starting >>>', again.output), again.output
    # the plan, and questions
    assert arm.link.there - before < 60_000
    sshd.wait_until_empty()


def test_an_edit_gets_there(deployer: Deployer, sshd: Sshd) -> None:
    _packaged(deployer, 'build')
    launch = _launch(deployer, '--watch')
    launch.wait_for(r'first in')
    _edit(deployer, 'second')
    launch.wait_for(rf'second in {sshd["arm"].home}')
    assert launch.interrupt() == 0
    assert 'Traceback' not in launch.output
    sshd.wait_until_empty()
    deployer.wait_until_empty()


def test_a_package_differs_there(deployer: Deployer, sshd: Sshd) -> None:
    _packaged(deployer, 'none')
    workspace = sshd['arm'].home / 'ws'
    workspace.mkdir()
    launch = _launch(deployer)
    assert launch.end() == 1
    assert 'robot' in launch.output
    assert 'Traceback' not in launch.output
