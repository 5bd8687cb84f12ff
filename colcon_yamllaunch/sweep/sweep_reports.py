# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files about a sweep that are made of what is known so far."""

from collections.abc import Iterator
from collections.abc import Mapping
from pathlib import Path
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.observers.launch_logs import COMMON_LOG
from colcon_yamllaunch.sweep.report_page import Page
from colcon_yamllaunch.sweep.report_page import report_page
from colcon_yamllaunch.sweep.results_csv import results_csv
from colcon_yamllaunch.sweep.results_folder import JUNIT
from colcon_yamllaunch.sweep.results_folder import MESSAGES
from colcon_yamllaunch.sweep.results_folder import REPORT
from colcon_yamllaunch.sweep.results_folder import RESULTS
from colcon_yamllaunch.sweep.results_folder import ResultsFolder
from colcon_yamllaunch.sweep.results_folder import shown_path
from colcon_yamllaunch.sweep.results_folder import SweepDefinition
from colcon_yamllaunch.sweep.results_folder import write_text
from colcon_yamllaunch.sweep.run_result import RunResult
from colcon_yamllaunch.sweep.run_result import versions_of
from colcon_yamllaunch.sweep.sweep_junit import junit_report

#: Seconds between two writings while runs go on, and how many times longer
#: than a writing takes that is at least.
_INTERVAL = 15.0
_SHARE = 50.0


class SweepReports:
    """
    Writes `results.csv`, `junit.xml` and `report.html`.

    :param results: What is known; it grows
    """

    def __init__(
        self,
        definition: SweepDefinition,
        folder: ResultsFolder,
        results: Mapping[int, RunResult],
    ) -> None:
        self._definition = definition
        self._folder = folder
        self._results = results
        self._started = time.time()
        self._next = time.monotonic() + _INTERVAL

    def refresh(self) -> None:
        """
        Write them if the last time is long ago.

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
        definition, results = self._definition, self._results
        table = definition.table
        path = self._folder.path
        title = ' '.join(definition.target)
        names = [Path(word).name for word in definition.target]
        class_name = '.'.join(n.partition('.')[0] or n for n in names)
        folders = {
            run.number: self._folder.run_folder(run.number)
            for run in table.runs
        }
        logs = {n: str(folder) for n, folder in folders.items()}

        def log_of(number: int) -> str | None:
            for name in (COMMON_LOG, MESSAGES):
                file = folders[number] / name
                if file.exists():
                    return str(file.relative_to(path))
            return None

        page = Page(
            title,
            definition.command,
            table,
            results,
            tuple(definition.metrics),
            log_of,
            time.time(),
        )
        try:
            write_text(
                path / RESULTS, results_csv(table, results, definition.metrics)
            )
            write_text(
                path / JUNIT,
                junit_report(
                    title, class_name, table, results, logs, self._started
                ),
            )
            write_text(path / REPORT, report_page(page))
        except OSError as e:
            raise UserError(
                f'{path} cannot be written: {e.strerror or e}',
                'what journal.jsonl there has is kept, and the same command '
                'goes on',
            ) from e

    def is_enough(self, required: float | None) -> bool:
        """
        Tell whether as many runs succeeded as have to.

        :param required: Their share, from 0 to 1; None for all
        """
        total = len(self._definition.table.runs)
        share = 1.0 if required is None else required
        # 95% of 20 is 19, whatever floating point makes of it
        return self._succeeded() + 1e-9 >= share * total

    def summary(self, required: float | None) -> list[str]:
        """Return what to say at the end."""
        total = len(self._definition.table.runs)
        succeeded = self._succeeded()
        counts = [f'{succeeded:,} succeeded']
        for outcome, text in (('failed', 'failed'), ('error', 'had an error')):
            count = sum(r.outcome == outcome for r in self._results.values())
            if count:
                counts.append(f'{count:,} {text}')
        if missing := total - len(self._results):
            counts.append(f'{missing:,} not run yet')
        runs = f'{total:,} run' + 's' * (total != 1)
        line = f'{runs}: {", ".join(counts)}'
        if required is not None:
            reached = 'enough' if self.is_enough(required) else 'too few'
            line += (
                f'; that is {_percent(succeeded / total)}, and '
                f'{_percent(required)} are required: {reached}'
            )
        path = self._folder.path
        return [
            line,
            *self._mixture(),
            f'results: {shown_path(path / REPORT)}, {RESULTS}, {JUNIT}',
        ]

    def _mixture(self) -> Iterator[str]:
        """Yield a warning if the results are of several versions."""
        versions = versions_of(self._results.values())
        if len(versions) < 2:
            return
        yield (
            f'warning: these results are of {len(versions)} versions of the '
            'code (commit, fingerprint):'
        )
        for name, found in versions.items():
            runs = f'{len(found):,} run' + 's' * (len(found) != 1)
            yield f'  {one_line(name)}: {runs}'
        yield 'help: for results that compare, do all again: --again all'

    def _succeeded(self) -> int:
        return sum(result.succeeded for result in self._results.values())


def _percent(share: float) -> str:
    return f'{100 * share:.4g}%'
