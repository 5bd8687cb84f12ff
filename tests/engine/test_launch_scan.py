# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os
from pathlib import Path
import signal
import subprocess
import sys

from colcon_yamllaunch.common.escalation import WHOLE
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.engine.channels import writer_link
from colcon_yamllaunch.engine.launch_scan import (
    Adopter,
    find_orphans,
    LAUNCH_ID_VARIABLE,
    launcher_of,
    new_identity,
)
import pytest
from support.waiting import wait_until

NO_SESSION = -1


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
        wait_until(Path(f'/proc/{process.pid}/environ').read_bytes)
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


def test_who_looks_is_no_orphan_although_its_parent_is_one(start):
    identity = new_identity()
    program = (
        'import os; from colcon_yamllaunch.engine.launch_scan import *; '
        f'found = {{o.pid for o in find_orphans({identity!r}, -1, {{}})}}; '
        'print(os.getppid() in found, os.getpid() in found)'
    )
    script = f'env -i "{sys.executable}" -c "$PROGRAM"; read x'
    process = start(
        {LAUNCH_ID_VARIABLE: f'{identity}.7', 'PROGRAM': program}, script
    )
    assert process.stdout.readline().split() == [b'True', b'False']


def test_who_is_older_than_the_launcher_is_none_of_the_launch(start):
    identity = new_identity()
    process = start({LAUNCH_ID_VARIABLE: f'{identity}.7'})
    birth = read_process(process.pid).birth
    elders = set()
    for _ in range(2):
        found = find_orphans(
            identity, NO_SESSION, {}, since=birth, elders=elders
        )
        assert [m.pid for m in found] == [process.pid]
        assert ('1', os.stat('/proc/1').st_ino) in elders
    assert not find_orphans(identity, NO_SESSION, {}, since=birth + 1)


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


def test_a_process_is_known_again_without_any_trace(start):
    process = start({}, start_new_session=True)
    identity = new_identity()
    assert find_orphans(identity, NO_SESSION, {}) == []
    adopter = Adopter(os.getpid(), {}, ())
    known = {}
    found = find_orphans(
        identity, NO_SESSION, {}, known=known, adopter=adopter
    )
    assert (process.pid, WHOLE) in [(o.pid, o.number) for o in found]
    key = next(key for key in known if key[0] == process.pid)
    known = {key: 5}
    (again,) = find_orphans(identity, NO_SESSION, {}, known=known)
    assert ((again.pid, again.birth), again.number) == (key, 5)
    # its id alone is not enough
    known = {(key[0], key[1] + 1): 5}
    assert find_orphans(identity, NO_SESSION, {}, known=known) == []


def test_an_adopted_process_comes_from_whose_output_it_writes_to(start):
    process, other = start({}), start({})
    link = writer_link(process.stdout.fileno())
    terminal, slave = os.openpty()
    assert writer_link(terminal) == os.ttyname(slave)
    os.close(terminal)
    os.close(slave)
    identity = new_identity()

    def found(others):
        adopter = Adopter(os.getpid(), {link: 4}, others)
        orphans = find_orphans(identity, NO_SESSION, {}, adopter=adopter)
        return {o.pid: o.number for o in orphans}

    # where any child may be somebody else's, only an output tells
    assert found(None) == {process.pid: 4}
    assert found({process.pid})[other.pid] == WHOLE
    assert process.pid not in found({process.pid})


def test_an_identity_tells_whether_the_launcher_runs(start):
    process = start({})
    identity = new_identity()
    assert launcher_of(identity) == (os.getpid(), True)
    of_another = f'{int(identity, 16) ^ 1 << 20:016x}'
    assert launcher_of(of_another) == (os.getpid(), False)
    of_another = f'{process.pid << 42:016x}'
    assert launcher_of(of_another) == (process.pid, False)
    assert launcher_of('something older') is None
