# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is kept for clients that subscribe; there is no launch here."""

import json

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.backlog import Backlog
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.events import Output
from colcon_yamllaunch.engine.events import StillRunning
from colcon_yamllaunch.engine.events import Warned
import pytest

BEGINNING = {'events': 0, 'bytes': 0}


class Told:
    """A backlog, and what a client of it is told."""

    def __init__(self, process):
        self.backlog = Backlog(now=lambda: 1732000000.5)
        self.process = process('a')

    def says(self, *texts):
        for text in texts:
            self.backlog.handle(Warned(text))

    def writes(self, *pieces, process=None):
        for data in pieces:
            one = process or self.process
            self.backlog.handle(Output(one, 'stdout', data))

    def cursor(self, since=BEGINNING, events=True, output=True, **more):
        return self.backlog.cursor(
            since, wants_events=events, wants_output=output, **more
        )

    def read(self, cursor, room=1 << 20):
        lines = self.backlog.read(cursor, room).splitlines()
        return [short(json.loads(line)) for line in lines]


def short(message):
    if 'event' in message:
        return message['event']['text']
    if 'output' in message:
        return protocol.bytes_of(message['output']['data'])
    return message['missed']


@pytest.fixture
def told(process):
    return Told(process)


def test_all_is_told_in_its_order(told):
    told.writes(b'one\n')
    told.says('first')
    cursor = told.cursor()
    assert told.read(cursor) == [b'one\n', 'first']
    assert not told.backlog.has_more(cursor)
    told.says('second')
    told.writes(b'two\n', b'\xff\n')
    assert told.backlog.has_more(cursor)
    assert told.read(cursor) == ['second', b'two\n', b'\xff\n']
    assert told.backlog.point == {'events': 2, 'bytes': 10}


def test_each_message_has_all_of_it(told):
    told.says('first')
    told.writes(b'one\n')
    event, output = map(
        json.loads, told.backlog.read(told.cursor(), 999).splitlines()
    )
    time = 1732000000.5
    assert event['event'] == {
        'time': time,
        'event': 'warning',
        'text': 'first',
    }
    assert output['output'] == {
        'process': 'a',
        'stream': 'stdout',
        'data': 'one\n',
        'time': time,
        'at': 0,
    }


def test_what_is_not_in_the_log_of_events_is_no_event(told):
    told.backlog.handle(StillRunning(('a',), 0, 2))
    assert told.backlog.point == BEGINNING


def test_a_client_begins_where_it_likes(told):
    told.says('first', 'second')
    told.writes(b'one\n', b'two\n')
    assert told.read(told.cursor(None)) == []
    since = {'events': 1, 'bytes': 6}
    assert told.read(told.cursor(since)) == ['second', b'o\n']


def test_a_client_is_told_only_what_it_wants(told):
    told.says('first')
    told.writes(b'one\n')
    for kind, expected in (('events', [b'one\n']), ('output', ['first'])):
        cursor = told.cursor(**{kind: False})
        assert told.read(cursor) == expected
        assert not told.backlog.has_more(cursor)


def test_a_client_may_want_the_output_of_some_processes_only(
    told, process, monkeypatch
):
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG', 8)
    quiet = process('quiet')
    cursor = told.cursor(labels={'quiet'})
    for _ in range(9):
        told.writes(b'flood\n')
        assert not told.backlog.has_more(cursor)
    told.says('first')
    told.writes(b'A\n', process=quiet)
    told.writes(b'flood\n')
    assert told.backlog.has_more(cursor)
    assert told.read(cursor) == ['first', b'A\n']
    # from there on, it may want others, or begin elsewhere
    told.writes(b'one\n')
    assert told.read(told.cursor(None, before=cursor)) == [b'one\n']
    told.writes(b'B\n', process=quiet)
    nobody = told.cursor(None, labels=(), before=cursor)
    assert not told.backlog.has_more(nobody)
    since = {'events': 1, 'bytes': 66}
    again = told.cursor(since, labels={'quiet'}, before=nobody)
    assert told.read(again) == [b'B\n']


def test_what_is_missed_is_counted_exactly(told, monkeypatch):
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG', 8)
    cursor, deaf = told.cursor(), told.cursor(output=False)
    told.writes(b'one\n', b'two\n')
    told.says('first')
    assert told.read(cursor, room=1) == [b'one\n']
    told.writes(b'three\n')
    told.says('second')
    assert told.read(cursor) == [
        {'events': 0, 'bytes': 4},
        'first',
        b'three\n',
        'second',
    ]
    assert told.read(deaf) == ['first', 'second']
    # longer than there is room
    told.writes(b'four, five\n')
    assert told.backlog.has_more(cursor)
    assert told.read(cursor) == [{'events': 0, 'bytes': 11}]
    assert not told.backlog.has_more(cursor)


def test_events_have_room_of_their_own(told, monkeypatch):
    monkeypatch.setattr(limits, 'EVENT_BACKLOG', 150)
    told.says('first', 'second', 'third')
    monkeypatch.setattr(limits, 'OUTPUT_PIECES', 1)
    told.writes(b'one\n', b'two\n')
    assert told.read(told.cursor()) == [
        {'events': 1, 'bytes': 4},
        'second',
        'third',
        b'two\n',
    ]


def test_long_output_comes_in_pieces_that_end_with_lines(told, monkeypatch):
    monkeypatch.setattr(protocol, 'MAXIMUM_OUTPUT', 8)
    told.writes(b'one\ntwo\nthree\n', b'0123456789')
    assert told.read(told.cursor()) == [
        b'one\ntwo\n',
        b'three\n',
        b'01234567',
        b'89',
    ]


def test_who_has_come_to_the_end_is_called_once(told):
    called = []
    told.backlog.call(lambda: called.append(1))
    told.says('first')
    told.writes(b'one\n')
    assert called == [1]


@pytest.mark.parametrize(
    'since',
    [
        7,
        'now',
        [],
        {},
        {'events': 0},
        {'events': 0, 'bytes': -1},
        {'events': 1, 'bytes': 0},
        {'events': True, 'bytes': 0},
        {'events': 0, 'bytes': 0.0},
    ],
)
def test_a_point_that_is_none_is_refused(told, since):
    with pytest.raises(protocol.ProtocolError, match="'since' is"):
        told.cursor(since)
