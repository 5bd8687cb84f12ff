# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Command lines are split as a POSIX shell splits them."""

import shlex
import time

from colcon_yamllaunch.language.syntax.text import (
    parse_template,
    split_command_line,
    Substitution,
    Template,
    UnclosedQuoteError,
)
from hypothesis import given
from hypothesis import strategies as st
import pytest


def split(text: str) -> list[str]:
    """Split a text, each substitution being shown as <name>."""
    return [
        ''.join(
            f'<{part.name}>' if isinstance(part, Substitution) else part
            for part in argument.parts
        )
        for argument in split_command_line(parse_template(text))
    ]


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('', []),
        (' \t\n ', []),
        ('prog', ['prog']),
        ('prog  --a\tb\nc ', ['prog', '--a', 'b', 'c']),
        ('prog \'a b\' "c d"', ['prog', 'a b', 'c d']),
        ('prog \'\' ""', ['prog', '', '']),
        ("prog a'b c'd", ['prog', 'ab cd']),
        ('prog "it\'s"', ['prog', "it's"]),
        ('a#b # c', ['a#b', '#', 'c']),
        # a substitution is one argument, or a part of one
        ('$(a)', ['<a>']),
        ('prog $(a)', ['prog', '<a>']),
        ('prog $(a)$(b) x$(c)y', ['prog', '<a><b>', 'x<c>y']),
        ('prog "$(a)"', ['prog', '<a>']),
        ("prog 'x $(a) y' z", ['prog', 'x <a> y', 'z']),
        ("bash -c 'echo $(a)'", ['bash', '-c', 'echo <a>']),
        ('$(a) $(b)', ['<a>', '<b>']),
        # a backslash for the text leaves one for the command line
        (r'a\\ b', ['a b']),
        (r'a\ b', ['a', 'b']),
        (r"'a\\b'", [r'a\b']),
        (r'"a\\"b"', ['a"b']),
        (r'"a\\b"', [r'a\b']),
        (r'a\\\\b', [r'a\b']),
        (r'a\\', ['a\\']),
    ],
)
def test_split(text, expected):
    assert split(text) == expected


@pytest.mark.parametrize(
    ('text', 'quote'),
    [("a 'b", "'"), ('a "b', '"'), ("'$(a)", "'"), ('"a\'', '"')],
)
def test_open_quote(text, quote):
    with pytest.raises(UnclosedQuoteError, match=quote):
        split(text)


def by_shlex(text: str) -> list[str] | None:
    try:
        return shlex.split(text)
    except ValueError:
        return None


@given(st.text('ab \'"\\\t\n#$;|é'))
def test_text_is_split_as_shlex_does(text):
    expected = by_shlex(text)
    template = Template((text,))
    if expected is None:
        # where we are milder: a backslash at the end stands for itself
        if not text.endswith('\\'):
            with pytest.raises(UnclosedQuoteError):
                split_command_line(template)
        return
    arguments = split_command_line(template)
    assert [argument.literal for argument in arguments] == expected


@given(st.lists(st.text()))
def test_quoted_words_come_back(words):
    arguments = split_command_line(Template((shlex.join(words),)))
    assert [argument.literal for argument in arguments] == words


def test_long_word_takes_linear_time() -> None:
    def seconds(length: int) -> float:
        start = time.process_time()
        assert split('a' * length) == ['a' * length]
        return time.process_time() - start

    # quadratic time would be 400 times as long
    assert seconds(600_000) < 120 * max(seconds(30_000), 0.005)
