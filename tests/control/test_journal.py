# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is kept for clients that subscribe; there is no launch here."""

import json
import os

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.journal import Cursor, Journal
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.events import Output, StillRunning, Warned
import pytest

BEGINNING = {'events': 0, 'bytes': 0}


class Told:
    """A journal, and what a client of it is told."""

    def __init__(self, process, tmp_path):
        self.journal = Journal(tmp_path, now=lambda: 1732000000.5)
        self.process = process('a')

    def says(self, *texts):
        for text in texts:
            self.journal.handle(Warned(text))

    def writes(self, *pieces, process=None):
        for data in pieces:
            one = process or self.process
            self.journal.handle(Output(one, 'stdout', data))

    def cursor(
        self, since=BEGINNING, events=True, output=True, before=None, **more
    ):
        cursor = Cursor(wants_events=events, wants_output=output, **more)
        return self.journal.subscribe(cursor, since, before)

    def read(self, cursor, room=1 << 20):
        lines = self.journal.read(cursor, room).splitlines()
        return [short(json.loads(line)) for line in lines]


def short(message):
    if 'event' in message:
        return message['event']['text']
    if 'output' in message:
        return protocol.bytes_of(message['output']['data'])
    return message['missed']


def opened_files():
    return len(os.listdir('/proc/self/fd'))


@pytest.fixture
def told(process, tmp_path, monkeypatch):
    # each piece by itself
    monkeypatch.setattr(limits, 'JOURNAL_MERGE_SECONDS', 0)
    return Told(process, tmp_path)


def test_events_and_output_are_read_in_order(told):
    told.writes(b'one\n')
    told.says('first')
    cursor = told.cursor()
    assert told.read(cursor) == [b'one\n', 'first']
    assert not told.journal.has_more(cursor)
    told.says('second')
    told.writes(b'two\n', b'\xff\n')
    assert told.journal.has_more(cursor)
    assert told.read(cursor) == ['second', b'two\n', b'\xff\n']
    assert told.journal.point == {'events': 2, 'bytes': 10}


def test_messages_have_all_fields(told):
    told.says('first')
    told.writes(b'one\n')
    lines = told.journal.read(told.cursor(), 999).splitlines()
    event, output = map(json.loads, lines)
    time = {'time': 1732000000.5}
    assert event['event'] == {**time, 'event': 'warning', 'text': 'first'}
    where = {'process': 'a', 'stream': 'stdout', 'at': 0}
    assert output['output'] == {**where, **time, 'data': 'one\n'}


def test_unrecorded_event_is_not_kept(told):
    told.journal.handle(StillRunning(('a',), 0, 2))
    assert told.journal.point == BEGINNING


def test_cursor_begins_at_any_point(told):
    told.says('first', 'second')
    told.writes(b'one\n', b'two\n')
    assert told.read(told.cursor(None)) == []
    since = {'events': 1, 'bytes': 6}
    assert told.read(told.cursor(since)) == ['second', b'o\n']


def test_cursor_without_output_or_events_skips_them(told):
    told.says('first')
    told.writes(b'one\n')
    for kind, expected in (('events', [b'one\n']), ('output', ['first'])):
        cursor = told.cursor(**{kind: False})
        assert told.read(cursor) == expected
        assert not told.journal.has_more(cursor)


def test_cursor_with_labels_skips_other_output(told, process, monkeypatch):
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG_BYTES', 8)
    quiet = process('quiet')
    cursor = told.cursor(labels={'quiet'})
    for _ in range(9):
        told.writes(b'flood\n')
        assert not told.journal.has_more(cursor)
    told.says('first')
    told.writes(b'A\n', process=quiet)
    told.writes(b'flood\n')
    assert told.journal.has_more(cursor)
    assert told.read(cursor) == ['first', b'A\n']
    # from there on, it may want others, or begin elsewhere
    told.writes(b'one\n')
    assert told.read(told.cursor(None, before=cursor)) == [b'one\n']
    told.writes(b'B\n', process=quiet)
    nobody = told.cursor(None, labels=(), before=cursor)
    assert not told.journal.has_more(nobody)
    since = {'events': 1, 'bytes': 66}
    again = told.cursor(since, labels={'quiet'}, before=nobody)
    assert told.read(again) == [b'B\n']


def test_lost_output_is_counted_exactly(told, monkeypatch):
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG_BYTES', 8)
    cursor, deaf = told.cursor(behind=0), told.cursor(output=False)
    told.writes(b'one\n')
    told.says('first')
    assert told.read(cursor, room=1) == [b'one\n']
    told.writes(b'two\n')
    told.says('second')
    told.writes(b'three\n')
    told.says('third')
    missed, *rest = told.read(cursor)
    assert missed == {'events': 0, 'bytes': 4}
    assert rest == ['first', 'second', b'three\n', 'third']
    assert told.read(deaf) == ['first', 'second', 'third']
    # longer than there is room
    told.writes(b'four, five\n')
    assert told.journal.has_more(cursor)
    assert told.read(cursor) == [{'events': 0, 'bytes': 11}]
    assert not told.journal.has_more(cursor)


def test_lagging_cursor_reads_output_from_files(told, process, monkeypatch):
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG_BYTES', 8)
    monkeypatch.setattr(limits, 'EVENT_BACKLOG_BYTES', 150)
    monkeypatch.setattr(limits, 'JOURNAL_FILE_BYTES', 100)
    files = opened_files()
    quiet = process('quiet')
    cursor = told.cursor()
    late, some = told.cursor(), told.cursor(labels={'quiet'})
    expected = []
    for number in range(40):
        told.says(f'event {number}')
        told.writes(b'line %d\n' % number)
        told.writes(b'q%d\n' % number, process=quiet)
        expected += [f'event {number}', b'line %d\n' % number]
        expected += [b'q%d\n' % number]
        if number == 20:
            assert told.read(cursor) == expected
            began = len(expected)
    assert opened_files() > files
    assert told.read(cursor) == expected[began:]
    assert told.read(late, room=1) == expected[:1]
    # whoever comes later gets what is still there
    latest = told.cursor()
    assert told.read(latest) == expected
    assert told.read(late) == expected[1:]
    assert told.read(some) == [
        one for one in expected if isinstance(one, str) or one[:1] == b'q'
    ]
    for one in (cursor, late, latest, some):
        told.journal.unsubscribe(one)
    told.writes(b'a longer line\n')
    assert opened_files() == files


def test_cursor_too_far_behind_continues_with_latest_output(told, monkeypatch):
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG_BYTES', 8)
    files = opened_files()
    cursor, other = told.cursor(behind=21), told.cursor(behind=60)
    for number in range(4):
        told.writes(b'line %d\n' % number)
    assert told.read(cursor, room=1) == [b'line 0\n']
    for number in range(4, 7):
        told.writes(b'line %d\n' % number)
    told.says('first')
    missed = {'events': 0, 'bytes': 35}
    assert told.read(cursor) == [missed, b'line 6\n', 'first']
    assert told.read(other, room=1) == [b'line 0\n']
    told.writes(b'one line that is longer than the client may be behind\n')
    told.writes(b'more\n')
    assert told.read(other) == [{'events': 0, 'bytes': 96}, 'first', b'more\n']
    told.writes(b'once\n', b'more\n')
    told.journal.unsubscribe(cursor)
    assert told.read(other) == [b'once\n', b'more\n']
    told.writes(b'more\n')
    assert opened_files() == files


def test_output_that_comes_together_is_merged(told, process, monkeypatch):
    monkeypatch.setattr(limits, 'JOURNAL_MERGE_SECONDS', 0.005)
    monkeypatch.setattr(protocol, 'MAXIMUM_OUTPUT', 10)
    told.writes(b'one\n', b'two\n')
    cursor = told.cursor()
    assert told.read(cursor) == [b'one\ntwo\n']
    told.writes(b'3\n', b'four\n')
    assert told.read(cursor) == [b'3\n', b'four\n']
    told.writes(b'5\n', process=process('b'))
    told.writes(b'6\n')
    told.says('first')
    told.writes(b'7\n')
    assert told.read(cursor) == [b'5\n', b'6\n', 'first', b'7\n']


def test_journal_without_cursors_writes_no_file(told, monkeypatch):
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG_BYTES', 8)
    files = opened_files()
    told.cursor(output=False)
    told.writes(*[b'one more line\n'] * 9)
    assert opened_files() == files


def test_output_does_not_displace_events(told, monkeypatch):
    monkeypatch.setattr(limits, 'EVENT_BACKLOG_BYTES', 150)
    told.says('first', 'second', 'third')
    monkeypatch.setattr(limits, 'OUTPUT_BACKLOG_PIECES', 1)
    told.writes(b'one\n', b'two\n')
    missed, *rest = told.read(told.cursor())
    assert missed == {'events': 1, 'bytes': 4}
    assert rest == ['second', 'third', b'two\n']


def test_long_output_is_split_at_line_ends(told, monkeypatch):
    monkeypatch.setattr(protocol, 'MAXIMUM_OUTPUT', 8)
    told.writes(b'one\ntwo\nthree\n', b'0123456789')
    pieces = [b'one\ntwo\n', b'three\n', b'01234567', b'89']
    assert told.read(told.cursor()) == pieces


def test_callback_is_called_once(told):
    called = []
    told.journal.call(lambda: called.append(1))
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
def test_invalid_point_is_refused(told, since):
    with pytest.raises(protocol.ProtocolError, match="'since' is"):
        told.cursor(since)
