# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os
from pathlib import Path
import subprocess
import sys
import time

from colcon_yamllaunch.common.process_scan import find_members
from colcon_yamllaunch.common.process_scan import is_alive
from colcon_yamllaunch.common.process_scan import MARK
from colcon_yamllaunch.common.process_scan import Member
from colcon_yamllaunch.common.process_scan import new_identity
import pytest

NO_SESSION = -1
#: Seconds; a loaded machine needs some.
DEADLINE = 60


@pytest.fixture
def start():
    """Return a function that starts a process; it reads its input."""
    started = []

    def run(environment, script='read x', **more):
        process = subprocess.Popen(
            ['sh', '-c', script],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={'PATH': os.environ['PATH'], **environment},
            **more,
        )
        started.append(process)
        # Popen returns just before the kernel has put the environment there
        deadline = time.monotonic() + DEADLINE
        while not Path(f'/proc/{process.pid}/environ').read_bytes():
            assert time.monotonic() < deadline
        return process

    yield run
    for process in started:
        process.communicate()


def test_a_process_is_found_by_its_mark_wherever_it_went(start):
    identity = new_identity()
    process = start({MARK: f'{identity}.7'}, start_new_session=True)
    start({MARK: f'{new_identity()}.7'})
    found = find_members(identity, {}, NO_SESSION)
    assert [(m.pid, m.number) for m in found] == [(process.pid, 7)]


def test_a_process_is_found_by_its_group_in_our_session_only(start):
    process = start({}, start_new_session=True)
    groups = {process.pid: 3}
    identity = new_identity()
    found = find_members(identity, groups, process.pid)
    assert [(m.pid, m.number) for m in found] == [(process.pid, 3)]
    assert find_members(identity, groups, os.getpid()) == []


def test_a_child_without_the_mark_is_found_by_its_parent(start):
    identity = new_identity()
    process = start(
        {MARK: f'{identity}.2'},
        "env -i sh -c 'echo $$; exec sleep 99' & read x; kill $!",
    )
    child = int(process.stdout.readline())
    found = {m.pid: m.number for m in find_members(identity, {}, NO_SESSION)}
    assert found == {process.pid: 2, child: 2}


def test_a_process_that_ended_is_not_alive(start):
    identity = new_identity()
    process = start({MARK: f'{identity}.0'})
    member = find_members(identity, {}, NO_SESSION)[0]
    assert is_alive(member)
    reused = Member(member.pid, member.birth + 1, member.group, 0)
    assert not is_alive(reused)
    process.communicate()
    assert not is_alive(member)


def test_a_process_may_have_any_name(start, tmp_path):
    identity = new_identity()
    link = tmp_path / ') Z 1 (x'
    link.symlink_to(sys.executable)
    process = start({MARK: f'{identity}.0'}, f"exec '{link}' -S -c 'input()'")
    found = find_members(identity, {}, NO_SESSION)
    assert [m.pid for m in found] == [process.pid]
    process.communicate(b'\n')
