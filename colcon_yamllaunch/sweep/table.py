# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The runs of a sweep: all combinations of the values of its arguments.

The values of an argument are a list, `lab,street`, whose items may be ranges
of numbers, `1..10` or `0..1..0.25`, as in brace expansion of bash: first, last
and step. A range counts down if it ends below its beginning, and keeps leading
zeros, `001..120`. Any other text is a value itself.

A table of runs is a CSV file (RFC 4180). Its first line has the names of
launch arguments, each further line their values for a run.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
import csv
from decimal import Decimal
from itertools import product
from math import prod
from pathlib import Path
import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import content_of
from colcon_yamllaunch.common.frozen import dataclass

#: Runs that a sweep may have; more of them are more often a slip of the pen
#: than a plan for the next years.
MAXIMUM_RUNS = 1_000_000
_NUMBER = r'[+-]?\d+(?:\.\d+)?'
_RANGE = re.compile(rf'({_NUMBER})\.\.({_NUMBER})(?:\.\.({_NUMBER}))?')
# certainly meant as a range, but with something that is no number
_NEARLY = re.compile(rf'{_NUMBER}\.\.+[^/]*|[^/]*\.\.+{_NUMBER}')
#: Digits that a number of a range has at most.
_MAXIMUM_DIGITS = 12


@dataclass(frozen=True, slots=True)
class Run:
    """
    One launch of a sweep.

    :param number: Its number, counted from 1
    :param arguments: Its launch arguments
    :param repeat: Its number among the runs with the same arguments, from 1
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
        """Return the differences between a run and the others, for people."""
        words = [f'{name}:={run.arguments[name]}' for name in self.varied]
        if self.repeats > 1:
            words.append(f'(repeat {run.repeat})')
        return ' '.join(words) or f'run {run.number}'


@dataclass(frozen=True, slots=True)
class TableFile:
    """
    The content of a table of runs.

    :param path: The file as the user named it
    :param columns: The launch arguments
    :param rows: Their values, one row a run
    """

    path: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def run_table(
    given: Mapping[str, str],
    file: TableFile | None = None,
    repeats: int = 1,
) -> RunTable:
    """
    Return the table of all combinations.

    :param given: The text that the user wrote for each launch argument
    :param file: Rows of arguments that belong together
    :param repeats: How often each combination is run
    :raises UserError: when an argument cannot be read, is given twice, or
      there are too many runs
    """
    file = file or TableFile('', (), ((),))
    for name in file.columns:
        if name in given:
            raise UserError(
                f"the launch argument '{name}' is given twice: as "
                f"'{name}:={given[name]}', and as a column of {file.path}"
            )
    values = {name: values_of(name, text) for name, text in given.items()}
    count = len(file.rows) * prod(map(len, values.values())) * repeats
    if count > MAXIMUM_RUNS:
        raise UserError(
            f'these are {count:,} runs, and a sweep may have {MAXIMUM_RUNS:,}',
            'give fewer values, or several sweeps',
        )
    columns = [*zip(*file.rows, strict=True), *values.values()]
    names = (*file.columns, *values)
    combinations = product(
        file.rows, product(*values.values()), range(repeats)
    )
    return RunTable(
        tuple(
            Run(
                number,
                dict(zip(names, (*row, *combination), strict=True)),
                repeat + 1,
            )
            for number, (row, combination, repeat) in enumerate(
                combinations, 1
            )
        ),
        names,
        tuple(
            name
            for name, column in zip(names, columns, strict=True)
            if len(set(column)) > 1
        ),
        repeats,
    )


def read_table(path: Path, shown: str) -> TableFile:
    """
    Read a table of runs.

    :param shown: The path as the user named it
    :raises UserError: when it is no such table; names the line
    """
    try:
        text = content_of(path).decode('utf-8-sig')
    except OSError as e:
        raise UserError(
            f"--table: '{shown}' cannot be read: {e.strerror or e}"
        ) from e
    except UnicodeDecodeError as e:
        raise UserError(
            f"--table: '{shown}' is no text in UTF-8: {e.reason} at byte "
            f'{e.start}'
        ) from e
    return parse_table(text, shown)


def parse_table(text: str, shown: str) -> TableFile:
    """
    Parse the text of a table of runs.

    :raises UserError: when it is no such table; names the line
    """
    lines = _rows(text, shown)
    line, head = next(lines, (0, []))
    if not line:
        raise UserError(
            'the table is empty',
            'its first line has the names of launch arguments, each further '
            'one their values for a run',
            place=shown,
        )
    columns = tuple(cell.strip() for cell in head)
    _check_columns(columns, f'{shown}:{line}')
    rows = []
    for line, row in lines:
        if len(row) != len(columns):
            count = f'{len(row)} value' + 's' * (len(row) != 1)
            raise UserError(
                f'there are {count}, and the first line names '
                f'{len(columns)}: {", ".join(columns)}',
                place=f'{shown}:{line}',
            )
        rows.append(tuple(row))
        if len(rows) > MAXIMUM_RUNS:
            raise UserError(
                f"--table: '{shown}' has more than {MAXIMUM_RUNS:,} rows"
            )
    if not rows:
        raise UserError(
            'the table has no run',
            'below its first line, each further one has the values for a run',
            place=shown,
        )
    return TableFile(shown, columns, tuple(rows))


def _rows(text: str, shown: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows that are not empty, with the numbers of their lines."""
    # the reader distinguishes line ends within quotes from others
    reader = csv.reader(text.splitlines(keepends=True), strict=True)
    while True:
        line = reader.line_num + 1
        try:
            row = next(reader)
        except StopIteration:
            return
        except csv.Error as e:
            raise UserError(str(e), place=f'{shown}:{line}') from e
        if any(cell.strip() for cell in row) or len(row) > 1:
            yield line, row


def _check_columns(columns: tuple[str, ...], place: str) -> None:
    for number, name in enumerate(columns, 1):
        if not name:
            raise UserError(
                f'column {number} has no name',
                'each is that of a launch argument',
                place=place,
            )
        if columns.index(name) != number - 1:
            raise UserError(
                f"the column '{name}' is there twice",
                'each is one launch argument',
                place=place,
            )
        if ':=' in name:
            raise UserError(
                f"'{name}' is no name of a launch argument",
                'the first line has the names, those below it the values',
                place=place,
            )


def values_of(name: str, text: str) -> tuple[str, ...]:
    r"""
    Return the values of a launch argument.

    A comma in brackets is part of a value, and so is `\,`.

    :param name: The argument, for errors
    :param text: The text that the user wrote behind `:=`
    :raises UserError: when a range makes no sense, or a value comes twice
    """
    place = f"in '{name}:={text}'"
    items = _items(text)
    values: list[str] = []
    for item in items:
        if not item and len(items) > 1:
            raise UserError(
                f'{place} a value of the list is empty',
                'there is a comma too many',
            )
        for value in _expanded(item, place):
            if len(values) == MAXIMUM_RUNS:
                raise UserError(
                    f'{place} there are more than {MAXIMUM_RUNS:,} values, '
                    'which is what a sweep may have'
                )
            values.append(value)
    for value, count in Counter(values).items():
        if count > 1:
            raise UserError(
                f"{place} the value '{value}' comes twice",
                'to run each combination several times: --repeat N',
            )
    return tuple(values)


def _items(text: str) -> list[str]:
    """Split a list at its commas, but not within brackets."""
    items, item, depth = [], '', 0
    characters = iter(text)
    for character in characters:
        if character == '\\':
            following = next(characters, '')
            # any other backslash stays what it is
            item += following if following == ',' else f'\\{following}'
        elif character == ',' and depth == 0:
            items.append(item)
            item = ''
        else:
            depth += character in '([{'
            depth -= character in ')]}' and depth > 0
            item += character
    return [*items, item]


def _expanded(item: str, place: str) -> Iterator[str]:
    """Yield the numbers of a range, or the item itself."""
    found = _RANGE.fullmatch(item)
    if found is None:
        if _NEARLY.fullmatch(item):
            raise UserError(
                f"{place} the range '{item}' is not made of numbers",
                'it is written first..last or first..last..step',
            )
        yield item
        return
    texts = [text for text in found.groups() if text is not None]
    if max(map(len, texts)) > _MAXIMUM_DIGITS:
        raise UserError(f"{place} the range '{item}' has too long numbers")
    first, last, step = map(Decimal, (*texts, '1')[:3])
    if not step:
        raise UserError(
            f"{place} the range '{item}' has a step of 0, and would never end"
        )
    if step < 0 and last > first:
        raise UserError(
            f"{place} the range '{item}' counts down from {texts[0]}, and "
            f'never gets to {texts[1]}'
        )
    steps = int(abs((last - first) / step))
    step = abs(step) if last >= first else -abs(step)
    # all have as many decimals as the one that has most: 0.0, 0.5, 1.0
    decimals = max(len(text.partition('.')[2]) for text in texts)
    zeros = ''
    if any(re.match(r'[+-]?0\d', text) for text in texts[:2]):
        zeros = f'0{max(len(text.lstrip("+")) for text in texts[:2])}'
    for number in range(steps + 1):
        yield f'{first + number * step:{zeros}.{decimals}f}'
