# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where the parts of a launch run is shown without connecting anywhere."""

import json
from pathlib import Path
from types import SimpleNamespace

from colcon_yamllaunch.verb import completing
from colcon_yamllaunch.verb.completing import Cursor
import pytest
from support.user import User

LAUNCH = """\
launch:
  - arg: {name: seconds, default: '1'}
  - executable: {cmd: sleep $(var seconds), name: base}
  - group:
    - push_ros_namespace: {namespace: arm}
    - executable: {cmd: sleep 2, name: driver}
"""
ROBOT = """\
machines:
  arm: {ssh: robot@arm.local, workspace: ~/ws, on_lost: keep}
  gpu: {slurm: [--gres=gpu:1], sync: none}
processes:
  - {match: {executable: driver*}, machine: arm}
"""
PLACEMENT = """\
machines:
    arm: ssh robot@arm.local, workspace ~/ws, on_lost keep, 1 process
    gpu: slurm --gres=gpu:1, sync none, nothing
    here: 1 process
"""


@pytest.fixture
def robot(user: User) -> User:
    """Return a user with a deployment, whose every connection would fail."""
    user.write('a.yaml', LAUNCH)
    user.write('robot.yaml', ROBOT)
    for name in ('ssh', 'srun'):
        path = user.write(f'bin/{name}', '#!/bin/sh\ntouch "$0.ran"\n', 0o755)
    user.environment['PATH'] = f'{path.parent}:{user.environment["PATH"]}'
    return user


def has_connected(user: User) -> bool:
    return any((user.root / 'bin').glob('*.ran'))


def test_a_plan_tells_what_runs_where(robot: User) -> None:
    output = robot.launch('a.yaml', '--deploy', 'robot.yaml', '--plan')
    assert output.splitlines() == [
        *PLACEMENT.splitlines(),
        '',
        'base-1  (a.yaml:3:5)',
        f'    (cd {robot.root} && sleep 1)',
        'arm│driver-2, process driver-2  (a.yaml:6:7)',
        '    machine: arm',
        f'    (cd {robot.root} && sleep 2)',
    ]
    assert not has_connected(robot)


def test_a_plan_of_another_machine(robot: User) -> None:
    output = robot.launch('a.yaml', '--on', 'robot@arm.local', '--plan')
    assert '    arm.local: ssh robot@arm.local, 2 processes\n' in output
    assert '    here: nothing\n' in output
    assert output.count('    machine: arm.local\n') == 2
    assert '│' not in output


def test_a_plan_for_programs_is_as_ever(robot: User) -> None:
    plain = robot.launch('a.yaml', '--plan=json')
    assert robot.launch('a.yaml', '--plan=json', '--on', 'x@y') == plain
    deployed = robot.launch('a.yaml', '--plan=json', '--deploy', 'robot.yaml')
    first, second = json.loads(deployed)['entries']
    assert first == json.loads(plain)['entries'][0]
    assert (second['label'], second['name']) == ('arm│driver-2', 'driver-2')
    assert second.keys() == json.loads(plain)['entries'][1].keys()


@pytest.mark.parametrize('form', ['mermaid', 'dot'])
def test_a_drawing_tells_it_by_the_labels(robot: User, form: str) -> None:
    words = ('a.yaml', f'--plan={form}', '--deploy', 'robot.yaml')
    assert '"arm│driver-2' in robot.launch(*words)


def test_there_is_no_script_for_several_machines(robot: User) -> None:
    words = ('a.yaml', '--plan=sh', '--deploy', 'robot.yaml')
    output = robot.launch(*words, code=1)
    assert (
        'there is no script for it, as parts of it run on arm: launch it'
        in output
    )
    robot.write('robot.yaml', 'machines: {arm: {ssh: h}}\n')
    assert robot.launch(*words).startswith('#!/usr/bin/env bash')


def test_a_check_tells_it_too(robot: User) -> None:
    output = robot.launch('a.yaml', '--deploy', 'robot.yaml', '--check')
    assert output.splitlines()[-4:] == [
        *PLACEMENT.splitlines(),
    ]
    assert not has_connected(robot)


def test_a_rule_in_vain_is_told(robot: User) -> None:
    robot.write(
        'robot.yaml',
        'machines: {arm: {ssh: h}}\n'
        'processes: [{match: drivr-2, machine: arm}]\n',
    )
    for what in ('--check', '--plan'):
        output = robot.launch('a.yaml', what, '--deploy', 'robot.yaml')
        assert (
            'robot.yaml:2:21: warning: no process of the launch is meant by '
            "'drivr-2'"
        ) in output
        assert "help: did you mean 'driver-2'?" in output


@pytest.mark.parametrize('what', [(), ('--check',), ('--plan',)])
def test_a_wrong_file_is_told_with_its_places(
    robot: User, what: tuple[str, ...]
) -> None:
    robot.write(
        'robot.yaml',
        'machines: {arm: {shh: h}}\nprocesses: [{match: a, machine: amr}]\n',
    )
    words = ('a.yaml', '--deploy', 'robot.yaml', *what)
    output = robot.launch(*words, code=1)
    assert "robot.yaml:1:18: error: a machine has no key 'shh'" in output
    assert "robot.yaml:2:33: error: there is no machine 'amr'" in output
    assert output.count('error: ') == 3


@pytest.mark.parametrize(
    ('words', 'problem'),
    [
        (['--on', '-x'], 'expected one argument'),
        (['--on=-x'], "--on takes USER@HOST as ssh does: '-x' begins with"),
        (['--on', 'amr', '--deploy', 'robot.yaml'],
         "there is no machine 'amr' in the deployment file: did you mean"),
        (['--deploy', 'robt.yaml'], "cannot read deployment file '"),
        (['--on', 'x', '-s'], '--on is about where processes run'),
        (['--deploy', ''], '--deploy needs the name of a file'),
    ],
)  # fmt: skip
def test_what_is_no_machine(
    robot: User, words: list[str], problem: str
) -> None:
    output = robot.launch('a.yaml', *words, code=1)
    assert problem in output
    assert not has_connected(robot)


def test_completion_of_hosts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def hosts(prefix: str = '', deploy: str | None = None) -> list[str]:
        known = SimpleNamespace(deploy=deploy)
        return list(completing.hosts(Cursor(prefix, known, None, {})))

    monkeypatch.setenv('HOME', str(tmp_path))
    assert hosts() == []
    folder = tmp_path / '.ssh'
    folder.mkdir()
    (folder / 'config').write_text(
        'Host arm gpu-*\n  HostName 10.0.0.1\nHost=edge !bad\nMatch all\n'
    )
    (folder / 'known_hosts').write_text(
        'base.local,10.0.0.2 ssh-ed25519 AAAA\n'
        '[port.local]:2222 ssh-ed25519 AAAA\n'
        '|1|hashed= ssh-ed25519 AAAA\n'
        '@cert-authority *.local ssh-ed25519 AAAA\n'
    )
    assert hosts() == ['10.0.0.2', 'arm', 'base.local', 'edge']
    assert 'me@arm' in hosts('me@')
    deployment = tmp_path / 'robot.yaml'
    deployment.write_text(ROBOT)
    assert hosts(deploy=str(deployment)) == ['arm', 'gpu']


def test_completion_of_profiles(tmp_path: Path) -> None:
    deployment = tmp_path / 'robot.yaml'
    deployment.write_text('profiles: {sim: {}, real: {}}\n')

    def profiles(deploy: str | None) -> list[str]:
        known = SimpleNamespace(deploy=deploy)
        return list(completing.profiles(Cursor('', known, None, {})))

    assert profiles(str(deployment)) == ['sim', 'real']
    assert profiles(None) == []


SETTINGS = """\
processes:
  - {match: driver, ready: {file: up}, nice: 5}
  - {match: base, after: driver}
  - {match: bsae, critical: true}
"""
VAIN = (
    'settings.yaml:4:13: warning: no process or component of the launch is '
    "meant by 'bsae'\n"
)


@pytest.mark.parametrize('what', ['--plan', '--check'])
def test_settings_without_machines_are_checked(user: User, what: str) -> None:
    user.write('a.yaml', LAUNCH)
    user.write('settings.yaml', SETTINGS)
    output = user.launch('a.yaml', '--deploy', 'settings.yaml', what)
    assert VAIN in output
    assert "did you mean 'base-1'" in output
    if what == '--plan':
        assert 'once driver-2 is ready:\n    base-1 ' in output
        assert 'stages:\n    1: driver-2\n    2: base-1\n' in output
    user.write('settings.yaml', SETTINGS.replace('{file: up}', '{fiel: up}'))
    words = ('a.yaml', '--deploy', 'settings.yaml', what)
    output = user.launch(*words, code=1)
    assert "'ready' has no key 'fiel'" in output


def test_launch_warns_of_settings_that_match_nothing(user: User) -> None:
    user.write('a.yaml', LAUNCH.replace('sleep 2', 'sleep 0'))
    user.write('settings.yaml', SETTINGS.replace('{file: up}', 'running'))
    words = ('a.yaml', 'seconds:=0', '--deploy', 'settings.yaml')
    output = user.launch(*words)
    assert output.count(VAIN) == 1
    assert output.index('driver-2: started') < output.index('base-1: started')
