# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whatever part is killed, and whenever: nothing is left running anywhere."""

import os
import signal
import time

import pytest
from support.deployer import Deployer
from support.deployer import HERE
from support.marked_processes import descendants
from support.sshd import Sshd
from support.user import Launch

pytestmark = pytest.mark.hostile

#: What a launch has on a machine beside the processes of the plan.
SERVANTS = ('relay', 'engine', 'guard')


def _begun(deployer: Deployer) -> Launch:
    deployer.places(
        {
            'stubborn': ('arm', (*deployer.talker, 'ignores')),
            'daemon': ('arm', ('sh', '-c', 'setsid sleep 1000 & wait')),
            'own': (HERE, (*deployer.talker, 'ignores')),
        },
        sync='none',
    )
    launch = deployer.deploys()
    launch.wait_for(r'stubborn\S*\] +up')
    launch.wait_for(r'own\S*\] +up')
    return launch


def _nothing_is_left(deployer: Deployer, sshd: Sshd) -> None:
    sshd.wait_until_empty()
    deployer.wait_until_empty()


def _servants(deployer: Deployer, sshd: Sshd) -> list[int]:
    """Return the processes there that are not of the plan, oldest first."""
    plan = ('talker.py', 'sleep')
    found = sshd.processes('arm')
    return sorted(
        pid
        for pid, command in found.items()
        if not any(word in command for word in plan)
    )


def test_the_launcher_is_killed(deployer: Deployer, sshd: Sshd) -> None:
    launch = _begun(deployer)
    launch.process.kill()
    _nothing_is_left(deployer, sshd)


def test_the_connection_is_killed(deployer: Deployer, sshd: Sshd) -> None:
    launch = _begun(deployer)
    (ssh,) = (
        pid
        for pid in descendants(launch.process.pid)
        if os.readlink(f'/proc/{pid}/exe').endswith('/ssh')
    )
    os.kill(ssh, signal.SIGKILL)
    launch.wait_for('lost|back|again')
    launch.interrupt()
    assert 'Traceback' not in launch.output
    _nothing_is_left(deployer, sshd)


@pytest.mark.parametrize('number', range(len(SERVANTS)))
def test_a_servant_there_is_killed(
    deployer: Deployer, sshd: Sshd, number: int
) -> None:
    launch = _begun(deployer)
    servants = _servants(deployer, sshd)
    if number >= len(servants):
        pytest.skip(f'there are only {len(servants)}')
    os.kill(servants[number], signal.SIGKILL)
    time.sleep(1)
    launch.interrupt()
    assert 'Traceback' not in launch.output
    _nothing_is_left(deployer, sshd)


def test_all_there_are_killed(deployer: Deployer, sshd: Sshd) -> None:
    launch = _begun(deployer)
    for pid in _servants(deployer, sshd):
        os.kill(pid, signal.SIGKILL)
    launch.wait_for(r'(?i)\barm\b.*(lost|ended|gone)')
    launch.interrupt()
    assert 'Traceback' not in launch.output


def test_the_machine_is_switched_off(deployer: Deployer, sshd: Sshd) -> None:
    launch = _begun(deployer)
    sshd.switch_off()
    launch.wait_for(r'(?i)\barm\b.*(lost|ended|gone)')
    launch.interrupt()
    assert 'Traceback' not in launch.output
    deployer.wait_until_empty()


@pytest.mark.parametrize('way', [signal.SIGINT, signal.SIGKILL])
def test_it_ends_while_it_connects(
    deployer: Deployer, sshd: Sshd, way: int
) -> None:
    deployer.places({'one': ('arm', deployer.talker)}, sync='none')
    sshd['arm'].link.hold()
    launch = deployer.deploys()
    while not sshd['arm'].link.accepted:
        assert launch.process.poll() is None, launch.output
        time.sleep(0.01)
    launch.process.send_signal(way)
    assert launch.end() in (130, -signal.SIGKILL)
    deployer.wait_until_empty()
    sshd['arm'].link.release()
    _nothing_is_left(deployer, sshd)


@pytest.mark.parametrize('delay', [0.0, 0.1, 0.2, 0.3, 0.5])
@pytest.mark.parametrize('way', [signal.SIGINT, signal.SIGKILL])
def test_it_ends_while_it_begins(
    deployer: Deployer, sshd: Sshd, way: int, delay: float
) -> None:
    deployer.places({'one': ('arm', deployer.talker)}, sync='none')
    launch = deployer.deploys()
    while not sshd['arm'].link.accepted:
        assert launch.process.poll() is None, launch.output
        time.sleep(0.01)
    time.sleep(delay)
    launch.process.send_signal(way)
    assert launch.end() in (130, -signal.SIGKILL), launch.output
    assert 'Traceback' not in launch.output
    _nothing_is_left(deployer, sshd)


def test_the_launcher_is_killed_while_it_stops(
    deployer: Deployer, sshd: Sshd
) -> None:
    launch = _begun(deployer)
    launch.process.send_signal(signal.SIGINT)
    launch.wait_for('stopping')
    launch.process.kill()
    _nothing_is_left(deployer, sshd)


def test_ctrl_c_twice_hurries(deployer: Deployer, sshd: Sshd) -> None:
    launch = _begun(deployer)
    launch.process.send_signal(signal.SIGINT)
    launch.wait_for('stopping')
    begin = time.monotonic()
    launch.process.send_signal(signal.SIGINT)
    launch.process.send_signal(signal.SIGINT)
    assert launch.end() == 0
    assert time.monotonic() - begin < 10
    _nothing_is_left(deployer, sshd)
