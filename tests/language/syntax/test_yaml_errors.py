# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a user reads after a mistake in the YAML itself."""

from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.syntax.yaml_reader import read_yaml
import pytest
from support.language_fixtures import Marked, source

MISTAKES = {
    'first item of a list deeper than the next': (
        'launch:\n'
        '    - node: {pkg: a, exec: b}\n'
        '  «- node: {pkg: a, exec: c}\n',
        'this list item is indented by 2 spaces, but the list item before it '
        '(line 2) by 4 spaces',
    ),
    'second item deeper than the first': (
        'launch:\n  - node:\n      pkg: a\n    «- node:\n',
        'this list item is indented by 4 spaces, but the list item before it '
        '(line 2) by 2 spaces',
    ),
    'attribute deeper than the one before': (
        'launch:\n  - node:\n      pkg: a\n       «exec: b\n',
        'this line is indented by 7 spaces, deeper than the lines that it '
        'belongs with',
    ),
    'attribute less deep than the one before': (
        'launch:\n  - node:\n      pkg: a\n     «exec: b\n',
        'this line is indented by 5 spaces, but the line before it (line 3) '
        'by 6 spaces',
    ),
    'item beside a key': (
        'a: b\n«- c\n',
        'this list item is indented by 0 spaces',
    ),
    'no space after the colon': (
        'launch:\n  - node:\n      pkg«:a\n      exec: b\n',
        "there is no space after 'pkg:'",
    ),
    'no colon': (
        'launch:\n  - node:\n      exec: b\n      «pkg a\n  - node:\n',
        "there is no ':' in this line",
    ),
    'no colon in the first attribute': (
        'launch:\n  - node:\n      «pkg a\n      exec: b\n',
        "there is no ':' in this line",
    ),
    'no colon behind an action': (
        'launch:\n  - «node\n      pkg: a\n      exec: b\n',
        "there is no ':' in this line",
    ),
    'no colon behind launch': (
        '«launch\n  - node:\n      exec: b\n',
        "there is no ':' in this line",
    ),
    'text of a block that is not indented': (
        'a: |\n«text\nb: c\n',
        "there is no ':' in this line",
    ),
    'tab before an item': (
        'launch:\n«\t- node:\n',
        'a tab stands where YAML wants spaces',
    ),
    'tab before an attribute': (
        'launch:\n  - node:\n«\t\tpkg: a\n',
        'a tab stands where YAML wants spaces',
    ),
    'colon in a value': (
        'a: b«: c\n',
        "a value with ': ' in it must be quoted",
    ),
    'at sign': ('a: «@b\n', "a value cannot start with '@'"),
    'backtick': ('a: «`b`\n', "a value cannot start with '`'"),
    'percent sign': ('a: «%b\n', "a value cannot start with '%'"),
    'comma': ('a: «, b\n', "a value cannot start with ','"),
    'bracket that was not opened': (
        'a: «]\n',
        "a value cannot start with ']'",
    ),
    'star that is no alias': (
        'a: «*.yaml\n',
        "a value cannot start with '*'",
    ),
    'star alone': ('a: «*\n', "a value cannot start with '*'"),
    'ampersand that is no anchor': (
        'a: «& b\n',
        "a value cannot start with '&'",
    ),
    'open double quote': ('a: «"b\nc: d\n', 'this quote is not closed'),
    'open single quote': ("a: «'b\nc: d\n", 'this quote is not closed'),
    'quote that the next one closes': (
        'a: "b\nc: "«d"\n',
        'the value ended before this text',
    ),
    'text after a quote': (
        'a: "b" «c\n',
        'the value ended before this text',
    ),
    'text after a brace': (
        'a: {b: c} «d\n',
        'the value ended before this text',
    ),
    'value that starts with a brace': (
        'a: {b}«/c\n',
        'the value ended before this text',
    ),
    'open brace': ('a: «{b: c\nd: e\n', "this '{' is not closed"),
    'open bracket': ('a: «[b, c\n', "this '[' is not closed"),
    'open bracket at the very end': ('a: «[b', "this '[' is not closed"),
    'nothing behind a comma': ('a: [b,«', 'a value is missing here'),
    'no comma between attributes': (
        'a: {b: c d«: e}\n',
        "'}' or ',' is missing before this",
    ),
    'unknown escape': (
        'a: "x«\\$(b)"\n',
        "YAML does not know this '\\' in double quotes",
    ),
    'escape without its digits': (
        'a: "x\\x«Z"\n',
        "YAML does not know this '\\' in double quotes",
    ),
}


@pytest.mark.parametrize('name', MISTAKES)
def test_mistake(name):
    marked, message = MISTAKES[name]
    mark = Marked.of(marked)
    with pytest.raises(LaunchError) as raised:
        read_yaml(source(mark.text))
    (diagnostic,) = raised.value.diagnostics
    assert diagnostic.message == message
    mark.check(diagnostic)


@pytest.mark.parametrize(
    'text',
    [
        'a: 1\n...\nb: 2\n',
        '%YAML 3.0\n---\na: 1\n',
        '%FOO\n---\na: 1\n',
        'a: |x\n  b\n',
        'a: !e!x b\n',
        'a: !<x b\n',
        'a' * 2000 + ': 1\n',
        '"a\nb": 1\n',
        '[a,',
        '{',
        '"',
        '- - -\n - ?\n :\n',
    ],
)
def test_any_other_mistake_has_a_place(text):
    with pytest.raises(LaunchError) as raised:
        read_yaml(source(text))
    position = raised.value.diagnostics[0].position
    assert 1 <= position.line <= text.count('\n') + 1
    assert position.column >= 1
