# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A build ends by Ctrl-C and other signals, and takes all with it."""

import os
from pathlib import Path
import re
import signal
import time

import pytest
from support.user import DEADLINE, Launch, User

BUILD = """\
cmake_minimum_required(VERSION 3.16)
project(slow NONE)
execute_process(COMMAND sh -c "{command}")
"""
#: Where a build tool tells its process id.
PID = 'pid'


@pytest.fixture
def builder(user: User) -> User:
    user.package('slow')
    user.package('other')
    return user


def _start(builder: User, verb: str, trap: str = '') -> Launch:
    pid = builder.root / PID
    command = f'{trap} echo $$$$ > {pid}.new && mv {pid}.new {pid}'
    text = BUILD.format(command=f'{command}; while :; do sleep 0.05; done')
    builder.write('src/slow/CMakeLists.txt', text.replace('$$$$', '\\$\\$'))
    started = builder.start('colcon', verb, 'slow', 'slow')
    started.wait_for('Starting >>> slow')
    return started


def _pid(builder: User, started: Launch) -> int:
    file = builder.root / PID
    while not file.exists():
        assert started.process.poll() is None, started.output
        time.sleep(0.01)
    return int(file.read_text())


def _wait_for_the_end(pid: int) -> None:
    # whoever adopted it has to take note of its end
    deadline = time.monotonic() + DEADLINE
    while Path(f'/proc/{pid}').exists():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.mark.parametrize('verb', ['launch', 'run'])
@pytest.mark.parametrize(
    ('name', 'code'),
    [
        ('SIGINT', 130),
        ('SIGTERM', 143),
        ('SIGHUP', 129),
        pytest.param('SIGQUIT', 131, marks=pytest.mark.hostile),
    ],
)
def test_signals(builder: User, verb: str, name: str, code: int) -> None:
    # as `kill` or a task runner sends it: the build tools do not get it
    started = _start(builder, verb)
    pid = _pid(builder, started)
    started.process.send_signal(signal.Signals[name])
    assert started.end() == code, started.output
    _wait_for_the_end(pid)
    assert 'Aborted  <<< slow' in started.output
    assert 'Traceback' not in started.output
    if verb == 'launch':
        last = 'the build was interrupted; not built: slow\n'
        assert started.output.endswith(last)


@pytest.mark.hostile
def test_build_tool_without_group_session_and_environment(
    builder: User,
) -> None:
    pid = builder.root / PID
    script = builder.write(
        'stray.sh',
        "env -i setsid sh -c 'echo $$ >new; mv new "
        f"{pid}; exec sleep 99' & wait\n",
    )
    text = BUILD.format(command=f'. {script}')
    builder.write('src/slow/CMakeLists.txt', text)
    started = builder.start('colcon', 'launch', 'slow', 'slow')
    stray = _pid(builder, started)
    # as a terminal sends it
    os.killpg(started.process.pid, signal.SIGINT)
    assert started.end() == 130, started.output
    _wait_for_the_end(stray)


@pytest.mark.parametrize('trap', ["trap '' INT;", "trap '' INT TERM;"])
def test_stubborn_build_tool(builder: User, trap: str) -> None:
    started = _start(builder, 'launch', trap)
    pid = _pid(builder, started)
    # as a terminal sends it
    os.killpg(started.process.pid, signal.SIGINT)
    assert started.end() == 130, started.output
    _wait_for_the_end(pid)


@pytest.mark.parametrize('delay', [0.0, 0.01, 0.03, 0.1])
def test_before_the_first_tool(builder: User, delay: float) -> None:
    started = _start(builder, 'launch')
    time.sleep(delay)
    os.killpg(started.process.pid, signal.SIGINT)
    assert started.end() == 130, started.output
    assert 'Traceback' not in started.output


def test_the_next_launch_builds(builder: User) -> None:
    started = _start(builder, 'launch')
    _pid(builder, started)
    started.interrupt()
    builder.package('slow')
    output = builder.launch('slow', 'slow.yaml')
    assert re.search(r'^1 package built \(slow: ', output, re.MULTILINE)
    assert 'hello from slow' in output


@pytest.mark.parametrize(
    ('name', 'code'), [('SIGINT', 130), ('SIGTERM', 143), ('SIGHUP', 129)]
)
def test_a_launch_that_waits_for_a_build(
    builder: User, name: str, code: int
) -> None:
    first = _start(builder, 'launch')
    pid = _pid(builder, first)
    second = builder.start('colcon', 'launch', 'other', 'other')
    second.wait_for("waiting for 'colcon launch ")
    second.process.send_signal(signal.Signals[name])
    assert second.end() == code, second.output
    assert 'Traceback' not in second.output
    # and the other one's build goes on
    assert Path(f'/proc/{pid}').exists()
    assert first.interrupt() == 130


def test_killed_launch(builder: User) -> None:
    killed = _start(builder, 'launch')
    pid = _pid(builder, killed)
    killed.process.kill()
    killed.end()
    assert Path(f'/proc/{pid}').exists()
    builder.package('slow')
    output = builder.launch('slow', 'slow.yaml')
    assert 'ending what is left of a build that was killed' in output
    _wait_for_the_end(pid)
    assert 'was cut off' in output
    assert 'hello from slow' in output
    # and that only once
    assert 'ending' not in builder.launch('slow', 'slow.yaml')
