# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""An expression finds in many lines what it finds in one of them."""

import re

from colcon_yamllaunch.runtime.streams.line_pattern import LinePattern
from hypothesis import given
from hypothesis import strategies as st
import pytest

PIECES = st.sampled_from(
    [
        *'ab.^$|*+? -',
        r'\s',
        r'\S',
        r'\d',
        r'\D',
        r'\w',
        r'\W',
        r'\b',
        r'\B',
        r'\A',
        r'\Z',
        r'\n',
        r'\x0a',
        '\n',
        '[^a]',
        '[ab]',
        '(a|b)',
        '(?:a)',
        '(?i)',
        '(?s)',
        '(?P<x>a)',
        '(?=a)',
        '(?!a)',
        '(?<=a)',
        '(?<!a)',
        '.*',
        '[!-~]',
        'é',
    ]
)
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


@pytest.mark.parametrize(
    ('text', 'line'),
    [
        ('Received .* which double is', 'Received 4 which double is 8'),
        ('^ready$', 'ready'),
        ('(?i)READY', 'ready'),
        (r'value: \d+', 'value: 12'),
        (r'^[^ ]+\s+up', 'node   up'),
        (r'\AStart(?!ed)', 'Starting'),
    ],
)
def test_an_expression_is_found_in_its_line(text, line):
    pattern = LinePattern(text)
    assert pattern.is_in(f'one\n{line}\ntwo\n')
    assert pattern.is_in(line)
    assert not pattern.is_in('one\ntwo\n')


def test_a_match_does_not_reach_over_a_line_end():
    assert not LinePattern(r'one\s+two').is_in('one\ntwo\n')
    assert not LinePattern('one[^x]two').is_in('one\ntwo\n')


def test_no_expression_is_refused():
    with pytest.raises(re.error):
        LinePattern('a(')
