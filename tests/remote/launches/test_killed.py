# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Whatever part is killed, and whenever: nothing is left running anywhere."""

import os
import signal
import time

import pytest
from support.deployer import DEADLINE, Deployer, HERE
from support.marked_processes import command_of, descendants
from support.sshd import Sshd
from support.user import Launch

pytestmark = pytest.mark.hostile


def _begun(deployer: Deployer, sshd: Sshd, timeouts: float = 1) -> Launch:
    deployer.places(
        {
            'stubborn': ('arm', (*deployer.talker, 'ignores')),
            'daemon': ('arm', ('sh', '-c', 'setsid sleep 1000 & wait')),
            'own': (HERE, (*deployer.talker, 'ignores')),
        },
        timeouts=timeouts,
        sync='none',
    )
    launch = deployer.deploys()
    launch.wait_for(r'stubborn\S*\] +up')
    launch.wait_for(r'own\S*\] +up')
    launch.wait_for(r'daemon\S*: started')
    # the shell has become it, and has begun it
    while sum(one.startswith('sleep') for one in sshd.left('arm')) != 1:
        assert launch.process.poll() is None
    return launch


def _nothing_is_left(deployer: Deployer, sshd: Sshd) -> None:
    sshd.wait_until_empty()
    deployer.wait_until_empty()


def _servants(deployer: Deployer, sshd: Sshd) -> list[int]:
    """Return the relay, the engine and the guard there."""
    plan = ('talker.py', 'sleep')
    begin = time.monotonic()
    while time.monotonic() < begin + DEADLINE:
        found = [
            pid
            for pid, command in sshd.processes('arm').items()
            if not any(word in command for word in plan)
        ]
        # it has variables of its own
        guards = [
            pid
            for pid in descendants(max(found))
            if 'GUARD' in command_of(pid) and pid not in found
        ]
        # what is about to become a program looks like who starts it
        if len(found) == 2 and len(guards) == 1:
            return [*sorted(found), *guards]
    raise AssertionError(sshd.processes('arm'))


def test_the_launcher_is_killed(deployer: Deployer, sshd: Sshd) -> None:
    launch = _begun(deployer, sshd)
    launch.process.kill()
    _nothing_is_left(deployer, sshd)


def test_the_connection_is_killed(deployer: Deployer, sshd: Sshd) -> None:
    launch = _begun(deployer, sshd)
    (ssh,) = (
        pid
        for pid in descendants(launch.process.pid)
        if os.readlink(f'/proc/{pid}/exe').endswith('/ssh')
    )
    os.kill(ssh, signal.SIGKILL)
    launch.wait_for('arm: the link is lost')
    launch.interrupt()
    assert 'Traceback' not in launch.output
    _nothing_is_left(deployer, sshd)


@pytest.mark.parametrize('number', range(3), ids=('relay', 'engine', 'guard'))
def test_a_servant_there_is_killed(
    deployer: Deployer, sshd: Sshd, number: int
) -> None:
    launch = _begun(deployer, sshd)
    os.kill(_servants(deployer, sshd)[number], signal.SIGKILL)
    time.sleep(1)
    launch.interrupt()
    assert 'Traceback' not in launch.output
    _nothing_is_left(deployer, sshd)


def test_all_there_are_killed(deployer: Deployer, sshd: Sshd) -> None:
    launch = _begun(deployer, sshd)
    for pid in _servants(deployer, sshd):
        os.kill(pid, signal.SIGKILL)
    launch.wait_for(r'arm is gone')
    launch.interrupt()
    assert 'Traceback' not in launch.output
    _nothing_is_left(deployer, sshd)


def test_the_machine_is_switched_off_and_on(
    deployer: Deployer, sshd: Sshd
) -> None:
    launch = _begun(deployer, sshd)
    sshd.switch_off()
    launch.wait_for(r'arm: the link is lost')
    sshd.start()
    launch.wait_for(r'arm is gone')
    launch.interrupt()
    assert 'Traceback' not in launch.output
    _nothing_is_left(deployer, sshd)


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


@pytest.mark.parametrize('delay', [0.0, 0.2, 0.4])
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
    ended = launch.end()
    # a fast machine has begun by then, and stops as launches do
    has_begun = 'stopping: interrupted' in launch.output
    assert ended in (130, -signal.SIGKILL, 0 if has_begun else 130)
    assert 'Traceback' not in launch.output
    _nothing_is_left(deployer, sshd)


def test_the_launcher_is_killed_while_it_stops(
    deployer: Deployer, sshd: Sshd
) -> None:
    launch = _begun(deployer, sshd)
    launch.process.send_signal(signal.SIGINT)
    launch.wait_for('stopping')
    launch.process.kill()
    _nothing_is_left(deployer, sshd)


def test_ctrl_c_again_forces(deployer: Deployer, sshd: Sshd) -> None:
    launch = _begun(deployer, sshd, timeouts=1000)
    launch.process.send_signal(signal.SIGINT)
    launch.wait_for('stopping')
    for number in ('SIGINT', 'SIGTERM'):
        launch.wait_for(rf'waiting for .*stubborn.* after {number};')
        launch.wait_for(rf'waiting for .*own.* after {number};')
        # who sends it twice at once means it once
        time.sleep(1)
        launch.process.send_signal(signal.SIGINT)
    assert launch.end() == 0
    _nothing_is_left(deployer, sshd)
