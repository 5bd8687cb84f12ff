# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The one client that holds a launch: it acknowledges, and has a lease."""

import os
import signal
import time

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.control import journal as journal_module
from colcon_yamllaunch.control import subscription
from colcon_yamllaunch.control.client import ControlError, LaunchEndedError
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.protocol import MessageReader, ProtocolError
from colcon_yamllaunch.control.service import Subscribers
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.events import Output, Warned
import pytest
from support.controlled import answer_to

#: Writes 100,000 numbered lines when a file is there, then `done`.
TALKER = (
    'import os, sys, time\n'
    'while not os.path.exists(sys.argv[1]): time.sleep(0.01)\n'
    'for n in range(100):\n'
    '    lines = range(n * 1000, (n + 1) * 1000)\n'
    '    print("\\n".join(f"line {n}" for n in lines), flush=True)\n'
    'print("done", flush=True)\n'
    'time.sleep(99)\n'
)


def test_holder_receives_everything_once_over_many_connections(
    controlled, python, tmp_path
):
    ready = tmp_path / 'ready'
    talker = python('a', TALKER, output='own_log')
    talker['argv'].append(str(ready))
    c = controlled(talker)
    c.becomes('a', 'running')
    point, written, events = subscription.BEGINNING, b'', []
    connections = 0
    while not written.endswith(b'done\n'):
        connections += 1
        client = c.connect()
        client.subscribe(point, holder='test')
        for number, one in enumerate(client.events()):
            ready.touch()
            assert not isinstance(one, subscription.LostData)
            if isinstance(one, subscription.ReceivedOutput):
                written += one.data
            if isinstance(one, subscription.ReceivedEvent):
                events.append(one.name)
            if number == connections or written.endswith(b'done\n'):
                break
        point = client.point
        client.send_request('ping', bool, ack=point.as_json())
        client.close()
    assert written == c.one.log_folder.joinpath('a/stdout.log').read_bytes()
    assert written.count(b'\n') == 100_001
    assert events == ['started']
    assert point.bytes == len(written)
    assert connections > 3


def test_only_the_holder_acknowledges(idle):
    holder = _holder(idle, 'one')
    with pytest.raises(ControlError, match='another client holds'):
        idle.connect().subscribe(holder='other')
    now = holder.now.as_json()
    assert answer_to(holder, 'ping', ack=now)['ok']
    before = time.time()
    clock = answer_to(holder, 'ping')['clock']
    assert before <= clock <= time.time()
    other = _holder(idle, None)
    assert answer_to(other, 'ping')['ok']
    assert 'another' in answer_to(other, 'ping', ack=now)['error']
    # with another connection, it is the same one
    again = _holder(idle, 'one')
    assert 'another' in answer_to(holder, 'ping', ack=now)['error']
    assert answer_to(again, 'ping', ack=now)['ok']


def _holder(controlled, holder, **more):
    client = controlled.connect()
    client.subscribe(holder=holder, **more)
    return client


def test_expired_lease_stops_the_launch(controlled, sh):
    c = controlled(sh('a', 'sleep 99'), sh('b', 'setsid sleep 99'))
    c.becomes('a', 'running')
    news = _holder(c, 'test', lease=0.4)
    begin = time.monotonic()
    while time.monotonic() < begin + 1.2:
        assert answer_to(news, 'ping')['ok']
        time.sleep(0.05)
    # others do not renew it
    with pytest.raises(LaunchEndedError):
        while True:
            c.client.refresh()
            time.sleep(0.05)
    assert c.one.ends() == 0
    assert 'SIGTERM received' in c.one.screen


@pytest.mark.full
def test_hanging_launcher_is_killed_when_its_lease_expires(
    controlled, sh, wait_until
):
    c = controlled(
        sh('a', 'sleep 99', sigterm_timeout=0.1, sigkill_timeout=0.1)
    )
    pid = c.becomes('a', 'running').pid
    c.connect().subscribe(holder='test', lease=0.2)
    c.one.popen.send_signal(signal.SIGSTOP)
    wait_until(lambda: read_process(pid) is None)
    assert c.one.popen.wait() == -signal.SIGKILL
    wait_until(lambda: not os.listdir(c.folder))


def test_unacknowledged_events_and_output_are_kept(
    process, tmp_path, monkeypatch
):
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG_BYTES', 8)
    monkeypatch.setattr(limits, 'EVENT_BACKLOG_BYTES', 8)
    monkeypatch.setattr(limits, 'UNREAD_EVENT_BYTES', 8)
    journal = Journal(tmp_path, limit=100)
    subscribers = Subscribers(journal)
    one = process('a')

    def happens(number):
        journal.handle(Warned(f'event {number}'))
        journal.handle(Output(one, 'stdout', b'line %d\n' % number))

    cursor = subscribers.subscribe({'holder': 'test'}, None)
    happens(0)
    point = dict(journal.point)
    journal.unsubscribe(cursor)
    for number in range(1, 9):
        happens(number)
    again = subscribers.subscribe({'holder': 'test', 'since': point}, None)
    lines = journal.read(again, 1 << 20).splitlines()
    assert len(lines) == 16
    assert b'event 1' in lines[0]
    assert b'line 8' in lines[-1]
    subscribers.ping({'ack': journal.point}, again)
    # no more output than the logs may take, but all events
    for number in range(10, 40):
        happens(number)
    lines = journal.read(again, 1 << 20).splitlines()
    assert b'missed' in lines[0]
    assert sum(b'event' in line for line in lines) == 31
    assert b'line 39' in lines[-1]


def test_full_disk_loses_only_what_did_not_fit(process, tmp_path, monkeypatch):
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG_BYTES', 8)
    monkeypatch.setattr(limits, 'JOURNAL_FILE_BYTES', 1)
    journal = Journal(tmp_path)
    subscribers = Subscribers(journal)
    one = process('a')
    cursor = subscribers.subscribe({'holder': 'test'}, None)
    room = journal_module._nameless_file

    def full(_folder):
        raise OSError

    for number in range(12):
        is_full = 4 <= number < 8
        monkeypatch.setattr(
            journal_module, '_nameless_file', full if is_full else room
        )
        journal.handle(Output(one, 'stdout', b'line %2d\n' % number))
    messages = [*MessageReader().feed(journal.read(cursor, 1 << 20))]
    (missed,) = (m['missed'] for m in messages if 'missed' in m)
    text = ''.join(m['output']['data'] for m in messages if 'output' in m)
    seen = [int(line.split()[1]) for line in text.splitlines()]
    assert seen == [n for n in range(12) if n in seen]
    assert {0, 1, 2, 9, 10, 11} <= {*seen}
    assert missed['bytes'] == 8 * (12 - len(seen)) > 0


def test_raw_output_follows_its_line(process):
    journal = Journal()
    cursor = Subscribers(journal).subscribe({'raw': True}, None)
    journal.handle(Output(process('a'), 'stderr', b'\xff\nb\n'))
    line, _, data = journal.read(cursor, 1 << 20).partition(b'\n')
    assert line.startswith(b'{"output":{"process":"a","stream":"stderr",')
    assert line.endswith(b'"at":0,"bytes":4}}')
    assert data == b'\xff\nb\n'


def test_lease_is_renewed_by_its_holder_only():
    renewed, now = [], [0.0]
    subscribers = Subscribers(Journal(), renewed.append, clock=lambda: now[0])
    other = subscribers.subscribe({}, None)
    holder = subscribers.subscribe({'holder': 'a', 'lease': 8}, None)
    for seconds in (0.5, 1.0, 1.5, 2.0):
        now[0] = seconds
        subscribers.heard(holder)
        subscribers.heard(other)
    assert renewed == [8.0] * 3
    subscribers.subscribe({'holder': 'a'}, None)
    subscribers.heard(holder)
    assert renewed == [8.0] * 3 + [None]


@pytest.mark.parametrize(
    ('message', 'error'),
    [
        ({'holder': 7}, ProtocolError),
        ({'holder': 'a', 'lease': 0}, ProtocolError),
        ({'holder': 'a', 'lease': True}, ProtocolError),
        ({'holder': 'a', 'lease': 1e9}, ProtocolError),
        ({'lease': 1}, ProtocolError),
        ({'behind': -1}, ProtocolError),
        ({'behind': 1.5}, ProtocolError),
        ({'raw': 1}, ProtocolError),
        ({'processes': [7]}, ProtocolError),
        ({'holder': 'b'}, RefusedError),
    ],
)
def test_malformed_subscription_changes_nothing(message, error):
    journal = Journal()
    subscribers = Subscribers(journal)
    holder = subscribers.subscribe({'holder': 'a'}, None)
    with pytest.raises(error):
        subscribers.subscribe(message, None)
    assert subscribers.is_holder(holder)
    for point in ({}, {'events': 1, 'bytes': 0}, 'now'):
        with pytest.raises(ProtocolError):
            subscribers.ping({'ack': point}, holder)
