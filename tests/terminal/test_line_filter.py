# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What of the output is shown."""

from colcon_yamllaunch.engine.events import Output
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.terminal.line_filter import (
    FEW,
    Filtering,
    LineFilter,
    MAXIMUM_LIVE,
)
from hypothesis import given, settings
from hypothesis import strategies as st
import pytest


@pytest.fixture
def made(process):
    """Return a function that makes outputs."""
    processes = {}

    def make(text, label='a', stream='stdout'):
        if label not in processes:
            processes[label] = process(label)
        data = text.encode() if isinstance(text, str) else text
        return Output(processes[label], stream, data)

    return make


def line_filter(filtering=None, *, color=False, form=None):
    result = LineFilter(
        color=color, is_ascii=False, form_of=lambda _process: form
    )
    result.filtering = filtering or Filtering()
    return result


def texts(outputs):
    return [(o.process.label, o.data.decode()) for o in outputs]


def shown(one, *outputs):
    """Return all that is shown of outputs, as one text."""
    parts = [part for output in outputs for part in one.shown(output)]
    return ''.join(o.data.decode() for o in (*parts, *one.end()))


def test_output_passes_unchanged_without_filter(made):
    output = made('one\ntwo\n')
    assert line_filter().shown(output) == [output]
    assert line_filter().shown(output)[0] is output
    many = made(''.join(f'{n}\n' for n in range(2 * FEW)))
    assert line_filter(color=True).shown(many)[0] is many


def test_output_for_the_log_only_is_not_shown(made, process):
    one = line_filter()
    quiet = Output(process('a', output='own_log'), 'stdout', b'x\n' * 3)
    assert not list(one.shown(quiet))
    assert not one.is_changing


@pytest.mark.parametrize(
    ('filtering', 'labels'),
    [
        (Filtering(), 'abc'),
        (Filtering(muted=frozenset('b')), 'ac'),
        (Filtering(only=frozenset('b')), 'b'),
        (Filtering(muted=frozenset('a'), only=frozenset('ab')), 'b'),
    ],
)
def test_muted_and_only_select_processes(made, filtering, labels):
    one = line_filter(filtering)
    assert [n for n in 'abc' if one.shown(made('x\n', n))] == list(labels)


def test_search_ignores_case_unless_upper_case_is_typed(made):
    text = 'Hello\nothers\n\x1b[31mHE\x1b[0mLLO\nshell\n'
    found = shown(line_filter(Filtering(search='hello')), made(text))
    assert found == 'Hello\n\x1b[31mHE\x1b[0mLLO\n'
    # upper case is meant
    one = line_filter(Filtering(search='Hello'))
    assert shown(one, made(text)) == 'Hello\n'
    assert shown(line_filter(Filtering(search='[x')), made(text)) == ''


def test_level_filter_keeps_lines_that_follow(made):
    one = line_filter(Filtering(level=Level.WARN))
    assert shown(
        one,
        made('printed\n[INFO] a\n  more of a\n[WARN] b\n'),
        made('  more of b\n[ERROR] [1.2] [n]: c\n[DEBUG] d\nmore of d\n'),
        made('noise\n', stream='stderr', label='b'),
        made('Traceback (most recent call last):\n  x\nE: y\n'),
        made('[INFO] e\n'),
    ) == (
        '[WARN] b\n  more of b\n[ERROR] [1.2] [n]: c\nnoise\n'
        'Traceback (most recent call last):\n  x\nE: y\n'
    )


def test_level_is_read_in_a_custom_format(made):
    one = line_filter(
        Filtering(level=Level.ERROR), form='{name} ({severity}) {message}'
    )
    text = 'a.b (WARN) x\na.b (ERROR) y\n'
    assert shown(one, made(text)) == 'a.b (ERROR) y\n'


def test_level_and_search_apply_together(made):
    one = line_filter(Filtering(level=Level.WARN, search='low'))
    text = '[INFO] low\n[WARN] low\n[WARN] high\n low, too\n'
    assert shown(one, made(text)) == '[WARN] low\n low, too\n'
    assert shown(one, made('[ERROR] high\n')) == ''
    # what follows goes with that all the same
    assert shown(one, made(' low\n[INFO] x\n'), made(' low\n')) == ' low\n'


def test_progress_bars_keep_their_order(made):
    one = line_filter()
    for count in range(1, 4):
        for label in 'ab':
            assert not one.shown(made(f'{count}0%\r', label))
    assert texts(one.live) == [('a', '30%'), ('b', '30%')]
    for label in 'cd':
        assert not one.shown(made('10%\r', label))
    assert not one.shown(made('40%\r', 'b'))
    assert texts(one.live) == [('b', '40%'), ('c', '10%'), ('d', '10%')]


def test_repeated_line_is_counted(made):
    one = line_filter()
    assert texts(one.shown(made('low\n'))) == [('a', 'low\n')]
    assert not list(one.live)
    assert not one.shown(made('low\nlow\n'))
    assert texts(one.live) == [('a', 'low ×3\n')]
    assert not one.shown(made('low\n' * 2 * FEW))
    assert texts(one.live) == [('a', f'low ×{3 + 2 * FEW}\n')]
    # somebody else wrote something
    assert texts(one.shown(made('low\n', 'b'))) == [
        ('a', f'low ×{3 + 2 * FEW}\n'),
        ('b', 'low\n'),
    ]
    assert texts(one.settle()) == []
    # and so it is a first one again
    assert texts(one.shown(made('low\n', 'b'))) == [('b', 'low\n')]


def test_repeated_line_with_other_time_is_counted(made):
    one = line_filter()
    lines = [f'[WARN] [17320000{n}.123] [n]: low\n' for n in range(10, 15)]
    counted = f'{lines[0]}{lines[-1][:-1]} ×5\n'
    assert shown(one, *map(made, lines)) == counted


def test_line_that_comes_twice_is_not_counted(made):
    text = 'a\nb\nb\nc\n\n\n\n\nc\nc\nc\n'
    counted = 'a\nb\nb\nc\n\n\n\n\nc\nc ×3\n'
    assert shown(line_filter(), made(text)) == counted


def test_progress_bar_is_one_live_line(made):
    one = line_filter()
    for percent in (10, 20, 30):
        assert not one.shown(made(f'\rload {percent}%\r'))
        assert texts(one.live) == [('a', f'load {percent}%')]
    assert texts(one.shown(made('other\n', 'b'))) == [('b', 'other\n')]
    assert one.is_changing
    ends = made('load 90%\rload 100%\r\nready\r\n')
    assert texts(one.shown(ends)) == [('a', 'load 100%\nready\n')]
    assert not one.is_changing
    # erased with blanks
    assert not one.shown(made('almost\r'))
    assert not one.shown(made('      \r'))
    assert not one.is_changing


def test_progress_bar_is_shown_when_its_process_ends(made):
    one = line_filter()
    for label in 'abcde':
        assert not one.shown(made(f'{label} 1%\r', label))
    assert not one.shown(made('a 2%\r'))
    # the last ones that have changed
    latest = ['d 1%', 'e 1%', 'a 2%'][-MAXIMUM_LIVE:]
    assert [t for _, t in texts(one.live)] == latest
    assert texts(one.end('d')) == [('d', 'd 1%\n')]
    one.filtering = Filtering(muted=frozenset('a'), search='1')
    assert 'a 2%' not in dict(texts(one.live)).values()
    assert [n for n, _ in texts(one.end())] == ['b', 'c', 'e']


def test_warnings_and_errors_are_coloured(made):
    one = line_filter(color=True)
    text = (
        '[INFO] a\n[WARN] b\n more\n\x1b[1m[ERROR] c\x1b[0m\n[ERROR] d\n'
        'no WARN, no ERROR\n[FATAL] e\n'
    )
    assert shown(one, made(text)) == (
        '[INFO] a\n\x1b[33m[WARN] b\x1b[0m\n more\n'
        '\x1b[1m[ERROR] c\x1b[0m\n\x1b[31m[ERROR] d\x1b[0m\n'
        'no WARN, no ERROR\n\x1b[1;31m[FATAL] e\x1b[0m\n'
    )
    # the traceback of a node that is stopped is folded later
    text = 'Traceback (most recent call last):\n  ERROR\nKeyboardInterrupt\n'
    assert '\x1b' not in shown(one, made(text)).partition('\n')[0]


def test_filter_text_names_all_conditions():
    assert Filtering(times=True).text == ''
    every = Filtering(frozenset('ab'), frozenset('c'), 'low', Level.ERROR)
    assert every.text == '/low, level ERROR, only c, 2 muted'


LINES = st.lists(
    st.sampled_from(['', 'a', 'b', '[WARN] a', '\x1b[1ma', 'ä']), max_size=30
)


@settings(max_examples=40, deadline=None)
@given(st.lists(LINES, max_size=5))
def test_random_lines_are_shown_or_counted(chunks):
    one = line_filter()
    outputs = []
    for lines in chunks:
        data = ''.join(f'{line}\n' for line in lines).encode()
        output = Output(_Shown(), 'stdout', data)
        outputs += [output] if data else []
    wanted = [line for lines in chunks for line in lines]
    got = []
    for line in shown(one, *outputs).splitlines():
        text, _, count = line.partition(' ×')
        # the first of those that are counted was shown, too
        got += [text] * (int(count) - 1 if count else 1)
    assert got == wanted


class _Shown:
    label = 'a'
    output = 'screen'


def test_run_of_carriage_returns_takes_linear_time(made):
    # what looks at a run of them from each of its bytes takes a minute
    run = '\r' * 2**18
    assert shown(line_filter(), made(f'{run}a\n{run}')) == 'a\n'
