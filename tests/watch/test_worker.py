# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The process that prepares launches anew."""

import os
from pathlib import Path
import select
import signal
import subprocess
import sys
import time

from colcon_yamllaunch.common import file_sync
from colcon_yamllaunch.watch.worker_link import WorkerLink
import pytest

#: Seconds after which something will not happen any more.
DEADLINE = 60.0


def is_running(pid):
    try:
        stat = Path(f'/proc/{pid}/stat').read_text(encoding='ascii')
    except (FileNotFoundError, ProcessLookupError):
        return False
    return stat.rpartition(') ')[2][0] not in 'ZX'


def wait_until(condition):
    deadline = time.monotonic() + DEADLINE
    while not (value := condition()):
        assert time.monotonic() < deadline, 'it did not happen'
        time.sleep(0.005)
    return value


@pytest.fixture
def make_worker():
    made = []

    def make(prepare, clean_up=lambda pid: None):
        made.append(WorkerLink(prepare, lambda: None, clean_up))
        return made[-1]

    yield make
    for worker in made:
        worker.close()


def children(worker):
    """Return the groups of the jobs that have begun, once there is one."""
    return wait_until(lambda: list(worker.take_children()))


def busy(make_worker):
    """Return a worker with a job that never ends, its group and its child."""

    def prepare(request, tell):
        tell(subprocess.Popen(['sleep', '1000']).pid)
        signal.pause()

    worker = make_worker(prepare)
    worker.ask(1)
    (group,) = children(worker)
    (pid,) = wait_until(lambda: list(worker.take()))
    return worker, group, pid


def messages(worker):
    """Return all that a job tells; its output is there then, too."""
    found = []
    while True:
        select.select(worker.job_descriptors, (), (), DEADLINE)
        try:
            found.extend(worker.take())
        except EOFError:
            return found


def test_disks_are_waited_for_after_the_answer(make_worker, monkeypatch):
    written, done = os.pipe()
    told, answered = os.pipe()

    def catch_up():
        os.read(told, 1)
        os.write(done, b'w')

    name = 'colcon_yamllaunch.watch.worker.catch_up'
    monkeypatch.setattr(name, catch_up)
    link = make_worker(lambda request, tell: 'answer')
    link.ask('something')
    select.select(link.job_descriptors, (), (), DEADLINE)
    assert list(link.take()) == ['answer']
    os.write(answered, b'a')
    assert os.read(written, 1) == b'w'
    for descriptor in (written, done, told, answered):
        os.close(descriptor)


def test_what_is_put_off_is_caught_up_with(tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr(file_sync, '_put_off', None)

    def refuse(path, _):
        opened.append(path)
        raise OSError

    monkeypatch.setattr(os, 'open', refuse)
    file_sync.put_off()
    file_sync.sync_file_systems([tmp_path])
    assert opened == []
    file_sync.catch_up()
    assert opened == [tmp_path]
    file_sync.catch_up()
    assert opened == [tmp_path]


def test_a_job_is_answered(make_worker):
    def prepare(request, tell):
        tell('begun')
        os.write(1, b'shown\n')
        return request * 2

    worker = make_worker(prepare)
    for number in (1, 2):
        worker.ask(number)
        assert messages(worker) == ['begun', 2 * number]
        assert worker.written == b'shown\n'
    worker.forget()


def test_errors_of_a_job_stand_where_they_belong(make_worker, monkeypatch):
    def prepare(request, tell):
        print('building')
        os.write(2, b'an error\n')
        print('failed')
        return 'done'

    with open(1, 'w', closefd=False) as stdout:
        monkeypatch.setattr(sys, 'stdout', stdout)
        worker = make_worker(prepare)
        worker.ask('something')
        assert messages(worker) == ['done']
        assert worker.written == b'building\nan error\nfailed\n'


def test_a_job_knows_nothing_of_those_before(make_worker):
    seen = []

    def prepare(request, tell):
        seen.append(request)
        return seen

    worker = make_worker(prepare)
    worker.ask(1)
    assert messages(worker) == [[1]]
    worker.ask(2)
    assert messages(worker) == [[2]]


def test_large_requests_and_answers_pass(make_worker):
    worker = make_worker(lambda request, tell: request)
    data = os.urandom(3_000_000)
    worker.ask(data)
    assert messages(worker) == [data]


def test_a_job_that_breaks_down_has_no_answer(make_worker):
    def prepare(request, tell):
        raise ValueError(request)

    worker = make_worker(prepare)
    worker.ask(1)
    assert messages(worker) == []


def test_a_job_leads_a_group_and_is_cancelled_with_it(make_worker):
    worker, group, pid = busy(make_worker)
    assert os.getpgid(pid) == group
    worker.cancel()
    wait_until(lambda: not is_running(group) and not is_running(pid))
    worker.ask(2)
    assert children(worker) != [group]


def test_one_that_is_stopped_leaves_nothing_behind(make_worker):
    worker, group, pid = busy(make_worker)
    os.kill(worker.pid, signal.SIGSTOP)
    worker.close()
    assert not is_running(group)
    assert not is_running(pid)


def test_another_job_makes_the_one_under_way_void(make_worker):
    def prepare(request, tell):
        if request == 1:
            signal.pause()
        return request

    worker = make_worker(prepare)
    worker.ask(1)
    (group,) = children(worker)
    worker.ask(2)
    assert messages(worker) == [2]
    assert not is_running(group)


def test_nothing_is_left_when_the_launcher_is_killed(tmp_path):
    program = f"""
import os, signal, subprocess, sys, time
from colcon_yamllaunch.watch.worker_link import WorkerLink

def prepare(request, tell):
    started = subprocess.Popen(['sleep', '1000'])
    with open({str(tmp_path / 'pids')!r}, 'w') as file:
        print(os.getppid(), os.getpid(), started.pid, file=file)
    signal.pause()

link = WorkerLink(prepare, lambda: None, lambda pid: None)
link.ask(1)
signal.pause()
"""
    launcher = subprocess.Popen(
        [sys.executable, '-c', program],
        env={'PYTHONPATH': ':'.join(sys.path), 'PATH': os.environ['PATH']},
    )
    file = tmp_path / 'pids'
    wait_until(lambda: file.exists() and file.read_text().endswith('\n'))
    pids = [int(word) for word in file.read_text().split()]
    launcher.kill()
    launcher.wait()
    wait_until(lambda: not any(map(is_running, pids)))
