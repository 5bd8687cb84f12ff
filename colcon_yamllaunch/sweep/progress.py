# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What is shown of a sweep while it goes on.

On a terminal that is one line, which is redrawn; elsewhere a line is written
now and then. A run that failed has a line of its own.
"""

from collections.abc import Callable, Collection
from contextlib import suppress
import os
import time
from typing import TextIO

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.table import duration
from colcon_yamllaunch.engine.channels import DEFAULT_SIZE, size_of
from colcon_yamllaunch.observers.presentation import only_prints
from colcon_yamllaunch.sweep.reports import SweepReports
from colcon_yamllaunch.sweep.results import Code, ResultsFolder, RunResult
from colcon_yamllaunch.sweep.table import Run

#: Seconds between two drawings of the line in a terminal.
_INTERVAL = 0.1
#: Seconds between two lines elsewhere.
_PLAIN_INTERVAL = 15.0
#: How many runs that failed are shown; results.csv has all.
_SHOWN_FAILURES = 20
#: How many have to be done before the time left is known.
_KNOWN_FROM = 3

_RED, _PLAIN = '\x1b[31m', '\x1b[0m'
_CLEAR = '\r\x1b[K'


class Progress:
    """
    Shows the progress of a sweep, and records results.

    :param stream: Where it is shown
    :param quiet: Whether only failures are
    :param code: Returns which version of the code there is now, with more
      files that runs use
    :param clock: Returns seconds that never go back
    """

    def __init__(
        self,
        stream: TextIO,
        folder: ResultsFolder,
        reports: SweepReports,
        *,
        quiet: bool = False,
        color: bool = True,
        code: Callable[[Collection[str]], Code] = lambda _: Code('', {}),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._stream = stream
        can_redraw = stream.isatty() and not only_prints(os.environ)
        self._is_terminal = can_redraw
        self._color = color and self._is_terminal
        self._table = folder.definition.table
        self._journal = folder.journal
        self._folder = folder
        self._reports = reports
        self._quiet = quiet
        self._code = code
        results = folder.results.values()
        self._versions = {result.fingerprint for result in results}
        self._clock = clock
        self._begin = clock()
        self._before = len(results)
        self._failures = sum(not result.succeeded for result in results)
        self._failures_shown = 0
        self._running = 0
        self._waiting = ''
        self._shown = -_PLAIN_INTERVAL
        self._is_drawn = False

    def set_running(self, running: int) -> None:
        """Set the number of running runs."""
        self._running = running

    def waiting(self, text: str) -> None:
        """Set a text about waiting runs."""
        self._waiting = text

    def planned(self, run: Run, uses: Collection[str] = ()) -> None:
        """
        Keep which version of the code a run uses.

        :param uses: Files that it uses; those of other runs may be left out
        :raises UserError: when it cannot be kept
        """
        fingerprint = self._journal.plan(run.number, self._code(uses))
        if self._versions and fingerprint not in self._versions:
            self._line(
                'warning: the code has changed since other runs of this '
                'sweep; results.csv says which run is of which version'
            )
        self._versions.add(fingerprint)

    def done(self, run: Run, result: RunResult) -> None:
        """
        Record the result of a run, and show a failure.

        :raises UserError: when it cannot be kept
        """
        self._journal.add(result)
        self._reports.refresh()
        if result.succeeded:
            return
        self._failures += 1
        self._failures_shown += 1
        if self._failures_shown > _SHOWN_FAILURES + 1:
            return
        if self._failures_shown > _SHOWN_FAILURES:
            self._line('more that fail are in results.csv')
            return
        name = f'run {run.number}'
        title = self._table.title(run)
        if title != name:
            name += f', {title}'
        self._line(
            f'{self._paint(_RED, result.outcome)}: {one_line(name)}: '
            f'{one_line(result.reason)}'
        )
        logs = self._folder.run_folder(run.number)
        if logs.is_dir():
            self._line(f'  logs: {self._folder.shown(logs)}')

    def interrupted(self, running: int, *, escalates: bool) -> None:
        """Show that the running runs are being stopped."""
        if escalates:
            self._line('killing what still runs')
        elif running:
            runs = f'{running} run' + 's' * (running > 1)
            self._line(f'stopping {runs} (Ctrl-C again to kill)')

    def say(self, text: str) -> None:
        """Show a line of its own."""
        self._line(one_line(text))

    def tick(self) -> None:
        """Show how far it is, if it is time for that."""
        now = self._clock()
        interval = _INTERVAL if self._is_terminal else _PLAIN_INTERVAL
        if self._quiet or now - self._shown < interval:
            return
        if not self._is_terminal and not (self._running or self._waiting):
            return
        self._shown = now
        if self._is_terminal:
            width = self._width()
            self._write(_CLEAR + self._text(width))
            self._is_drawn = True
        else:
            self._write(self._text(0) + '\n')

    def end(self) -> None:
        """Clear the line that is redrawn."""
        if self._is_drawn:
            self._write(_CLEAR)
            self._is_drawn = False

    def _text(self, width: int) -> str:
        """Return the line; at most of a width, 0 for any."""
        total, done = len(self._table.runs), len(self._journal.results)
        parts = [f'{done:,} of {total:,} done']
        if self._failures:
            parts.append(f'{self._failures:,} failed')
        if self._running:
            parts.append(f'{self._running:,} running')
        if self._waiting:
            parts.append(self._waiting)
        parts.append(self._time_left(total - done, done - self._before))
        text = ' · '.join(filter(None, parts))
        if width and len(text) > width:
            text = text[: max(0, width - 1)] + '…'
        failed = f'{self._failures:,} failed'
        if self._failures and self._color and failed in text:
            text = text.replace(failed, self._paint(_RED, failed))
        return text

    def _time_left(self, missing: int, done: int) -> str:
        if done < _KNOWN_FROM or not missing:
            return ''
        each = (self._clock() - self._begin) / done
        left = each * missing
        # nobody reads tenths of longer times
        text = f'{left:.1f} s' if left < 9.95 else duration(round(left))
        return f'{text} left'

    def _paint(self, color: str, text: str) -> str:
        return f'{color}{text}{_PLAIN}' if self._color else text

    def _line(self, text: str) -> None:
        clear = _CLEAR if self._is_drawn else ''
        self._is_drawn = False
        self._write(f'{clear}{text}\n')
        self._shown = -_PLAIN_INTERVAL if self._is_terminal else self._shown

    def _width(self) -> int:
        with suppress(OSError, ValueError):
            return size_of(self._stream.fileno()).columns - 1
        return DEFAULT_SIZE.columns - 1

    def _write(self, text: str) -> None:
        # the sweep goes on if nobody sees it
        with suppress(OSError, ValueError):
            self._stream.write(text)
            self._stream.flush()
