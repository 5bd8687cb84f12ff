# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.common.table import (
    column_widths,
    decimal_size,
    table_lines,
    table_width,
    without_end,
    without_middle,
)
import pytest

ROWS = [('NAME', 'PID', 'STATE'), ('a_long_name', '7', 'ended')]


def test_columns_are_as_wide_as_their_texts():
    assert column_widths(ROWS) == [11, 3, 5]
    assert table_width([11, 3, 5]) == 23


def test_rows_are_aligned_and_shortened():
    assert table_lines(ROWS, [5, 3, 5], without_end, {1}) == [
        'NAME   PID  STATE',
        'a_lo…    7  ended',
    ]


def test_columns_without_a_width_are_left_out():
    assert table_lines(ROWS, [11, 3], without_end) == [
        'NAME         PID',
        'a_long_name  7',
    ]


def test_a_text_may_lose_its_middle():
    assert without_middle('a_long_name', 7) == 'a_l…ame'
    assert without_middle('name', 4) == 'name'


@pytest.mark.parametrize(
    ('size', 'text'),
    [
        (0, '0 bytes'),
        (999, '999 bytes'),
        (1500, '1.5 kB'),
        (2_000_000_000, '2 GB'),
        (1 << 30, '1.074 GB'),
        (5_000_000_000_000, '5000 GB'),
    ],
)
def test_size_of_a_limit(size, text):
    assert decimal_size(size) == text
