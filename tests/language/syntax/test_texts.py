# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The grammar of substitutions (ROS 2's `launch/frontend/grammar.lark`)."""

from colcon_yamllaunch.language.syntax.text import (
    MAXIMUM_DEPTH,
    parse_template,
    Substitution,
    Template,
    TemplateSyntaxError,
    unescape,
)
from hypothesis import given
from hypothesis import strategies as st
import pytest


def simple(template: Template) -> list[object]:
    """Return texts as they are, substitutions as (name, *arguments)."""
    return [
        (part.name, *map(simple, part.arguments))
        if isinstance(part, Substitution)
        else part
        for part in template.parts
    ]


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('', []),
        ('plain text', ['plain text']),
        ('two\nlines', ['two\nlines']),
        ('a b', ['a b']),
        # a dollar is a text unless a bracket follows it
        ('$', ['$']),
        ('$HOME ${HOME} 5$', ['$HOME ${HOME} 5$']),
        ('$ (a)', ['$ (a)']),
        ('$$(a)', ['$', ('a',)]),
        # substitutions
        ('$(a)', [('a',)]),
        ('$(find-pkg-share x)', [('find-pkg-share', ['x'])]),
        ('$(log_dir)', [('log_dir',)]),
        ('x$(a)y$(b)z', ['x', ('a',), 'y', ('b',), 'z']),
        ('$(a b c)', [('a', ['b'], ['c'])]),
        ('$(a b:=[1]{2}=;,)', [('a', ['b:=[1]{2}=;,'])]),
        ('$(a b$c)', [('a', ['b$c'])]),
        # nesting, also for a part of an argument
        ('$(a $(b c))', [('a', [('b', ['c'])])]),
        ('$(a x$(b)y$(c)z)', [('a', ['x', ('b',), 'y', ('c',), 'z'])]),
        # quotes
        ("$(a 'b c')", [('a', ['b c'])]),
        ('$(a "b c" \'d\')', [('a', ['b c'], ['d'])]),
        ("$(a '')", [('a', [])]),
        ('$(a "" x)', [('a', [], ['x'])]),
        ('$(a \'(b) "c"\')', [('a', ['(b) "c"'])]),
        ("$(a 'x $(b) y')", [('a', ['x ', ('b',), ' y'])]),
        ('$(a "x $(b) y")', [('a', ['x ', ('b',), ' y'])]),
        # within quotes, the other kind of quote is a text
        ('$(a \'$(b "c d")\')', [('a', [('b', ['"c'], ['d"'])])]),
        ('$(a "$(b \'c d\')")', [('a', [('b', ["'c"], ["d'"])])]),
        ("'$(a)'", ["'", ('a',), "'"]),
        # backslashes
        (r'a\b', ['ab']),
        (r'a\\b', [r'a\b']),
        (r'\n', ['n']),
        (r'\$(a b)', ['$(a b)']),
        (r'\\$(a b)', [r'\$(a b)']),
        ('back\\', ['back\\']),
        (r'$(a b\)c)', [('a', ['b)c'])]),
        (r'$(a \(b)', [('a', ['(b'])]),
        (r'$(a \"b\')', [('a', ['"b\''])]),
        (r'$(a b\\)', [('a', ['b\\'])]),
        (r"$(a 'it\'s')", [('a', ["it's"])]),
        (r"$(a '\$(b)')", [('a', ['$(b)'])]),
        (r'$(a \$\(b\))', [('a', ['$(b)'])]),
        (r'x\y$(a)\z', ['xy', ('a',), 'z']),
    ],
)
def test_parts(text, expected):
    assert simple(parse_template(text)) == expected


@pytest.mark.parametrize(
    ('text', 'index', 'message'),
    [
        ('$(', 0, 'starts with its name'),
        ('x $()', 2, 'starts with its name'),
        ('$( a)', 0, 'starts with its name'),
        ('$(1a)', 0, 'starts with its name'),
        ('$(-a)', 0, 'starts with its name'),
        ('ab$(var', 2, 'is not closed'),
        ('$(var a', 0, 'is not closed'),
        ('$(a $(b c)', 0, 'is not closed'),
        ('$(a $(b c', 4, 'is not closed'),
        ('$(a  b)', 3, 'one space'),
        ('$(a b )', 5, 'one space'),
        ('$(a )', 3, 'one space'),
        ('$(a b  c)', 5, 'one space'),
        ("$(a 'b)", 4, 'quote is not closed'),
        ('$(a "b\')', 4, 'quote is not closed'),
        ("$(a 'b'c)", 7, "'c' does not belong here"),
        ("$(a b'c')", 5, 'does not belong here'),
        ("$(a 'b''c')", 7, 'does not belong here'),
        ('$(a (b))', 4, 'does not belong here'),
        ('$(a b(c))', 5, 'does not belong here'),
        ('$(a\tb)', 3, 'does not belong here'),
        ('$(a\nb)', 3, 'does not belong here'),
        ('$(a.b)', 3, "'.' does not belong here"),
        ("$(a '$(b 'c')')", 9, 'does not belong here'),
    ],
)
def test_errors(text, index, message):
    with pytest.raises(TemplateSyntaxError, match=message) as raised:
        parse_template(text)
    assert raised.value.index == index


def test_start_and_end_of_substitutions():
    text = 'ab$(c $(d) "$(e)")f'
    outer = parse_template(text).parts[1]
    found = []
    pending = [outer]
    while pending:
        part = pending.pop()
        found.append(text[part.start : part.end])
        for argument in part.arguments:
            pending += argument.parts
    assert found == ['$(c $(d) "$(e)")', '$(e)', '$(d)']


def nested(depth: int) -> str:
    return '$(a ' * depth + 'x' + ')' * depth


def test_nesting_has_a_limit():
    parse_template(nested(MAXIMUM_DEPTH))
    for depth in (MAXIMUM_DEPTH + 2, 100_000):
        with pytest.raises(TemplateSyntaxError, match='nested more than'):
            parse_template(nested(depth))


def test_a_long_text_takes_one_pass():
    # some megabytes would take minutes if the time grew with the square
    text = r'x\y$$ (' * 300_000 + '$(a)' * 10_000
    assert len(parse_template(text).parts) == 10_001


@given(st.text())
def test_unescape_undoes_doubled_backslashes(text):
    assert unescape(text.replace('\\', '\\\\')) == text


@given(st.text(alphabet=st.characters(exclude_characters='\\$')))
def test_text_without_dollar_and_backslash_is_itself(text):
    assert (parse_template(text).literal or '') == text


WORDS = st.text('ab0 "\'()$\\\t,:', min_size=0, max_size=8)


def quoted(word: str) -> str:
    """Write a text as an argument in quotes, whatever is in it."""
    for character in '\\\'"$':
        word = word.replace(character, f'\\{character}')
    return f"'{word}'"


@given(st.lists(WORDS, max_size=4))
def test_quoted_arguments_are_what_was_quoted(words):
    text = ' '.join(['$(name', *map(quoted, words)]) + ')'
    (part,) = parse_template(text).parts
    assert [argument.literal for argument in part.arguments] == words
