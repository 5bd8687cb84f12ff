# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""An expression finds in many lines what it finds in one of them."""

import re
import time

from colcon_yamllaunch.engine import line_pattern
from colcon_yamllaunch.engine.line_pattern import LinePattern, SearchTimeError
from hypothesis import given
from hypothesis import strategies as st
import pytest

WORDS = r"""
\s \S \d \D \w \W \b \B \A \Z \n \x0a [^a] [ab] (a|b) (?:a) (?i) (?s)
(?P<x>a) (?=a) (?!a) (?<=a) (?<!a) .* .*? [!-~] é
"""
PIECES = st.sampled_from([*'ab.^$|*+? -', '\n', *WORDS.split()])
LINES = st.lists(st.text('abAB 1é\t', max_size=4), min_size=1, max_size=4)


@given(st.lists(PIECES, max_size=6).map(''.join), LINES, st.booleans())
def test_many_lines_are_as_good_as_one(text, lines, ends):
    try:
        pattern = LinePattern(text)
    except re.error:
        return
    expected = any(re.search(text, line) for line in lines)
    joined = '\n'.join(lines) + '\n' * ends
    assert pattern.is_in(joined) == expected


@pytest.mark.hostile
@pytest.mark.parametrize('text', ['.*ready', '.*?ready$', '.*.*(r|t)eady'])
def test_a_long_line_is_searched_at_once(text):
    pattern = LinePattern(text)
    line = 'x' * 300_000
    assert not pattern.is_in(line)
    assert pattern.is_in(f'{line}ready')


@pytest.mark.hostile
@pytest.mark.parametrize(
    ('text', 'lines'),
    [
        ('(a+)+$', 'a' * 40 + 'b'),
        ('[a-z]+ready', 'x' * 300_000),
        ('(x*)(x*)ready', 'x' * 16_000_000),
        ('(?:x|y)*?ready', 'x' * 8000 + '\n' + 'x' * 300_000),
    ],
)
def test_a_search_ends_in_its_time(text, lines):
    pattern = LinePattern(text)
    before = time.process_time()
    with pytest.raises(SearchTimeError):
        pattern.is_in(lines)
    assert time.process_time() - before < 20 * line_pattern.SEARCH_TIME


@pytest.mark.parametrize(
    ('text', 'line', 'expected'),
    [
        ('^b', 'a{}b', False),
        ('a$', 'a{}b', False),
        ('^ab', 'ab{}', True),
        ('b$', 'a{}b', True),
        (r'a\s*\Z', 'a{}b', False),
        (r'(?<=a) ', 'b{}a b', True),
        (r' (?!a)b', 'a{} a b', True),
        (r' (?!a)b', 'a{} ab', False),
        ('a *b', 'b{}a b', True),
    ],
)
def test_a_long_line_is_searched_as_a_whole(text, line, expected):
    pattern = LinePattern(text)
    for size in range(-3, 4):
        gap = ' ' * (2 * line_pattern.PIECE + size)
        assert pattern.is_in(line.format(gap)) == expected
