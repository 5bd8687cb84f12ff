# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launcher that is killed while it connects leaves no connection."""

from pathlib import Path
import subprocess
import sys
import time

import colcon_yamllaunch
import pytest
from support.marked_processes import kill

ROOT = Path(colcon_yamllaunch.__file__).parents[1]
#: Starts two that end only by a signal, waits for one of them, and for input.
CONNECTS = """\
import os, sys
from colcon_yamllaunch.remote.connection.connect_process import (
    ConnectProcess,
)
one, other = (
    ConnectProcess(['sleep', '1000'], os.environ, kept=True) for _ in 'ab'
)
if 'first' in sys.argv:
    one.close(0)
if 'all' in sys.argv:
    other.close(0)
print(one.pid, other.pid, flush=True)
input()
"""

#: Is killed as soon as the process that connects runs.
IS_KILLED = """\
import os, signal
from colcon_yamllaunch.remote.connection.connect_process import (
    ConnectProcess,
)
def spawn(path, argv, *arguments, **more):
    pid = start(path, argv, *arguments, **more)
    if '1000' in argv:
        print(pid, flush=True)
        os.kill(os.getpid(), signal.SIGKILL)
    return pid
start, os.posix_spawn = os.posix_spawn, spawn
ConnectProcess(['sleep', '1000'], os.environ, kept=True)
"""


def _runs(pid: int) -> bool:
    try:
        return Path(f'/proc/{pid}/stat').read_text().split()[2] not in 'ZX'
    except OSError:
        return False


def _start(code: str, *arguments: str) -> 'subprocess.Popen[bytes]':
    return subprocess.Popen(
        [sys.executable, '-c', code, *arguments],
        env={'PYTHONPATH': str(ROOT), 'PATH': '/usr/bin:/bin'},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )


@pytest.mark.parametrize('ended', [(), ('first',), ('first', 'all')])
def test_killed_launcher_leaves_no_connection(ended: tuple[str, ...]) -> None:
    with _start(CONNECTS, *ended) as connects:
        assert connects.stdout is not None
        pids = [*map(int, connects.stdout.readline().split())]
        assert [_runs(pid) for pid in pids] == [
            'first' not in ended,
            'all' not in ended,
        ]
        connects.kill()
        connects.wait()
        while any(map(_runs, pids)):
            pass


def test_launcher_killed_at_once_leaves_no_connection() -> None:
    with _start(IS_KILLED) as connects:
        pid = int(connects.communicate()[0])
    deadline = time.monotonic() + 60
    try:
        while _runs(pid):
            assert time.monotonic() < deadline
            time.sleep(0.01)
    finally:
        kill([pid])
