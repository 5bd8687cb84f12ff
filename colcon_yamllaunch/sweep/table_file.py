# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A table of runs as a CSV file (RFC 4180).

Its first line has the names of launch arguments, each further one a run.
"""

from collections.abc import Iterator
from collections.abc import Mapping
import csv
from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.sweep.run_limits import MAXIMUM_RUNS


@dataclass(frozen=True, slots=True)
class TableFile:
    """
    What such a file says.

    :param path: The file as the user named it
    :param columns: The launch arguments
    :param rows: Their values, one row a run
    """

    path: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def as_mappings(self) -> Iterator[Mapping[str, str]]:
        """Iterate over the rows as launch arguments."""
        for row in self.rows:
            yield dict(zip(self.columns, row, strict=True))


def read_table(path: Path, shown: str) -> TableFile:
    """
    Read the file.

    :param path: The file
    :param shown: How the user named it
    :raises UserError: when it is no such table; says in which line
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
    Read the text of such a file.

    :raises UserError: when it is no such table; says in which line
    """
    columns: tuple[str, ...] | None = None
    rows: list[tuple[str, ...]] = []
    for line, row in _rows(text, shown):
        if columns is None:
            columns = tuple(cell.strip() for cell in row)
            _check_columns(columns, f'{shown}:{line}')
            continue
        if len(row) != len(columns):
            raise UserError(
                f'there are {_count(len(row))}, and the first line names '
                f'{len(columns)}: {", ".join(columns)}',
                place=f'{shown}:{line}',
            )
        rows.append(tuple(row))
        if len(rows) > MAXIMUM_RUNS:
            raise UserError(
                f"--table: '{shown}' has more than {MAXIMUM_RUNS:,} rows"
            )
    if columns is None:
        raise UserError(
            'the table is empty',
            'its first line has the names of launch arguments, each further '
            'one their values for a run',
            place=shown,
        )
    if not rows:
        raise UserError(
            'the table has no run',
            'below its first line, each further one has the values for a run',
            place=shown,
        )
    return TableFile(shown, columns, tuple(rows))


def _rows(text: str, shown: str) -> Iterator[tuple[int, list[str]]]:
    """Iterate over the rows that are not empty, with their lines."""
    # the reader tells line ends within quotes from others
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


def _count(number: int) -> str:
    return f'{number} value' + 's' * (number != 1)
