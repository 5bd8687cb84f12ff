# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A line that is typed."""

from colcon_yamllaunch.terminal.keys import InputLine, LONGEST, REMEMBERED
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

NAMES = (
    *('left', 'right', 'home', 'end', 'ctrl-left', 'ctrl-right', 'alt-b'),
    *('alt-f', 'backspace', 'delete', 'ctrl-w', 'alt-backspace', 'alt-d'),
    *('ctrl-u', 'ctrl-k', 'ctrl-y', 'up', 'down', 'tab', 'ctrl-a', 'ctrl-e'),
)
KEYS = st.one_of(
    st.characters(categories=('L', 'N', 'P', 'S', 'Z', 'M')),
    st.sampled_from(NAMES),
)


def typed(text, *keys):
    line = InputLine()
    for key in (*text, *keys):
        line.press(key)
    return line


@pytest.mark.parametrize(
    ('keys', 'before', 'after'),
    [
        ([], 'one two-three', ''),
        (['left', 'left'], 'one two-thr', 'ee'),
        (['home', 'right'], 'o', 'ne two-three'),
        (['ctrl-a', 'ctrl-e'], 'one two-three', ''),
        (['alt-b'], 'one two-', 'three'),
        (['ctrl-left', 'ctrl-left'], 'one ', 'two-three'),
        (['home', 'alt-f', 'alt-f'], 'one two', '-three'),
        (['backspace', 'x'], 'one two-threx', ''),
        (['home', 'delete', 'ctrl-d'], '', 'e two-three'),
        (['ctrl-w'], 'one ', ''),
        (['alt-backspace'], 'one two-', ''),
        (['home', 'alt-d'], '', ' two-three'),
        (['alt-b', 'ctrl-u'], '', 'three'),
        (['alt-b', 'ctrl-k'], 'one two-', ''),
        (['ctrl-w', 'home', 'ctrl-y'], 'two-three', 'one '),
        (['home', 'left', 'backspace'], '', 'one two-three'),
    ],
)
def test_key_edits_line_and_moves_cursor(keys, before, after):
    line = typed('one two-three', *keys)
    assert line.text[: line.cursor] == before
    assert line.text[line.cursor :] == after


def test_combining_accent_is_deleted_with_its_letter():
    line = typed('e\u0301x', 'left', 'backspace')
    assert (line.text, line.cursor) == ('x', 0)


def test_up_and_down_recall_history():
    line = InputLine(['first', 'second'])
    line.press('d')
    for key, text in (
        ('up', 'second'),
        ('up', 'first'),
        ('up', 'first'),
        ('down', 'second'),
        ('down', 'd'),
        ('down', 'd'),
    ):
        line.press(key)
        assert line.text == text
    assert line.enter() == 'd'
    assert (line.text, line.cursor) == ('', 0)
    assert line.history == ['first', 'second', 'd']


def test_blank_repeated_and_secret_lines_are_not_remembered():
    line = InputLine(['a'])
    for text, remember in (('a', True), ('  ', True), ('secret', False)):
        line.set(text)
        line.enter(remember=remember)
    assert line.history == ['a']
    for number in range(REMEMBERED + 5):
        line.set(str(number))
        line.enter()
    assert len(line.history) == REMEMBERED
    assert line.history[-1] == str(REMEMBERED + 4)


def test_other_keys_do_not_edit():
    line = typed('one', 'esc', 'ctrl-]')
    assert (line.text, line.cursor) == ('one', 3)


def test_line_length_is_limited_in_bytes():
    line = InputLine()
    line.set('ä' * (LONGEST // 2))
    line.press('x')
    assert len(line.text.encode()) == LONGEST
    assert 'x' not in line.text


@settings(max_examples=40, deadline=None)
@given(st.lists(KEYS, max_size=40))
def test_random_keys_keep_cursor_in_line(keys):
    line = InputLine(['a line', 'wörter und 漢字'])
    for key in keys:
        line.press(key)
        assert 0 <= line.cursor <= len(line.text)
    text = line.text
    assert line.enter() == text
