# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is shown while a sweep goes on."""

import io
from pathlib import Path

from colcon_yamllaunch.sweep.progress import Progress
from colcon_yamllaunch.sweep.reports import SweepReports
from colcon_yamllaunch.sweep.results import (
    ResultsFolder,
    RunResult,
    SweepDefinition,
)
from colcon_yamllaunch.sweep.table import run_table
import pytest


class Tty(io.StringIO):
    """A stream that is a terminal."""

    def isatty(self) -> bool:
        return True


class Shown:
    """A progress, with a clock that is set by hand."""

    def __init__(
        self, folder: Path, stream: io.StringIO, runs: int, *, quiet: bool
    ) -> None:
        self.table = run_table({'seed': f'1..{runs}'})
        definition = SweepDefinition('', ('a.yaml',), self.table, {}, {})
        results = ResultsFolder(folder, definition, print)
        self.now = 0.0
        self.stream = stream
        self.progress = Progress(
            stream,
            results,
            SweepReports(results),
            quiet=quiet,
            clock=lambda: self.now,
        )

    def done(self, *numbers: int, failed: bool = False) -> None:
        for number in numbers:
            outcome = 'failed' if failed else 'succeeded'
            result = RunResult(number, outcome, 'it fell' if failed else '')
            self.progress.done(self.table.runs[number - 1], result)

    def text(self) -> str:
        return self.stream.getvalue()


def shown(
    folder: Path, *, tty: bool = False, runs: int = 10, quiet: bool = False
) -> Shown:
    return Shown(folder, Tty() if tty else io.StringIO(), runs, quiet=quiet)


def test_progress_without_a_terminal_is_some_lines(tmp_path: Path) -> None:
    one = shown(tmp_path)
    one.progress.set_running(2)
    for one.now in range(30):
        one.progress.tick()
    one.done(1, 2, 3)
    one.now = 30.0
    one.progress.tick()
    assert one.text().splitlines() == [
        '0 of 10 done · 2 running',
        '0 of 10 done · 2 running',
        '3 of 10 done · 2 running · 1 min 10 s left',
    ]


def test_progress_on_a_terminal_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv('TERM', 'xterm')
    one = shown(tmp_path, tty=True)
    one.progress.set_running(2)
    one.progress.tick()
    one.done(1, failed=True)
    one.now = 1.0
    one.progress.tick()
    one.progress.end()
    assert one.text() == (
        '\r\x1b[K0 of 10 done · 2 running'
        '\r\x1b[K\x1b[31mfailed\x1b[0m: run 1, seed:=1: it fell\n'
        '\r\x1b[K1 of 10 done · \x1b[31m1 failed\x1b[0m · 2 running'
        '\r\x1b[K'
    )


def test_only_the_first_failures_are_shown(tmp_path: Path) -> None:
    one = shown(tmp_path, runs=40, quiet=True)
    one.done(*range(1, 41), failed=True)
    one.progress.tick()
    lines = one.text().splitlines()
    assert len(lines) == 21
    assert lines[-1] == 'more that fail are in results.csv'


def test_control_characters_in_reasons_are_escaped(tmp_path: Path) -> None:
    one = shown(tmp_path)
    result = RunResult(1, 'failed', 'a\x1b[2Jb\nc')
    one.progress.done(one.table.runs[0], result)
    assert one.text().count('\n') == 1
    assert '\x1b' not in one.text()


def test_progress_on_a_closed_stream_is_ignored(tmp_path: Path) -> None:
    one = shown(tmp_path)
    one.stream.close()
    one.done(1, failed=True)
    one.progress.tick()
