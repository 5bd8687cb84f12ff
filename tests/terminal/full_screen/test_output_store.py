# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Lines are kept up to a limit, and found again as somebody wants."""

from collections.abc import Iterable

from colcon_yamllaunch.control.subscription import ReceivedOutput
from colcon_yamllaunch.observers.log_levels import Level
from colcon_yamllaunch.terminal.full_screen import output_store
from colcon_yamllaunch.terminal.full_screen.widgets import RowIndex
from colcon_yamllaunch.terminal.line_filter import Filtering
from support.shown_launch import wrote


def texts(lines: Iterable[output_store.Line]) -> list[str]:
    return [line.text for line in lines]


def raw(data: bytes, stream: str = 'stdout') -> ReceivedOutput:
    return ReceivedOutput('a', stream, data, 1.0)


def test_lines_of_all_processes_are_in_order() -> None:
    store = output_store.OutputStore()
    store.add(wrote('a', '1', '2'))
    store.add(wrote('b', '3'))
    store.add_note(None, '4', 1.0, Level.INFO)
    store.add(wrote('a', '5'))
    assert texts(store.lines(None)) == ['1', '2', '3', '4', '5']
    assert texts(store.lines({'b'})) == ['3', '4']


def test_store_keeps_at_most_its_limits() -> None:
    store = output_store.OutputStore(limit=10, characters=1000)
    made = store.add(wrote('a', *map(str, range(100))))
    latest = list(map(str, range(90, 100)))
    assert texts(made) == texts(store.lines(None)) == latest
    store.add(wrote('b', 'x' * 2 * output_store.LONGEST_LINE))
    assert store.size <= 1000
    for label in 'abcdef':
        for number in range(20):
            store.add(wrote(label, f'{number}' * 40))
    assert store.size <= 1000
    assert store.size == sum(len(t) + 1 for t in texts(store.lines(None)))


def test_repeated_line_is_counted() -> None:
    store = output_store.OutputStore()
    store.add(wrote('a', 'same', 'same'))
    assert store.add(wrote('a', 'same')) == []
    store.add(wrote('b', 'same'))
    store.add(wrote('a', 'same'))
    assert [line.count for line in store.lines(None)] == [3, 1, 1]


def test_repeated_line_with_other_time_is_counted() -> None:
    store = output_store.OutputStore()
    (line,) = store.add(wrote('a', '[INFO] [1732000000.1] [a]: same'))
    store.add(wrote('a', '[INFO] [1732000001.20] [a]: same'))
    assert (line.count, line.text) == (2, '[INFO] [1732000001.20] [a]: same')
    assert list(store.altered) == [line]
    assert store.size == len(line.text) + 1
    store.add(wrote('a', '', ''))
    assert texts(store.lines(None)) == [line.text, '', '']


def test_progress_display_is_one_line() -> None:
    store = output_store.OutputStore()
    (line,) = store.add(raw(b'10 %\r'))
    for data in (b'20 %\r', b'30 %\r40 %\r'):
        assert store.add(raw(data)) == []
    assert line.text == '40 %'
    assert store.add(raw(b'done\nnext\n'))[0].text == 'next'
    assert texts(store.lines(None)) == ['done', 'next']
    assert store.size == len('done\nnext\n')


def test_control_characters_are_removed() -> None:
    store = output_store.OutputStore()
    store.add(raw(b'\x1b[2J\x1b[31mred\x1b[0m\x07\xff\r\n'))
    assert texts(store.lines(None)) == ['\x1b[31mred\x1b[0m\ufffd\ufffd']


def test_line_without_level_has_the_level_before() -> None:
    store = output_store.OutputStore()
    data = b'plain\n[ERROR] [1.2] [a]: hot\n  trace\n'
    lines = store.add(raw(data)) + store.add(raw(b'other\n', 'stderr'))
    levels = [line.level for line in lines]
    assert levels == [Level.INFO, *[Level.ERROR] * 3]
    assert [line.is_leveled for line in lines] == [False, True, False, False]
    (line,) = output_store.OutputStore(form='{severity}, ').add(
        raw(b'WARN, hm\n')
    )
    assert line.level == Level.WARN


def test_view_has_lines_that_the_filter_lets_through() -> None:
    store = output_store.OutputStore()
    view = output_store.OutputView(store)
    for label in 'abc':
        view.add(store.add(wrote(label, f'[INFO] [1] [x]: {label} Hello')))
        view.add(store.add(wrote(label, f'[ERROR] [1] [x]: {label} Hot')))
    assert len(view.lines) == 6
    view.choose(Filtering(frozenset('b'), frozenset('ab')))
    assert len(view.lines) == 2
    view.choose(Filtering(search='hot'))
    assert len(view.lines) == 3
    view.choose(Filtering(search='hOT'))
    assert view.lines == []
    view.choose(Filtering(level=Level.WARN))
    assert [line.level for line in view.lines] == [Level.ERROR] * 3
    view.choose(Filtering(frozenset('abc')))
    view.add([store.add_note(None, 'stopping', 1.0, Level.INFO)])
    assert texts(view.lines) == ['stopping']


def test_view_drops_oldest_lines_at_its_limit() -> None:
    store = output_store.OutputStore(limit=4)
    view = output_store.OutputView(store, limit=8)
    for number in range(100):
        view.add(store.add(wrote('a', str(number))))
    assert len(view.lines) <= 8
    assert view.dropped + len(view.lines) == 100
    assert view.lines[-1].text == '99'
    view.choose(Filtering())
    assert texts(view.lines) == ['96', '97', '98', '99']


def test_row_index_finds_lines_of_several_rows() -> None:
    index = RowIndex()
    for rows in (1, 3, 2):
        index.add(rows)
    rows = [index.at(row) for row in range(index.rows)]
    assert rows == [(0, 0), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1)]
    index.alter(1, 1)
    assert [index.first_row(line) for line in range(3)] == [0, 1, 2]
    assert index.drop(2) == 2
    index.add(2)
    assert (len(index), index.rows, index.at(3)) == (2, 4, (1, 1))
    assert index.drop(9) == 4
    assert (index.drop(1), index.rows) == (0, 0)


def test_altered_lines_are_found_in_the_view() -> None:
    store = output_store.OutputStore()
    view = output_store.OutputView(store)
    view.add(store.add(wrote('a', 'warm')))
    view.add(store.add(wrote('b', 'same')))
    assert view.pop_altered() == []
    store.add(wrote('b', 'same'))
    assert view.pop_altered() == [1]
    store.add(wrote('b', 'same'))
    view.choose(Filtering(frozenset('b')))
    assert view.pop_altered() == []
