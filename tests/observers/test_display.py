# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which streams are terminals that something may stay at the end of."""

import os

from colcon_yamllaunch.observers import presentation
import pytest


@pytest.fixture
def terminals():
    """Return two terminals, as text streams."""
    pairs = os.openpty(), os.openpty()
    streams = [os.fdopen(one, 'w', encoding='utf-8') for _, one in pairs]
    yield streams
    for stream in streams:
        stream.close()
    for one, _ in pairs:
        os.close(one)


@pytest.mark.parametrize(
    ('environment', 'expected'),
    [
        ({'TERM': 'xterm-256color'}, True),
        ({'TERM': 'vt100', 'NO_COLOR': '1'}, True),
        ({'TERM': 'xterm', 'CI': ''}, True),
        ({'TERM': 'xterm', 'CI': 'true'}, False),
        ({'TERM': 'dumb'}, False),
        ({'TERM': ''}, False),
        ({}, False),
    ],
)
def test_environment_decides_about_the_status_block(
    terminals, environment, expected
):
    assert presentation.can_have_status(terminals[0], environment) is expected


def test_file_has_no_status_block(tmp_path):
    with (tmp_path / 'screen').open('w') as stream:
        assert not presentation.can_have_status(stream, {'TERM': 'xterm'})
        assert not presentation.is_same_terminal(stream, stream.fileno())


def test_keyboard_of_another_terminal_is_not_used(terminals):
    one, other = terminals
    assert presentation.is_same_terminal(one, one.fileno())
    assert not presentation.is_same_terminal(one, other.fileno())
    assert not presentation.is_same_terminal(None, one.fileno())


@pytest.mark.parametrize(
    ('terminal', 'expected'),
    [('xterm', False), ('vte', False), ('linux', True), ('vt220', True)],
)
def test_term_decides_about_ascii(terminals, terminal, expected):
    display = presentation.Display(terminals[0], None, {'TERM': terminal})
    display.writer.close()
    assert display.is_ascii is expected
