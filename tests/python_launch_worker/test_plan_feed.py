# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the worker of Python launch files is told, and what it answers."""

from collections import deque
import os
import signal
from types import SimpleNamespace

from colcon_yamllaunch.engine import commands, events, limits
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.language.evaluation.request import WorkerError
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.plan import plan
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.python_launch.plan_feed import PlanFeed
from colcon_yamllaunch.python_launch.worker_process import NUMBER
import pytest
from support.test_loop import TestLoop

POSITION = Position('/ws/a.launch.py', 7, 9)
TALKER = plan.Process('kitchen', ('t',), '/', POSITION, name='talker-1')
OTHER = plan.Process('other', ('o',), '/', POSITION, name='o-2')
WORKER = 4711
IDLE = {'type': 'shutdown', 'reason': 'idle', 'by_sigint': False}


class PlayedLink:
    """A link whose worker says what the test has it say."""

    def __init__(self):
        self.says = deque()
        self.descriptor, self.answers = os.pipe()
        self.pid = WORKER
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
        self.pid = 0


class PlayedGrowing:
    """Knows one process, as 17; each message is what comes to the plan."""

    def __init__(self):
        self.has_handlers = True
        self.wants_output = frozenset(['talker-1'])
        self.asked = []
        self.is_busy = self.is_gone = False

    def id_of(self, name):
        return {'talker-1': 17}.get(name)

    def ask(self, request):
        if self.is_gone:
            raise WorkerError('ended')
        self.asked.append(request)

    def handle(self, message):
        return message

    def lost(self, reason):
        self.is_gone = True
        self.is_busy = False
        return plan.Growth((), problems=(reason,) if reason else ())


class Launch:
    """A feed, and what it has done to the launch."""

    def __init__(self):
        self.link = PlayedLink()
        self.growing = PlayedGrowing()
        self.loop = TestLoop()
        self.done = []
        self.blocks = ()
        self.helpers = {}
        self.settled = list
        self.feed = PlanFeed(
            self.link, self.growing, lambda found: self.settled(found)
        )
        self.feed.join(self)
        self.feed.begin()

    # what it does to the launch

    @property
    def dispatcher(self):
        return SimpleNamespace(
            do=lambda command: self.done.append(list(command.entries))
        )

    def emit(self, event):
        self.done.append(event)

    def add_helper(self, pid, ended, number):
        assert number == NUMBER
        self.helpers[pid] = ended

    def remove_helper(self, pid):
        del self.helpers[pid]

    # what happens

    def answers(self, *messages):
        self.link.says.extend(messages)
        os.write(self.link.answers, b'.')
        self.loop.turn(1)

    def told(self, event):
        """Return the message that the worker gets about an event."""
        self.growing.asked.clear()
        if isinstance(event, events.Output):
            self.feed.handle_output(event)
        else:
            self.feed.handle(event)
        return [request['event'] for request in self.growing.asked]

    def close(self):
        self.feed.close()
        self.loop.close()
        os.close(self.link.descriptor)
        os.close(self.link.answers)


@pytest.fixture
def launch():
    made = Launch()
    yield made
    made.close()


def test_starts_and_ends_of_its_processes_are_told(launch):
    assert launch.told(events.Started(TALKER, 12)) == [
        {'type': 'start', 'process': 17, 'pid': 12}
    ]
    ended = [
        (Outcome(code=3), None, 3, False),
        (Outcome(signal=signal.SIGINT), 0.0, -2, True),
        (Outcome(lost='arm'), None, -9, False),
    ]
    for outcome, delay, returncode, respawns in ended:
        event = events.Exited(TALKER, 12, outcome, 1.0, False, True, delay)
        (told,) = launch.told(event)
        assert told == {
            'type': 'exit',
            'process': 17,
            'asked': False,
            'returncode': returncode,
            'respawns': respawns,
        }
    assert launch.told(events.Started(OTHER, 13)) == []
    assert launch.told(events.Warned('trouble')) == []


def test_a_restart_after_a_change_is_no_end(launch):
    outcome = Outcome(signal=signal.SIGINT)
    ended = events.Exited(TALKER, 12, outcome, 1.0, True, False, None)
    changed = events.Requested(TALKER, 'change')
    assert launch.told(changed) == []
    assert launch.told(ended) == []
    # another change before it has begun anew
    assert launch.told(changed) == []
    assert launch.told(events.Started(TALKER, 13)) == []
    # one that ended before begins anew for all
    assert launch.told(changed) == []
    assert len(launch.told(events.Started(TALKER, 14))) == 1
    # what makes an end of it after all is told with it
    assert launch.told(changed) == []
    assert launch.told(ended) == []
    (told,) = launch.told(events.Requested(TALKER, 'stop'))
    assert told['type'] == 'exit'
    assert launch.told(changed) == []
    assert launch.told(events.Requested(TALKER, 'stop')) == []
    assert len(launch.told(ended)) == 1


def test_answers_get_the_settings_of_a_deployment(launch):
    launch.settled = lambda entries: [*entries, OTHER]
    launch.answers(plan.Growth((TALKER,)))
    assert launch.done == [[TALKER, OTHER]]


def test_answers_that_a_deployment_does_not_fit_end_the_launch(launch):
    def settled(_):
        raise error('no process is called this', POSITION, hint='look')

    launch.settled = settled
    launch.answers(plan.Growth((TALKER,)))
    failed, (end,) = launch.done
    assert failed.problems[0].endswith('error: no process is called this')
    assert isinstance(end, plan.Shutdown)


def test_only_output_that_a_handler_wants_is_told(launch):
    (told,) = launch.told(events.Output(TALKER, 'stderr', b'one\xff\n'))
    text = 'one\N{REPLACEMENT CHARACTER}\n'
    where = {'process': 17, 'stream': 'stderr'}
    assert told == {'type': 'output', **where, 'text': text}
    assert launch.told(events.Output(OTHER, 'stderr', b'two\n')) == []


def test_states_are_told_while_there_are_handlers(launch):
    event = events.StateChanged(OTHER, '/lc', 'inactive', 'configuring')
    (told,) = launch.told(event)
    change = {'from': 'configuring', 'to': 'inactive'}
    assert told == {'type': 'state', 'node': '/lc', **change}
    launch.growing.has_handlers = False
    assert launch.told(event) == []


def test_the_end_of_the_launch_is_told(launch):
    assert launch.told(events.ShuttingDown('interrupted', True)) == [
        {'type': 'shutdown', 'reason': 'interrupted', 'by_sigint': True}
    ]


def test_calls_are_passed_on(launch):
    launch.feed.call(3)
    assert launch.growing.asked == [{'do': 'call', 'number': 3}]


def test_what_it_has_not_taken_is_sent_soon(launch):
    launch.feed.end_turn()
    assert launch.loop.next_due() is None
    launch.link.is_full = True
    for _ in range(3):
        launch.feed.end_turn()
    assert launch.loop.next_due() == pytest.approx(limits.WORKER_RETRY_DELAY)


def test_who_writes_too_much_is_held_up_while_it_works(launch):
    launch.growing.is_busy = True
    half = b'x' * (limits.STREAM_BACKLOG_BYTES // 2)
    for one in (TALKER, OTHER, OTHER):
        launch.told(events.Output(one, 'stdout', half))
    assert launch.feed.accepts(TALKER.label)
    launch.told(events.Output(TALKER, 'stdout', half))
    assert not launch.feed.accepts(TALKER.label)
    assert launch.feed.accepts(OTHER.label)
    launch.growing.is_busy = False
    assert launch.feed.accepts(TALKER.label)


def test_the_blocks_of_the_plan_are_those_of_its_last_growth(launch):
    blocks = (
        plan.Block('group', '/left', Position('/ws/a.launch.py', 7, 1), None),
    )
    launch.answers(plan.Growth(blocks=blocks), plan.Growth())
    assert launch.blocks == blocks


def test_what_it_answers_comes_to_the_plan_in_order(launch):
    first, second = plan.Message('INFO', '1'), plan.Message('INFO', '2')
    launch.growing.handle = lambda message: (
        None if message == 'log' else message
    )
    launch.answers(
        plan.Growth((first,)), 'log', plan.Growth(), plan.Growth((second,))
    )
    assert launch.done == [[first], [second]]


def test_a_problem_ends_the_launch(launch):
    said = plan.Message('INFO', 'before')
    launch.answers(plan.Growth((said,), problems=('error: oh\n  no', 'and')))
    failed, entries = launch.done
    assert failed == events.PlanFailed(('error: oh', '  no', 'and'))
    # after what went well
    assert entries == [said, plan.Shutdown('a launch file in Python failed')]


def test_a_worker_that_cannot_be_read_is_a_problem(launch):
    said = plan.Message('INFO', 'before')
    launch.answers(plan.Growth((said,)), WorkerError('ended oddly'))
    assert launch.done[0] == [said]
    assert launch.done[1] == events.PlanFailed(('ended oddly',))


def test_the_launch_goes_on_while_an_answer_is_to_come(launch):
    launch.growing.is_busy = True
    assert launch.feed.prepare_end()
    launch.loop.now += 1000.0
    assert launch.feed.prepare_end()
    assert launch.loop.next_due() is None
    assert launch.growing.asked == []


def test_it_is_told_once_that_nothing_is_left_to_do(launch):
    for _ in range(2):
        assert not launch.feed.prepare_end()
        assert [r['event'] for r in launch.growing.asked] == [IDLE]


def test_what_it_says_to_the_end_is_not_awaited_for_ever(launch):
    launch.told(events.ShuttingDown('enough'))
    launch.growing.is_busy = True
    assert launch.feed.prepare_end()
    assert launch.loop.next_due() == limits.WORKER_ANSWER_TIMEOUT
    launch.loop.now += limits.WORKER_ANSWER_TIMEOUT - 1.0
    assert launch.feed.prepare_end()
    launch.loop.now += 1.0
    assert not launch.feed.prepare_end()


def test_who_escalates_does_not_wait_for_it(launch):
    launch.told(events.ShuttingDown('interrupted', interactive=True))
    launch.growing.is_busy = True
    done = launch.feed.execute(
        commands.Escalate(), bool, lambda *_: commands.DONE
    )
    assert done == commands.DONE
    assert not launch.feed.prepare_end()


def test_its_end_is_told_once_after_its_last_answers(launch):
    assert launch.feed.children() == {WORKER} == launch.helpers.keys()
    said = plan.Message('INFO', 'last words')
    launch.link.says.append(plan.Growth((said,)))
    launch.helpers.pop(WORKER)(9)
    assert launch.done[0] == [said]
    (lost,) = launch.done[1:]
    assert isinstance(lost, events.WorkerLost)
    assert 'SIGKILL' in lost.lines()[0]
    assert launch.link.pid == 0
    launch.growing.is_busy = True
    assert launch.told(events.ShuttingDown('enough')) == []
    assert not launch.feed.prepare_end()


def test_nothing_is_asked_of_one_that_was_closed(launch):
    launch.feed.close()
    assert launch.link.is_closed
    assert not launch.helpers
    assert launch.told(events.Started(TALKER, 12)) == []
    launch.feed.call(3)
    assert not launch.feed.prepare_end()
    assert launch.growing.asked == []
