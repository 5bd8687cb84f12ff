# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A real launch reports to systemd and to the journal."""

import os
import signal

import pytest
from support.systemd import Systemd
from support.user import DEADLINE, User

LAUNCH = """\
launch:
- executable: {cmd: sh -c "echo up; exec sleep 1000", name: driver}
- executable:
    cmd: sh -c "until [ -e go ]; do sleep 0.1; done; echo '[WARN] x'; sleep 99"
    name: filter
    cwd: FOLDER
"""
SETTINGS = """\
processes:
  - match: driver-1
    ready: {after: 0.1}
    critical: true
  - match: filter-2
    after: driver-1
    ready: {log: x}
"""


@pytest.fixture
def words(user: User) -> list[str]:
    """Return the command line of a launch with readiness."""
    text = LAUNCH.replace('FOLDER', str(user.root))
    file = user.write('demo.launch.yaml', text)
    settings = user.write('robot.yaml', SETTINGS)
    return [str(file), '--deploy', str(settings)]


def test_launch_is_ready_when_all_members_are(
    systemd: Systemd, words: list[str], user: User
) -> None:
    systemd.start(*words)
    systemd.wait_for(
        "STATUS=1 of 2 ready; waiting for filter-2 (a line that matches 'x')"
    )
    assert 'READY=1' not in systemd.receive(0.3)
    user.write('go', '')
    systemd.wait_for('READY=1')
    assert systemd.notified[-2:] == ['STATUS=2 of 2 ready', 'READY=1']


def test_launch_without_readiness_is_ready_when_all_are_started(
    systemd: Systemd, words: list[str]
) -> None:
    systemd.start(words[0])
    systemd.wait_for('READY=1')
    assert 'STATUS=2 of 2 started' in systemd.notified


def test_end_of_a_launch_is_announced(
    systemd: Systemd, words: list[str]
) -> None:
    launch = systemd.start(words[0])
    systemd.wait_for('READY=1')
    launch.terminate()
    systemd.wait_for('STATUS=stopping: SIGTERM received')
    assert 'STOPPING=1' in systemd.notified
    assert launch.wait(timeout=DEADLINE) == 0


def test_watchdog_is_pinged_only_without_a_critical_problem(
    systemd: Systemd, words: list[str], user: User
) -> None:
    user.write('go', '')
    systemd.start(*words, watchdog=0.8)
    systemd.wait_for('READY=1')
    systemd.wait_for('WATCHDOG=1')
    started = next(
        m for m in systemd.journal() if 'driver-1: started' in m['MESSAGE']
    )
    driver = int(started['MESSAGE'].rpartition(' ')[2])
    os.kill(driver, signal.SIGSTOP)
    systemd.wait_for('STATUS=2 of 2 ready; not healthy: driver-1')
    assert 'WATCHDOG=1' not in systemd.receive(1)
    os.kill(driver, signal.SIGCONT)
    systemd.wait_for('STATUS=2 of 2 ready')
    systemd.notified.clear()
    systemd.wait_for('WATCHDOG=1')


def test_failure_of_a_critical_process_is_the_status(
    systemd: Systemd, words: list[str], user: User
) -> None:
    user.write('go', '')
    launch = systemd.start(*words)
    systemd.wait_for('READY=1')
    started = next(
        m for m in systemd.journal() if 'driver-1: started' in m['MESSAGE']
    )
    os.kill(int(started['MESSAGE'].rpartition(' ')[2]), signal.SIGABRT)
    assert launch.wait(timeout=DEADLINE) == 1
    systemd.receive(0.2)
    assert any(
        line.startswith('STATUS=driver-1') and 'SIGABRT' in line
        for line in systemd.notified
    )


def test_each_process_has_its_identifier_in_the_journal(
    systemd: Systemd, words: list[str], user: User
) -> None:
    user.write('go', '')
    launch = systemd.start(*words)
    systemd.wait_for('READY=1')
    found = systemd.journal()
    launch.terminate()
    launch.wait(timeout=DEADLINE)
    found += systemd.journal()
    output = {
        m['SYSLOG_IDENTIFIER']: (m['MESSAGE'], m['PRIORITY'])
        for m in found
        if 'SYSLOG_PID' in m
    }
    assert output == {'driver-1': ('up', '6'), 'filter-2': ('[WARN] x', '4')}
    own = [m['MESSAGE'] for m in found if m['SYSLOG_IDENTIFIER'] == 'launch']
    assert 'stopping: SIGTERM received' in own
    # the journal has it already
    assert (systemd.folder / 'stdout').read_text() == ''


def test_processes_do_not_notify_systemd(systemd: Systemd, user: User) -> None:
    text = 'launch: [executable: {cmd: sh -c "env > vars", cwd: FOLDER}]\n'
    text = text.replace('FOLDER', str(user.root))
    file = user.write('env.launch.yaml', text)
    launch = systemd.start(str(file), watchdog=60)
    assert launch.wait(timeout=DEADLINE) == 0
    variables = (user.root / 'vars').read_text()
    assert 'NOTIFY_SOCKET' not in variables
    assert 'WATCHDOG_' not in variables


def test_saved_plan_with_settings_keeps_the_order(
    systemd: Systemd, words: list[str], user: User
) -> None:
    plan = user.launch(*words, '--plan=json')
    file = user.write('saved.json', plan[plan.index('{') :])
    systemd.start('--from-plan', str(file))
    systemd.wait_for(
        "STATUS=1 of 2 ready; waiting for filter-2 (a line that matches 'x')"
    )
    user.write('go', '')
    systemd.wait_for('READY=1')
