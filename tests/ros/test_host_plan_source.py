# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the host of launch files in Python is told of a launch that runs."""

from collections import deque
import signal

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.plan_source import PlanSource
from colcon_yamllaunch.language.evaluation.launch_host import HostError
from colcon_yamllaunch.plan.plan import Growth
from colcon_yamllaunch.plan.plan import Message
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.ros.host_plan_source import HostPlanSource
import pytest

POSITION = Position('/ws/a.launch.py', 7, 9)
TALKER = Process('kitchen', ('t',), '/', POSITION, name='talker-1')
OTHER = Process('other', ('o',), '/', POSITION, name='o-2')


class PlayedLink:
    """A link whose host says what the test has it say."""

    def __init__(self):
        self.says = deque()
        self.descriptor = 7
        self.pid = 4711
        self.is_closed = self.is_full = False

    def poll(self):
        message = self.says.popleft() if self.says else None
        if isinstance(message, Exception):
            raise message
        return message

    def flush(self):
        return not self.is_full

    def reaped(self):
        self.pid = 0

    def close(self):
        self.is_closed = True


class PlayedGrowing:
    """Makes a message of each `done`; it knows one process, as 17."""

    def __init__(self):
        self.has_handlers = True
        self.wants_output = frozenset(['talker-1'])
        self.asked = []
        self.is_gone = False

    @property
    def is_busy(self):
        return bool(self.asked)

    def id_of(self, name):
        return {'talker-1': 17}.get(name)

    def ask(self, request):
        if self.is_gone:
            raise HostError('ended')
        self.asked.append(request)

    def take(self, message):
        if message['say'] != 'done':
            return None
        return Growth((Message('INFO', str(message['id'])),))

    def lost(self, reason):
        return Growth((), problems=(reason,) if reason else ())


class Played:
    def __init__(self):
        self.link = PlayedLink()
        self.growing = PlayedGrowing()
        self.source: PlanSource = HostPlanSource(self.link, self.growing, 99)

    def told(self, event):
        """Return what the host is told of an event."""
        self.growing.asked.clear()
        self.source.handle(event)
        return [r['event'] for r in self.growing.asked]

    def texts(self, growths):
        return [e.text for g in growths for e in g.entries]


@pytest.fixture
def played():
    return Played()


def test_what_happens_to_its_processes(played):
    assert played.told(events.Started(TALKER, 12)) == [
        {'type': 'start', 'process': 17, 'pid': 12}
    ]
    ended = [
        (Outcome(code=3), None, 3, False),
        (Outcome(signal=signal.SIGINT), 0.0, -2, True),
    ]
    for outcome, delay, returncode, respawns in ended:
        event = events.Exited(TALKER, 12, outcome, 1.0, False, True, delay)
        assert played.told(event) == [
            {
                'type': 'exit',
                'process': 17,
                'returncode': returncode,
                'respawns': respawns,
                'asked': False,
            }
        ]
    assert played.told(events.Started(OTHER, 13)) == []
    assert played.told(events.Warned('trouble')) == []


def test_a_restart_after_a_change_is_no_end(played):
    outcome = Outcome(signal=signal.SIGINT)
    ended = events.Exited(TALKER, 12, outcome, 1.0, True, False, None)
    changed = events.Requested(TALKER, 'change')
    assert played.told(changed) == []
    assert played.told(ended) == []
    # another change before it has begun anew
    assert played.told(changed) == []
    assert played.told(events.Started(TALKER, 13)) == []
    # one that ended before begins anew for all
    assert played.told(changed) == []
    assert len(played.told(events.Started(TALKER, 14))) == 1
    # what makes an end of it after all is told with it
    assert played.told(changed) == []
    assert played.told(ended) == []
    (told,) = played.told(events.Requested(TALKER, 'stop'))
    assert told['type'] == 'exit'
    assert played.told(changed) == []
    assert played.told(events.Requested(TALKER, 'stop')) == []
    assert len(played.told(ended)) == 1


def test_what_they_write(played):
    played.source.output('talker-1', 'stderr', b'one\xff\n')
    played.source.output('o-2', 'stderr', b'two\n')
    assert [r['event'] for r in played.growing.asked] == [
        {
            'type': 'output',
            'process': 17,
            'stream': 'stderr',
            'text': 'one\N{REPLACEMENT CHARACTER}\n',
        }
    ]


def test_states_while_somebody_waits_for_something(played):
    event = events.StateChanged(OTHER, '/lc', 'inactive', 'configuring')
    assert played.told(event) == [
        {
            'type': 'state',
            'node': '/lc',
            'from': 'configuring',
            'to': 'inactive',
        }
    ]
    played.growing.has_handlers = False
    assert played.told(event) == []


def test_the_end_of_the_launch(played):
    assert played.told(events.ShuttingDown('interrupted', True)) == [
        {'type': 'shutdown', 'reason': 'interrupted', 'by_sigint': True}
    ]


def test_calls(played):
    played.source.call(3)
    assert played.growing.asked == [{'do': 'call', 'number': 3}]
    assert played.source.is_busy


def test_what_the_host_has_not_taken_is_sent_later(played):
    assert played.source.flush()
    played.link.is_full = True
    assert not played.source.flush()


def test_answers_come_in_order(played):
    played.link.says += [
        {'say': 'message'},
        {'say': 'done', 'id': 1},
        {'say': 'done', 'id': 2},
    ]
    assert played.texts(played.source.take()) == ['1', '2']
    assert played.source.take() == []


def test_the_last_words_of_a_host_that_ended_count(played):
    played.link.says.append({'say': 'done', 'id': 1})
    assert played.texts(played.source.ended(9)) == ['1']
    assert played.source.pid == 0
    played.growing.is_gone = True
    assert played.told(events.Started(TALKER, 12)) == []


def test_a_host_that_cannot_be_read_is_a_problem(played):
    played.link.says += [{'say': 'done', 'id': 1}, HostError('ended oddly')]
    growths = played.source.take()
    assert played.texts(growths) == ['1']
    assert growths[-1].problems == ('ended oddly',)


def test_it_is_closed(played):
    played.source.close()
    assert played.link.is_closed
