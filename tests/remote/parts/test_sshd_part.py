# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The machines that tests reach by ssh are what they say they are."""

import os
import subprocess
import time

import pytest
from support.sshd import (
    ASKING,
    IMPOSTOR,
    LOCKED,
    MACHINES,
    OFF,
    Sshd,
    STRANGER,
)

#: Seconds that a held link is looked at.
LOOKED_AT = 0.5


@pytest.mark.parametrize('name', MACHINES)
def test_each_machine_has_a_home(sshd: Sshd, name: str) -> None:
    done = sshd.ssh(name, 'cd ~ && pwd')
    assert (done.stdout, done.stderr) == (f'{sshd[name].home}\n', '')


@pytest.mark.parametrize(
    'name, message',
    [
        (STRANGER, 'Host key verification failed'),
        (IMPOSTOR, 'REMOTE HOST IDENTIFICATION HAS CHANGED'),
        (LOCKED, 'Permission denied'),
        (ASKING, 'Permission denied'),
        (OFF, 'Connection refused'),
    ],
)
def test_a_machine_refuses(sshd: Sshd, name: str, message: str) -> None:
    done = sshd.ssh(name, 'true')
    assert done.returncode == 255
    assert message in done.stderr


def test_only_what_runs_there_is_found(sshd: Sshd) -> None:
    assert sshd.left() == []
    sshd.ssh('arm', 'setsid sleep 1000 >/dev/null 2>&1 &')
    # the shell may just be about to become it
    while sshd.left() != ['sleep 1000']:
        time.sleep(0.01)
    sshd.switch_off()
    assert sshd.left() == []
    sshd.start()
    assert sshd.ssh('arm', 'true').returncode == 0


def test_a_machine_may_lack_programs(sshd: Sshd) -> None:
    sshd['arm'].lacks_all_but('ls')
    assert sshd.ssh('arm', 'ls').returncode == 0
    assert sshd.ssh('arm', 'python3 --version').returncode == 127
    assert sshd.ssh('gpu', 'python3 --version').returncode == 0


def _cat(sshd: Sshd, name: str) -> 'subprocess.Popen[bytes]':
    return subprocess.Popen(
        ['ssh', name, 'cat'],
        env=sshd.environment(dict(os.environ)),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        bufsize=0,
    )


def _echo(cat: 'subprocess.Popen[bytes]', data: bytes) -> float:
    """Return the seconds until data is back."""
    assert cat.stdin is not None
    assert cat.stdout is not None
    begin = time.monotonic()
    cat.stdin.write(data)
    got = b''
    while len(got) < len(data):
        piece = cat.stdout.read(len(data))
        assert piece
        got += piece
    assert got == data
    return time.monotonic() - begin


def test_a_link_can_be_held_and_broken(sshd: Sshd) -> None:
    link = sshd['arm'].link
    with _cat(sshd, 'arm') as cat, _cat(sshd, 'gpu') as other:
        _echo(cat, b'one\n')
        link.hold()
        assert cat.stdin is not None
        cat.stdin.write(b'two\n')
        before = (link.there, link.back)
        _echo(other, b'not held\n')
        time.sleep(LOOKED_AT)
        assert (link.there, link.back) == before
        link.release()
        assert cat.stdout is not None
        assert cat.stdout.read(10) == b'two\n'
        link.break_off()
        assert cat.wait() == 255
        assert other.poll() is None
        other.kill()
    sshd.wait_until_empty()


def test_a_link_can_be_slow(sshd: Sshd) -> None:
    with _cat(sshd, 'arm') as cat:
        _echo(cat, b'one\n')
        sshd['arm'].link.delay = 0.2
        assert _echo(cat, b'two\n') >= 0.4
        sshd['arm'].link.delay = 0.0
        sshd['arm'].link.bytes_per_second = 50_000
        assert _echo(cat, os.urandom(25_000)) >= 0.5
        cat.kill()
