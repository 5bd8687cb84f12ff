# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Machines that are noisy, slow, full, or asked by several at once."""

import json
import os
from pathlib import Path
import re
import signal
import sys
import time

import pytest
from support.deployer import Deployer, HERE
from support.hostile import with_mounts
from support.sshd import Sshd
from support.time_limits import within
from support.user import Launch

pytestmark = pytest.mark.hostile

#: Reads single keys, and says which.
RAW = """\
import os, sys, tty
tty.setraw(0)
print('ready\\r', flush=True)
while True:
    key = os.read(0, 1)
    print(f'key {key.hex()}\\r', flush=True)
    if key == b'q':
        break
"""
#: Writes as fast as it can.
FLOOD = """\
import os
line = b'x' * 99 + b'\\n'
while True:
    os.write(1, line * 500)
"""


def _one(deployer: Deployer, *words: str, **settings: str) -> None:
    command = words or deployer.talker
    deployer.places({'one': ('arm', command)}, sync='none', **settings)


def _ends(launch: Launch, sshd: Sshd, code: int = 0) -> None:
    assert launch.interrupt() == code, launch.output
    assert 'Traceback' not in launch.output
    sshd.wait_until_empty()


def test_a_shell_talks_before(deployer: Deployer, sshd: Sshd) -> None:
    noise = 'seq 20000; echo Welcome; echo careful >&2'
    sshd['arm'].shell_reads(noise)
    _one(deployer)
    launch = deployer.deploys()
    launch.wait_for(r'one-1\] up')
    assert 'Welcome' not in launch.output
    _ends(launch, sshd)


def test_a_shell_runs_something_else(deployer: Deployer, sshd: Sshd) -> None:
    sshd['arm'].shell_reads('exit 3')
    _one(deployer)
    launch = deployer.deploys()
    assert launch.end() == 1
    assert 'Traceback' not in launch.output
    assert 'arm (ssh arm): ' in launch.output


def test_two_launches_come_first_at_once(
    deployer: Deployer, sshd: Sshd
) -> None:
    _one(deployer)
    launches = [deployer.deploys() for _ in range(3)]
    for launch in launches:
        launch.wait_for(r'one-1\] up')
    cache = sshd['arm'].home / '.cache/colcon-launch/program'
    assert len([*cache.iterdir()]) == 1
    for launch in launches:
        _ends(launch, sshd) if launch is launches[-1] else launch.interrupt()


def test_the_home_cannot_be_written(deployer: Deployer, sshd: Sshd) -> None:
    home = sshd['arm'].home
    # also for root
    (home / '.cache').write_text('not a folder')
    (home / '.ros').write_text('not a folder')
    _one(deployer)
    launch = deployer.deploys()
    launch.wait_for(r'one-1\] up')
    _ends(launch, sshd)


def test_a_slow_link_carries_much(deployer: Deployer, sshd: Sshd) -> None:
    count = 300_000
    link = sshd['arm'].link
    link.delay = 0.05
    link.bytes_per_second = 1_500_000
    _one(deployer, 'seq', '-f', 'a line with number %.0f', str(count))
    launch = deployer.deploys('--quiet')
    assert launch.end() == 0, launch.output
    text = deployer.logged('one')
    lines = re.findall(r'number (\d+)$', text, re.M)
    assert [*map(int, lines)] == [*range(1, count + 1)]
    # before it was known to be slow, what is sent was not compressed
    assert link.back < 0.9 * len(text)


def test_ctrl_c_gets_through_a_flood(deployer: Deployer, sshd: Sshd) -> None:
    script = deployer.write('flood.py', FLOOD)
    sshd['arm'].link.bytes_per_second = 1_000_000
    _one(deployer, sys.executable, str(script))
    launch = deployer.deploys()
    launch.wait_for('xxx')
    launch.process.send_signal(signal.SIGINT)
    with within(30):
        launch.end()
    sshd.wait_until_empty()


def test_the_launcher_is_held_for_long(deployer: Deployer, sshd: Sshd) -> None:
    deployer.places(
        {'one': ('arm', deployer.talker), 'own': (HERE, deployer.talker)},
        sync='none',
    )
    launch = deployer.deploys()
    launch.wait_for(r'one\S*\] +up')
    os.kill(launch.process.pid, signal.SIGSTOP)
    # a robot must not drive on unwatched
    while any('talker' in one for one in sshd.left('arm')):
        time.sleep(0.1)
    os.kill(launch.process.pid, signal.SIGCONT)
    launch.wait_for('one.*(stopped|died|lost)|arm is gone')
    launch.interrupt()
    assert 'Traceback' not in launch.output
    sshd.wait_until_empty()


def test_single_keys_get_there(deployer: Deployer, sshd: Sshd) -> None:
    script = deployer.write('raw.py', RAW)
    _one(deployer, sys.executable, str(script))
    launch = deployer.deploys('--tty')
    launch.wait_for('ready')
    terminal = deployer.in_terminal('--attach', 'one*')
    terminal.shows('attached')
    for key, code in (('a', '61'), ('\x1b', '1b'), ('\x04', '04')):
        terminal.types(key).shows(f'key {code}')
    terminal.types('q')
    terminal.ends()
    assert launch.end() == 0, launch.output
    sshd.wait_until_empty()


@pytest.mark.parametrize(
    'script, code, said',
    [
        ('exit 7', 1, 'exited with code 7'),
        ('kill -SEGV $$', 1, 'SIGSEGV'),
        ('echo done', 0, 'finished'),
    ],
)
def test_an_end_there_counts(
    deployer: Deployer, sshd: Sshd, script: str, code: int, said: str
) -> None:
    _one(deployer, 'sh', '-c', script)
    launch = deployer.deploys('--junit', 'result.xml')
    assert launch.end() == code, launch.output
    assert said in launch.output
    result = (deployer.root / 'result.xml').read_text(encoding='utf-8')
    assert 'arm│one' in result
    assert ('<failure' in result) == bool(code)
    sshd.wait_until_empty()


def test_timeout_ends_the_connecting(deployer: Deployer) -> None:
    machines = {'arm': {'connect': ['sh', '-c', 'exec sleep 1000']}}
    deployer.places({'one': ('arm', deployer.talker)}, machines, sync='none')
    launch = deployer.deploys('--timeout', '3')
    assert launch.end() == 1
    assert '--timeout: the launch did not begin within 3 s' in launch.output
    deployer.wait_until_empty()


def test_a_line_there_ends_the_launch(deployer: Deployer, sshd: Sshd) -> None:
    _one(deployer, 'sh', '-c', 'echo Goal reached; exec sleep 1000')
    launch = deployer.deploys('--until', 'Goal reached', '--timeout', '60')
    assert launch.end() == 0, launch.output
    sshd.wait_until_empty()


def test_all_of_it_is_on_one_machine(deployer: Deployer, sshd: Sshd) -> None:
    script = 'echo home $HOME variable $ROS_X $OTHER_X; exit 0'
    launch_file = {
        'launch': [{'executable': {'cmd': f"sh -c '{script}'", 'name': 'one'}}]
    }
    deployer.write('plain.yaml', json.dumps(launch_file))
    deployer.environment |= {'ROS_X': 'along', 'OTHER_X': 'secret'}
    output = deployer.launch('--on', 'arm', 'plain.yaml')
    assert f'home {sshd["arm"].home} variable along\n' in output
    sshd.wait_until_empty()


def test_the_disk_is_full_here(deployer: Deployer, sshd: Sshd) -> None:
    logs = Path(deployer.environment['HOME']) / '.ros'
    logs.mkdir()
    command = ['colcon', 'launch', '--deploy', 'robot.yaml', 'plain.yaml']
    argv = with_mounts(f'mount -t tmpfs -o size=64k tmpfs {logs}', command)
    _one(deployer, 'sh', '-c', 'seq 100000; echo Last line; sleep 1000')
    launch = deployer.start(*argv)
    launch.wait_for(r'Last line')
    assert 'No space left' in launch.output
    launch.interrupt()
    assert 'Traceback' not in launch.output
    sshd.wait_until_empty()
