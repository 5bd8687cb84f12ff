# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What gets through of the output of a process that has the keyboard."""

from colcon_yamllaunch.runtime.terminal.tame import Tame
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
def test_what_stays_in_its_line_passes(data):
    assert Tame().feed(data) == data


@pytest.mark.parametrize(
    'data',
    [
        b'\x1b[2J',
        b'\x1b[H',
        b'\x1b[5;5H',
        b'\x1b[A',
        b'\x1b[B',
        b'\x1b[?25l',
        b'\x1b[?1049h',
        b'\x1b[>4m',
        b'\x1b[1;10r',
        b'\x1b[6n',
        b'\x1b[!p',
        b'\x1b7',
        b'\x1b8',
        b'\x1bD',
        b'\x1bM',
        b'\x1bc',
        b'\x1b(0',
        b'\x1b#8',
        b'\x1b]0;title\x07',
        b'\x1b]52;c;eA==\x1b\\',
        b'\x1bPq\x1b\\',
        b'\x0e',
        b'\x0b',
        b'\x0c',
        b'\xc2\x9b2J'[:2],
        b'\x00\x7f',
    ],
)
def test_what_leaves_the_line_vanishes(data):
    assert Tame().feed(b'a' + data + b'b') == b'ab'
    # wherever it is cut
    for cut in range(len(data) + 1):
        tame = Tame()
        assert tame.feed(b'a' + data[:cut]) + tame.feed(data[cut:] + b'b') == (
            b'ab'
        )


def test_a_sequence_without_end_is_not_waited_for():
    tame = Tame()
    shown = tame.feed(b'\x1b]' + b'x' * 5000)
    assert len(shown + tame.feed(b'after')) > 5000
