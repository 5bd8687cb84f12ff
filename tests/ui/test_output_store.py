# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Lines are kept up to a limit, and found again as somebody wants."""

from collections.abc import Iterable

from colcon_yamllaunch.runtime.clients.subscription import Wrote
from colcon_yamllaunch.ui.line_levels import DEBUG
from colcon_yamllaunch.ui.line_levels import ERROR
from colcon_yamllaunch.ui.line_levels import FATAL
from colcon_yamllaunch.ui.line_levels import INFO
from colcon_yamllaunch.ui.line_levels import level_of
from colcon_yamllaunch.ui.line_levels import WARN
from colcon_yamllaunch.ui.output_store import LINE
from colcon_yamllaunch.ui.output_store import Line
from colcon_yamllaunch.ui.output_store import OutputStore
from colcon_yamllaunch.ui.output_view import Choice
from colcon_yamllaunch.ui.output_view import OutputView
import pytest
from support.shown_launch import wrote


def texts(lines: Iterable[Line]) -> list[str]:
    return [line.text for line in lines]


def raw(data: bytes, stream: str = 'stdout') -> Wrote:
    return Wrote('a', stream, data, 1.0)


@pytest.mark.parametrize(
    ('text', 'level'),
    [
        ('[INFO] [1732000000.123456789] [kitchen]: hot', INFO),
        ('\x1b[33m[WARN] [1.2] [kitchen]: hot\x1b[0m', WARN),
        ('1732.5 [kitchen] [ERROR]: hot', ERROR),
        ('[FATAL] [1.2] [x]: y', FATAL),
        ('[DEBUG] [1.2] [x]: y', DEBUG),
        ('WARNING:root:hot', WARN),
        ('ERROR hot', ERROR),
        ('the INFORMATION is [INFORMATIVE]', None),
        ('', None),
    ],
)
def test_levels_are_read(text: str, level: int | None) -> None:
    assert level_of(text) == level


def test_lines_of_all_come_in_order() -> None:
    store = OutputStore()
    store.take(wrote('a', '1', '2'))
    store.take(wrote('b', '3'))
    store.tell(None, '4', 1.0, INFO)
    store.take(wrote('a', '5'))
    assert texts(store.lines(None)) == ['1', '2', '3', '4', '5']
    assert texts(store.lines({'b'})) == ['3', '4']


def test_no_more_is_kept_than_there_is_room_for() -> None:
    store = OutputStore(limit=10, characters=1000)
    made = store.take(wrote('a', *map(str, range(100))))
    assert (
        texts(made)
        == texts(store.lines(None))
        == list(map(str, range(90, 100)))
    )
    store.take(wrote('b', 'x' * 2 * LINE))
    assert store.size <= 1000
    for label in 'abcdef':
        for number in range(20):
            store.take(wrote(label, f'{number}' * 40))
    assert store.size <= 1000
    assert store.size == sum(len(t) + 1 for t in texts(store.lines(None)))


def test_a_line_that_comes_again_is_counted() -> None:
    store = OutputStore()
    store.take(wrote('a', 'same', 'same'))
    assert store.take(wrote('a', 'same')) == []
    store.take(wrote('b', 'same'))
    store.take(wrote('a', 'same'))
    assert [line.count for line in store.lines(None)] == [3, 1, 1]


def test_a_progress_display_is_one_line() -> None:
    store = OutputStore()
    (line,) = store.take(raw(b'10 %\r'))
    for data in (b'20 %\r', b'30 %\r40 %\r'):
        assert store.take(raw(data)) == []
    assert line.text == '40 %'
    assert store.take(raw(b'done\nnext\n'))[0].text == 'next'
    assert texts(store.lines(None)) == ['done', 'next']
    assert store.size == len('done\nnext\n')


def test_what_harms_a_terminal_is_no_part_of_a_line() -> None:
    store = OutputStore()
    store.take(raw(b'\x1b[2J\x1b[31mred\x1b[0m\x07\xff\r\n'))
    assert texts(store.lines(None)) == ['\x1b[31mred\x1b[0m\ufffd\ufffd']


def test_lines_without_a_level_go_with_the_one_before() -> None:
    store = OutputStore()
    data = b'plain\n[ERROR] [1.2] [a]: hot\n  trace\n'
    lines = store.take(raw(data)) + store.take(raw(b'other\n', 'stderr'))
    assert [line.level for line in lines] == [INFO, ERROR, ERROR, INFO]


def test_only_what_is_chosen_is_seen() -> None:
    store = OutputStore()
    view = OutputView(store)
    for label in 'abc':
        view.add(store.take(wrote(label, f'[INFO] [1] [x]: {label} Hello')))
        view.add(store.take(wrote(label, f'[ERROR] [1] [x]: {label} Hot')))
    assert len(view.lines) == 6
    view.choose(Choice(frozenset('ab'), frozenset('b')))
    assert len(view.lines) == 2
    view.choose(Choice(search='hot'))
    assert len(view.lines) == 3
    view.choose(Choice(search='hOT'))
    assert view.lines == []
    view.choose(Choice(level=WARN))
    assert [line.level for line in view.lines] == [ERROR] * 3
    view.choose(Choice(mutes_all=True))
    view.add([store.tell(None, 'stopping', 1.0, INFO)])
    assert texts(view.lines) == ['stopping']


def test_a_view_grows_up_to_a_limit_and_tells_what_is_gone() -> None:
    store = OutputStore(limit=4)
    view = OutputView(store, limit=8)
    for number in range(100):
        view.add(store.take(wrote('a', str(number))))
    assert len(view.lines) <= 8
    assert view.dropped + len(view.lines) == 100
    assert view.lines[-1].text == '99'
    view.choose(Choice())
    assert texts(view.lines) == ['96', '97', '98', '99']
