# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One build at a time."""

import os
import signal
import subprocess
import sys
import threading

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.building.build_lock import build_lock
from colcon_yamllaunch.workspace.building.build_lock import WAITING
import pytest

HOLDER = """\
import sys
from pathlib import Path
from colcon_yamllaunch.workspace.building.build_lock import build_lock
with build_lock(Path(sys.argv[1]), print) as lock:
    lock.tell('builds flow, my_pkg')
    print('held', flush=True)
    sys.stdin.read()
"""


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
        what = f'process {holder.pid} builds flow, my_pkg'
        assert said == [f'{WAITING}: {what}…']


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
