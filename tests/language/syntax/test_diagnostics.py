# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How problems are shown, and what is suggested."""

from colcon_yamllaunch.common.suggestions import did_you_mean, listing, nearest
from colcon_yamllaunch.language.syntax.diagnostics import (
    Diagnostic,
    LaunchError,
    MAXIMUM_INCLUDES,
    MAXIMUM_LINE_WIDTH,
    render,
)
from colcon_yamllaunch.plan.position import Position
import pytest


def shown(tmp_path, text, line, column, length=1, encoding='utf-8'):
    """Return the two lines that show where a problem is."""
    path = tmp_path / 'demo.yaml'
    path.write_bytes(text.encode(encoding))
    position = Position(str(path), line, column)
    diagnostic = Diagnostic('error', 'm', position, length=length)
    return render([diagnostic], str(tmp_path)).splitlines()[1:]


@pytest.mark.parametrize(
    ('text', 'line', 'column', 'length', 'expected'),
    [
        ('a: bcd\n', 1, 4, 3, ['  1 | a: bcd', '    |    ^^^']),
        ('a\n\nb: c', 3, 1, 1, ['  3 | b: c', '    | ^']),
        ('\n' * 11 + 'ab\n', 12, 2, 1, ['  12 | ab', '     |  ^']),
        ('a: b\r\nc\r\n', 1, 4, 1, ['  1 | a: b', '    |    ^']),
        # behind the end of the line
        ('a:\n', 1, 3, 5, ['  1 | a:', '    |   ^']),
        ('ab\n', 1, 2, 99, ['  1 | ab', '    |  ^']),
        # a tab is one space wide, other control characters are not shown
        ('\ta\n', 1, 2, 1, ['  1 |  a', '    |  ^']),
        ('\x1b[2Ja\n', 1, 5, 1, ['  1 | \ufffd[2Ja', '    |     ^']),
        # wide and combining characters
        ('é: b\n', 1, 4, 1, ['  1 | é: b', '    |    ^']),
        ('漢字: b\n', 1, 5, 1, ['  1 | 漢字: b', '    |       ^']),
        ('a: 漢字\n', 1, 4, 2, ['  1 | a: 漢字', '    |    ^^^^']),
        ('😀 b\n', 1, 3, 1, ['  1 | 😀 b', '    |    ^']),
        ('e\u0301: b\n', 1, 5, 1, ['  1 | e\u0301: b', '    |    ^']),
        # no such line
        ('a\n', 9, 1, 1, []),
    ],
)
def test_excerpt(tmp_path, text, line, column, length, expected):
    assert shown(tmp_path, text, line, column, length) == expected


@pytest.mark.parametrize('encoding', ['utf-8-sig', 'utf-16'])
def test_excerpt_of_a_file_with_a_byte_order_mark(tmp_path, encoding):
    lines = shown(tmp_path, 'é: b\n', 1, 4, encoding=encoding)
    assert lines == ['  1 | é: b', '    |    ^']


@pytest.mark.parametrize('column', [1, 50, 500, 2995, 3000])
def test_long_line(tmp_path, column):
    text = ''.join(chr(0x4E00 + n) for n in range(3000))
    line, caret = shown(tmp_path, text + '\n', 1, column, length=1000)
    assert len(line) <= MAXIMUM_LINE_WIDTH + len('  1 | ')
    before = caret.index('^')
    # the characters are two columns wide
    index = len('  1 | ') + (before - len('  1 | ')) // 2
    assert line[index] == text[column - 1]


def test_file_that_is_gone(tmp_path):
    diagnostic = Diagnostic('error', 'm', Position('/nowhere/a.yaml', 1, 1))
    assert (
        render([diagnostic], str(tmp_path)) == '/nowhere/a.yaml:1:1: error: m'
    )


def test_several_problems(tmp_path):
    text = render(
        [
            Diagnostic('error', 'first', hint='do it'),
            Diagnostic('warning', 'second'),
        ],
        str(tmp_path),
    )
    assert text.splitlines() == [
        'colcon launch: error: first',
        '  help: do it',
        'colcon launch: warning: second',
    ]


def test_nothing_to_show(tmp_path):
    assert render([], str(tmp_path)) == ''


def test_paths_are_as_short_as_can_be(tmp_path):
    folder = tmp_path / 'ws'
    places = [tmp_path / 'ws/src/a.yaml', tmp_path / 'other/b.yaml']
    diagnostics = [
        Diagnostic('error', 'm', Position(str(path), 1, 2)) for path in places
    ]
    assert render(diagnostics, str(folder)).splitlines() == [
        'src/a.yaml:1:2: error: m',
        f'{tmp_path}/other/b.yaml:1:2: error: m',
    ]


def includes_of(count):
    return tuple(Position(f'/x/{n}.yaml', n, 1) for n in range(1, count + 1))


@pytest.mark.parametrize('count', [0, 1, MAXIMUM_INCLUDES])
def test_includes(count):
    diagnostic = Diagnostic('error', 'm', includes=includes_of(count))
    assert render([diagnostic], '/x').splitlines()[1:] == [
        f'  included from {n}.yaml:{n}:1' for n in range(1, count + 1)
    ]


def test_of_many_includes_the_first_and_last_are_shown():
    diagnostic = Diagnostic('error', 'm', includes=includes_of(30))
    lines = render([diagnostic], '/x').splitlines()[1:]
    assert len(lines) == MAXIMUM_INCLUDES + 1
    assert lines[0] == '  included from 1.yaml:1:1'
    assert lines[MAXIMUM_INCLUDES // 2] == '  … 22 more'
    assert lines[-1] == '  included from 30.yaml:30:1'


def test_included_from_adds_to_every_diagnostic():
    inner, outer = includes_of(2)
    problem = LaunchError(Diagnostic('error', 'a'), Diagnostic('error', 'b'))
    problem = problem.included_from(inner).included_from(outer)
    assert [d.includes for d in problem.diagnostics] == [(inner, outer)] * 2
    assert str(problem) == 'a'


@pytest.mark.parametrize(
    ('word', 'names', 'expected'),
    [
        ('nod', ['node', 'log'], 'node'),
        ('launch_prefix', ['launch-prefix', 'name'], 'launch-prefix'),
        ('NAME', ['name'], 'name'),
        ('zzz', ['node', 'log'], None),
        ('', ['node'], None),
        ('node', [], None),
        # of two that are equally near, always the same
        ('a_b', ['a-b', 'A_B'], 'A_B'),
        ('a_b', ['A_B', 'a-b'], 'A_B'),
    ],
)
def test_nearest(word, names, expected):
    assert nearest(word, names) == expected


def test_did_you_mean():
    assert did_you_mean('nod', ['node']) == "did you mean 'node'?"
    assert did_you_mean('nod', []) is None


def test_listing():
    assert listing({'b', 'a'}) == 'a, b'
