# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Requests, messages, restarts and the end of a helper process."""

import os
import sys

from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.helper_process import HelperProcess
from colcon_yamllaunch.engine.loop import ended_children
from colcon_yamllaunch.engine.spawn import spawn_process, StartError
import pytest
from support.test_loop import TestLoop
from support.waiting import wait_until

#: Answers each request with its double; ends at the end of its input.
DOUBLE = """
import json, sys
print('no JSON', flush=True)
for line in sys.stdin:
    number = json.loads(line)['number']
    print('[1]', flush=True)
    print(json.dumps({'number': 2 * number}), flush=True)
print('last words', file=sys.stderr)
"""
#: Closes its output, and never ends.
SILENT = """
import os, time
os.close(1)
time.sleep(1000)
"""


class Served:
    """A helper process, and what it reports."""

    def __init__(self, log):
        self.loop = TestLoop()
        self.program = DOUBLE
        self.messages = []
        self.lost = []
        self.process = HelperProcess(
            self.loop,
            self.spawn,
            self.messages.append,
            lambda *reason: self.lost.append(reason),
            log,
        )

    def spawn(self, streams):
        if not self.program:
            raise StartError('there is no program')
        argv = [sys.executable, '-c', self.program]
        return spawn_process(argv, os.environ, '/', streams)

    def wait(self, is_so):
        def seen():
            self.loop.run_once()
            for pid, status in ended_children({*self.loop.children}):
                self.loop.children.pop(pid)[0](status)
            return is_so()

        wait_until(seen)


@pytest.fixture
def served(tmp_path):
    made = Served(tmp_path / 'helper.log')
    yield made
    made.process.close()
    made.loop.close()


def test_requests_are_answered_by_messages(served):
    served.process.send({'number': 0})
    served.process.start()
    for number in range(3):
        served.process.send({'number': number})
    served.wait(lambda: len(served.messages) == 3)
    assert served.messages == [{'number': 0}, {'number': 2}, {'number': 4}]


def test_large_requests_do_not_block(served):
    served.process.start()
    served.process.send({'number': 1, 'text': 'x' * 1_000_000})
    served.wait(lambda: served.messages)


def test_a_helper_ends_with_its_input_and_is_not_restarted(served, tmp_path):
    served.process.start()
    served.process.send({'number': 1})
    served.wait(lambda: served.messages)
    served.process.stop()
    served.wait(lambda: not served.process.pid)
    assert served.lost == []
    assert served.loop.next_due() is None
    log = tmp_path / 'helper.log'
    assert served.process.last_line() == f'last words; see {log}'


def test_a_killed_helper_is_reported_and_restarted(served):
    served.process.start()
    os.kill(served.process.pid, 9)
    served.wait(lambda: served.lost)
    assert served.lost == [('died by SIGKILL (killed)', True)]
    assert served.process.restart_later()
    served.loop.pass_time(limits.SHORTEST_RESTART_PAUSE)
    assert served.process.pid


def test_a_helper_that_closes_its_output_is_killed(served):
    served.program = SILENT
    served.process.start()
    served.wait(lambda: served.lost)
    assert served.lost == [('died by SIGKILL (killed)', True)]


def test_each_pause_is_twice_as_long_as_the_one_before(served):
    served.program = ''
    served.process.start()
    pauses = []
    while served.process.restart_later():
        pauses.append(served.loop.next_due())
        served.loop.pass_time(pauses[-1])
        assert served.loop.next_due() is None
    factors = [2.0**number for number in range(limits.HELPER_RESTARTS)]
    expected = [limits.SHORTEST_RESTART_PAUSE * factor for factor in factors]
    assert pauses == pytest.approx(expected)
    assert served.process.ends == limits.HELPER_RESTARTS + 1
    reason = 'could not be started: there is no program', False
    assert served.lost == [reason] * (limits.HELPER_RESTARTS + 1)
    # one that has run for a while may end as often again
    served.process.start()
    served.loop.now += limits.HELPER_STEADY_TIME + 1
    assert served.process.restart_later()
    assert served.process.ends == 1


def test_another_program_starts_at_once_and_counts_as_no_end(served):
    served.process.restart_now()
    assert served.loop.next_due() == 0.0
    assert served.process.ends == 0
