# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Control groups: real ones where they can be made, else folders like them."""

from contextlib import suppress
import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import colcon_yamllaunch
from colcon_yamllaunch.common.escalation import Escalation, Timeouts
from colcon_yamllaunch.common.process_scan import cgroup_of
from colcon_yamllaunch.control.resource_usage import usage_of
from colcon_yamllaunch.engine import cgroup
from colcon_yamllaunch.engine.cgroup import LaunchCgroup
from colcon_yamllaunch.engine.guard import GuardedLaunch
from colcon_yamllaunch.engine.launch_scan import find_orphans, new_identity
import pytest
from support.hostile import (
    needs_control_group,
    needs_other_user,
    OTHER_USER,
    with_mounts,
)

pytestmark = pytest.mark.hostile
ROOT = Path(colcon_yamllaunch.__file__).parents[1]
#: A shell that lets a process go which nothing but its control group knows.
LOSES_A_CHILD = (
    '(env -i setsid sh -c "trap \'\' INT; echo child \\$\\$; sleep 99" &)\n'
    'exec sleep 99'
)


@pytest.fixture
def made():
    """Return a function that returns the group of a new launch."""
    groups = []

    def make(identity=None):
        groups.append(LaunchCgroup(identity or new_identity()))
        return groups[-1]

    yield make
    for group in groups:
        group.remove()


@pytest.fixture
def fake(tmp_path):
    """Return a folder that looks like a control group, and a launch in it."""
    (tmp_path / 'cgroup.procs').write_text('1\n')
    group = LaunchCgroup(new_identity())
    group._home = str(tmp_path)
    return tmp_path, group


def folders_of(path):
    """Return the folders of launches that a control group has."""
    return {p for p in path.iterdir() if p.name.startswith('colcon_launch-')}


def child_of(one):
    """Return the process that `LOSES_A_CHILD` lost."""
    return int(one.shows('child ').screen.partition('child ')[2].split()[0])


@needs_control_group
def test_what_is_started_is_born_in_the_group_of_its_process(made):
    identity = new_identity()
    group = made(identity)
    home = cgroup_of('self')
    with group.entered(3):
        process = subprocess.Popen(['sleep', '99'], start_new_session=True)
    assert cgroup_of('self') == home
    assert cgroup.number_of(process.pid, identity) == 3
    assert cgroup.number_of(process.pid, new_identity()) is None
    assert [o.number for o in find_orphans(identity, -1, {})] == [3]
    folder = cgroup.process_folder(process.pid)
    assert cgroup.members(folder) == {process.pid}
    group.kill(2)
    assert process.poll() is None
    group.kill(3)
    assert process.wait() == -signal.SIGKILL
    group.remove()
    assert not Path(folder).parent.exists()


@needs_control_group
def test_the_move_that_makes_ready_does_not_take_a_process_back(
    made, monkeypatch
):
    group, move = made(), cgroup._move_to

    def move_late(folder):
        # the thread is slow, and the launch fast
        if threading.current_thread() is not threading.main_thread():
            time.sleep(0.2)
        move(folder)

    monkeypatch.setattr(cgroup, '_early_move', None)
    monkeypatch.setattr(cgroup, '_move_to', move_late)
    cgroup.make_ready()
    with group.entered(0):
        time.sleep(0.3)
        assert cgroup_of('self').endswith(f'{group._name}/0')


@needs_control_group
def test_who_expects_moves_stays_where_he_is():
    home = cgroup_of('self')
    program = (
        'import threading, time\n'
        'from colcon_yamllaunch.common.process_scan import cgroup_of\n'
        'from colcon_yamllaunch.engine import cgroup\n'
        'move, moves = cgroup._move_to, []\n'
        'def moved(folder):\n'
        '    move(folder)\n'
        '    moves.append(cgroup_of("self"))\n'
        'cgroup._move_to = moved\n'
        'threading.Thread(target=cgroup.expect_moves, daemon=True).start()\n'
        'while len(moves) < 3: time.sleep(0.01)\n'
        'print(*moves[:3])'
    )
    command = [sys.executable, '-c', program]
    told = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert told.stdout.split() == [home] * 3, told.stderr


def test_moves_are_expected_for_a_moment(monkeypatch):
    moves = []
    monkeypatch.setattr(cgroup, '_VAIN_MOVES', 3)
    monkeypatch.setattr(cgroup, 'cgroup_of', lambda pid: '/group')
    monkeypatch.setattr(cgroup, '_mounted', lambda path: '/group')
    monkeypatch.setattr(cgroup, '_move_to', moves.append)
    cgroup.expect_moves()
    assert moves == ['/group'] * 3


def test_where_there_are_no_moves_none_are_expected(monkeypatch):
    monkeypatch.setattr(cgroup, 'cgroup_of', lambda pid: None)
    cgroup.expect_moves()


@needs_control_group
def test_two_launches_have_groups_of_their_own(made):
    one, other = made(), made()
    with one.entered(0), other.entered(0):
        # it is the launcher that was moved, by somebody else
        assert cgroup_of('self').endswith(f'{one._name}/0/{other._name}/0')
    with one.entered(0):
        pass
    other.remove()
    assert Path(one._folder, '0').exists()


@needs_control_group
def test_a_group_that_was_taken_for_a_stale_one_is_made_again(
    made, monkeypatch
):
    group = made()

    def lock_too_late(folder, lock=cgroup._lock):
        # another launch may have left a group, too
        if folder == group._folder:
            monkeypatch.undo()
            while Path(folder).exists():
                cgroup._remove_stale(group._home)
        return lock(folder)

    monkeypatch.setattr(cgroup, '_lock', lock_too_late)
    with group.entered(0):
        assert cgroup_of('self').endswith(f'{group._name}/0')
    cgroup._remove_stale(group._home)
    assert Path(group._folder).exists()


@needs_control_group
def test_a_launcher_that_was_moved_stays_where_it_is(made):
    group = made()
    with group.entered(0):
        home = group._home
    elsewhere = Path(home, f'test-{new_identity()}')
    elsewhere.mkdir()
    (elsewhere / 'cgroup.procs').write_text('0')
    try:
        with group.entered(1):
            assert cgroup_of('self').endswith(elsewhere.name)
    finally:
        Path(home, 'cgroup.procs').write_text('0')
        elsewhere.rmdir()


@needs_control_group
def test_what_cannot_get_out_again_does_not_kill_itself(made):
    group = made()
    with group.entered(0):
        group._home = '/nonexistent'
    try:
        assert cgroup_of('self').endswith(group._name)
        group.kill(0)
        group.remove()
        assert Path(group._folder).exists()
    finally:
        del group._home
        Path(group._folder).with_name('cgroup.procs').write_text('0')


@pytest.mark.full
@needs_control_group
@needs_other_user
@pytest.mark.parametrize('namespace', [(), ('unshare', '--cgroup')])
def test_the_group_is_found_as_a_container_has_it(made, tmp_path, namespace):
    point = tmp_path / 'a b'
    point.mkdir()
    # so that the one of the machine is hidden
    hide = (
        'grep " - cgroup2 " /proc/self/mountinfo | cut -d" " -f5 |'
        'while read x; do umount -l "$x"; done'
    )
    mount = f'mount -t cgroup2 none "{point}"; exec "$0" "$@"'
    identity = new_identity()
    script = (
        'from colcon_yamllaunch.engine.cgroup import LaunchCgroup\n'
        f'group = LaunchCgroup("{identity}")\n'
        'with group.entered(0):\n'
        '    print(group._folder)\n'
        'group.remove()\n'
    )
    argv = [*namespace, 'sh', '-ec', mount, sys.executable, '-S', '-c', script]
    outside = made()
    with outside.entered(0):
        inside = '' if namespace else cgroup_of('self')
        found = subprocess.run(
            with_mounts(hide, argv),
            env={**os.environ, 'PYTHONPATH': str(ROOT)},
            capture_output=True,
            check=False,
            text=True,
        )
    folder = f'{point}{inside}/colcon_launch-{identity}\n'
    assert found.stdout == folder, found.stderr


def test_where_no_folder_can_be_made_all_goes_on(fake):
    folder, group = fake
    # a file in its way
    (folder / group._name).touch()
    with group.entered(0):
        assert not (folder / group._name).is_dir()
    group.kill(0)


def test_none_is_made_that_is_not_wanted(launch, sleep, wait_until):
    one = launch(sleep('a'), environment={'COLCON_LAUNCH_CGROUP': '0'})
    (pid,) = wait_until(one.shows('started').processes)
    assert cgroup.process_folder(pid) is None
    assert one.sends(signal.SIGTERM).ends() == 0


def test_no_share_of_the_machine_is_changed(fake):
    folder, group = fake
    (folder / 'cgroup.subtree_control').write_text('cpu memory pids\n')
    with group.entered(0):
        assert folders_of(folder) == set()


def test_nobody_hears_of_it_where_there_are_no_control_groups(monkeypatch):
    monkeypatch.setattr(cgroup, 'cgroup_of', lambda pid: None)
    group = LaunchCgroup(new_identity())
    with group.entered(0):
        group.kill(0)
    group.remove()
    assert cgroup.number_of(os.getpid(), new_identity()) is None
    assert cgroup.process_folder(os.getpid()) is None


def test_launches_may_be_nested(monkeypatch):
    outer, inner = new_identity(), new_identity()
    path = f'/x/colcon_launch-{outer}/3/colcon_launch-{inner}/12/more'
    monkeypatch.setattr(cgroup, 'cgroup_of', lambda pid: path)
    monkeypatch.setattr(cgroup, '_mounted', lambda path: path)
    assert cgroup.number_of(1, outer) == 3
    assert cgroup.number_of(1, inner) == 12
    assert cgroup.process_folder(1) == path.removesuffix('/more')


def test_figures_of_a_group(tmp_path):
    assert cgroup.processor_time(str(tmp_path)) is None
    assert cgroup.memory(str(tmp_path)) is None
    (tmp_path / 'cpu.stat').write_text('usage_usec 1500000\nuser_usec 7\n')
    (tmp_path / 'memory.current').write_text('5000\n')
    assert cgroup.processor_time(str(tmp_path)) == 1.5
    assert cgroup.memory(str(tmp_path)) == 5000
    (tmp_path / 'memory.stat').write_text('anon 1\ninactive_file 1000\n')
    assert cgroup.memory(str(tmp_path)) == 4000


@needs_control_group
def test_who_cleared_its_environment_and_lost_its_parent_is_stopped(
    launch, sh, is_running
):
    one = launch(sh('a', LOSES_A_CHILD, sigterm_timeout=0.1))
    child = child_of(one)
    folder = Path(cgroup.process_folder(child)).parent
    assert one.sends(signal.SIGINT).ends() == 0
    assert not is_running(child)
    assert not folder.exists()
    assert child in {e['pid'] for e in one.events('signalled')}


@pytest.mark.full
@needs_control_group
def test_the_guard_stops_it_too_and_removes_the_group(
    launch, sh, is_running, wait_until
):
    one = launch(sh('a', LOSES_A_CHILD, sigterm_timeout=0.1))
    child = child_of(one)
    folder = Path(cgroup.process_folder(child)).parent
    one.sends(signal.SIGKILL).popen.wait()
    wait_until(lambda: not folder.exists())
    assert not is_running(child)


@pytest.mark.full
@needs_control_group
def test_who_is_born_faster_than_found_is_killed_by_the_group(
    launch, python, tmp_path
):
    fifo = tmp_path / 'fifo'
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    script = (
        'import os, signal, time\n'
        'signal.signal(signal.SIGINT, signal.SIG_IGN)\n'
        'signal.signal(signal.SIGTERM, signal.SIG_IGN)\n'
        f'os.open("{fifo}", os.O_WRONLY)\n'
        'print("ready", flush=True)\n'
        # those that it starts know nothing of it
        'if os.fork():\n'
        '    time.sleep(99)\n'
        'while True:\n'
        '    if os.fork():\n'
        '        os._exit(0)\n'
        '    os.setsid()\n'
        '    time.sleep(0.001)\n'
    )
    one = launch(
        python('a', script, sigterm_timeout=0.1, sigkill_timeout=0.1)
    ).shows('ready')
    one.sends(signal.SIGINT).ends()
    # nobody has the other end any more
    assert os.read(reader, 1) == b''
    os.close(reader)


@pytest.mark.full
@needs_control_group
def test_an_empty_group_of_a_killed_launch_goes_with_the_next(
    launch, sh, sleep, wait_until
):
    one = launch(sh('a', LOSES_A_CHILD))
    other = launch(sleep('b')).shows('started')
    folder = Path(cgroup.process_folder(child_of(one))).parent
    (theirs,) = wait_until(other.processes)
    used = cgroup.process_folder(theirs)
    (guard,) = wait_until(one.guards)
    os.kill(guard, signal.SIGSTOP)
    one.sends(signal.SIGKILL).popen.wait()
    os.kill(guard, signal.SIGKILL)
    # it is stale only when nothing runs in it
    assert launch(sh('c', 'true')).ends() == 0
    assert folder.exists()
    (folder / 'cgroup.kill').write_text('1')
    wait_until(lambda: not cgroup.members(str(folder)))
    assert launch(sh('c', 'true')).ends() == 0
    assert not folder.exists()
    assert Path(used).exists()


@pytest.fixture
def delegated(made):
    """Return a control group that is delegated to another user."""
    group = made()
    with group.entered(0):
        folder = Path(group._home, f'test-{new_identity()}')
    folder.mkdir()
    # see "Delegation" in the documentation of cgroup v2
    for name in ('', 'cgroup.procs', 'cgroup.threads'):
        os.chown(folder / name, OTHER_USER, OTHER_USER)
    yield folder
    (folder / 'cgroup.kill').write_text('1')
    cgroup._remove(str(folder))


@pytest.fixture
def sudo():
    """Return a copy of setpriv(1) that stands for sudo."""
    program = shutil.which('setpriv')
    if program is None:
        pytest.skip('there is no setpriv')
    # each user may go there
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)
        copy = Path(name, 'sudo')
        shutil.copy(program, copy)
        copy.chmod(0o4755)
        yield str(copy)


@needs_control_group
@needs_other_user
def test_a_user_can_kill_what_root_runs_in_his_group(delegated, sudo):
    """Without it, a process of root may not even be sent SIGKILL."""
    pid = os.fork()
    if pid == 0:
        with suppress(BaseException):
            os._exit(stop_as_other_user(delegated, sudo))
        os._exit(100)
    assert os.waitpid(pid, 0)[1] == 0
    assert [p for p in delegated.iterdir() if p.is_dir()] == []


def stop_as_other_user(home, sudo):
    (home / 'cgroup.procs').write_text('0')
    os.setgroups([])
    os.setgid(OTHER_USER)
    os.setuid(OTHER_USER)
    launch = GuardedLaunch(new_identity(), -1)
    launch.timeouts[0] = Timeouts(0.1, 0.1)
    with launch.cgroup.entered(0):
        # without a mark, parent or group that would tell of it
        os.posix_spawn(sudo, ['sudo', '--reuid=0', 'sleep', '99'], {})
    while [o.number for o in launch.search(())] != [0]:
        pass
    Escalation(launch, launch.timeouts, time.monotonic()).run()
    left = launch.search(())
    launch.cgroup.remove()
    return len(left)


@pytest.mark.full
@needs_control_group
def test_status_counts_all_of_the_group(launch, sh):
    busy = LOSES_A_CHILD.replace('sleep 99"', 'while :; do :; done"')
    one = launch(sh('a', busy))
    child = child_of(one)
    (leader,) = one.processes()
    found = usage_of({leader})[leader]
    assert found.cpu > 0
    # either alone has about half of it, and the kernel counts it roughly
    assert found.memory > 0.75 * (resident(child) + resident(leader))


def resident(pid):
    status = Path(f'/proc/{pid}/status').read_text()
    (line,) = (x for x in status.splitlines() if x.startswith('VmRSS:'))
    return 1024 * int(line.split()[1])
