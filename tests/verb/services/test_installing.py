# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Services are installed, updated and removed."""

import json
import os
from pathlib import Path
import pwd
import re
import shutil
import socket
import subprocess

import pytest
from support.systemd import Systemd
from support.user import DEADLINE, User

# offline, `systemctl` only makes links
pytestmark = pytest.mark.skipif(
    shutil.which('systemctl') is None, reason="needs Debian's systemd"
)
LAUNCH = 'launch: [executable: {cmd: sleep 1000, name: driver}]\n'
MACHINES = """\
machines:
  OWN: {ssh: nobody@example.invalid}
  far: {ssh: robot@far.invalid}
processes:
  - match: driver-1
    machine: OWN
    restart: {when: failure}
  - match: planner-2
    machine: far
  - match: nav-3
    after: [driver-1, planner-2]
"""
THREE = """\
launch:
- executable: {cmd: sleep 1000, name: driver}
- executable: {cmd: sleep 1000, name: planner}
- executable: {cmd: sleep 1000, name: nav}
"""


@pytest.fixture
def file(user: User) -> str:
    """Return the path of a launch file."""
    return str(user.write('demo.launch.yaml', LAUNCH))


def installed(user: User) -> tuple[Path, Path]:
    """Return the folder of the service and its unit file."""
    config = Path(user.environment['HOME'], '.config')
    return (
        config / 'colcon_launch/services/my_robot',
        config / 'systemd/user/my_robot.service',
    )


def verified(unit: Path) -> str:
    """Return what systemd finds wrong in a unit file."""
    if shutil.which('systemd-analyze') is None:
        pytest.skip('needs systemd-analyze')
    done = subprocess.run(
        ['systemd-analyze', 'verify', '--man=no', str(unit)],
        capture_output=True,
        text=True,
        timeout=DEADLINE,
    )
    # it also reports on other units of this computer
    lines = [n for n in done.stderr.splitlines() if unit.stem in n]
    return '\n'.join(lines)


def error_of(systemd: Systemd, *words: str) -> str:
    """Return the error of a command that fails."""
    done = systemd.run(*words)
    assert done.returncode == 1, done
    assert 'Traceback' not in done.stderr
    return done.stderr


def test_service_of_a_user_is_installed(
    systemd: Systemd, user: User, file: str
) -> None:
    user.environment['ROS_DOMAIN_ID'] = '7'
    done = systemd.run('--install-service', 'my_robot', file, '--user')
    assert done.returncode == 0, done.stderr
    folder, unit = installed(user)
    assert done.stdout.splitlines() == [
        f'installed the service my_robot: {unit}',
        '  enable: systemctl --user enable --now my_robot && '
        'loginctl enable-linger',
        '  show: systemctl --user status my_robot',
    ]
    assert sorted(p.name for p in folder.iterdir()) == [
        'environment',
        'my_robot.json',
    ]
    modes = {p.name: p.stat().st_mode & 0o777 for p in folder.iterdir()}
    assert modes == {'environment': 0o600, 'my_robot.json': 0o640}
    variables = (folder / 'environment').read_text()
    assert 'ROS_DOMAIN_ID="7"\n' in variables
    assert 'COLCON_LOG_PATH' not in variables
    assert verified(unit) == ''


def test_service_of_the_system_runs_as_a_user(
    systemd: Systemd, file: str
) -> None:
    if os.getuid():
        pytest.skip('needs root')
    done = systemd.run('--install-service', 'my_robot', file, '--as', 'daemon')
    assert done.returncode == 0, done.stderr
    unit = systemd.folder / 'etc/system/my_robot.service'
    text = unit.read_text()
    assert '\nUser=daemon\n' in text
    assert '\nAfter=network-online.target\n' in text
    assert '\nRuntimeDirectory=colcon_launch/my_robot\n' in text
    assert verified(unit) == ''
    folder = systemd.folder / 'etc/services/my_robot'
    assert folder.stat().st_gid == pwd.getpwnam('daemon').pw_gid
    assert folder.stat().st_mode & 0o777 == 0o750


def test_installed_plan_runs_without_sources(
    systemd: Systemd, user: User, file: str
) -> None:
    systemd.run('--install-service', 'my_robot', file, '--user')
    _, unit = installed(user)
    Path(file).unlink()
    command = re.findall(r'ExecStart=(.*)', unit.read_text())[0]
    words = re.findall(r'"([^"]*)"', command)
    assert words[2:4] == ['launch', '--from-plan']
    systemd.start(*words[3:])
    systemd.wait_for('READY=1')
    status = systemd.run('--status', '--of', 'my_robot')
    assert status.stdout.startswith('my_robot: running for ')


def test_second_installation_updates_the_service(
    systemd: Systemd, user: User, file: str
) -> None:
    words = ('--install-service', 'my_robot', file, '--user')
    systemd.run(*words)
    Path(file).write_text(LAUNCH.replace('1000', '2000'))
    done = systemd.run(*words, '--service-logs', 'files')
    assert done.stdout.startswith('updated the service my_robot')
    assert 'systemctl --user restart my_robot' in done.stdout
    folder, unit = installed(user)
    plan = json.loads((folder / 'my_robot.json').read_text())
    assert plan['entries'][0]['argv'] == ['sleep', '2000']
    assert 'StandardOutput=null' in unit.read_text()


def test_enabled_service_is_linked_until_it_is_removed(
    systemd: Systemd, user: User, file: str
) -> None:
    words = ('--install-service', 'my_robot', file, '--user', '--enable')
    done = systemd.run(*words)
    assert done.returncode == 0, done.stderr
    assert 'start now: systemctl --user start my_robot' in done.stdout
    _, unit = installed(user)
    link = unit.parent / 'default.target.wants/my_robot.service'
    assert link.resolve() == unit
    assert systemd.run('--remove-service', 'my_robot').returncode == 0
    assert not link.is_symlink()


def test_log_files_replace_the_journal(
    systemd: Systemd, user: User, file: str
) -> None:
    words = ('--install-service', 'my_robot', file, '--service-logs=files')
    systemd.run(*words, '--user', '--log-limit', '20MB', '--tty')
    _, unit = installed(user)
    text = unit.read_text()
    assert 'COLCON_LOG_PATH' not in text
    assert text.count('StandardOutput=null') == 1
    assert '"--tty" "--log-limit" "20000000"' in text
    assert verified(unit) == ''


def test_service_is_removed(systemd: Systemd, user: User, file: str) -> None:
    systemd.run('--install-service', 'my_robot', file, '--user')
    folder, unit = installed(user)
    done = systemd.run('--remove-service', 'my_robot')
    assert done.returncode == 0, done.stderr
    assert not folder.exists()
    assert not unit.exists()
    assert 'there is none' in error_of(systemd, '--remove-service', 'my_robot')


def test_unknown_service_is_not_removed(systemd: Systemd, file: str) -> None:
    systemd.run('--install-service', 'my_robot', file, '--user')
    error = error_of(systemd, '--remove-service', 'my_robt')
    assert "did you mean 'my_robot'?" in error


@pytest.mark.parametrize(
    ('words', 'error'),
    [
        (('--install-service', '../x', 'FILE'), "'../x' is no name"),
        (('--install-service', 'x', 'FILE', '--as', 'nobdy'), 'no user'),
        (('--install-service', 'x', 'FILE', '--watch'), 'runs no launch now'),
        (('--install-service', 'x', 'FILE', '--check'), 'runs no launch'),
        (('FILE', '--enable'), '--enable goes with --install-service'),
        (('--remove-service', 'x', 'FILE'), 'takes nothing to launch'),
        (
            ('--install-service', 'x', 'FILE', '--on', 'u@h'),
            'install it there',
        ),
        (
            ('--install-service', 'systemd-journald', 'FILE', '--system'),
            'there is another service',
        ),
    ],
)
def test_mistake_is_one_error(
    systemd: Systemd, file: str, words: tuple[str, ...], error: str
) -> None:
    found = error_of(systemd, *(file if w == 'FILE' else w for w in words))
    assert error in found


def test_computer_without_systemd_is_reported(
    systemd: Systemd, user: User, file: str
) -> None:
    user.environment['PATH'] = '/nowhere'
    error = error_of(systemd, '--install-service', 'x', file)
    assert 'there is no systemd on this computer' in error
    assert 'there is no systemd' in error_of(systemd, '--remove-service', 'x')


@pytest.mark.skipif(os.getuid() != 0, reason='needs root')
def test_ordinary_user_installs_files_by_sudo(
    systemd: Systemd, user: User, file: str
) -> None:
    programs = user.root / 'programs'
    user.write(
        'programs/sudo', f'#!/bin/sh\necho "$@" >> {programs}/log\nexec "$@"\n'
    ).chmod(0o755)
    words = ('--install-service', 'my_robot', file, '--as', 'daemon')
    user.environment['PLAYED_USER'] = '1'
    if shutil.which('sudo') is None:
        assert 'there is no sudo here' in error_of(systemd, *words)
    path = user.environment['PATH']
    user.environment['PATH'] = f'{programs}{os.pathsep}{path}'
    done = systemd.run(*words)
    assert done.returncode == 0, done.stderr
    assert 'enable: sudo systemctl enable --now my_robot' in done.stdout
    done = systemd.run('--remove-service', 'my_robot')
    assert done.returncode == 0, done.stderr
    log = (programs / 'log').read_text().splitlines()
    assert [line.split()[0] for line in log] == [*['install'] * 5, 'rm']


@pytest.fixture
def machines(user: User) -> tuple[str, ...]:
    """Return the words of a launch on two machines, one of them this."""
    own = socket.gethostname()
    file = user.write('three.launch.yaml', THREE)
    deploy = user.write('robot.yaml', MACHINES.replace('OWN', own))
    return str(file), '--deploy', str(deploy), '--user'


def labels(user: User) -> list[str]:
    """Return the labels of the installed plan."""
    text = (installed(user)[0] / 'my_robot.json').read_text()
    return re.findall(r'"label": "([^"]*)"', text)


def test_part_of_a_machine_is_installed_there(
    systemd: Systemd, user: User, machines: tuple[str, ...]
) -> None:
    words = ('--install-service', 'my_robot', *machines)
    done = systemd.run(*words, '--on', socket.gethostname())
    assert done.returncode == 0, done.stderr
    assert labels(user) == ['driver-1']
    done = systemd.run(*words, '--on', 'here')
    assert labels(user) == ['nav-3']
    assert 'warning: nav-3 does not wait for' in done.stderr
    folder, _ = installed(user)
    systemd.start('--from-plan', str(folder / 'my_robot.json'))
    systemd.wait_for('READY=1')


def test_part_of_another_machine_is_not_installed_here(
    systemd: Systemd, machines: tuple[str, ...]
) -> None:
    words = ('--install-service', 'my_robot', *machines)
    assert 'on each of the others' in error_of(systemd, *words)
    error = error_of(systemd, *words, '--on', 'far')
    assert 'log in there (ssh robot@far.invalid)' in error
    error = error_of(systemd, *words, '--on', 'fra')
    assert "did you mean 'far'?" in error
