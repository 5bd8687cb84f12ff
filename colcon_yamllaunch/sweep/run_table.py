# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The runs of a sweep: all combinations of what its arguments may be."""

from collections.abc import Iterator
from collections.abc import Mapping
from itertools import product
from math import prod

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.sweep.run_limits import MAXIMUM_RUNS
from colcon_yamllaunch.sweep.table_file import TableFile
from colcon_yamllaunch.sweep.value_ranges import values_of


@dataclass(frozen=True, slots=True)
class Run:
    """
    One launch of a sweep.

    :param number: Its number, counted from 1
    :param arguments: Its launch arguments
    :param repeat: Which one it is of those with the same arguments, from 1
    """

    number: int
    arguments: Mapping[str, str]
    repeat: int = 1


@dataclass(frozen=True, slots=True)
class RunTable:
    """
    All runs of a sweep.

    :param runs: In order: the last argument changes fastest, the rows of a
      table slowest
    :param names: The launch arguments, in the order given
    :param varied: Those of them that have more than one value
    :param repeats: How often each combination is run
    """

    runs: tuple[Run, ...]
    names: tuple[str, ...]
    varied: tuple[str, ...]
    repeats: int = 1

    def title(self, run: Run) -> str:
        """Return what tells a run from the others, for people."""
        words = [f'{name}:={run.arguments[name]}' for name in self.varied]
        if self.repeats > 1:
            words.append(f'(repeat {run.repeat})')
        return ' '.join(words) or f'run {run.number}'


def run_table(
    given: Mapping[str, str],
    table: TableFile | None = None,
    repeats: int = 1,
) -> RunTable:
    """
    Make the table of all combinations.

    :param given: What the user wrote for each launch argument
    :param table: Rows of arguments that belong together
    :param repeats: How often each combination is run
    :raises UserError: when an argument cannot be read, is given twice, or
      there are too many runs
    """
    rows = (
        [{}] if table is None else [dict(row) for row in table.as_mappings()]
    )
    columns = () if table is None else table.columns
    for name in columns:
        if name in given:
            raise UserError(
                f"the launch argument '{name}' is given twice: as "
                f"'{name}:={given[name]}', and as a column of "
                f'{table.path if table else ""}'
            )
    values = {name: values_of(name, text) for name, text in given.items()}
    count = len(rows) * prod(map(len, values.values())) * repeats
    if count > MAXIMUM_RUNS:
        raise UserError(
            f'these are {count:,} runs, and a sweep may have {MAXIMUM_RUNS:,}',
            'give fewer values, or several sweeps',
        )
    varied = [n for n in columns if len({row[n] for row in rows}) > 1]
    varied += [name for name, found in values.items() if len(found) > 1]
    return RunTable(
        tuple(_numbered(rows, values, repeats)),
        (*columns, *values),
        tuple(varied),
        repeats,
    )


def _numbered(
    rows: list[dict[str, str]],
    values: Mapping[str, tuple[str, ...]],
    repeats: int,
) -> Iterator[Run]:
    number = 0
    for row in rows:
        for combination in product(*values.values()):
            arguments = {**row, **dict(zip(values, combination, strict=True))}
            for repeat in range(1, repeats + 1):
                number += 1
                yield Run(number, arguments, repeat)
