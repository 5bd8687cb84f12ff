# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os
import subprocess

from colcon_yamllaunch.common import process_scan
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
    process = process_scan.read_process(cat.pid)
    assert (process.pid, process.parent) == (cat.pid, os.getpid())
    assert (process.group, process.session) == (cat.pid, cat.pid)
    assert process.pages > 0
    assert process.pid in {p.pid for p in process_scan.running_processes()}


def test_a_variable_is_read(cat):
    assert process_scan.variable_of(cat.pid, 'WHO') == 'a=b'
    assert process_scan.variable_of(cat.pid, 'EMPTY') == ''
    assert process_scan.variable_of(cat.pid, 'HO') is None


def test_a_process_that_ended_is_not_alive(cat):
    birth = process_scan.read_process(cat.pid).birth
    assert process_scan.is_alive(cat.pid, birth)
    assert not process_scan.is_alive(cat.pid, birth + 1)
    cat.stdin.close()
    os.waitid(os.P_PID, cat.pid, os.WEXITED | os.WNOWAIT)
    # it is a zombie now
    assert process_scan.read_process(cat.pid) is None
    assert not process_scan.is_alive(cat.pid, birth)
    cat.wait()
    assert process_scan.variable_of(cat.pid, 'WHO') is None
