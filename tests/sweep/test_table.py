# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The runs of a sweep: combinations, tables in CSV files, and ranges."""

import csv
from decimal import Decimal
import io
from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.sweep.table import (
    parse_table,
    read_table,
    run_table,
    values_of,
)
from hypothesis import given
from hypothesis import strategies as st
import pytest


def test_all_combinations() -> None:
    table = run_table({'seed': '1..2', 'world': 'lab,street', 'rate': '5'})
    assert [tuple(run.arguments.values()) for run in table.runs] == [
        ('1', 'lab', '5'),
        ('1', 'street', '5'),
        ('2', 'lab', '5'),
        ('2', 'street', '5'),
    ]
    assert [run.number for run in table.runs] == [1, 2, 3, 4]
    assert table.names == ('seed', 'world', 'rate')
    assert table.varied == ('seed', 'world')
    assert table.title(table.runs[1]) == 'seed:=1 world:=street'


def test_repeats_number_the_runs() -> None:
    table = run_table({'seed': '1..2'}, repeats=3)
    assert [(r.arguments['seed'], r.repeat) for r in table.runs] == [
        *[('1', 1), ('1', 2), ('1', 3)],
        *[('2', 1), ('2', 2), ('2', 3)],
    ]
    assert table.title(table.runs[4]) == 'seed:=2 (repeat 2)'


def test_table_rows_combine_with_ranges() -> None:
    file = parse_table('x,y,z\n1,2,0\n3,4,0\n', 'runs.csv')
    table = run_table({'seed': '7..8'}, file)
    assert [tuple(run.arguments.values()) for run in table.runs] == [
        *[('1', '2', '0', '7'), ('1', '2', '0', '8')],
        *[('3', '4', '0', '7'), ('3', '4', '0', '8')],
    ]
    # one that is the same in all rows tells none from another
    assert table.varied == ('x', 'y', 'seed')


def test_argument_in_table_and_command_is_refused() -> None:
    file = parse_table('x\n1\n', 'runs.csv')
    with pytest.raises(UserError, match=r"'x' is given twice: as 'x:=1..2'"):
        run_table({'x': '1..2'}, file)


def test_too_many_runs_are_refused() -> None:
    given = dict.fromkeys('abc', '1..1000')
    with pytest.raises(UserError, match=r'these are 1,000,000,000 runs'):
        run_table(given)


def test_blank_lines_and_quotes_in_a_csv_table() -> None:
    table = parse_table('seed, world\n1,lab\n\n2,"a, b"\r\n3,\n', 'runs.csv')
    assert table.columns == ('seed', 'world')
    assert table.rows == (('1', 'lab'), ('2', 'a, b'), ('3', ''))


@pytest.mark.parametrize(
    ('text', 'error'),
    [
        ('', 'runs.csv: the table is empty: its first line has the names'),
        ('a,b\n', 'runs.csv: the table has no run'),
        ('a,b\n1,2\n3\n', 'runs.csv:3: there are 1 value, and the first'),
        ('a,b\n1,2,3\n', 'runs.csv:2: there are 3 values, and the first'),
        ('a,,b\n1,2,3\n', 'runs.csv:1: column 2 has no name'),
        ('a,b,a\n1,2,3\n', "runs.csv:1: the column 'a' is there twice"),
        ('a:=1\nb:=2\n', "'a:=1' is no name of a launch argument"),
        ('a\n"x\ny\n', 'runs.csv:2: unexpected end of data'),
        ('a\n"x"y\n', "runs.csv:2: ',' expected"),
    ],
)
def test_mistakes_have_their_place(text: str, error: str) -> None:
    with pytest.raises(UserError) as caught:
        parse_table(text, 'runs.csv')
    assert error in str(caught.value)
    assert caught.value.lines('colcon sweep').startswith('runs.csv')


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(UserError, match='cannot be read: No such file'):
        read_table(tmp_path / 'runs.csv', 'runs.csv')
    with pytest.raises(UserError, match='cannot be read: Is a directory'):
        read_table(tmp_path, '.')
    (tmp_path / 'x').write_bytes(b'a\n\xff\n')
    with pytest.raises(UserError, match=r'no text in UTF-8.* at byte 2'):
        read_table(tmp_path / 'x', 'x')
    # a byte order mark, as spreadsheets write it
    (tmp_path / 'y').write_bytes(b'\xef\xbb\xbfa\n1\n')
    assert read_table(tmp_path / 'y', 'y').columns == ('a',)


cells = st.text(
    st.characters(exclude_categories=('Cs', 'Cc', 'Zl', 'Zp')), max_size=9
)


@given(st.lists(st.tuples(cells, cells), min_size=1, max_size=9))
def test_table_from_a_spreadsheet_is_read(
    rows: list[tuple[str, str]],
) -> None:
    text = io.StringIO()
    csv.writer(text).writerows([('a', 'b'), *rows])
    assert parse_table(text.getvalue(), 'x').rows == tuple(rows)


@given(st.text(max_size=60))
def test_any_text_is_a_table_or_an_error(text: str) -> None:
    try:
        assert parse_table(text, 'x').rows
    except UserError as e:
        assert str(e)


@pytest.mark.parametrize(
    ('text', 'values'),
    [
        ('1..5', '1 2 3 4 5'),
        ('3..1', '3 2 1'),
        ('-1..1', '-1 0 1'),
        ('-1..-3', '-1 -2 -3'),
        ('0..10..5', '0 5 10'),
        ('0..9..5', '0 5'),
        ('10..0..-5', '10 5 0'),
        ('10..0..5', '10 5 0'),
        ('0..1..0.25', '0.00 0.25 0.50 0.75 1.00'),
        ('0.1..0.3..0.1', '0.1 0.2 0.3'),
        ('0.5..1.5', '0.5 1.5'),
        ('008..011', '008 009 010 011'),
        ('-01..1', '-01 000 001'),
        ('7..7', '7'),
        ('lab,street', 'lab street'),
        ('1..3,7,10..8', '1 2 3 7 10 9 8'),
        ('../x', '../x'),
        ('a/../b', 'a/../b'),
        ('[1,2],[3]', '[1,2] [3]'),
        ('{a: [1, 2]}', None),
        ('1.5', '1.5'),
        (r'a\,b', 'a,b'),
        (r'C:\x', r'C:\x'),
        ('a\\', 'a\\'),
        (')', ')'),
        ('', None),
    ],
)
def test_values_of_an_argument_are_listed(
    text: str, values: str | None
) -> None:
    expected = (text,) if values is None else tuple(values.split())
    assert values_of('x', text) == expected


@pytest.mark.parametrize(
    ('text', 'error'),
    [
        ('1..x', "the range '1..x' is not made of numbers"),
        ('a..5', 'is not made of numbers'),
        ('1...3', 'is not made of numbers'),
        ('1..2..3..4', 'is not made of numbers'),
        ('1..5..0', 'has a step of 0, and would never end'),
        ('1..5..-1', 'counts down from 1, and never gets to 5'),
        ('1..2000000', 'more than 1,000,000 values'),
        ('1..900000,1..900000..2', 'more than 1,000,000 values'),
        ('0..1..0.0000001', 'more than 1,000,000 values'),
        ('a,,b', 'a value of the list is empty'),
        ('a,', 'a value of the list is empty'),
        ('a,b,a', "the value 'a' comes twice: to run each combination"),
        ('1..3,2', "the value '2' comes twice"),
        ('1..1000000000000000', 'has too long numbers'),
    ],
)
def test_mistakes_in_ranges(text: str, error: str) -> None:
    with pytest.raises(UserError) as caught:
        values_of('speed', text)
    assert str(caught.value).startswith(f"in 'speed:={text}' ")
    assert error in str(caught.value)


numbers = st.decimals(-1000, 1000, allow_nan=False, places=2)


@given(numbers, numbers, st.integers(0, 200))
def test_a_range_is_exact(first: Decimal, step: Decimal, count: int) -> None:
    if not step:
        return
    last = first + step * count
    values = values_of('x', f'{first}..{last}..{step}')
    expected = [first + step * number for number in range(count + 1)]
    assert list(map(Decimal, values)) == expected


@given(
    st.lists(
        st.text('abc/.-_:=  äß', min_size=1, max_size=8),
        min_size=1,
        max_size=8,
        unique=True,
    )
)
def test_list_has_the_written_items(items: list[str]) -> None:
    try:
        assert values_of('x', ','.join(items)) == tuple(items)
    except UserError as e:
        assert '..' in ''.join(items), e


@given(st.text(max_size=40))
def test_any_argument_is_values_or_an_error(text: str) -> None:
    try:
        assert values_of('x', text)
    except UserError as e:
        assert str(e)
