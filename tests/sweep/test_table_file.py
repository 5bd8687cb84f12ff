# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Tables of runs in CSV files, and where they are wrong."""

import csv
import io
from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.sweep.table_file import parse_table
from colcon_yamllaunch.sweep.table_file import read_table
from hypothesis import given
from hypothesis import strategies as st
import pytest


def test_a_table() -> None:
    table = parse_table('seed, world\n1,lab\n\n2,"a, b"\r\n3,\n', 'runs.csv')
    assert table.columns == ('seed', 'world')
    assert table.rows == (('1', 'lab'), ('2', 'a, b'), ('3', ''))
    assert next(table.as_mappings()) == {'seed': '1', 'world': 'lab'}


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
def test_what_a_spreadsheet_writes_is_read(
    rows: list[tuple[str, str]],
) -> None:
    text = io.StringIO()
    csv.writer(text).writerows([('a', 'b'), *rows])
    assert parse_table(text.getvalue(), 'x').rows == tuple(rows)


@given(st.text(max_size=60))
def test_whatever_is_in_it_is_a_table_or_an_error(text: str) -> None:
    try:
        assert parse_table(text, 'x').rows
    except UserError as e:
        assert str(e)
