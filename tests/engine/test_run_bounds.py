# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches that wait for ever, or for what can hardly be found."""

import signal
import subprocess

from colcon_yamllaunch.engine import limits
import pytest

pytestmark = pytest.mark.hostile

#: Seconds; epoll counts milliseconds in an int, which end after 24.8 days.
CENTURIES = 1e10


@pytest.mark.parametrize('what', ['timer', 'respawn', 'timeout', 'sigterm'])
def test_a_launch_waits_for_centuries(launch, sh, wait_until, what):
    ready = sh('a', 'echo ready; exec sleep 99')
    more = {}
    if what == 'timer':
        later = [sh('late', 'echo late')]
        entries = [
            ready,
            {'kind': 'timer', 'period': CENTURIES, 'entries': later},
        ]
    elif what == 'respawn':
        ends = sh('a', 'echo ready', respawn=True, respawn_delay=CENTURIES)
        entries = [ends]
    elif what == 'timeout':
        entries, more = [ready], {'timeout': CENTURIES}
    else:
        deaf = sh('a', 'trap "" INT; echo ready; exec sleep 99')
        entries = [deaf | {'sigterm_timeout': CENTURIES}]
    one = launch(*entries, **more).shows('ready').sends(signal.SIGINT)
    if what == 'sigterm':
        # the next step, once that is no echo of the first signal
        one.shows('interrupted')
        wait_until(lambda: one.sends(signal.SIGTERM) and has_ended(one))
    one.ends()
    assert 'error' not in one.screen.lower()
    assert one.processes() == []


def has_ended(one):
    try:
        one.popen.wait(2 * limits.SIGNAL_ECHO_INTERVAL)
    except subprocess.TimeoutExpired:
        return False
    return True


def test_ctrl_c_comes_through_while_lines_are_searched(launch, sh):
    script = 'echo ready; exec yes aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaab'
    one = launch(sh('a', script), until=['(a+)+$']).shows('ready')
    one.sends(signal.SIGINT)
    assert one.ends() in (0, 1)
    assert one.processes() == []
