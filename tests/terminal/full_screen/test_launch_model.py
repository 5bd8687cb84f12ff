# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is known of a launch follows from its news."""

from pathlib import Path
import re
from typing import Any

from colcon_yamllaunch.control.resource_usage import Usage
from colcon_yamllaunch.control.subscription import LostData
from colcon_yamllaunch.engine.description import Branch
from colcon_yamllaunch.engine.events import Ended, Exited
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.terminal.full_screen import launch_model
from colcon_yamllaunch.terminal.full_screen.screen_texts import curve
import pytest
from support.shown_launch import (
    component,
    exited,
    happened,
    process,
    ShownLaunch,
    wrote,
)

SIGNAL = 'died by SIGSEGV (segmentation fault), core dumped'
DOWN: dict[str, Any] = {'phase': 'failed', 'pid': None}


class Clock:
    """A clock that a test sets."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def model_of(*members: Any) -> launch_model.LaunchModel:
    return launch_model.LaunchModel(ShownLaunch(*members))


def lines_of(model: launch_model.LaunchModel) -> list[tuple[str | None, str]]:
    return [(line.label, line.text) for line in model.view.lines]


def rows_of(model: launch_model.LaunchModel) -> list[str]:
    return [f'{r.look.sign} {r.title} {r.note}'.strip() for r in model.rows()]


def test_rows_show_state_restarts_and_cpu() -> None:
    model = model_of(
        process('a', restarts=2),
        process('box'),
        process('b', lifecycle='inactive'),
        process('c', phase='respawn', ending='exited with code 1', pid=None),
        process('d', phase='waiting', pid=None),
        process('e', **DOWN, condition='failed', ending=SIGNAL),
        component('talker', 'box', lifecycle='active'),
        component('lost', 'box', phase='failed', ending='no such class'),
        component('remote', None, phase='waiting'),
    )
    model.add_usage({1000: Usage(0.75, 1)})
    assert rows_of(model) == [
        '● a running ×2 75%',
        '● box running 75%',
        '● talker active',
        '✗ lost no such class',
        '● b inactive 75%',
        '↻ c respawns (exit 1)',
        '○ d waiting',
        '✗ e SIGSEGV, core dumped',
        '▢ /far not of this launch',
        '○ remote waiting',
    ]
    assert model.label_of('2') == 'box'
    assert model.label_of('0') is None


def test_plan_rows_are_indented_like_the_plan() -> None:
    model = model_of(process('a'), process('b'))

    def branch(kind: str, title: str, *children: Branch) -> Branch:
        return Branch(kind, title, '/ws/demo.yaml:3:5', list(children))

    group = branch('group', '/left', branch('process', 'b'))
    include = branch('file', '/ws/more.yaml', group)
    model.tree = [
        branch('file', '/ws/demo.yaml', branch('process', 'a'), include)
    ]
    assert [(r.depth, r.title, r.note, r.key) for r in model.plan_rows()] == [
        (0, 'demo.yaml', '', ''),
        (1, 'a', 'running', '1'),
        (1, 'more.yaml', 'demo.yaml:3:5', ''),
        (2, '/left', 'demo.yaml:3:5', ''),
        (3, 'b', 'running', '2'),
    ]


def test_gap_is_counted_where_output_is_missing() -> None:
    model = model_of(process('a'))
    model.receive(LostData(0, 1024))
    model.receive(LostData(2, 1024))
    model.receive(wrote('a', 'x'))
    model.receive(LostData(0, 512))
    assert lines_of(model) == [
        (None, '… 2.0 KiB not shown …'),
        ('a', 'x'),
        (None, '… 0.5 KiB not shown …'),
    ]
    assert model.missed_bytes == 2560
    assert model.wants_tree


def test_end_marks_processes_ended_and_stops_the_clock() -> None:
    clock = Clock()
    names = ('a', 'b', 'c')
    members = *map(process, names), component('talker', 'a')
    launch = ShownLaunch(*members, stopping=True, clock=clock)
    model = launch_model.LaunchModel(launch)
    clock.now += 4
    plan = Process('a', ('true',), Position('/ws/demo.yaml', 1, 1), '/')
    finished = Exited(plan, 7, Outcome(code=0), 1.0, False, False)
    launch.state.apply(finished)
    launch.state.apply(Ended(1))
    # the others run as the launcher is killed
    model.end('')
    clock.now += 50
    assert model.state.seconds == 10.0
    assert model.state.exit_code == 1
    ended = ['✓ a finished', '✓ talker unloaded', '■ b ended', '■ c ended']
    assert rows_of(model) == ended


def test_usage_history_is_limited() -> None:
    model = model_of(process('a', pid=7))
    for number in range(launch_model.HISTORY + 5):
        model.add_usage({7: Usage(float(number), 1)})
    assert len(model.usage['a']) == launch_model.HISTORY
    assert model.usage['a'][0].cpu == 5.0
    # those of other machines come with the state
    there = process('b', pid=7, machine='arm', cpu=0.25, memory=2)
    model = model_of(there)
    model.add_usage({7: Usage(1.0, 1)})
    assert list(model.usage['b']) == [Usage(0.25, 2)]
    assert curve([0.0, 0.5, 1.0]) == '▁▅█'
    assert curve([0.0, 0.0]) == '▁▁'


CHECK = {'passed': False, 'missing': ['ok'], 'failures': ['a failed']}
CHECKED = happened('checked', **CHECK)


@pytest.mark.parametrize(
    ('event', 'text', 'level'),
    [
        (happened('started', 'a', pid=7), 'started, pid 7', Level.INFO),
        (exited('a', 3), 'exited with code 3 after 1.0 s', Level.ERROR),
        (
            happened('start_failed', 'a', reason='no\nfile', respawn_delay=1),
            r'could not be started: no\nfile, starts again in 1 s',
            Level.ERROR,
        ),
        (happened('message', level='WARNING', text='hm'), 'hm', Level.WARN),
        (CHECKED, "red: a failed, 'ok' was not seen", Level.ERROR),
        (happened('requested', 'a', action='change'), '', Level.INFO),
        (happened('changed', files=['x']), '', Level.INFO),
        (happened('started', 'a'), 'started', Level.INFO),
    ],
)
def test_event_becomes_sentence_and_level(
    event: Any, text: str, level: int
) -> None:
    assert launch_model.sentence_of(event.name, event.fields) == text
    assert launch_model.level_of_event(event.name, event.fields) == level


def test_each_documented_event_has_a_sentence() -> None:
    page = Path(__file__).parents[3] / 'docs' / 'logs.md'
    table = page.read_text(encoding='utf-8').partition('what happened | f')[2]
    rows = table.partition('\n\n')[0]
    assert set(re.findall(r'^\| `(\w+)` \|', rows, re.M)) == set(
        launch_model.SENTENCES
    )
