# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launching files in Python, with a worker that is played by a script."""

import json
import os
from pathlib import Path
import re
import signal
import sys
import time

from colcon_yamllaunch.common.process_scan import read_process
import pytest
from support.user import built, DEADLINE, User

#: Stands for each Python of the environment. As the worker, it says what
#: stands in a launch file, line by line.
PLAYED = f"""\
#!{sys.executable}
import json, os, subprocess, sys, time

if not sys.argv[-1].endswith('python_launch/worker'):
    os.execv({sys.executable!r}, ['python3', *sys.argv[1:]])

def say(message):
    print(json.dumps(message), flush=True)

def take():
    return json.loads(sys.stdin.readline() or sys.exit())

def answer(request):
    for line in open(request['path']).read().splitlines()[1:]:
        said = json.loads(line)
        if said == 'wait':
            child = subprocess.Popen(['sleep', '1000'], start_new_session=True)
            print('waiting', child.pid, os.getpid(), file=sys.stderr)
            sys.stderr.flush()
            time.sleep(1000)
        elif 'needs' in said and not packages[said['needs']]['built']:
            return {{'error': {{'text': 'no', 'package': said['needs']}}}}
        elif said.get('do', request['do']) == request['do']:
            say(said)
    return {{'scope': request['scope']}}

say({{'say': 'found', 'missing': []}})
while True:
    request = take()
    done = {{'scope': request.get('scope')}}
    if request['do'] == 'start':
        packages = request['packages']
    elif 'path' in request:
        done = answer(request)
    say({{'say': 'done', 'id': request['id'], **done}})
"""


@pytest.fixture
def player(user: User) -> User:
    """Give a user whose Pythons play the worker."""
    program = user.write('../bin/python3', PLAYED, 0o755)
    path = user.environment['PATH']
    user.environment['PATH'] = f'{program.parent.resolve()}:{path}'
    return user


def launch_file(user: User, *said: object) -> Path:
    """Write a launch file that makes the worker say something."""
    lines = ['# in Python', *map(json.dumps, said)]
    return user.write('src/one/launch/robot.launch.py', '\n'.join(lines))


def process(text: str) -> dict[str, object]:
    return {
        'say': 'process',
        'do': 'visit',
        'id': 1,
        'program': 'echo',
        'argv': ['echo', text],
        'output': 'screen',
    }


def test_a_file_in_python_is_built_for_launched_and_looked_at(
    player: User,
) -> None:
    player.package('one')
    player.package('two')
    launch_file(
        player,
        {'needs': 'two'},
        process('hello from Python'),
        {'say': 'argument', 'name': 'rate', 'default': '5'},
    )
    output = player.launch('one', 'robot')
    assert built(output) == ['one', 'two']
    assert '[echo-1] hello from Python' in output
    plan = player.launch('one', 'robot', '--plan', 'rat:=1')
    assert "echo 'hello from Python'" in plan
    assert "did you mean 'rate'?" in plan
    assert "'rate':" in player.launch('one', 'robot', '--show-args')
    assert 'in 1 launch file' in player.launch('one', 'robot', '--check')
    assert 'in 3 launch files' in player.launch('--check')


@pytest.mark.parametrize(
    ('number', 'look'),
    [
        (signal.SIGINT, ()),
        (signal.SIGKILL, ()),
        (signal.SIGKILL, ('--plan',)),
    ],
)
def test_what_ends_the_launcher_ends_the_worker(
    player: User, number: int, look: tuple[str, ...]
) -> None:
    player.package('one')
    path = str(launch_file(player, 'wait'))
    launch = player.start('colcon', 'launch', path, *look)
    waiting = r'waiting (\d+) (\d+)'
    found = launch.wait_for(waiting) if look else in_log(player, waiting)
    launch.process.send_signal(number)
    assert launch.end() == (130 if number == signal.SIGINT else -number)
    deadline = time.monotonic() + DEADLINE
    while any(read_process(int(pid)) for pid in found.groups()):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def in_log(user: User, pattern: str) -> re.Match[str]:
    """Wait until the log for launch files has something."""
    deadline = time.monotonic() + DEADLINE
    while time.monotonic() < deadline:
        for path in user.root.glob('log/launch_*/launch_files.log'):
            found = re.search(pattern + '\n', path.read_text())
            if found:
                return found
        time.sleep(0.02)
    raise AssertionError(f'no {pattern!r} in {os.listdir(user.root)}')


def test_a_file_that_takes_too_long(player: User) -> None:
    player.package('one')
    path = str(launch_file(player, 'wait'))
    player.environment['COLCON_LAUNCH_PYTHON_TIMEOUT'] = '0.1'
    output = player.launch(path, '--plan', code=1)
    assert "'robot.launch.py' takes more than 0.1 s to be read" in output
    player.environment['COLCON_LAUNCH_PYTHON_TIMEOUT'] = 'long'
    output = player.launch(path, '--plan', code=1)
    assert "is a number of seconds, not 'long'" in output
