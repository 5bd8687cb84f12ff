# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The values of an argument: lists, ranges, and mistakes in them."""

from decimal import Decimal

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.sweep.value_ranges import values_of
from hypothesis import given
from hypothesis import strategies as st
import pytest


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
    ],
)
def test_values(text: str, values: str | None) -> None:
    expected = (text,) if values is None else tuple(values.split())
    assert values_of('x', text) == expected


def test_no_value_is_an_empty_one() -> None:
    assert values_of('x', '') == ('',)


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
def test_mistakes(text: str, error: str) -> None:
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


@given(st.integers(-999, 999), st.integers(-999, 999))
def test_a_range_of_whole_numbers_has_whole_numbers(a: int, b: int) -> None:
    step = 1 if b >= a else -1
    expected = tuple(map(str, range(a, b + step, step)))
    assert values_of('x', f'{a}..{b}') == expected


@given(
    st.lists(
        st.text('abc/.-_:=  äß', min_size=1, max_size=8),
        min_size=1,
        max_size=8,
        unique=True,
    )
)
def test_a_list_has_what_is_written(items: list[str]) -> None:
    try:
        assert values_of('x', ','.join(items)) == tuple(items)
    except UserError as e:
        assert '..' in ''.join(items), e


@given(st.text(max_size=40))
def test_whatever_is_written_is_values_or_an_error(text: str) -> None:
    try:
        assert values_of('x', text)
    except UserError as e:
        assert str(e)
