# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Ctrl-C, or a kill, while code is brought to a machine and built there."""

import json
import signal
import time

import pytest
from support.deployer import Deployer
from support.sshd import Sshd
from support.time_limits import within
from support.user import Launch

DEADLINE = 60
ENDLESS = '\nexecute_process(COMMAND sh -c "sleep 4001")\n'


def _building(deployer: Deployer, sshd: Sshd) -> Launch:
    """Launch a package whose build there does not end."""
    folder = deployer.package('robot')
    deployer.manifest('robot')
    file = folder / 'CMakeLists.txt'
    file.write_text(file.read_text() + ENDLESS)
    deployment = {
        'machines': {'arm': {'ssh': 'arm', 'workspace': '~/ws'}},
        'processes': [{'match': '*', 'machine': 'arm'}],
    }
    deployer.write('robot.yaml', json.dumps(deployment))
    words = ('--deploy', 'robot.yaml', 'robot', 'robot.yaml')
    launch = deployer.start('colcon', 'launch', *words)
    deadline = time.monotonic() + DEADLINE
    while not any('sleep 4001' in line for line in sshd.left('arm')):
        assert time.monotonic() < deadline, launch.output
        time.sleep(0.05)
    return launch


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_build_on_the_machine(
    deployer: Deployer, sshd: Sshd, number: signal.Signals
) -> None:
    launch = _building(deployer, sshd)
    begin = time.monotonic()
    launch.process.send_signal(number)
    assert launch.end() == 128 + number
    print(f'ended after {time.monotonic() - begin:.2f} s')
    assert 'Traceback' not in launch.output
    assert 'arm│ ' in launch.output
    with within(20):
        sshd.wait_until_empty('arm')
    deployer.wait_until_empty()


@pytest.mark.hostile
def test_no_build_outlives_a_killed_launcher(
    deployer: Deployer, sshd: Sshd
) -> None:
    launch = _building(deployer, sshd)
    launch.process.kill()
    launch.end()
    with within(20):
        sshd.wait_until_empty('arm')
    deployer.wait_until_empty()
