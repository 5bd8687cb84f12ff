# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch over several machines is one launch for its user."""

from collections.abc import Iterator
import json
from pathlib import Path
import re

import pytest
from support.deployer import Deployer, HERE
from support.sshd import skip_without_sshd, Sshd
from support.user import Launch

# one launch, seen from all sides
pytestmark = [pytest.mark.full, pytest.mark.xdist_group('one_launch')]


class Running:
    """The launch, its user, and the machines."""

    def __init__(self, sshd: Sshd, user: Deployer) -> None:
        self.sshd = sshd
        self.user = user
        talker = user.talker
        user.places(
            {
                'arm_talker': ('arm', talker),
                'arm_reader': ('arm', (*talker, 'reads')),
                'gpu_talker': ('gpu', talker),
                'gpu_reader': ('gpu', (*talker, 'reads')),
                'own_talker': (HERE, talker),
            }
        )
        self.launch: Launch = user.deploys('--tty')
        machines = ('arm_talker', 'arm_reader', 'gpu_talker', 'gpu_reader')
        for name in (*machines, 'own_talker'):
            self.launch.wait_for(rf'{name}\S*\] +up')


@pytest.fixture(scope='module')
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    skip_without_sshd()
    with Sshd(tmp_path_factory.mktemp('sshd')) as sshd:
        user = Deployer(tmp_path_factory.mktemp('deployer'), sshd)
        yield Running(sshd, user)
        user.leave()


def _states(running: Running) -> dict[str, dict[str, object]]:
    text = running.user.launch('--status=json')
    (launch,) = json.loads(text)['launches']
    return {one['label']: one for one in launch['processes']}


def test_processes_are_told_with_their_machine(running: Running) -> None:
    assert re.search(
        r'^\[arm│arm_talker\S*\] +up ', running.launch.output, re.M
    )
    states = _states(running)
    assert {label.rpartition('│')[0] for label in states} == {'', 'arm', 'gpu'}
    assert {one['phase'] for one in states.values()} == {'running'}
    table = running.user.launch('--status')
    assert re.search(r'^  gpu│gpu_talker\S* +running ', table, re.M), table


@pytest.mark.parametrize('name', ['arm_talker*', 'arm│arm_talker*'])
def test_one_is_restarted(running: Running, name: str) -> None:
    (label,) = (one for one in _states(running) if 'arm_talker' in one)
    before = _states(running)[label]['pid']
    running.user.launch('--restart', name)
    after = _states(running)[label]['pid']
    assert before != after
    assert Path(f'/proc/{after}').exists()


def test_a_stranger_is_not_meant(running: Running) -> None:
    refused = running.user.launch('--restart', 'edge/x', code=1)
    assert 'edge/x' in refused


def test_its_logs_are_here(running: Running) -> None:
    shown = running.user.launch('--logs', 'gpu_talker*')
    assert 'up []' in shown
    assert 'up' in running.user.logged('arm_reader')


def test_one_is_typed_at(running: Running) -> None:
    terminal = running.user.in_terminal('--attach', 'arm_reader*')
    terminal.shows('arm_reader')
    terminal.types('good morning\n').shows('heard good morning')
    # it leaves, the process goes on
    terminal.types('\x1d')
    terminal.ends()


def test_one_is_stopped(running: Running) -> None:
    running.user.launch('--stop', 'gpu/gpu_reader*')
    (label,) = (one for one in _states(running) if 'gpu_reader' in one)
    assert _states(running)[label]['phase'] != 'running'


def test_ctrl_c_ends_all_of_it(running: Running) -> None:
    assert running.launch.interrupt() == 0, running.launch.output
    running.sshd.wait_until_empty()
    output = running.launch.output
    assert 'Traceback' not in output
    assert re.search(r'arm│arm_talker\S*: stopped after', output), output
    folder = running.user.log_folder
    assert len([*folder.glob('*/stdout.log')]) == 5
    events = [
        json.loads(line)
        for line in (folder / 'events.jsonl').read_text().splitlines()
    ]
    ended = {e['label'] for e in events if e['event'] == 'exited'}
    assert len(ended) == 5
