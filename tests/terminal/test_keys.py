# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What keys mean."""

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.plan.plan import Component, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.terminal.keys import help_lines, KeyPress, Keys, Typed
from colcon_yamllaunch.terminal.line_filter import Filtering
from colcon_yamllaunch.terminal.status_model import StatusModel
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest
from support.launch_states import planned_state

PLACE = Position('/ws/demo.yaml', 14, 5)


def keys_of(*labels):
    entries = [Process(n, (f'run_{n[::-1]}',), PLACE, '/') for n in labels]
    model = StatusModel(planned_state(*entries))
    return Keys(model)


@pytest.fixture
def keys():
    """Return the keys of a launch of three."""
    return keys_of('kitchen', 'bath', 'bathroom')


def typed(keys, text):
    return list(keys.feed(text.encode()))


@pytest.mark.parametrize(
    ('key', 'command'),
    [('w', 'watch'), ('?', 'help'), ('q', 'quit'), ('\r', 'break')],
)
def test_key_without_choice_presses_for_all(keys, key, command):
    assert typed(keys, key) == [KeyPress(command)]


def test_help_lists_all_keys_and_fits_the_width():
    text = '\n'.join(help_lines())
    for key in (*'sraklimodLtMwEq:/?', 'Enter'):
        assert f'\n  {key} ' in text
    for columns in (20, 40, 80, 200):
        lines = help_lines(columns)
        assert all(len(line) < max(columns, 25) for line in lines)


def test_overlay_closes_with_the_next_key(keys):
    for key in ('?', ' ', '\r', 'q', 'E', '2'):
        keys.show(['one', 'two', 'three'], 5)
        assert keys.view().overlay == ('one', 'two', 'three')
        assert keys.view().hint == '  Esc goes back'
        assert typed(keys, key) == []
        assert keys.view().overlay == ()
    assert keys.view().chosen == 'bath'
    # what is told meanwhile is more urgent, and so is who is typed at
    keys.show(['one'], 5)
    keys.show_note('there is no debugger')
    assert keys.view().overlay == ()
    keys.show(['one'], 5)
    keys.attach('bath')
    assert keys.view().overlay == ()


def test_long_overlay_has_pages(keys):
    keys.show(['one', 'two', 'three'], 2)
    assert keys.view().overlay == ('one', 'two')
    assert keys.view().hint == '  Enter shows more  Esc goes back'
    typed(keys, '\r')
    assert keys.view().overlay == ('three',)
    typed(keys, '\r')
    assert keys.view().overlay == ()
    keys.show(['one', 'two', 'three'], 2)
    typed(keys, 'q')
    assert keys.view().overlay == ()


def test_errors_key_needs_errors_of_a_build():
    entry = Process('a', ('true',), PLACE, '/')
    model = StatusModel(planned_state(entry))
    keys = Keys(model)
    assert typed(keys, 'E') == []
    assert keys.view().note == 'no build has failed'
    model.state.apply(
        events.ChangeReported(
            'a.cpp changed: the build failed', True, 'a.cpp:1\n'
        )
    )
    # which neither another change nor one that fails without a word is
    model.state.apply(events.ChangeReported('b.py changed: restarted b'))
    model.state.apply(
        events.ChangeReported('c.py changed: could not start c', True)
    )
    assert model.state.errors == ('a.cpp changed: the build failed', 'a.cpp:1')
    assert typed(keys, 'E') == [KeyPress('errors')]
    assert 'E errors' in keys.view().hint


def test_second_choice_replaces_the_first(keys):
    typed(keys, '13')
    assert keys.view().chosen == 'bathroom'
    # and none
    typed(keys, ' ')
    assert keys.view().chosen is None
    typed(keys, '1\x1b')
    assert keys.is_waiting
    assert list(keys.settle()) == []
    assert keys.view().chosen is None
    # the help is no choice
    assert typed(keys, '1?') == [KeyPress('help')]
    assert keys.view().chosen == 'kitchen'


def test_unknown_key_shows_a_note(keys):
    assert typed(keys, '9') == []
    assert "'9'" in keys.view().note
    assert typed(keys, '1') == []
    assert keys.view().note == ''
    assert typed(keys, 'z') == []
    assert "'z'" in keys.view().note
    keys.show_note('something')
    assert keys.view().note == 'something'


def test_mute_keys_change_the_filter(keys):
    typed(keys, '1m')
    assert keys.filtering.muted == {'kitchen'}
    assert keys.view().filtering.muted == {'kitchen'}
    assert keys.view().filtering.text == '1 muted'
    typed(keys, 'M')
    assert keys.filtering.muted == {'kitchen', 'bath', 'bathroom'}
    typed(keys, '2m')
    assert keys.filtering.muted == {'kitchen', 'bathroom'}
    typed(keys, 'MM')
    assert keys.filtering == Filtering()


def test_filter_key_for_a_component_names_its_container():
    component = Component('part', 'box', 'a::B', 'part', PLACE)
    model = StatusModel(planned_state(component))
    keys = Keys(model)
    for key in 'mo':
        assert typed(keys, f'1{key}') == []
        assert 'container' in keys.view().note
    typed(keys, 'M')
    assert keys.filtering == Filtering()
    assert typed(keys, '1s') == [KeyPress('stop', 'part')]


def test_level_key_cycles_through_levels(keys):
    levels = []
    for _ in Level:
        typed(keys, 'L')
        levels.append(keys.filtering.level.name)
    assert levels == ['INFO', 'WARN', 'ERROR', 'FATAL', 'DEBUG']


@pytest.mark.parametrize('key', ['L', 't', 'M', 'w', '/', ':'])
def test_keys_for_all_work_while_a_process_is_chosen(keys, key):
    alone = keys_of('kitchen', 'bath', 'bathroom')
    expected = typed(alone, key)
    assert typed(keys, f'2{key}') == expected
    assert keys.view() == alone.view()


def test_q_with_a_choice_does_not_stop_the_launch(keys):
    assert typed(keys, '2q') == []
    assert keys.view().chosen is None
    assert 'q stops the launch' in keys.view().note
    assert typed(keys, 'q') == [KeyPress('quit')]


def test_process_key_without_choice_asks_to_choose(keys):
    for key in 'srkamodli':
        assert typed(keys, key) == []
        assert 'choose it first: 1-3' in keys.view().note


def test_escape_clears_the_filter(keys):
    typed(keys, '/low\rLL1m2ot\x1b')
    list(keys.settle())
    assert keys.filtering == Filtering(times=True)
    assert 'all is shown' in keys.view().note
    typed(keys, '\x1b')
    list(keys.settle())
    assert keys.view().note == ''


def test_hint_follows_the_state_of_the_process(process):
    model = StatusModel(planned_state(process('a'), process('b')))
    model.state.process('a').terminal = True
    keys = Keys(model)
    assert '? help  1-2 choose  / search' in keys.view().hint
    assert 'w watch' not in keys.view().hint
    model.state.watch = ''
    assert 'w watch  q stop' in keys.view().hint
    typed(keys, '1m1o1')
    # who is alone is not muted
    assert 'm mute  o all' in keys.view().hint
    typed(keys, 'm1')
    assert 'm unmute  o all' in keys.view().hint
    assert 's stop  r restart  k kill  a attach' in keys.view().hint
    model.state.apply(events.Started(process('b'), 7))
    model.state.apply(
        events.Exited(process('b'), 7, Outcome(code=3), 1.0, False, True)
    )
    typed(keys, '2')
    assert keys.view().hint.startswith('r start  m mute  o only  d debug')
    model.state.apply(events.ShuttingDown('interrupted'))
    assert keys.view().hint.startswith('m mute  o only  l log')


def test_hint_omits_keys_without_effect(process):
    component = Component('part', 'box', 'a::B', 'part', PLACE)
    model = StatusModel(planned_state(process('a'), component))
    keys = Keys(model)
    typed(keys, '1')
    hint = keys.view().hint
    assert hint.startswith('s stop  r restart  k kill  m mute  o only')
    typed(keys, '2')
    assert keys.view().hint.startswith('s stop  r restart  l log  i info')


def test_search_filters_with_each_key(keys):
    typed(keys, '/lo')
    assert keys.filtering.search == 'lo'
    view = keys.view()
    assert (view.prompt, view.typed, view.cursor) == ('/', 'lo', 2)
    # it is not told twice
    assert view.filtering.text == ''
    typed(keys, 'x\x7fw\r')
    assert keys.filtering.search == 'low'
    assert keys.view().prompt is None
    # Esc takes what was before
    typed(keys, '/other')
    assert keys.filtering.search == 'other'
    typed(keys, '\x1b')
    list(keys.settle())
    assert keys.filtering.search == 'low'
    # the one before is remembered
    typed(keys, '/\x1b[A')
    assert keys.filtering.search == 'low'
    # nothing is all
    typed(keys, '\x15\r')
    assert keys.filtering == Filtering()
    typed(keys, '/\x7f')
    assert keys.view().prompt is None


@pytest.mark.parametrize(
    ('name', 'label'),
    [
        ('kit', 'kitchen'),
        ('RUN_NE', 'kitchen'),
        ('chen', 'kitchen'),
        ('bath', 'bath'),
        ('athr', 'bathroom'),
        ('bathr\t', 'bathroom'),
    ],
)
def test_name_prompt_chooses_the_best_match(keys, name, label):
    typed(keys, f':{name}')
    assert keys.view().prompt == ':'
    assert keys.view().chosen == label
    assert keys.view().hint.startswith(f'Enter chooses {label}  Tab')
    typed(keys, '\r')
    assert keys.view().chosen == label
    assert typed(keys, 's') == [KeyPress('stop', label)]


def test_name_prompt_lists_matches(keys):
    typed(keys, ':')
    # Enter would choose none
    assert 'Enter' not in keys.view().hint
    typed(keys, 'bath')
    assert keys.view().hint.endswith('Esc goes back  bathroom')


def test_name_prompt_without_match_shows_a_note(keys):
    typed(keys, ':zz')
    assert 'no process' in keys.view().hint
    typed(keys, '\r')
    assert "'zz'" in keys.view().note
    assert keys.view().chosen is None
    for way_out in (':\x7f', ':\r', ':a\x07'):
        typed(keys, way_out)
        assert keys.view().prompt is None
        assert keys.view().chosen is None


def test_attached_process_gets_edited_lines(keys):
    keys.attach('bath')
    assert typed(keys, 'wärm\x1b[D') == []
    view = keys.view()
    assert (view.prompt, view.typed, view.cursor) == ('bath> ', 'wärm', 3)
    assert view.chosen == 'bath'
    assert 'Ctrl-] goes back' in view.hint
    assert typed(keys, 'q\r\x1b[A') == [Typed('wärqm\n'.encode())]
    assert keys.view().typed == 'wärqm'
    assert typed(keys, '\x15\t\x04\x01') == []
    assert keys.view().typed == ' '
    assert typed(keys, '\x0b\x04') == [Typed(b'\x04')]
    assert typed(keys, 'x\x1dq') == [
        KeyPress('detach', 'bath'),
        KeyPress('quit'),
    ]
    # what was not sent is there again
    keys.attach('bath')
    assert keys.view().typed == 'x'
    keys.attach('kitchen')
    assert keys.view().typed == ''


def test_pasted_text_is_sent_line_by_line(keys):
    keys.attach('bath')
    pasted = '\x1b[200~one\rtwo\nthree\x1b[201~'
    assert typed(keys, pasted) == [Typed(b'one\n'), Typed(b'two\n')]
    assert keys.view().typed == 'three'


def test_ctrl_d_in_an_empty_line_ends_the_input(keys):
    keys.attach('bath')
    assert typed(keys, '\x04') == [Typed(b'\x04')]
    assert 'bath' in keys.view().note
    # in a line it deletes
    assert typed(keys, 'ab\x01\x04') == []
    assert (keys.view().typed, keys.view().note) == ('b', '')


def test_secret_input_is_masked_and_not_remembered(keys):
    keys.attach('bath', is_secret=True)
    typed(keys, 'word')
    assert keys.view().typed == '****'
    assert typed(keys, '\r\x1b[A') == [Typed(b'word\n')]
    assert keys.view().typed == ''


def test_keys_after_attach_go_to_the_process(keys):
    done = []
    assert typed(keys, '2') == []
    assert keys.view().chosen == 'bath'
    assert 's stop' in keys.view().hint
    for command in keys.feed(b'aq\r\x1d1s'):
        done.append(command)
        if command == KeyPress('attach', 'bath'):
            keys.attach('bath', is_raw=True)
    assert done[1:] == [
        Typed(b'q\r'),
        KeyPress('detach', 'bath'),
        KeyPress('stop', 'kitchen'),
    ]


def test_key_for_a_dropped_process_does_nothing(process):
    model = StatusModel(planned_state(process('kitchen')))
    keys = Keys(model)
    typed(keys, '1')
    model.state.apply(events.Dropped(process('kitchen')))
    assert typed(keys, 's') == []


PIECES = st.one_of(
    st.binary(max_size=3),
    st.sampled_from([b'1', b':ba', b'/', b'\r', b'\x1b[A', b'\x1d', b'm']),
)


@settings(max_examples=40, deadline=None)
@given(st.lists(PIECES, max_size=15))
def test_split_bytes_have_the_same_effect(pieces):
    whole, split = keys_of('a', 'bath'), keys_of('a', 'bath')
    commands = _do(whole, [b''.join(pieces)])
    assert commands == _do(split, pieces)
    assert whole.view() == split.view()


def _do(keys, pieces):
    commands = []
    for piece in pieces:
        for command in keys.feed(piece):
            if isinstance(command, KeyPress) and command.name == 'attach':
                keys.attach(command.label)
            commands.append(command)
    return commands
