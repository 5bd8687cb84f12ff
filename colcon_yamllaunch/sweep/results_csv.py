# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The results of a sweep as a table (CSV, RFC 4180), for programs.

A line for each run that is done, with its arguments, its outcome, the reason,
the seconds that it took, its metrics and the code that was run. No
spreadsheet takes a value for a formula, and no terminal for a command.
"""

from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import suppress
import re

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.sweep.run_result import RunResult
from colcon_yamllaunch.sweep.run_table import RunTable

RUN = 'run'
REPEAT = 'repeat'
OUTCOME = 'outcome'
REASON = 'reason'
SECONDS = 'seconds'
COMMIT = 'commit'
FINGERPRINT = 'fingerprint'
#: The columns that each table has.
FIXED = (RUN, REPEAT, OUTCOME, REASON, SECONDS, COMMIT, FINGERPRINT)
#: What a value begins with that spreadsheets run (OWASP, "CSV Injection").
_FORMULA = ('=', '+', '-', '@', '\t', '\r', '\n', '＝', '＋', '－', '＠')
_QUOTED = re.compile('[",\r\n]')
_CONTROL = re.compile(r'[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f]')


def refuse_columns_twice(
    arguments: Iterable[str], metrics: Iterable[str]
) -> None:
    """
    Refuse metrics whose column there is already.

    :raises UserError: when there is one
    """
    known = {argument_column(name) for name in arguments}
    for name in metrics:
        if name in FIXED or name in known:
            what = 'a launch argument' if name in known else 'each result'
            raise UserError(
                f"--metric: results.csv has a column '{name}' already, of "
                f'{what}',
                'call the metric otherwise',
            )


def argument_column(name: str) -> str:
    """Return what the column of a launch argument is called."""
    return f'argument {name}' if name in FIXED else name


def results_csv(
    table: RunTable,
    results: Mapping[int, RunResult],
    metrics: Iterable[str],
) -> str:
    """Return the table, with the runs that are done."""
    metrics = tuple(metrics)
    repeat = (REPEAT,) if table.repeats > 1 else ()
    rows: list[tuple[object, ...]] = [
        (
            RUN,
            *map(argument_column, table.names),
            *repeat,
            OUTCOME,
            REASON,
            SECONDS,
            *metrics,
            COMMIT,
            FINGERPRINT,
        )
    ]
    for run in table.runs:
        result = results.get(run.number)
        if result is None:
            continue
        rows.append(
            (
                run.number,
                *(run.arguments[name] for name in table.names),
                *((run.repeat,) if repeat else ()),
                result.outcome,
                result.reason,
                f'{result.seconds:.3f}',
                *(result.metrics.get(name, '') for name in metrics),
                result.commit,
                result.fingerprint,
            )
        )
    return ''.join(f'{",".join(map(_cell, row))}\n' for row in rows)


def _cell(value: object) -> str:
    """Return a value with an apostrophe if it looks like a formula."""
    text = _CONTROL.sub(lambda m: f'\\x{ord(m[0]):02x}', str(value))
    if text.lstrip(" '").startswith(_FORMULA) and not _is_number(text):
        text = f"'{text}"
    if _QUOTED.search(text):
        text = '"{}"'.format(text.replace('"', '""'))
    return text


def _is_number(text: str) -> bool:
    with suppress(ValueError):
        float(text)
        return True
    return False
