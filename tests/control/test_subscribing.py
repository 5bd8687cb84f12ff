# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Real launches, and clients that are told what happens in them."""

from collections import defaultdict
import json
import os
import signal
import socket

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.client import ControlError, LaunchEndedError
from colcon_yamllaunch.control.subscription import (
    BEGINNING,
    LostData,
    Point,
    ReceivedEvent,
    ReceivedOutput,
)
from colcon_yamllaunch.engine import commands
import pytest
from support.controlled import answer_to, idles, memory_of

#: Stands for gdb: takes a command, then runs the program.
GDB = (
    '#!/bin/sh\n'
    'echo "gdb $*"\n'
    'read command\n'
    'echo "got $command"\n'
    'shift 2\n'
    'exec "$@"\n'
)
#: Writes 8 MB and a bit when a file is there.
TALKER = (
    'import os, sys, time\n'
    'while not os.path.exists(sys.argv[1]): time.sleep(0.01)\n'
    'for _ in range(1000): os.write(1, b"x" * 8191 + b"\\n")\n'
    'os.write(1, b"done\\n")\n'
    'time.sleep(99)\n'
)
TALK = 1000 * 8192 + 5


def subscribed(client, since=None, **more):
    client.subscribe(since, **more)
    return client


def news_of(client, until=None):
    """Return what is received up to one, or to the end of the launch."""
    found = []
    try:
        for one in client.events():
            found.append(one)
            if until is not None and until(one):
                break
    except LaunchEndedError:
        assert until is None
    return found


def size_of(news):
    """Return how many bytes were written, or missed."""
    return sum(
        len(one.data) if isinstance(one, ReceivedOutput) else one.bytes
        for one in news
        if isinstance(one, ReceivedOutput | LostData)
    )


def test_subscriber_receives_everything_to_the_end(controlled, sh):
    c = controlled(
        sh('a', 'printf "one\\ntwo"; echo three >&2; exit 3'),
        sh('b', 'trap "" INT; echo up; sleep 99'),
    )
    c.becomes('a', 'ended')
    c.one.shows('[b]      up')
    before = subscribed(c.client, BEGINNING)
    assert [p.label for p in before.state.processes] == ['a', 'b']
    after = subscribed(c.connect(), output=False)
    assert after.now == after.point == before.now
    responses = []
    before.ask(commands.Kill('b'), responses.append)
    news = news_of(before)
    # by then the logs are written
    assert c.one.ends() == 1
    assert responses == [commands.DONE]
    events = [one.fields for one in news if isinstance(one, ReceivedEvent)]
    lines = c.one.log('events.jsonl').splitlines()
    recorded = [untimed(json.loads(line)) for line in lines]
    assert list(map(untimed, events)) == recorded
    assert events[-1]['event'] == 'ended'
    assert events[-1]['exit_code'] == 1
    assert events[0]['time'] > 1.7e9
    written = defaultdict(bytes)
    for one in news:
        if isinstance(one, ReceivedOutput):
            written[one.process, one.stream] += one.data
    assert written == {
        ('a', 'stderr'): b'three\n',
        ('a', 'stdout'): b'one\ntwo',
        ('b', 'stdout'): b'up\n',
    }
    assert before.point == Point(len(events), size_of(news))
    # who came later was told the rest
    names = [one.name for one in news_of(after)]
    assert names == [e['event'] for e in events[after.now.events :]]
    assert 'requested' in names


def untimed(record):
    return {**record, 'time': 0}


def test_subscriber_can_send_requests(idle):
    news = subscribed(idle.connect(), events=False)
    answer = answer_to(news, 'stop', member='x')
    assert answer['error'] == "there is no process 'x'"
    description = answer_to(news, 'describe', member='a')['description']
    assert description['argv'] == ['sleep', '9999']
    assert description['position'] == '/ws/demo.yaml:14:5'
    assert (description['cwd'], description['environment']) == ('/', {})
    (branch,) = answer_to(news, 'tree')['tree']
    assert (branch['kind'], branch['title']) == ('process', 'a')
    refused = answer_to(news, 'attach', process='a')['error']
    assert 'another connection' in refused
    assert answer_to(news, 'status')['launch']['title']
    refused = answer_to(news, 'watch', action='pause')['error']
    assert refused == 'no files are watched; that is --watch'
    # a second time takes the place of the first
    answers, received = [], []
    news.send_request('subscribe', answers.append, since=BEGINNING.as_json())
    while not received:
        news.read()
        received += news.received()
    assert answers[0]['now'] == news.now.as_json()
    assert received[0].name == 'started'


@pytest.mark.parametrize(
    'message',
    [
        {'request': 'status', 'id': []},
        {'request': 'subscribe', 'since': 7},
        {'request': 'subscribe', 'output': 'yes'},
        {'request': 'subscribe', 'processes': 'a'},
        {'request': 'watch', 'action': 'off'},
        {'request': 'dance', 'id': 1},
        {'request': 'kill'},
    ],
)
def test_malformed_request_ends_only_the_subscription(idle, message):
    client = idle.connect()
    client.subscribe()
    client.send({'version': protocol.VERSION, **message})
    with pytest.raises(LaunchEndedError):
        for _ in client.events():
            pass
    assert idle.process('a').phase == 'running'


def test_half_closed_subscriber_still_receives_events(controlled, sh):
    c = controlled(sh('a', 'sleep 99'))
    c.becomes('a', 'running')
    c.client.subscribe()
    c.client.connection.shutdown(socket.SHUT_WR)
    c.one.sends(signal.SIGINT)
    assert news_of(c.client)[-1].name == 'ended'


def test_state_of_a_client_follows_the_events(controlled, sh):
    c = controlled(sh('a', 'sleep 99'), sh('b', 'sleep 99'))
    c.becomes('b', 'running')
    client = subscribed(c.client, states=True)
    client.ask(commands.Kill('b'))
    ended = news_of(client, lambda one: getattr(one, 'name', '') == 'exited')
    assert ended[-1].fields['label'] == 'b'
    list(client.received())
    while client.state.process('b').phase != 'ended':
        client.read()
        list(client.received())
    assert client.state.process('b').ending == 'stopped'
    c.one.sends(signal.SIGINT)
    news_of(client)
    assert client.state.exit_code == 0
    assert {p.phase for p in client.state.processes} == {'ended'}


@pytest.mark.full
def test_slow_subscribers_cost_no_time_and_memory(
    controlled, python, tmp_path
):
    ready = tmp_path / 'ready'
    talker = python('a', TALKER, output='own_log')
    talker['argv'].append(str(ready))
    c = controlled(talker)
    c.becomes('a', 'running')
    pid = c.one.popen.pid
    reader = subscribed(c.client)
    deaf = [c.connect() for _ in range(protocol.MAXIMUM_CLIENTS - 1)]
    deaf = [subscribed(client) for client in deaf]
    before = memory_of(pid)
    ready.touch()
    read = news_of(
        reader,
        lambda one: isinstance(one, ReceivedOutput) and b'done\n' in one.data,
    )
    assert size_of(read) == TALK
    # the log is complete, whatever they do
    assert len(c.one.log('a/stdout.log')) == TALK
    assert memory_of(pid) - before < 16_000_000
    # those that die are forgotten
    for one in deaf[1:]:
        one.close()
    assert answer_to(reader, 'status')['ok']
    assert idles(pid)
    c.one.sends(signal.SIGINT)
    late = news_of(deaf[0])
    c.one.ends()
    logs = [c.one.log(f'a/{name}.log') for name in ('stdout', 'stderr')]
    assert size_of(late) == sum(map(len, logs)) >= TALK
    assert any(isinstance(one, LostData) for one in late)
    assert late[-1].name == 'ended'


@pytest.mark.full
def test_a_process_is_started_under_a_debugger_once(controlled, sh, tmp_path):
    (tmp_path / 'gdb').write_text(GDB)
    (tmp_path / 'gdb').chmod(0o755)
    c = controlled(
        sh('a', 'echo begun; sleep 99'),
        environment={'PATH': f'{tmp_path}:{os.environ["PATH"]}'},
    )
    c.one.shows('  begun')
    c.client.do(commands.Debug('a'))
    c.wait_until(lambda: c.process('a').terminal)
    typist = c.connect()
    typist.request('attach', process='a')
    typist.send({'keys': 'run\r'})
    c.one.shows('gdb -q --args sh -c echo').shows('got run')
    c.wait_until(lambda: c.one.screen.count('  begun') == 2)
    assert c.process('a').restarts == 1
    c.client.do(commands.Restart('a'))
    c.wait_until(lambda: c.process('a').restarts == 2)
    with pytest.raises(ControlError, match='emulate_tty'):
        c.client.request('attach', process='a')
    actions = [e['action'] for e in c.one.events('requested')]
    assert actions == ['debug', 'restart']
