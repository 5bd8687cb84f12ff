# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One build at a time."""

from contextlib import contextmanager
import fcntl
import os
import signal
import subprocess
import sys
import threading
import time

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.process_scan import is_suspended
from colcon_yamllaunch.workspace.building.build_lock import (
    is_locked,
    LOCK_NAME,
    WorkspaceLock,
)
import pytest
from support.file_clock import let_files_settle

HOLDER = """\
import sys
from pathlib import Path
from colcon_yamllaunch.workspace.building.build_lock import WorkspaceLock
with WorkspaceLock('colcon launch x') as lock:
    lock.acquire(Path(sys.argv[1]), print)
    lock.publish_build(['flow', 'my_pkg'])
    print('held', flush=True)
    sys.stdin.read()
"""


@contextmanager
def build_lock(build, announce, title=''):
    """Hold the lock."""
    with WorkspaceLock(title) as lock:
        lock.acquire(build, announce)
        yield lock


@pytest.fixture
def holder(tmp_path, workspace):
    """Another process that holds the lock."""
    with subprocess.Popen(
        [sys.executable, '-c', HOLDER, str(tmp_path / 'build')],
        env=workspace.environment(),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout.readline() == 'held\n'
        yield process
        process.kill()


def test_free_lock_says_nothing(tmp_path):
    said = []
    for _ in range(2):
        with build_lock(tmp_path / 'build', said.append):
            pass
    assert said == []


def test_waits_for_another_process(tmp_path, holder):
    said = []

    def announce(text):
        said.append(text)
        holder.stdin.close()

    with build_lock(tmp_path / 'build', announce):
        what = f"'colcon launch x' (process {holder.pid})"
        assert said == [f'waiting for {what}, which builds flow, my_pkg…']


def test_waits_for_the_name_of_one_that_has_just_begun(tmp_path):
    build = tmp_path / 'build'
    build.mkdir()
    said = []

    def announce(text):
        said.append(text)
        os.close(descriptor)

    def acquire():
        with build_lock(build, announce):
            pass

    descriptor = os.open(build / LOCK_NAME, os.O_RDWR | os.O_CREAT)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    thread = threading.Thread(target=acquire)
    thread.start()
    os.write(descriptor, b'4194305\tcolcon launch x\tbuilds flow')
    time.sleep(0.05)
    assert said == []
    os.write(descriptor, b', my_pkg\n')
    thread.join()
    what = "'colcon launch x' (process 4194305)"
    assert said == [f'waiting for {what}, which builds flow, my_pkg…']


def test_lock_ends_with_its_process(tmp_path, holder):
    def announce(text):
        os.kill(holder.pid, signal.SIGKILL)

    with build_lock(tmp_path / 'build', announce):
        assert holder.wait() == -signal.SIGKILL


def test_threads_exclude_each_other(tmp_path):
    inside = []

    def work():
        with build_lock(tmp_path / 'build', lambda text: None):
            inside.append(len(inside))
            assert len(inside) == 1
            inside.pop()

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert inside == []


def test_build_folder_that_is_a_file(tmp_path):
    (tmp_path / 'build').touch()
    lock = build_lock(tmp_path / 'build', print)
    with pytest.raises(WorkspaceError, match='--no-build'), lock:
        pass


CHILD = """\
import sys
from pathlib import Path
from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.building.build_lock import WorkspaceLock
try:
    with WorkspaceLock() as lock:
        lock.acquire(Path(sys.argv[1]), print)
        print('taken')
except WorkspaceError as e:
    print(e)
"""


@pytest.mark.hostile
def test_what_the_holder_calls_does_not_wait(tmp_path, workspace):
    build = tmp_path / 'build'

    def call():
        words = ['sh', '-c', '"$@"; true', 'sh', sys.executable, '-c', CHILD]
        done = subprocess.run(
            [*words, build],
            env=workspace.environment(),
            capture_output=True,
            text=True,
            timeout=60,
        )
        return done.stdout

    with build_lock(build, print, 'colcon launch x') as lock:
        assert call() == 'taken\n'
        lock.publish_build(['flow'])
        said = call()
        assert said.startswith(f"'colcon launch x' (process {os.getpid()})")
        assert 'builds flow in this workspace' in said
        assert '--no-build' in said
    assert call() == 'taken\n'


@pytest.mark.hostile
def test_a_suspended_holder_is_told(tmp_path, holder):
    said = []

    def announce(text):
        said.append(text)
        os.kill(holder.pid, signal.SIGKILL)

    os.kill(holder.pid, signal.SIGSTOP)
    while not is_suspended(holder.pid):
        time.sleep(0.01)
    with build_lock(tmp_path / 'build', announce):
        pass
    assert f"is suspended: 'kill -CONT {holder.pid}' goes on" in said[0]


@pytest.mark.hostile
def test_nothing_that_another_one_wrote_acts_on_the_terminal(tmp_path):
    build = tmp_path / 'build'
    with build_lock(build, print, 'colcon launch \x1b[31m\n') as lock:
        lock.publish_build(['\x1b]0;x\a', 'a\tb'])
        text = (build / LOCK_NAME).read_text()
    line, end, rest = text.partition('\n')
    assert (end, rest) == ('\n', '')
    assert line.replace('\t', '').isprintable()
    assert line.count('\t') == 2


@pytest.mark.hostile
def test_a_launch_keeps_the_lock_until_it_lets_it_go(tmp_path):
    build = tmp_path / 'build'
    with WorkspaceLock('colcon launch x') as lock:
        lock.look(build)
        assert not lock.acquire(build, print)
        assert not lock.acquire(build, print)
        assert is_locked(build)
        lock.release()
        assert not is_locked(build)
        assert (build / LOCK_NAME).read_text() == ''


@pytest.mark.hostile
def test_who_has_read_before_another_one_built_reads_again(tmp_path):
    build = tmp_path / 'build'
    with WorkspaceLock() as first, WorkspaceLock() as second:
        first.look(build)
        second.acquire(build, print)
        let_files_settle(tmp_path)
        second.release()
        assert first.acquire(build, print)


@pytest.mark.hostile
def test_a_program_does_not_inherit_the_lock(tmp_path):
    build = tmp_path / 'build'
    with WorkspaceLock() as lock:
        lock.acquire(build, print)
        with subprocess.Popen(['sleep', '600']) as process:
            lock.release()
            assert not is_locked(build)
            process.kill()
