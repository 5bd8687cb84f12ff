# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os
import subprocess

from colcon_yamllaunch.common.process_scan import (
    is_alive,
    read_process,
    running_processes,
    variable_of,
)
import pytest


@pytest.fixture
def cat():
    """Return a process that ends with its input."""
    with subprocess.Popen(
        ['cat'],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={'WHO': 'a=b', 'EMPTY': ''},
        start_new_session=True,
    ) as process:
        # Popen returns just before the kernel has put the environment there
        process.stdin.write(b'\n')
        process.stdin.flush()
        process.stdout.readline()
        yield process


def test_a_process_is_read(cat):
    process = read_process(cat.pid)
    assert (process.pid, process.parent) == (cat.pid, os.getpid())
    assert (process.group, process.session) == (cat.pid, cat.pid)
    assert process.pages > 0
    assert process.pid in {p.pid for p in running_processes()}


def test_a_variable_is_read(cat):
    assert variable_of(cat.pid, 'WHO') == 'a=b'
    assert variable_of(cat.pid, 'EMPTY') == ''
    assert variable_of(cat.pid, 'HO') is None


def test_a_process_that_ended_is_not_alive(cat):
    birth = read_process(cat.pid).birth
    assert is_alive(cat.pid, birth)
    assert not is_alive(cat.pid, birth + 1)
    cat.stdin.close()
    os.waitid(os.P_PID, cat.pid, os.WEXITED | os.WNOWAIT)
    # it is a zombie now
    assert read_process(cat.pid) is None
    assert not is_alive(cat.pid, birth)
    cat.wait()
    assert variable_of(cat.pid, 'WHO') is None
