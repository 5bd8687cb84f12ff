# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The reports of a sweep: `results.csv`, `junit.xml` and `report.html`."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
import re
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import write_file
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.observers.junit import (
    junit_case,
    junit_document,
    junit_outcome,
)
from colcon_yamllaunch.observers.log_files import COMMON_LOG
from colcon_yamllaunch.sweep.report_page import report_page
from colcon_yamllaunch.sweep.results import (
    JUNIT,
    MESSAGES,
    REPORT,
    RESULTS,
    ResultsFolder,
    RunResult,
    SweepDefinition,
    versions_of,
)
from colcon_yamllaunch.sweep.table import RunTable

#: Seconds between two writings while runs go on: at least this many, and this
#: many times as long as a writing takes.
_INTERVAL = 15.0
_SHARE = 50.0
#: The columns of each results.csv, beside arguments and metrics.
_FIXED = (
    *('run', 'repeat', 'outcome', 'reason', 'seconds', 'commit'),
    'fingerprint',
)
#: Spreadsheets run a value that begins with these (OWASP, "CSV Injection").
_FORMULA = ('=', '+', '-', '@', '\t', '\r', '\n', '＝', '＋', '－', '＠')
_QUOTED = re.compile('[",\r\n]')
_CONTROL = re.compile(r'[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f]')


class SweepReports:
    """Writes `results.csv`, `junit.xml` and `report.html` of a folder."""

    def __init__(self, folder: ResultsFolder) -> None:
        self._folder = folder
        self._table = folder.definition.table
        self._results = folder.results
        self._started = time.time()
        self._next = time.monotonic() + _INTERVAL

    def refresh(self) -> None:
        """
        Write them if they are old.

        :raises UserError: when they cannot be written
        """
        begin = time.monotonic()
        if begin >= self._next:
            self.write()
            end = time.monotonic()
            self._next = end + max(_INTERVAL, _SHARE * (end - begin))

    def write(self) -> None:
        """
        Write them.

        :raises UserError: when they cannot be written
        """
        definition, path = self._folder.definition, self._folder.path
        page = report_page(
            definition, self._results, self._log_of, time.time()
        )
        table = results_csv(self._table, self._results, definition.metrics)
        report = junit_report(
            definition, self._results, self._folder.run_folder, self._started
        )
        try:
            write_file(path / RESULTS, table.encode(errors='replace'))
            write_file(path / JUNIT, report)
            write_file(path / REPORT, page.encode(errors='replace'))
        except OSError as e:
            raise UserError(
                f'{path} cannot be written: {e.strerror or e}',
                'what journal.jsonl there has is kept, and the same command '
                'goes on',
            ) from e

    def _log_of(self, number: int) -> str | None:
        """Return the path of the log of a run, from the page on."""
        for name in (COMMON_LOG, MESSAGES):
            file = self._folder.run_folder(number) / name
            if file.exists():
                return str(file.relative_to(self._folder.path))
        return None

    def is_enough(self, required: float | None) -> bool:
        """
        Return whether enough runs succeeded.

        :param required: Their share, from 0 to 1; None for all
        """
        total = len(self._table.runs)
        share = 1.0 if required is None else required
        # 95% of 20 is 19, whatever floating point makes of it
        return self._outcomes()['succeeded'] + 1e-9 >= share * total

    def summary(self, required: float | None) -> list[str]:
        """Return the lines at the end of the sweep."""
        total = len(self._table.runs)
        outcomes = self._outcomes()
        succeeded = outcomes['succeeded']
        others = {
            'failed': outcomes['failed'],
            'had an error': outcomes['error'],
            'not run yet': total - len(self._results),
        }
        counts = [f'{succeeded:,} succeeded']
        counts += [f'{n:,} {text}' for text, n in others.items() if n]
        line = f'{_runs(total)}: {", ".join(counts)}'
        if required is not None:
            reached = 'enough' if self.is_enough(required) else 'too few'
            line += (
                f'; that is {_percent(succeeded / total)}, and '
                f'{_percent(required)} are required: {reached}'
            )
        lines = [line]
        versions = versions_of(self._results.values())
        if len(versions) > 1:
            lines += [
                f'warning: these results are of {len(versions)} versions of '
                'the code (commit, fingerprint):',
                *(
                    f'  {one_line(name)}: {_runs(len(found))}'
                    for name, found in versions.items()
                ),
                'help: for results that compare, do all again: --again all',
            ]
        path = self._folder.shown(self._folder.path / REPORT)
        return [*lines, f'results: {path}, {RESULTS}, {JUNIT}']

    def _outcomes(self) -> Counter[str]:
        return Counter(result.outcome for result in self._results.values())


def _runs(count: int) -> str:
    return f'{count:,} run' + 's' * (count != 1)


def _percent(share: float) -> str:
    return f'{100 * share:.4g}%'


def junit_report(
    definition: SweepDefinition,
    results: Mapping[int, RunResult],
    folder_of: Callable[[int], Path],
    started: float,
) -> bytes:
    """
    Return a JUnit report with a case for each run.

    :param folder_of: Returns the folder for the logs of a run
    :param started: When, in seconds since the epoch
    """
    table = definition.table
    names = [Path(word).name for word in definition.target]
    class_name = '.'.join(n.partition('.')[0] or n for n in names)
    cases = []
    for run in table.runs:
        result = results.get(run.number)
        outcome = None
        if result is None:
            outcome = junit_outcome('skipped', 'it was not run yet')
        elif not result.succeeded:
            outcome = junit_outcome(
                'failure' if result.outcome == 'failed' else 'error',
                result.reason,
                f'{result.reason}\n\nlogs: {folder_of(run.number)}',
                'run',
            )
        seconds = 0.0 if result is None else result.seconds
        cases.append(
            junit_case(table.title(run), class_name, seconds, outcome)
        )
    total = sum(result.seconds for result in results.values())
    return junit_document(definition.title, class_name, started, total, cases)


def results_csv(
    table: RunTable,
    results: Mapping[int, RunResult],
    metrics: Iterable[str],
) -> str:
    """
    Return the runs that are done as a table (CSV, RFC 4180), for programs.

    No spreadsheet runs a value as a formula, and no terminal as a command.
    """
    metrics = tuple(metrics)
    is_repeated = table.repeats > 1
    rows: list[tuple[object, ...]] = [
        (
            'run',
            *map(_argument_column, table.names),
            *(['repeat'] if is_repeated else []),
            *('outcome', 'reason', 'seconds'),
            *metrics,
            *('commit', 'fingerprint'),
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
                *([run.repeat] if is_repeated else []),
                result.outcome,
                result.reason,
                f'{result.seconds:.3f}',
                *(result.metrics.get(name, '') for name in metrics),
                result.commit,
                result.fingerprint,
            )
        )
    return ''.join(f'{",".join(map(_cell, row))}\n' for row in rows)


def refuse_columns_twice(
    arguments: Iterable[str], metrics: Iterable[str]
) -> None:
    """
    Check that no metric has the name of another column.

    :raises UserError: when one has
    """
    known = {_argument_column(name) for name in arguments}
    for name in metrics:
        if name in _FIXED or name in known:
            what = 'a launch argument' if name in known else 'each result'
            raise UserError(
                f"--metric: results.csv has a column '{name}' already, of "
                f'{what}',
                'call the metric otherwise',
            )


def _argument_column(name: str) -> str:
    """Return the name of the column of a launch argument."""
    return f'argument {name}' if name in _FIXED else name


def _cell(value: object) -> str:
    """Return a value, with an apostrophe if it looks like a formula."""
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
