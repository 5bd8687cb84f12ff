# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Processes with limits and priorities, started by the installed program."""

import os
import signal
import sys
import time

from colcon_yamllaunch.engine.limit_groups import group_support
import pytest
from support.hostile import needs_other_user
from support.user import DEADLINE, User

CPU = min(os.sched_getaffinity(0))
CONTROLLERS = group_support(os.environ).controllers
LAUNCH = """\
launch:
  - executable: {cmd: PROGRAM first.py, name: first}
  - executable: {cmd: PROGRAM second.py, name: second}
"""
SHOWS = """\
import os
print('has', os.nice(0), *os.sched_getaffinity(0),
      open('/proc/self/oom_score_adj').read().strip(),
      os.environ['COLOUR'], os.getpgid(0) == os.getpid())
print('runs in', os.getcwd())
"""
EATS = """\
import sys, time
time.sleep(0.5)
try:
    eaten = bytearray(1 << 30)
except MemoryError:
    sys.exit('MemoryError: there is no more')
print('ate all of it')
"""
WAITS = """\
import time
time.sleep(SECONDS)
print('goes on')
"""


@pytest.fixture
def robot(user: User) -> User:
    user.write('a.yaml', LAUNCH.replace('PROGRAM', sys.executable))
    user.write('second.py', "print('second')\n")
    return user


def launch(user: User, first: str, rules: str, code: int = 0) -> str:
    """Launch with rules, and return the output."""
    user.write('first.py', first)
    user.write('robot.yaml', f'processes:\n{rules}')
    return user.launch('a.yaml', '--deploy', 'robot.yaml', code=code)


def test_process_has_its_priority_processors_and_score(robot: User) -> None:
    rule = f"""\
  - match: first*
    nice: 6
    cpus: {CPU}
    oom: 321
    env: {{COLOUR: green}}
    output: both
"""
    output = launch(robot, SHOWS, rule)
    assert f'has 6 {CPU} 321 green True' in output
    assert f'runs in {robot.root}\n' in output


def test_node_that_takes_too_much_memory_dies_alone(robot: User) -> None:
    robot.write('second.py', WAITS.replace('SECONDS', '3'))
    rule = '  - {match: first*, memory: 200M}\n'
    output = launch(robot, EATS, rule, code=1)
    assert 'ate all of it' not in output
    assert 'goes on' in output
    assert "raise 'memory' at robot.yaml:2:21" in output
    if 'memory' in CONTROLLERS:
        assert 'first-1: killed: over its 200 MiB limit, peak 200' in output
    else:
        assert "warning: 'memory' limits each process by" in output


def test_respawned_process_is_limited_again(robot: User) -> None:
    text = LAUNCH.replace('PROGRAM', sys.executable).replace(
        'name: first', "name: first, respawn: 'true', respawn_max_retries: 1"
    )
    robot.write('a.yaml', text)
    rule = '  - {match: first*, nice: 4}\n'
    shows = 'import os; print("nice", os.nice(0)); exit(1)\n'
    output = launch(robot, shows, rule, code=1)
    assert output.count('nice 4\n') == 2


def test_impossible_limits_are_errors_before_anything_starts(
    robot: User,
) -> None:
    rules = """\
  - {match: first*, cpus: 1000}
  - {match: second*, user: nobdy}
"""
    output = launch(robot, '', rules, code=1)
    assert 'robot.yaml:2:21: error: the launch has no processor' in output
    assert "robot.yaml:3:22: error: there is no user 'nobdy'" in output
    assert "did you mean 'nobody'?" in output
    assert 'started' not in output


def test_limit_is_never_ignored(robot: User) -> None:
    rule = '  - {match: first*, tasks: 5}\n'
    forks = (
        'import os, sys, time\n'
        'for _ in range(9):\n'
        '    try:\n'
        '        if not os.fork():\n'
        '            time.sleep(9)\n'
        '    except OSError as e:\n'
        '        sys.exit(str(e))\n'
    )
    output = launch(robot, forks, rule, code=1)
    if 'pids' in CONTROLLERS:
        assert 'exited with code 1 (at its limit of 5 tasks)' in output
        assert "raise 'tasks' at robot.yaml:2:21" in output
    else:
        assert "error: 'tasks' cannot be limited here: " in output
        assert 'docs/deployment.md#limits' in output
        assert 'started' not in output


def test_folder_that_does_not_exist_is_named(robot: User) -> None:
    rule = '  - {match: first*, directory: /no/where}\n'
    output = launch(robot, '', rule, code=1)
    assert "the working directory '/no/where' cannot be entered" in output
    assert 'second' in output


@pytest.mark.skipif(os.geteuid() == 0, reason='root may do all of that')
def test_missing_permissions_are_errors_before_anything_starts(
    robot: User,
) -> None:
    rule = """\
  - match: first*
    nice: -5
    oom: last
    user: root
    scheduling: {fifo: 50}
"""
    output = launch(robot, '', rule, code=1)
    assert 'robot.yaml:3:5: error: this user may not set the nice' in output
    assert ' - nice -5' in output
    assert 'robot.yaml:4:5: error: the launch may not lower oom' in output
    assert 'robot.yaml:5:5: error: only root may start' in output
    assert 'robot.yaml:6:5: error: this user may not set the prio' in output
    assert 'started' not in output


@needs_other_user
def test_process_runs_as_its_user(robot: User) -> None:
    robot.write(
        'a.yaml',
        'launch:\n'
        "  - executable: {cmd: sh -c 'id -un; echo $HOME $USER $LOGNAME'"
        ', name: first}\n',
    )
    output = launch(robot, '', '  - {match: first*, user: nobody}\n')
    assert ' nobody\n' in output
    assert ' nobody nobody\n' in output


@pytest.mark.skipif(
    'memory' not in CONTROLLERS,
    reason='no control group with limits can be made here',
)
def test_killed_launcher_leaves_no_group_with_limits(robot: User) -> None:
    base = group_support(os.environ).base
    before = sorted(os.listdir(base))
    robot.write('first.py', WAITS.replace('SECONDS', '300'))
    robot.write('robot.yaml', 'processes: [{match: first*, memory: 200M}]')
    one = robot.start('colcon', 'launch', 'a.yaml', '--deploy', 'robot.yaml')
    one.wait_for('first-1: started')
    one.process.send_signal(signal.SIGKILL)
    one.process.wait()
    deadline = time.monotonic() + DEADLINE
    while sorted(os.listdir(base)) != before and time.monotonic() < deadline:
        time.sleep(0.05)
    assert sorted(os.listdir(base)) == before
