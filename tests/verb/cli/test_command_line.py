# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How words are written for argparse, and which are no options."""

from argparse import Namespace

from colcon_yamllaunch.verb.command_line import (
    split_line,
    written_for_argparse,
)
from colcon_yamllaunch.verb.options import LaunchOptions
from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.user import User

WORDS = st.lists(
    st.sampled_from(
        [*LaunchOptions.by_flag(), '--check=json', '--until=-x', '-x', 'a']
    ),
    max_size=8,
)


@given(words=WORDS)
def test_words_are_written_once(words: list[str]) -> None:
    once = written_for_argparse(words, 'launch')
    assert written_for_argparse(once, 'launch') == once


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
def test_values_that_argparse_mistakes_get_a_sign(
    line: str, expected: str
) -> None:
    assert written_for_argparse(line.split(), 'launch') == expected.split()


@pytest.mark.parametrize(
    ('line', 'positionals'),
    [
        ('--workspace /ws pkg file', ['pkg', 'file']),
        ('--stop a b --of 3', []),
        ('--unknown pkg', ['--unknown', 'pkg']),
        ('--timeout -1 pkg', ['pkg']),
    ],
)
def test_values_are_no_positionals(line: str, positionals: list[str]) -> None:
    _, words, _ = split_line(Namespace(positionals=line.split()))
    assert words == positionals


@pytest.mark.parametrize(
    'words',
    [
        ('launch', 'a.yaml', '--stop=--'),
        ('launch', '--check=--', 'a.yaml'),
        ('sweep', '--for', '--', 'a.yaml', '--until=--'),
        ('run', '--paths=--', 'pkg', 'program'),
    ],
)
def test_separator_is_no_value(user: User, words: tuple[str, ...]) -> None:
    started = user.start('colcon', *words)
    assert started.end() == 1
    assert started.output.startswith(f'colcon {words[0]}: error: --')
    assert "takes no value '--': leave it out" in started.output
