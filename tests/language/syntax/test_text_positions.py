# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The caret stands under the very token, however the text is written."""

from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.text import Text
from colcon_yamllaunch.language.syntax.yaml_reader import read_yaml
from hypothesis import given
from hypothesis import strategies as st
import pytest
from support.language_fixtures import Marked, source
import yaml


@pytest.mark.parametrize(
    'marked',
    [
        # plain
        'a: «$(nope) x',
        'a: b $(var c) «$(nope)',
        'a:   b«$(nope)c   # $(nope)',
        'a: b\n   c\n  «$(nope) d',
        'a: b $(var c)\n\n\n  c «$(nope)',
        '- - - b: «$(nope)',
        '{a: b, c: d«$(nope)}',
        '[a, «$(nope)]',
        'a:\n  «$(nope)',
        '? «$(nope)\n',
        # after text that is not ASCII
        'é: ü 漢 😀 «$(nope)',
        '# 漢字\n漢: «$(nope)',
        'a: "漢\\u6f22«$(nope)"',
        # single quotes
        "a: '«$(nope)'",
        "a: 'it''s «$(nope)'",
        "a: 'b\n\n  ''c'' «$(nope)'",
        "a: '   b   «$(nope)'",
        # double quotes
        'a: "«$(nope)"',
        'a: "b\\"c\\n\\t\\\\ «$(nope)"',
        'a: "\\x41\\u00e9\\U0001F600 «$(nope)"',
        'a: "b\n\n\n   \\"c «$(nope)"',
        'a: "b \\\n   \\ c«$(nope)"',
        'a: "b\\\n\n   c «$(nope)"',
        'a: "b\n   \\   c «$(nope)"',
        'a: "\\x24(var b) «$(nope)"',
        # literal and folded
        'a: |\n  «$(nope)\n',
        'a: |\n  b\n    c\n\n  d «$(nope)\n',
        'a: |-\n  b «$(nope)\n  c\n',
        'a: |2+\n    b\n   «$(nope)\n',
        'a: | # a comment\n  «$(nope)\n',
        'a: >\n  b\n  c «$(nope)\n',
        'a: >-\n\n  b\n\n\n    c\n  «$(nope)\n',
        '- |\n  é\n  «$(nope)\n',
        # with properties
        'a: &x «$(nope)',
        'a: !!str "«$(nope)"',
        'a: &x !!str |\n  b «$(nope)\n',
        'a: !!str &x\n  b «$(nope)',
        'a: &x b\nc: «$(nope)',
        # lines that end as on Windows
        'a: b\r\n  c «$(nope)\r\n',
        'a: |\r\n  b\r\n  c «$(nope)\r\n',
        'a: "b\r\n\r\n  c «$(nope)"\r\n',
        'a: "b\\\r\n  c «$(nope)"\r\n',
    ],
)
def test_unknown_substitution(marked):
    mark = Marked.of(marked)
    with pytest.raises(LaunchError, match="'nope'") as raised:
        read_texts(read_yaml(source(mark.text)))
    diagnostic = raised.value.diagnostics[0]
    mark.check(diagnostic)
    assert diagnostic.length == len('$(nope')


def read_texts(value):
    if hasattr(value, 'text'):
        Text(value)
    for key, item in getattr(value, 'pairs', {}).values():
        read_texts(key)
        read_texts(item)
    for item in getattr(value, 'items', ()):
        read_texts(item)


@pytest.mark.parametrize(
    'marked',
    [
        'a: x $(var a« )',
        "a: 'x $(var b« )'",
        'a: "\\t$(var \\"b\\"«\\"c\\")"',
        'a: >\n  x\n  $(var b« )\n',
        'a: «$(var b',
        'a: |-\n  b\n  «$(var\n',
        'a: b\n  $(var «$(1))',
    ],
)
def test_syntax_error(marked):
    mark = Marked.of(marked)
    with pytest.raises(LaunchError) as raised:
        read_texts(read_yaml(source(mark.text)))
    mark.check(raised.value.diagnostics[0])


@given(
    st.text('ab$()é漢😀 \n\t\'"\\:#-', max_size=30),
    st.sampled_from([None, "'", '"', '|', '>']),
    st.integers(5, 30),
    st.booleans(),
    st.booleans(),
)
def test_each_character_is_found(text, style, width, is_ascii, is_windows):
    # letters become characters of their own, so that each is found only once
    text = ''.join(
        chr(0x4E00 + index) if character in 'ab' else character
        for index, character in enumerate(text)
    )
    raw = 'é: 1\n' + yaml.dump(
        {'key': [text]},
        default_style=style,
        width=width,
        allow_unicode=not is_ascii,
    )
    if is_windows:
        raw = raw.replace('\n', '\r\n')
    scalar = read_yaml(source(raw)).pairs['key'][1].items[0]
    found = Text(scalar, plain=True)
    lines = raw.split('\n')
    for index, character in enumerate(scalar.text):
        if character.isspace():
            continue
        position = found.position_at(index)
        there = lines[position.line - 1][position.column - 1 :]
        escape = f'\\u{ord(character):04X}'
        assert there.startswith((character, '\\', escape))
        if '一' <= character <= '丿':
            wanted = character if character in raw else escape
            assert there.startswith(wanted)
