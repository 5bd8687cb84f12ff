# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Machines that are reached by Slurm, and by any other command."""

from collections.abc import Iterator
import os
from pathlib import Path
import re
import shlex
import signal

import pytest
from support.deployer import Deployer, HERE
from support.namespaces import NamespaceMachine
from support.slurm import Slurm
from support.user import BLOCKING


@pytest.fixture
def deployer(tmp_path: Path) -> Iterator[Deployer]:
    home = tmp_path / 'deployer'
    home.mkdir()
    somebody = Deployer(home)
    yield somebody
    somebody.leave()


@pytest.fixture
def slurm_user(deployer: Deployer, slurm: Slurm) -> Iterator[Deployer]:
    deployer.environment = slurm.environment(deployer.environment)
    machine = {'slurm': ['--partition=gpu', '--gres=gpu:1']}
    say = (*deployer.talker, 'reads')
    deployer.places({'learns': ('gpu', say)}, {'gpu': machine}, sync='none')
    yield deployer
    slurm.cancel_all()


def test_slurm_gives_an_allocation(slurm_user: Deployer, slurm: Slurm) -> None:
    launch = slurm_user.deploys()
    launch.wait_for(r'gpu│learns\S*\] +up')
    assert len(slurm.queue()) == 1
    assert launch.interrupt() == 0, launch.output
    slurm.wait_until_empty()
    slurm_user.wait_until_empty()


def test_package_is_built_in_an_allocation(
    slurm_user: Deployer, slurm: Slurm
) -> None:
    slurm_user.package('robot')
    slurm_user.manifest('robot')
    words = ('--on', 'slurm:partition=gpu', 'robot', 'robot')
    launch = slurm_user.start('colcon', 'launch', *words)
    launch.wait_for('hello from robot')
    assert 'Starting >>> robot' in launch.output
    launch.interrupt()
    slurm.wait_until_empty()


def test_slurm_gives_a_step_of_the_present_one(
    slurm_user: Deployer, slurm: Slurm
) -> None:
    words = ('--deploy', 'robot.yaml', 'plain.yaml')
    options = ('-p', 'gpu', '--gres=gpu:1')
    argv = ('salloc', *options, 'colcon', 'launch', *words)
    launch = slurm_user.start(*argv)
    launch.wait_for(r'gpu│learns\S*\] +up')
    assert len(slurm.queue()) == 1
    # salloc passes no signal on to what it runs
    (launcher,) = (
        pid
        for pid, command in slurm_user.processes().items()
        if re.search(r'colcon\S* launch', command)
        and not command.startswith('salloc')
    )
    os.kill(launcher, signal.SIGINT)
    launch.end()
    slurm.wait_until_empty()


def test_a_killed_launcher_leaves_no_job(
    slurm_user: Deployer, slurm: Slurm
) -> None:
    launch = slurm_user.deploys()
    launch.wait_for(r'gpu│learns\S*\] +up')
    launch.process.kill()
    slurm.wait_until_empty()
    slurm_user.wait_until_empty()


def test_slurm_refuses(slurm_user: Deployer, slurm: Slurm) -> None:
    machine = {'slurm': ['--partition=none']}
    command = slurm_user.talker
    slurm_user.places({'one': ('gpu', command)}, {'gpu': machine}, sync='none')
    launch = slurm_user.deploys()
    assert launch.end() == 1
    assert 'there is no such partition' in launch.output


@pytest.fixture
def docked(
    deployer: Deployer, namespace: NamespaceMachine
) -> Iterator[Deployer]:
    machine = {'connect': shlex.join([str(namespace.enter)])}
    say = (*deployer.talker, 'reads')
    stubborn = (*deployer.talker, 'ignores')
    deployer.places(
        {'reads': ('edge', say), 'stubborn': ('edge', stubborn)},
        {'edge': machine},
        sync='none',
    )
    return deployer


def test_a_command_leads_to_a_machine(
    docked: Deployer, namespace: NamespaceMachine
) -> None:
    launch = docked.deploys()
    launch.wait_for(r'edge│stubborn\S*\] +up')
    launch.wait_for(r'edge│reads\S*\] +up')
    assert launch.interrupt() == 0, launch.output
    namespace.wait_until_empty()
    docked.wait_until_empty()


def test_blocked_signals_are_unblocked_on_a_machine(
    deployer: Deployer,
) -> None:
    script = deployer.write('end.sh', 'grep SigBlk /proc/self/status; exit 3')
    machine = {'connect': shlex.join([*BLOCKING, 'env'])}
    ends = {'ends': ('edge', ('sh', str(script)))}
    deployer.places(ends, {'edge': machine}, sync='none')
    launch = deployer.deploys()
    assert launch.end() == 1, launch.output
    assert 'exited with code 3' in launch.output
    assert 'SigBlk:\t0000000000000000' in launch.output


def test_a_killed_launcher_leaves_nothing_behind_a_command(
    docked: Deployer, namespace: NamespaceMachine
) -> None:
    launch = docked.deploys()
    launch.wait_for(r'edge│stubborn\S*\] +up')
    launch.process.kill()
    namespace.wait_until_empty()
    docked.wait_until_empty()


def test_a_machine_reboots(
    docked: Deployer, namespace: NamespaceMachine
) -> None:
    launch = docked.deploys()
    launch.wait_for(r'edge│stubborn\S*\] +up')
    namespace.reboot()
    launch.wait_for(r'(?i)\bedge\b.*(lost|ended|gone|reboot)')
    launch.interrupt()
    assert 'Traceback' not in launch.output
    assert namespace.left() == []
    docked.wait_until_empty()


@pytest.mark.parametrize('on_lost', ['stop', 'restart'])
def test_processes_come_back_with_a_rebooted_machine(
    deployer: Deployer, namespace: NamespaceMachine, on_lost: str
) -> None:
    machine = {'connect': str(namespace.enter), 'on_lost': on_lost}
    deployer.places(
        {
            'one': ('edge', deployer.talker),
            'two': ('edge', deployer.talker),
            'own': (HERE, deployer.talker),
        },
        {'edge': machine},
        sync='none',
    )
    launch = deployer.deploys()
    for name in ('one', 'two', 'own'):
        launch.wait_for(rf'{name}\S*\] +up')
    namespace.reboot()
    launch.wait_for('edge is gone: ')
    if on_lost == 'stop':
        assert 'lost with edge' in deployer.launch('--status')
        restarted = deployer.launch('--restart', 'edge/*')
        assert restarted.count('started anew') == 2
    for name in ('one', 'two'):
        launch.wait_for(rf'(?s)is gone.*{name}\S*\] +up')
    states = deployer.launch('--status')
    assert len(re.findall(r'edge│\S+ +running', states)) == 2
    assert launch.interrupt() == 0, launch.output
    namespace.wait_until_empty()


def test_a_machine_does_not_run(
    docked: Deployer, namespace: NamespaceMachine
) -> None:
    namespace.power_off()
    launch = docked.deploys()
    assert launch.end() == 1
    assert 'the machine does not run' in launch.output
