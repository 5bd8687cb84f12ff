# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches whose plan grows while they run, by a source that is played."""

import json
import os
from pathlib import Path
import signal
import time

from colcon_yamllaunch.common import files as common_files
from colcon_yamllaunch.control import socket_folder
from colcon_yamllaunch.control.client import running_launches
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.commands import Stop
import pytest

ABOUT = {'title': 'demo', 'package': None, 'file': '/f', 'folder': '/'}


@pytest.fixture
def told(launch):
    """Return a function that returns what the source of a launch was told."""

    def read(started):
        return (started.folder / 'told').read_text().splitlines()

    return read


def host_of(launch):
    """Return the process id of the host."""
    children = Path(f'/proc/{launch.popen.pid}/task/{launch.popen.pid}')
    for pid in (children / 'children').read_text().split():
        if b'until' in Path(f'/proc/{pid}/cmdline').read_bytes():
            return int(pid)
    raise AssertionError


def test_what_comes_later_is_a_part_like_any_other(
    launch, sh, sleep, told, wait_until, monkeypatch
):
    monkeypatch.setattr(socket_folder, 'USER_FOLDERS', '/does/not/exist')
    monkeypatch.setattr(common_files, 'SHARED_FOLDERS', ())
    answer = [
        {'kind': 'message', 'level': 'INFO', 'text': 'a is over'},
        sh('b', 'echo hello; exec sleep 99', name='b-2'),
        sh('c', 'echo never', name='c-3', output='log'),
        {'kind': 'signal', 'process': 'c-3', 'signal': 0},
        {'kind': 'call', 'number': 3, 'title': 'spawn'},
    ]
    more = {'when': 'stdout b-2 hello', 'entries': [sh('d', 'echo done')]}
    started = launch(
        sh('a', 'echo one; echo two >&2', name='a-1'),
        sleep('keep'),
        source=[{'when': 'exited a', 'entries': answer}, more],
        wanted=['b-2'],
        about=ABOUT,
    )
    started.shows('[d]      done')
    environment = {'TMPDIR': str(started.folder)}
    (running,) = running_launches(environment, pytest.fail)
    phases = ['ended', 'running', 'running', 'ended', 'ended']
    wait_until(
        lambda: [p.phase for p in running.refresh().processes] == phases
    )
    logs = [Path(p.log).parent.name for p in running.refresh().processes]
    assert logs == ['a-1', 'keep', 'b-2', 'c-3', 'd']
    running.do(Stop('b-2'))
    wait_until(lambda: started.events('exited')[-1]['label'] == 'b')
    running.close()
    assert started.sends(signal.SIGINT).ends() == 0
    assert started.log('b-2/stdout.log') == b'hello\n'
    assert '[b]      hello' in started.screen
    assert '[launch.user]: a is over' in started.screen
    assert started.processes() == []
    events = told(started)
    for order in (
        ['exited a', 'planned', 'started b', 'started c', 'call 3'],
        ['started c', 'requested c', 'exited c'],
        ['started b', 'stdout b-2 hello', 'started d', 'exited d'],
        ['exited d', 'requested b', 'exited b', 'shutdown interrupted'],
        ['shutdown interrupted', 'exited keep'],
    ):
        assert [e for e in dict.fromkeys(events) if e in order] == order


def test_the_launch_waits_for_what_is_still_to_come(launch, sh, told):
    bye = {'kind': 'message', 'level': 'INFO', 'text': 'bye'}
    late = {'late': 'now', 'entries': [sh('b', 'echo two')]}
    source = [
        {'when': 'exited a', **late},
        {'when': 'shutdown idle', 'entries': [bye, sh('c', 'echo three')]},
    ]
    started = launch(sh('a', 'echo one'), source=source).shows('a: finished')
    (started.folder / 'now').touch()
    assert started.ends() == 0
    assert 'two' in started.screen
    assert 'bye' in started.screen
    assert 'three' not in started.screen
    assert 'stopping' not in started.screen
    assert told(started)[-1] == 'message bye'


def test_a_launch_file_that_fails_ends_the_launch(launch, sh, sleep):
    problems = ['demo.launch.py:7: error: ValueError: no', '    raise …']
    started = launch(
        sleep('a'),
        sh('b', ':'),
        source=[{'when': 'exited b', 'problems': problems}],
    )
    assert started.ends() == 1
    for line in problems:
        assert line in started.screen
    assert 'stopping: a launch file in Python failed' in started.screen
    assert f'failed: {problems[0]}' in started.screen
    assert started.events('plan_failed')
    assert started.processes() == []


def test_processes_outlive_the_host(launch, sh, sleep, wait_until):
    source = [{'when': 'shutdown interrupted', 'never': True}]
    started = launch(sleep('a'), source=source).shows('a: started')
    os.kill(host_of(started), signal.SIGKILL)
    started.shows('worker for Python launch files died by SIGKILL')
    assert len(started.processes()) == 1
    assert started.sends(signal.SIGINT).ends() == 1
    assert started.screen.count('worker for Python launch files') == 2
    (lost,) = started.events('host_lost')
    assert lost['reason'] == 'died by SIGKILL (killed)'
    assert [e['failed'] for e in started.events('exited')] == [False]


def test_who_never_answers_does_not_hold_up_the_end(launch, sleep):
    source = [{'when': 'started a', 'never': True}]
    started = launch(sleep('a'), source=source, patience=0.01)
    started.shows('a: started').sends(signal.SIGINT)
    assert started.ends() == 0
    assert started.processes() == []


def test_ctrl_c_again_does_not_wait_for_an_answer(launch, sleep, wait_until):
    source = [{'when': 'started a', 'never': True}]
    started = launch(sleep('a'), source=source, patience=900.0)
    started.shows('a: started').sends(signal.SIGINT)
    started.shows('a: stopped')
    shown = time.monotonic()
    wait_until(
        lambda: time.monotonic() - shown > 2 * limits.SIGNAL_ECHO_INTERVAL
    )
    started.sends(signal.SIGINT)
    assert started.ends() == 0
    assert started.processes() == []


def test_a_killed_launch_leaves_neither_host_nor_processes(
    launch, sh, sleep, wait_until
):
    source = [{'when': 'exited a', 'entries': [sleep('b')]}]
    started = launch(sh('a', 'echo one'), source=source).shows('b: started')
    wait_until(started.guards)
    assert len(started.processes()) == 2
    started.sends(signal.SIGKILL)
    wait_until(lambda: not started.processes())


def test_the_record_of_a_launch_has_what_came_later(launch, sh, sleep):
    later = [sleep('b', sigterm_timeout=7.0)]
    source = [{'when': 'exited a', 'entries': later}]
    started = launch(sh('a', 'echo one'), source=source, about=ABOUT)
    started.shows('b: started')
    (path,) = started.folder.glob('*/*.json')
    record = json.loads(path.read_text())
    # between them the number of what speaks with ROS
    assert [p.get('label') for p in record['processes']] == ['a', None, 'b']
    assert record['processes'][2]['timeouts'] == [7.0, 5.0]
    assert started.sends(signal.SIGINT).ends() == 0


def test_what_no_process_of_the_plan_started_ends_with_the_launch(
    launch, sh, sleep
):
    """As what launch files start themselves while they are read."""
    mark = 'COLCON_LAUNCH_ID=${COLCON_LAUNCH_ID%.*}.1000000000'
    started = launch(
        sleep('a'),
        sh('b', f'{mark} setsid -f sleep 98 > /dev/null 2>&1'),
        environment={'COLCON_LAUNCH_CGROUP': '0'},
    )
    started.shows('b: finished')
    assert len(started.processes()) == 2
    assert started.sends(signal.SIGINT).ends() == 0
    assert started.processes() == []
