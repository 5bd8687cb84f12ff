# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The lines of the status block."""

import re
from signal import SIGINT

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.terminal.line_filter import Filtering
from colcon_yamllaunch.terminal.status_block import (
    block_of,
    next_change,
    Style,
    View,
    width,
)
from colcon_yamllaunch.terminal.status_model import StatusModel
import pytest
from support.launch_states import planned_state

COLOURS = re.compile(r'\x1b\[[0-9;]*m')
BAD = Outcome(code=3)
RED = '\x1b[1;31m'


@pytest.fixture
def board(process):
    """Return a function that makes the board of a launch."""

    def make(*labels):
        made = StatusModel(planned_state(*map(process, labels)))
        for pid, label in enumerate(labels, 100):
            made.state.apply(events.Started(process(label), pid))
        return made

    return make


@pytest.fixture
def fails(process):
    """Return a function that has a process of a board fail."""

    def fail(board, label, again=None):
        event = events.Exited(process(label), 7, BAD, 1.0, False, True, again)
        board.state.apply(event)

    return fail


def lines(board, columns=80, view=None, waits_for='', now=100.0, **style):
    view = view or View()
    style = Style(columns, **{'color': False, **style})
    block = block_of(board, view, style, now, waits_for)
    assert len(block.lines) <= style.lines + len(view.live)
    for line in block.lines:
        assert width(line) < columns
    return list(block.lines)


def test_each_process_shows_its_state(board, process, fails):
    one = board('a', 'b', 'c', 'd')
    fails(one, 'b')
    fails(one, 'c', again=1.0)
    one.state.apply(events.Started(process('c'), 300))
    one.state.apply(events.StateChanged(process('d'), '/d', 'inactive', None))
    one.measure({'a': 1.5})
    line = ' 1 ● a 150%  2 ✗ b exit 3  3 ● c ×1  4 ● d inactive'
    assert lines(one) == [line]
    line = ' 1 * a 150%  2 ! b exit 3  3 * c x1  4 * d inactive'
    assert lines(one, ascii=True) == [line]


def test_failed_process_is_red(board, fails):
    one = board('a', 'b')
    fails(one, 'b')
    (line,) = lines(one, color=True)
    assert f'{RED}✗\x1b[0m {RED}b' in line
    assert COLOURS.sub('', line) == ' 1 ● a  2 ✗ b exit 3'


@pytest.mark.parametrize('columns', [20, 40, 80, 200, 400])
@pytest.mark.parametrize('count', [1, 3, 20, 200])
@pytest.mark.parametrize('color', [False, True])
def test_block_fits_width_and_counts_every_process(
    board, fails, columns, count, color
):
    labels = [f'node_{n}' for n in range(count)]
    one = board(*labels)
    fails(one, labels[-1])
    shown = lines(one, columns, color=color, waits_for="waits for 'received'")
    text = COLOURS.sub('', '\n'.join(shown))
    # what failed is there whatever else is
    assert f'✗ {labels[-1]} exit 3' in text
    assert "waits for 'r" in text
    named = text.count('node_')
    rest = re.search(r'● (\d+)(?! node)', text)
    assert named + int(rest[1] if rest else 0) == count


def test_many_running_processes_are_counted(board, process, fails):
    one = board(*(f'node_{n}' for n in range(60)))
    for columns in (40, 80, 120, 200):
        assert lines(one, columns) == [' ● 60 running']
    fails(one, 'node_7')
    one.state.apply(
        events.Signalled(process('node_8'), 7, SIGINT, group=False)
    )
    assert lines(one) == [' 8 ✗ node_7 exit 3  9 ◍ node_8  ● 58 running']
    # few are named
    assert lines(board('front', 'back', 'left', 'right'), 20) == [
        ' 1 ● front',
        ' 2 ● back  3 ● left',
        ' 4 ● right',
    ]
    some = board(*(f'node_{n}' for n in range(12)))
    assert len(lines(some, 80)) == 2
    assert lines(some, 70) == [' ● 12 running']
    one.state.apply(events.ShuttingDown('interrupted'))
    assert lines(one)[0] == ' 8 ✗ node_7 exit 3  ◍ 59 stopping'


def test_result_of_watch_leaves_room_for_keys(board):
    one = board('a')
    news = 'double.py changed: restarted my_double (0.21 s)'
    one.state.apply(events.ChangeReported(news))
    view = View(hint='? help  / search  L level  q stop')
    keys = f' {view.hint}'
    assert lines(one, 120, view)[1:] == [f' ✓ {news}   {view.hint}']
    assert lines(one, 80, view)[1:] == [f' ✓ {news}', keys]
    # of what has no room the first keys are left, and none is cut
    assert lines(one, 30, view)[1:] == [
        ' ✓ double.py changed: restar…',
        ' ? help  / search  L level',
    ]
    assert lines(one, 40, view, lines=2)[1:] == [
        ' ✓ double.py changed: restart…   ? help'
    ]


def test_overlay_replaces_the_block(board):
    view = View(hint='Esc goes back', overlay=('one', 'two', 'three'))
    shown = lines(board('a'), view=view, lines=4)
    assert shown == ['one', 'two', 'three', 'Esc goes back']
    shown = lines(board('a'), view=view, height=4)
    assert shown == ['one', 'two', 'Esc goes back']


def test_failed_and_busy_processes_come_first(board, process, fails):
    one = board(*(f'node_{n}' for n in range(200)))
    fails(one, 'node_150')
    ended = (process('node_120'), 7, Outcome(code=0), 1.0, False, False)
    one.state.apply(events.Exited(*ended))
    one.measure({'node_170': 0.9})
    assert lines(one, 40, lines=3) == [
        ' ✗ node_150 exit 3  ● node_170 90%',
        ' ● 197 running  ✓ 1 ended',
    ]


def test_unnamed_processes_are_counted_by_state(board, process, fails):
    one = board(*(f'node_{n}' for n in range(50)))
    for number in range(20):
        fails(one, f'node_{number}')
    assert lines(one, 40, lines=1) == [' j ✗ node_19 exit 3  ● 30  ✗ 19']


def test_chosen_process_is_always_named(board):
    one = board(*(f'node_{n}' for n in range(200)))
    view = View(chosen='node_180', hint='s stop  r restart')
    assert lines(one, 40, view)[0].startswith(' >● node_180<')
    assert lines(one, 40, view)[-1] == ' s stop  r restart'
    coloured = lines(one, 40, view, color=True)[0]
    assert coloured.startswith(' \x1b[7m● node_180\x1b[0m')


def test_hidden_process_is_in_parentheses(board):
    one = board('a', 'b', 'c')
    view = View(filtering=Filtering(muted=frozenset('b'), search='foo'))
    assert lines(one, view=view) == [
        ' 1 ● a  2 ● (b)  3 ● c',
        ' /foo, 1 muted',
    ]
    view = View(filtering=Filtering(only=frozenset('b')))
    assert lines(one, view=view)[0] == ' 1 ● (a)  2 ● b  3 ● (c)'


def test_stopping_shows_countdown_to_next_signal(board):
    one = board('a', 'b')
    one.state.apply(events.ShuttingDown('interrupted'))
    assert lines(one)[-1] == ' stopping (Ctrl-C forces)'
    one.state.apply(events.StillRunning(('a', 'b'), 1, 2, 15, 3.5))
    line = ' stopping, SIGTERM in 4 s (Ctrl-C forces): a, b, 1 timer'
    assert lines(one)[-1] == line
    line = ' stopping, SIGTERM in 4 s: a, b, 1 tim…'
    assert lines(one, 40)[-1] == line
    # it is another text in half a second, and then each second
    assert next_change(one.state, 100.0) == pytest.approx(100.5)
    assert next_change(one.state, 100.5) == pytest.approx(101.5)
    assert next_change(one.state, 104.0) is None


def test_last_change_is_shown_until_the_next(board):
    one = board('a')
    one.state.apply(
        events.ChangeReported('no.py: nothing uses it', is_final=False)
    )
    assert lines(one)[-1] == ' … no.py: nothing uses it'
    assert next_change(one.state, 100.0) is None
    one.state.apply(events.FilesChanged(('double.py',)))
    text = 'double.py changed: building'
    one.state.apply(events.ChangeReported(text, is_final=False))
    assert lines(one)[-1] == f' … {text}'
    assert next_change(one.state, 100.0) == pytest.approx(101.0)
    assert lines(one, now=102.5)[-1] == ' 2 s … double.py changed: building'
    assert next_change(one.state, 102.5) == pytest.approx(103.0)
    one.state.apply(
        events.ChangeReported('double.py changed: restarted a (0.21 s)')
    )
    assert lines(one)[-1] == ' ✓ double.py changed: restarted a (0.21 s)'
    assert next_change(one.state, 103.0) is None
    # which it is also when nothing follows from another one
    one.state.apply(
        events.ChangeReported('off: what is saved waits', is_paused=True)
    )
    assert 'off' not in lines(one)[1]
    text = 'double.py changed: it failed'
    one.state.apply(events.ChangeReported(text, failed=True))
    assert lines(one)[-1] == f' ✗ {text}'
    assert lines(one, 20)[-1] == ' ✗ double.py chang…'


def test_prompt_is_the_last_line(board):
    one = board(*(f'node_{n}' for n in range(200)))
    view = View(prompt='/', typed='hello', cursor=2)
    block = block_of(one, view, Style(40, color=False), 100.0, 'waits')
    assert block.lines[-1] == '/hello'
    assert block.cursor == (2, 3)
    assert block.lines[-2] == ' waits'


@pytest.mark.parametrize('columns', [10, 20, 40])
@pytest.mark.parametrize('cursor', [0, 5, 50, 99, 100])
def test_long_input_is_cut_around_the_cursor(board, columns, cursor):
    text = ''.join(chr(ord('a') + n % 26) for n in range(100))
    view = View(prompt='> ', typed=text, cursor=cursor)
    block = block_of(board('a'), view, Style(columns, color=False), 100.0)
    line, column = block.cursor
    assert line == len(block.lines) - 1
    assert width(block.lines[line]) < columns
    assert column < columns
    if cursor < len(text):
        assert block.lines[line][column] in (text[cursor], '…')


def test_control_characters_in_names_are_removed(board):
    (line,) = lines(board('a\x1b[2Jb\nc', '台所'))
    assert line == r' 1 ● ab\nc  2 ● 台所'


def test_live_lines_are_above_the_block(board):
    view = View(live=('[a] 50 %',))
    assert lines(board('a'), view=view) == ['[a] 50 %', ' 1 ● a']
    # of a long one the end is seen
    view = View(live=(f'[a] {"low " * 20}×31',))
    cut = '[a] low low low low low low l…w low ×31'
    assert lines(board('a'), 40, view)[0] == cut


def test_hint_and_note_wrap_into_several_lines(board):
    hint = 's stop  r restart  k kill  a attach  m mute  Esc none'
    view = View(chosen='b', filtering=Filtering(level=Level.WARN), hint=hint)
    assert lines(board('a', 'b'), 80, view)[1:] == [f' {hint}   level WARN']
    assert lines(board('a', 'b'), 40, view) == [
        ' 1 ● a  >2 ● b<',
        ' s stop  r restart  k kill  a attach',
        ' m mute  Esc none   level WARN',
    ]
    narrow = lines(board('a', 'b'), 20, view)[1:]
    keys = (' s stop  r restart', ' k kill  a attach', ' m mute  Esc none')
    assert narrow == [*keys]
    view = View(note='a note that is long enough for two lines, and so on')
    note = lines(board('a'), 40, view)[1:]
    assert note == [' a note that is long enough for two', ' lines, and so on']
    assert lines(board('a'), 12, view, lines=2)[1:] == [' a note …']


def test_hint_is_shown_below_many_failures(board, fails):
    view = View(hint='? help  1-z choose')
    many = board(*(f'node{n}' for n in range(99)))
    for number in range(99):
        fails(many, f'node{number}')
    assert len(lines(many, 40, view)) == 4
    assert lines(many, 40, view)[-1] == ' ? help  1-z choose'
    assert lines(board('a'), 40, view)[-1] == ' ? help  1-z choose'


def test_low_terminal_shows_the_most_important_line(board):
    one = board(*(f'node_{n}' for n in range(200)))
    (line,) = lines(one, lines=1, waits_for='timer in 3 s')
    assert line == ' ● 200 running'
    assert lines(one, lines=0) == []
    # what asks for something, or takes long, comes first
    noted = View(note='no such key', hint='? help')
    (line,) = lines(one, lines=1, view=noted)
    assert line.startswith(' no such key')
    one.state.apply(events.ShuttingDown('interrupted'))
    assert lines(one, lines=1) == [' stopping (Ctrl-C forces)']


def test_live_lines_leave_room_in_a_low_terminal(board):
    view = View(live=('10 %', '20 %', '30 %'))
    for height, live in ((3, 0), (4, 1), (6, 3), (24, 3)):
        block = lines(board('a'), view=view, lines=1, height=height)
        assert block == [*view.live[3 - live :], ' 1 ● a']


def test_what_waits_is_shown_until_all_is_ready(process):
    members = [process(label) for label in ('driver', 'nav')]
    state = planned_state(*members)
    state.has_readiness = True
    state.after = {'driver': (), 'nav': ('driver',)}
    driver, nav = members
    board = StatusModel(state)
    state.apply(events.Waiting(nav, ('driver',)))
    state.apply(events.Started(driver, 100))
    unmet = ('a publisher of scan',)
    state.apply(events.MemberChanged(driver, unmet=unmet))
    state.clock = lambda: 104.2
    assert lines(board, 120) == [
        ' 1 ◌ driver  2 ◌ nav',
        ' 0 of 2 ready, driver: waiting for a publisher of scan (4 s), nav: '
        'waiting for driver (4 s)',
    ]
    assert next_change(state, 104.2) == pytest.approx(105.0)
    state.apply(events.Ready(driver, 4.2))
    state.apply(events.Started(nav, 101))
    assert lines(board, 120)[1:] == [' 1 of 2 ready']
    state.apply(events.Ready(nav, 0.0))
    assert lines(board, 120) == [' 1 ● driver  2 ● nav']
    assert next_change(state, 104.2) is None


def test_many_that_wait_are_counted(process):
    members = [process(f'p{number}') for number in range(60)]
    state = planned_state(*members)
    state.has_readiness = True
    state.after = {member.label: ('p0',) for member in members[1:]}
    for member in members[1:]:
        state.apply(events.Waiting(member, ('p0',)))
    shown = lines(StatusModel(state), 200)[-1]
    assert shown.startswith(' 0 of 60 ready, p1: waiting for p0 (0 s), ')
    assert ' more wait' in shown
