# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from colcon_yamllaunch.runtime.stopping.launch_scan import find_orphans
from colcon_yamllaunch.runtime.stopping.launch_scan import LAUNCH_ID_VARIABLE
from colcon_yamllaunch.runtime.stopping.launch_scan import new_identity
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
    process = start(
        {LAUNCH_ID_VARIABLE: f'{identity}.7'}, start_new_session=True
    )
    start({LAUNCH_ID_VARIABLE: f'{new_identity()}.7'})
    found = find_orphans(identity, NO_SESSION, {})
    assert [(m.pid, m.number) for m in found] == [(process.pid, 7)]


def test_a_process_is_found_by_its_group_in_our_session_only(start):
    process = start({}, start_new_session=True)
    groups = {process.pid: 3}
    identity = new_identity()
    found = find_orphans(identity, process.pid, groups)
    assert [(m.pid, m.number) for m in found] == [(process.pid, 3)]
    assert find_orphans(identity, os.getpid(), groups) == []


def test_a_child_without_the_mark_is_found_by_its_parent(start):
    identity = new_identity()
    process = start(
        {LAUNCH_ID_VARIABLE: f'{identity}.2'},
        "env -i sh -c 'echo $$; exec sleep 99' & read x; kill $!",
    )
    child = int(process.stdout.readline())
    found = {m.pid: m.number for m in find_orphans(identity, NO_SESSION, {})}
    assert found == {process.pid: 2, child: 2}


def test_a_group_whose_leader_runs_is_left_out_but_not_who_left_it(start):
    identity = new_identity()
    process = start(
        {LAUNCH_ID_VARIABLE: f'{identity}.2'},
        "setsid sh -c 'echo $$; exec sleep 99' & read x; kill $!",
        start_new_session=True,
    )
    child = int(process.stdout.readline())
    groups = {process.pid: 2}
    found = find_orphans(identity, process.pid, groups, groups)
    assert [(m.pid, m.number) for m in found] == [(child, 2)]
    os.kill(child, signal.SIGKILL)


def test_a_process_may_have_any_name(start, tmp_path):
    identity = new_identity()
    link = tmp_path / ') Z 1 (x'
    link.symlink_to(sys.executable)
    process = start(
        {LAUNCH_ID_VARIABLE: f'{identity}.0'}, f"exec '{link}' -S -c 'input()'"
    )
    found = find_orphans(identity, NO_SESSION, {})
    assert [m.pid for m in found] == [process.pid]
    process.communicate(b'\n')
