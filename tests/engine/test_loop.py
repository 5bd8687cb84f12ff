# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Waiting for child processes and descriptors."""

from collections.abc import Iterator
import fcntl
import os
import resource
import signal
import socket
import subprocess

from colcon_yamllaunch.engine import loop
import pytest


@pytest.fixture
def start():
    """Return a function that starts a child that does nothing long."""
    children = []

    def begin():
        children.append(subprocess.Popen(['sleep', '99']))
        return children[-1]

    yield begin
    for child in children:
        child.kill()
        child.wait()


def test_each_child_is_told_once(start, wait_until):
    ours = [start(), start()]
    for child in ours:
        child.terminate()
    pids = {child.pid for child in ours}
    seen = []

    def all_ended():
        seen.extend(loop.ended_children(pids))
        return len(seen) == 2

    wait_until(all_ended)
    assert {pid for pid, _ in seen} == pids
    assert list(loop.ended_children(pids)) == []


def test_a_child_is_suspended_and_goes_on(start, wait_until):
    foreign, ours = start(), start()
    foreign.send_signal(signal.SIGSTOP)
    flags = os.WSTOPPED | os.WNOHANG | os.WNOWAIT
    wait_until(lambda: os.waitid(os.P_PID, foreign.pid, flags))
    ours.send_signal(signal.SIGSTOP)
    held = wait_until(lambda: list(loop.suspended_children({ours.pid})))
    assert held == [(ours.pid, signal.SIGSTOP)]
    assert list(loop.suspended_children({ours.pid})) == []
    ours.send_signal(signal.SIGCONT)
    held = wait_until(lambda: list(loop.suspended_children({ours.pid})))
    assert held == [(ours.pid, None)]
    assert os.waitid(os.P_PID, foreign.pid, flags) is not None


#: The first one that does not fit into an fd_set (select(2)).
HIGH = 1024


@pytest.fixture
def many_descriptors() -> Iterator[None]:
    """Allow more descriptors than `select` takes."""
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    if before[1] <= HIGH:
        pytest.skip('no process may have so many descriptors here')
    limits = max(before[0], HIGH + 64), before[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, limits)
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, before)


@pytest.mark.usefixtures('many_descriptors')
def test_a_high_descriptor() -> None:
    reader, writer = os.pipe()
    high = fcntl.fcntl(reader, fcntl.F_DUPFD, HIGH)
    try:
        assert loop.readable([high], 0.0) == []
        os.write(writer, b'x')
        assert loop.readable([high]) == [high]
    finally:
        for descriptor in (reader, writer, high):
            os.close(descriptor)


def test_what_is_ready_is_returned_and_so_is_an_end() -> None:
    first, second = socket.socketpair()
    third, fourth = socket.socketpair()
    with first, second, third:
        fourth.close()
        ends = [first.fileno(), second.fileno(), third.fileno()]
        assert loop.readable(ends) == [third.fileno()]
        second.send(b'x')
        assert set(loop.readable(ends)) == {first.fileno(), third.fileno()}
