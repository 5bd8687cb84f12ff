# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

import os
import subprocess

from colcon_yamllaunch.workspace.building.build_processes import (
    BUILD_ID_VARIABLE,
    BuildProcesses,
    end_orphans,
    mark,
)
import pytest


@pytest.fixture
def start():
    """Return a function that starts a process of a build."""
    started = []

    def run(variables, script='echo; exec sleep 99'):
        environment = {'PATH': os.environ['PATH'], **variables}
        process = subprocess.Popen(
            ['sh', '-c', script], stdout=subprocess.PIPE, env=environment
        )
        started.append(process)
        process.stdout.readline()
        return process

    yield run
    for process in started:
        process.kill()
        process.communicate()


def test_orphans_are_those_of_the_build_folder(start, tmp_path):
    orphan = start({BUILD_ID_VARIABLE: f'1:{tmp_path}/build'})
    start({BUILD_ID_VARIABLE: f'1:{tmp_path}/other'})
    assert [o.pid for o in BuildProcesses(tmp_path / 'build').search()] == [
        orphan.pid
    ]
    said = []
    end_orphans(tmp_path / 'build', said.append)
    assert orphan.wait() == -15
    assert said == [
        f'ending what is left of a build that was killed: process {orphan.pid}'
    ]


def test_nothing_is_said_where_there_is_no_orphan(tmp_path):
    end_orphans(tmp_path / 'build', pytest.fail)


def test_own_processes_are_ended_whatever_they_build(start, tmp_path):
    one, two = start(mark(tmp_path / 'a')), start(mark(tmp_path / 'b'))
    other = start({BUILD_ID_VARIABLE: f'1:{tmp_path}/a'})
    assert {o.pid for o in BuildProcesses().search()} == {one.pid, two.pid}
    BuildProcesses().end()
    assert (one.wait(), two.wait()) == (-15, -15)
    assert other.poll() is None


@pytest.mark.hostile
def test_a_child_of_a_build_tool_is_ended_with_it(start, tmp_path):
    script = "env -i setsid sh -c 'echo $$; exec sleep 99' & wait"
    tool = start(mark(tmp_path), script)
    assert len(BuildProcesses().search()) == 2
    BuildProcesses().end()
    assert tool.wait() == -15
    assert BuildProcesses().search() == []
    # its output ends with its child
    assert tool.stdout.read() == b''
