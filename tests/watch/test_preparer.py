# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The process that prepares launches anew."""

import os
import signal
import subprocess
import sys
import time

from colcon_yamllaunch.common import files as common_files
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.watch import preparer
from colcon_yamllaunch.watch.preparer import Announced, Begun, Failed, Preparer
import pytest
from support.waiting import is_running, wait_until

ANSWERS = (str, bytes, list, Failed)


class Jobs:
    """A preparer, and what its jobs report."""

    def __init__(self, prepare, clean_up=lambda pid: None):
        self.preparer = Preparer(prepare, lambda: None, clean_up)
        self.loop = Loop()
        self.reported = []
        self.preparer.begin(self.loop, self.reported.append)

    def ask(self, request):
        self.reported.clear()
        self.preparer.ask(request)

    def wait_for(self, kind):
        """Return the first report of a kind."""

        def found():
            self.loop.call_later(0.1, self.loop.wake)
            self.loop.run_once()
            return [m for m in self.reported if isinstance(m, kind)]

        return wait_until(found)[0]

    def answer(self):
        """Return the reports of a job but for its begin, and its answer."""
        self.wait_for(ANSWERS)
        return [m for m in self.reported if not isinstance(m, Begun)]


@pytest.fixture
def make_preparer():
    made = []

    def make(*args):
        made.append(Jobs(*args))
        return made[-1]

    yield make
    for jobs in made:
        jobs.preparer.close()
        jobs.loop.close()


def busy(make_preparer):
    """Return a preparer with an endless job, its group and its child."""

    def prepare(request, announce):
        announce(subprocess.Popen(['sleep', '1000']).pid)
        signal.pause()

    jobs = make_preparer(prepare)
    jobs.ask(1)
    pid = int(jobs.wait_for(Announced).text)
    return jobs, jobs.wait_for(Begun).pid, pid


def test_answer_does_not_wait_for_the_disks(make_preparer, monkeypatch):
    written, done = os.pipe()
    told, answered = os.pipe()

    def catch_up():
        os.read(told, 1)
        os.write(done, b'w')

    name = 'colcon_yamllaunch.watch.preparer.catch_up'
    monkeypatch.setattr(name, catch_up)
    jobs = make_preparer(lambda request, announce: 'answer')
    jobs.ask('something')
    assert jobs.answer() == ['answer']
    os.write(answered, b'a')
    assert os.read(written, 1) == b'w'
    for descriptor in (written, done, told, answered):
        os.close(descriptor)


def test_file_systems_are_synchronized_once_after_put_off(
    tmp_path, monkeypatch
):
    opened = []
    monkeypatch.setattr(common_files, '_put_off', None)

    def refuse(path, _):
        opened.append(path)
        raise OSError

    monkeypatch.setattr(os, 'open', refuse)
    common_files.put_off()
    common_files.sync_file_systems([tmp_path])
    assert opened == []
    common_files.catch_up()
    assert opened == [tmp_path]
    common_files.catch_up()
    assert opened == [tmp_path]


def test_each_job_is_answered_without_state_of_those_before(make_preparer):
    seen = []

    def prepare(request, announce):
        announce('begun')
        os.write(1, b'shown\n')
        seen.append(request)
        return seen

    jobs = make_preparer(prepare)
    for number in (1, 2):
        jobs.ask(number)
        assert jobs.answer() == [Announced('begun'), [number]]
        assert jobs.preparer.written == b'shown\n'
    jobs.preparer.forget()


def test_output_keeps_its_order_and_all_sizes_pass(make_preparer, monkeypatch):
    def prepare(request, announce):
        print('building')
        os.write(2, b'an error\n')
        print('failed')
        sys.stdout.buffer.write(request)
        return request[:-1]

    data = os.urandom(3_000_000)
    with open(1, 'w', closefd=False) as stdout:
        monkeypatch.setattr(sys, 'stdout', stdout)
        jobs = make_preparer(prepare)
        jobs.ask(data)
        assert jobs.answer() == [data[:-1]]
        output = b'building\nan error\nfailed\n'
        assert jobs.preparer.written == output + data


def test_job_that_raises_has_failed(make_preparer):
    def prepare(request, announce):
        raise ValueError(request)

    jobs = make_preparer(prepare)
    jobs.ask(1)
    assert jobs.answer() == [Failed('job')]


def test_job_leads_a_group_and_is_cancelled_with_it(make_preparer):
    jobs, group, pid = busy(make_preparer)
    assert os.getpgid(pid) == group
    jobs.preparer.cancel()
    wait_until(lambda: not is_running(group) and not is_running(pid))
    jobs.ask(2)
    assert jobs.wait_for(Begun) != Begun(group)


def test_suspended_preparer_leaves_nothing_behind(make_preparer):
    jobs, group, pid = busy(make_preparer)
    os.kill(jobs.preparer.pid, signal.SIGSTOP)
    jobs.preparer.close()
    assert not is_running(group)
    # it was killed, and ends when the system gets to it
    wait_until(lambda: not is_running(pid))


def test_many_jobs_in_a_row_are_cancelled_at_once(make_preparer):
    cleaned, clean = os.pipe()

    def prepare(request, announce):
        while request < 30:
            signal.pause()
        return str(request)

    jobs = make_preparer(prepare, lambda pid: os.write(clean, b'%d\n' % pid))
    begun = time.monotonic()
    jobs.ask(0)
    first = jobs.wait_for(Begun).pid
    for number in range(1, 31):
        jobs.ask(number)
    assert jobs.answer() == ['30']
    # none of them waited for SIGTERM
    assert time.monotonic() - begun < preparer._GRACE
    assert not is_running(first)
    assert int(os.read(cleaned, 1000).split()[0]) == first
    os.close(cleaned)
    os.close(clean)
