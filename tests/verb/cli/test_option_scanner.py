# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which words are options, which are their values, and how to write them."""

from colcon_yamllaunch.verb.cli.option_scanner import normalised
from colcon_yamllaunch.verb.cli.option_scanner import scan
from colcon_yamllaunch.verb.cli.option_table import options_of
from hypothesis import given
from hypothesis import strategies as st
import pytest

WORDS = st.lists(
    st.sampled_from(
        [*options_of('launch'), '--check=json', '--until=-x', '--', '-x', 'a']
    ),
    max_size=8,
)


@given(words=WORDS)
def test_each_word_is_in_one_item(words: list[str]) -> None:
    items = list(scan(words, 'launch'))
    assert [word for item in items for word in item.words] == words
    for item in items:
        assert words[item.index] == item.words[0]


@given(words=WORDS)
def test_words_are_normalised_once(words: list[str]) -> None:
    once = normalised(words, 'launch')
    assert normalised(once, 'launch') == once


@pytest.mark.parametrize(
    ('line', 'expected'),
    [
        ('--check pkg file', '--check=text pkg file'),
        ('--check=json pkg', '--check=json pkg'),
        ('pkg --status', 'pkg --status=text'),
        ('--until --stop pkg', '--until=--stop pkg'),
        ('--build-args --no-build pkg', '--build-args=--no-build pkg'),
        ('--workspace --check', '--workspace --check=text'),
        ('--stop --of 3 a', '--stop --of 3 a'),
        ('--until', '--until'),
    ],
)
def test_words_that_argparse_cannot_tell(line: str, expected: str) -> None:
    assert normalised(line.split(), 'launch') == expected.split()


@pytest.mark.parametrize(
    ('line', 'positionals'),
    [
        ('--workspace /ws pkg file', ['pkg', 'file']),
        ('--stop a b --of 3', []),
        ('--paths a b -- pkg', ['pkg']),
        ('--unknown pkg', ['pkg']),
        ('--timeout -1 pkg', ['pkg']),
    ],
)
def test_values_are_no_positionals(line: str, positionals: list[str]) -> None:
    items = scan(line.split(), 'launch')
    found = [item.words[0] for item in items if item.is_positional]
    assert found == positionals
