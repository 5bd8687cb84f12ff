# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""All combinations of arguments, as runs."""

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.sweep.run_table import run_table
from colcon_yamllaunch.sweep.table_file import parse_table
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


def test_without_arguments_there_is_one_run() -> None:
    table = run_table({})
    assert [run.arguments for run in table.runs] == [{}]
    assert table.title(table.runs[0]) == 'run 1'


def test_repeats() -> None:
    table = run_table({'seed': '1..2'}, repeats=3)
    assert [(r.arguments['seed'], r.repeat) for r in table.runs] == [
        *[('1', 1), ('1', 2), ('1', 3)],
        *[('2', 1), ('2', 2), ('2', 3)],
    ]
    assert table.title(table.runs[4]) == 'seed:=2 (repeat 2)'


def test_rows_of_a_file_with_ranges_beside() -> None:
    file = parse_table('x,y,z\n1,2,0\n3,4,0\n', 'runs.csv')
    table = run_table({'seed': '7..8'}, file)
    assert [tuple(run.arguments.values()) for run in table.runs] == [
        *[('1', '2', '0', '7'), ('1', '2', '0', '8')],
        *[('3', '4', '0', '7'), ('3', '4', '0', '8')],
    ]
    # one that is the same in all rows tells none from another
    assert table.varied == ('x', 'y', 'seed')


def test_an_argument_in_both() -> None:
    file = parse_table('x\n1\n', 'runs.csv')
    with pytest.raises(UserError, match=r"'x' is given twice: as 'x:=1..2'"):
        run_table({'x': '1..2'}, file)


def test_too_many() -> None:
    given = dict.fromkeys('abc', '1..1000')
    with pytest.raises(UserError, match=r'these are 1,000,000,000 runs'):
        run_table(given)
