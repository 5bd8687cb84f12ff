# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What gets through of the output of a process that has the keyboard."""

import re

from colcon_yamllaunch.terminal.status_writer import InLineOutput
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest


@pytest.mark.parametrize(
    'data',
    [
        b'plain text, \xc3\xa4 and \xff\r\n',
        b'\x1b[1;31mred\x1b[m',
        b'typed\b\b\x1b[K\x1b[2D\x1b[3C\x1b[4G\x1b[1P\x1b[2@',
        b'bell\a and\ttab',
    ],
)
def test_sequences_inside_a_line_pass(data):
    assert InLineOutput().feed(data) == data


@pytest.mark.parametrize(
    'data',
    [
        *(b'\x1b[2J', b'\x1b[H', b'\x1b[5;5H', b'\x1b[A', b'\x1b[B'),
        *(b'\x1b[?25l', b'\x1b[?1049h', b'\x1b[>4m', b'\x1b[1;10r'),
        *(b'\x1b[6n', b'\x1b[!p'),
        *(b'\x1b7', b'\x1b8', b'\x1bD', b'\x1bM', b'\x1bc', b'\x1b(0'),
        *(b'\x1b#8', b'\x1b]0;title\x07', b'\x1b]52;c;eA==\x1b\\'),
        b'\x1bPq\x1b\\',
        *(b'\x0e', b'\x0b', b'\x0c', b'\xc2\x9b2J'[:2], b'\x00\x7f', b'\x9b'),
        b'\xc2\x9b',
    ],
)
def test_sequences_that_leave_the_line_are_removed(data):
    assert InLineOutput().feed(b'a' + data + b'b') == b'ab'
    # wherever it is cut
    for cut in range(len(data) + 1):
        output = InLineOutput()
        assert output.feed(b'a' + data[:cut]) + output.feed(
            data[cut:] + b'b'
        ) == (b'ab')


def test_endless_sequence_is_not_held_back():
    output = InLineOutput()
    shown = output.feed(b'\x1b]' + b'x' * 5000)
    assert len(shown + output.feed(b'after')) > 5000


def test_removal_does_not_join_bytes_into_a_sequence():
    shown = InLineOutput().feed(b'a\xc2\x00\x9b2J\x1b\x00[2J\xc2\xc2\x9b\x9bb')
    assert '\x9b' not in shown.decode(errors='replace')
    assert b'\x1b' not in shown


def test_split_character_is_shown_whole():
    output = InLineOutput()
    data = '\N{BLACK CIRCLE}'.encode()
    assert [output.feed(data[n : n + 1]) for n in range(3)] == [b'', b'', data]


PARTS = st.sampled_from(b'\x1b[?2Jm]P\\\x07;\xc2\x9b\x84\x00\r\n( \xff')
HARMLESS = re.compile(r'\x1b\[[0-9:;]*[mP]')


@settings(max_examples=30)
@given(st.lists(PARTS, max_size=30))
def test_random_bytes_let_only_harmless_sequences_pass(parts):
    output = InLineOutput()
    shown = b''.join(output.feed(bytes([part])) for part in parts).decode(
        errors='replace'
    )
    assert not re.search('[\x1b\x00\x80-\x9f]', HARMLESS.sub('', shown))
