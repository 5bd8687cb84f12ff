# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the worker answers while the plan runs becomes more of the plan."""

from colcon_yamllaunch.language.python_files.growing_launch import (
    GrowingLaunch,
)
from colcon_yamllaunch.plan.plan import (
    ChangeState,
    Component,
    EventHandler,
    Growth,
    Plan,
    Process,
    Timer,
)
from colcon_yamllaunch.plan.position import Position
from support.played_worker import Message, Play, position, process

from tests.language.python_files.conftest import Played


def handlers(played: Played, *which: object) -> Message:
    handler = {
        'event': 'exit',
        'processes': [*which] or None,
        'condition': '',
        'actions': ['start rviz2'],
        'position': position(played.path, 3, 5),
    }
    return {'say': 'handlers', 'handlers': [handler], 'output': [1, 77]}


def begun(played: Played, **plays: object) -> tuple[Plan, GrowingLaunch]:
    """Evaluate a file with a handler and a call."""

    played.says(
        process(1, node='/talker'),
        {'say': 'begin', 'kind': 'group', 'title': ''},
        {'say': 'call', 'number': 4, 'title': 'more'},
        {'say': 'end'},
        handlers(played, 1, 'later'),
    )
    for name, its in plays.items():
        played.plays[name] = its  # type: ignore[assignment]
    evaluation = played.good()
    assert evaluation.growing is not None
    return evaluation.plan, evaluation.growing


def grown(played: Played, growing: GrowingLaunch, request: Message) -> Growth:
    """Ask for something, and return all that comes of it."""
    growing.ask(request)
    assert growing.is_busy
    growths = []
    while growing.is_busy:
        growth = growing.handle(played.worker.receive())
        growths += [] if growth is None else [growth]
    (growth,) = growths
    return growth


def test_a_plan_has_its_handlers(played: Played) -> None:
    plan, growing = begun(played)
    place = Position(played.path, 3, 5)
    names = ('talker-1', 'later')
    handler = EventHandler('exit', names, '', ('start rviz2',), place)
    assert plan.handlers == (handler,)
    assert growing.has_handlers
    assert growing.wants_output == {'talker-1'}
    assert (growing.id_of('talker-1'), growing.id_of('echo-2')) == (1, None)
    assert [r['do'] for r in played.worker.requests][-1] == 'finish'


def test_an_event_makes_more_of_the_plan(played: Played) -> None:
    def event(request: Message) -> Play:
        assert request['event']['type'] == 'exit'
        yield process(2, node='/talker')
        yield {
            'say': 'component',
            'id': 3,
            'container': '/box',
            'package': 'alpha',
            'plugin': 'x::talker',
            'parameters': [],
        }
        yield handlers(played)

    plan, growing = begun(played, event=event)
    event_of = {'type': 'exit', 'process': 1, 'returncode': 0}
    growth = grown(played, growing, {'do': 'event', 'event': event_of})
    second, component = growth.entries
    assert isinstance(second, Process)
    assert isinstance(component, Component)
    labels = {p.label for p in plan.processes()}
    assert labels == {'talker'}
    assert (second.label, second.name) == ('talker-2', 'talker-2')
    assert component.label not in ('talker', 'talker-2')
    assert second.block == 0
    assert growing.has_handlers
    assert growing.id_of('talker-2') == 2


def test_a_call_goes_on_where_it_stood(played: Played) -> None:
    def call(request: Message) -> Play:
        assert request['number'] == 4
        yield {'say': 'begin', 'kind': 'group', 'title': 'x'}
        yield process(2)
        yield {'say': 'end'}
        yield process(3)

    plan, growing = begun(played, call=call)
    growth = grown(played, growing, {'do': 'call', 'number': 4})
    inner, outer = growth.entries
    assert isinstance(inner, Process)
    assert isinstance(outer, Process)
    assert outer.block == len(plan.blocks) - 1
    assert inner.block == len(plan.blocks)


def test_settled_call_becomes_what_it_comes_to(played: Played) -> None:
    def play(_request: Message) -> Play:
        yield {'say': 'begin', 'kind': 'timer', 'period': 2.0}
        yield {'say': 'call', 'number': 4, 'title': 'configure /talker'}
        yield process(1, node='/talker')
        yield {'say': 'end'}

    def finish(_request: Message) -> Play:
        yield {'say': 'begin', 'kind': 'settled', 'number': 4}
        yield {
            'say': 'change_state',
            'node': '/talker',
            'transition': 'configure',
            'position': position(played.path, 3, 5),
        }
        yield {'say': 'end'}

    played.does(play)
    played.plays['finish'] = finish
    evaluation = played.good()
    # nothing is left for Python to do
    assert evaluation.growing is None
    (timer,) = evaluation.plan.entries
    assert isinstance(timer, Timer)
    change, talker = timer.entries
    place = Position(played.path, 3, 5)
    assert change == ChangeState('/talker', 'configure', place)
    assert isinstance(talker, Process)


def test_files_that_are_included_while_it_runs(played: Played) -> None:
    low = played.launcher.write(
        'low.yaml',
        'launch: [executable: {cmd: echo}, include: {file: x.launch.py}]',
    )
    other = played.file('x.launch.py')

    def included(_request: Message) -> Play:
        yield process(8, 'other')

    played.does(included, other)

    def event(_request: Message) -> Play:
        yield {
            'say': 'include',
            'ask': 1,
            'path': str(low),
            'scope': {
                'configurations': {},
                'environment': {},
                'namespace': None,
            },
        }

    _, growing = begun(played, event=event)
    growth = grown(played, growing, {'do': 'event', 'event': {}})
    names = [p.name for p in growth.entries if isinstance(p, Process)]
    assert names == ['echo-2', 'other-3']
    assert growth.problems == ()


def test_answers_that_come_while_a_file_is_included(played: Played) -> None:
    low = played.launcher.write(
        'low.yaml', 'launch: [include: {file: x.launch.py}]'
    )
    other = played.file('x.launch.py')

    def included(_request: Message) -> Play:
        return (yield from played.worker.overtaken())

    played.does(included, other)

    def event(request: Message) -> Play:
        if request['event']:
            yield process(2, 'late')
            return {'error': {'text': 'ValueError: no', 'frames': []}}
        scope = {'configurations': {}, 'environment': {}, 'namespace': None}
        include = {'say': 'include', 'path': str(low), 'scope': scope}
        yield {**include, 'ask': 1}
        return None

    _, growing = begun(played, event=event)
    growing.ask({'do': 'event', 'event': {}})
    include = played.worker.receive()
    growing.ask({'do': 'event', 'event': {'type': 'start'}})
    assert growing.handle(include) is None
    growth = growing.handle(played.worker.receive())
    assert growth is not None
    assert [p.name for p in growth.entries if isinstance(p, Process)] == [
        'late-2'
    ]
    (problem,) = growth.problems
    assert 'ValueError: no' in problem
    assert not growing.is_busy


def test_what_goes_wrong_while_it_runs(played: Played) -> None:
    def event(_request: Message) -> Play:
        yield {'say': 'warning', 'text': 'odd'}
        yield {'say': 'shutdown', 'reason': ''}
        frames = [{'position': position(played.path, 1, 1)}]
        return {'error': {'text': 'ValueError: no', 'frames': frames}}

    _, growing = begun(played, event=event)
    growth = grown(played, growing, {'do': 'event', 'event': {}})
    warning, _ = growth.entries
    assert 'odd' in str(warning)
    (problem,) = growth.problems
    assert problem.startswith('robot.launch.py:1:1: error: ValueError: no\n')


def test_a_worker_that_is_lost(played: Played) -> None:
    def event(_request: Message) -> Play:
        yield process(2)

    _, growing = begun(played, event=event)
    growing.ask({'do': 'event', 'event': {}})
    assert growing.handle(played.worker.receive()) is None
    growth = growing.lost('it died')
    assert (len(growth.entries), growth.problems) == (1, ('it died',))
    assert not growing.has_handlers
    assert not growing.is_busy
    assert growing.lost('').problems == ()
