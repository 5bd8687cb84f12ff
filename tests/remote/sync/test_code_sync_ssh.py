# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Code is brought to a machine by one connection of ssh, and ends with it."""

from collections.abc import Iterator
import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys
import threading
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.remote.sync.code_sync import Synced
import pytest
from support.developer import Developer
from support.marked_processes import command_of, descendants
from support.sshd import Sshd
from support.time_limits import within

pytestmark = pytest.mark.full

#: Seconds; a loaded machine needs some.
DEADLINE = 60
#: A build that does not end, with what it starts.
ENDLESS = """
execute_process(COMMAND sh -c "sleep 4000 & sleep 4001")
"""


@pytest.fixture
def developer(tmp_path: Path, sshd: Sshd) -> Iterator[Developer]:
    machine = sshd['arm']
    machine.shell_reads(f'PATH={Path(sys.executable).parent}:$PATH')
    developer = Developer(tmp_path)
    developer.machine.root = machine.home / 'ws'
    developer.package('a')
    connect(developer, sshd)
    try:
        yield developer
    finally:
        assert isinstance(developer.connection, MachineConnection)
        developer.connection.close()
        sshd.wait_until_empty('arm')
        shutil.rmtree(machine.home / 'ws', ignore_errors=True)


def connect(developer: Developer, sshd: Sshd) -> None:
    """Connect, anew if necessary."""
    if isinstance(developer.connection, MachineConnection):
        developer.connection.close()
    connection = MachineConnection(
        Machine('arm', 'ssh', ('arm',)),
        environment=sshd.environment(dict(os.environ)),
    )
    connection.connect()
    developer.connection = connection


def sync_endlessly(
    developer: Developer, sshd: Sshd, command: str
) -> list[str]:
    """Begin to send code, until a command runs there; return errors later."""
    errors: list[str] = []

    def sync() -> None:
        try:
            developer.sync('a')
        except UserError as e:
            errors.append(str(e))

    threading.Thread(target=sync, daemon=True).start()
    deadline = time.monotonic() + DEADLINE
    while not any(command in line for line in sshd.left('arm')):
        assert time.monotonic() < deadline, (sshd.left('arm'), errors)
        time.sleep(0.05)
    return errors


def build_endlessly(developer: Developer, sshd: Sshd) -> list[str]:
    """Start a build that does not end, and return where errors come."""
    file = developer.root / 'src/a/CMakeLists.txt'
    file.write_text(file.read_text() + ENDLESS)
    return sync_endlessly(developer, sshd, 'sleep 4001')


def endless_rsync(sshd: Sshd) -> Path:
    """Let rsync on the machine not end; return its path."""
    rsync = sshd['arm'].home / 'bin/rsync'
    rsync.write_text('#!/bin/sh\nexec sleep 4002\n')
    rsync.chmod(0o755)
    sshd['arm'].shell_reads(
        f'PATH={rsync.parent}:{Path(sys.executable).parent}:$PATH'
    )
    return rsync


def wait_for(errors: list[str]) -> str:
    deadline = time.monotonic() + DEADLINE
    while not errors:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return errors[0]


def test_sources_come_by_the_connection(developer: Developer) -> None:
    odd = os.fsencode(developer.root / 'src/a/config') + b'/odd \xff\n name'
    Path(os.fsdecode(odd)).write_bytes(os.urandom(3_000_000))
    assert developer.sync('a') == Synced(4, frozenset({'a'}))
    assert developer.hello('a') == 'hello from a\n'
    assert developer.sync('a') == Synced()


@pytest.mark.hostile
@pytest.mark.parametrize(
    'doomed',
    ['remote.sync.colcon_build', '-I -S -c', 'ssh'],
)
def test_no_build_outlives_who_waits_for_it(
    developer: Developer, sshd: Sshd, doomed: str
) -> None:
    errors = build_endlessly(developer, sshd)
    connection = developer.connection
    assert isinstance(connection, MachineConnection)
    if doomed == 'ssh':
        process = connection._process
        assert process is not None
        os.kill(process.pid, signal.SIGKILL)
    else:
        pids = [
            pid
            for pid, command in sshd.processes('arm').items()
            if doomed in command and 'sh -c' not in command
        ]
        assert pids
        for pid in pids:
            os.kill(pid, signal.SIGKILL)
    assert wait_for(errors).startswith('arm: ')
    connection.close()
    with within(20):
        sshd.wait_until_empty('arm')


@pytest.mark.hostile
@pytest.mark.parametrize('ending', ['close', 'kill ssh', 'kill rsync there'])
def test_no_transfer_outlives_its_connection(
    developer: Developer, sshd: Sshd, ending: str
) -> None:
    rsync = endless_rsync(sshd)
    connect(developer, sshd)
    errors = sync_endlessly(developer, sshd, 'sleep 4002')
    connection = developer.connection
    assert isinstance(connection, MachineConnection)
    if ending == 'kill ssh':
        process = connection._process
        assert process is not None
        os.kill(process.pid, signal.SIGKILL)
    elif ending == 'kill rsync there':
        for pid, command in sshd.processes('arm').items():
            if 'sleep 4002' in command:
                os.kill(pid, signal.SIGKILL)
    else:
        connection.close()
    assert wait_for(errors).startswith('arm: ')
    connection.close()
    with within(20):
        sshd.wait_until_empty('arm')
    assert 'rsync' not in commands_of_children()
    rsync.unlink()


def commands_of_children() -> str:
    """Return the command lines of all that this process has started."""
    return ' '.join(map(command_of, descendants(os.getpid())))


_LAUNCHER = """\
import os, sys
from pathlib import Path
sys.path[:0] = {path!r}
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.deployment.deployment import Machine
from support.developer import Developer
developer = Developer(Path({folder!r}))
developer.add('a', 'src/a', 'cmake')
developer.machine.root = Path({there!r})
developer.connection = MachineConnection(Machine('arm', 'ssh', ('arm',)))
developer.connection.connect()
developer.sync('a')
"""


@pytest.mark.hostile
def test_a_killed_launcher_leaves_no_transfer(
    developer: Developer, sshd: Sshd, tmp_path: Path
) -> None:
    rsync = endless_rsync(sshd)
    program = _LAUNCHER.format(
        path=sys.path,
        folder=str(tmp_path),
        there=str(developer.machine.root),
    )
    temporary = tmp_path / 'temporary'
    temporary.mkdir()
    launcher = subprocess.Popen(
        [sys.executable, '-c', program],
        env=sshd.environment(dict(os.environ) | {'TMPDIR': str(temporary)}),
        start_new_session=True,
    )
    with launcher:
        deadline = time.monotonic() + DEADLINE
        while not any('sleep 4002' in line for line in sshd.left('arm')):
            assert time.monotonic() < deadline and launcher.poll() is None
            time.sleep(0.05)
        doomed = descendants(launcher.pid)
        assert any('rsync_shell' in command_of(pid) for pid in doomed)
        assert list(temporary.iterdir())
        launcher.kill()
    rsync.unlink()
    deadline = time.monotonic() + DEADLINE
    while any(command_of(pid) for pid in doomed):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    assert list(temporary.iterdir()) == []
