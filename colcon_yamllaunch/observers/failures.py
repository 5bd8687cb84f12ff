# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Reports of what failed in a launch, and the closing lines about it."""

from collections.abc import Callable, Sequence
from pathlib import Path

from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.lines import bare
from colcon_yamllaunch.engine.state import Failure, LaunchState
from colcon_yamllaunch.plan.plan import Member, SHOWN

#: Returns the package that has a Python module and that another package does
#: not declare, or None; it gets the module and that other package.
OwnerOf = Callable[[str, str | None], str | None]


class Failures:
    """
    Reports what failed in a launch, with the last output of each process.

    :param state: The state of the launch, which says what failed
    :param advise: Returns how to fix a failure, from the last lines that the
      process wrote, or None
    """

    def __init__(
        self,
        state: LaunchState,
        advise: Callable[[events.Exited, Sequence[str]], str | None] = (
            lambda _event, _tail: None
        ),
    ) -> None:
        self._state = state
        self._advise = advise
        self._tails: dict[str, bytes] = {}
        self._core_dumps: dict[str, str | None] = {}
        # how many lines of the launcher were shown after the last output of a
        # process, and how many of them before the line about each label
        self._lines_after = 0
        self._shown_at: dict[str, int] = {}

    def handle(self, event: events.Event) -> None:
        """Note an event, which the state has applied."""
        self._lines_after += len(event.lines())
        match event:
            case events.Output():
                label = event.process.label
                data = event.data
                if len(data) < limits.TAIL_BYTES:
                    data = self._tails.get(label, b'') + data
                self._tails[label] = data[-limits.TAIL_BYTES :]
                if event.stream in SHOWN[event.process.output]:
                    self._lines_after = 0
                    self._shown_at = {label: 0}
            case events.Started():
                self._tails.pop(event.process.label, None)
            case events.Exited(failed=True, outcome=outcome):
                if not outcome.lost:
                    self._look_for_core_dump(event)
            case events.StartFailed():
                self._core_dumps.pop(event.process.label, None)
                self._shown_at[event.process.label] = self._lines_after
            case events.TransitionFailed() | events.LoadFailed():
                self._shown_at[_failed_member(event).label] = self._lines_after
            case _:
                return

    @property
    def _others(self) -> list[str]:
        return [*self._state.problems, *self._state.gone.values()]

    def reports(self) -> tuple[events.FailureReport, ...]:
        """Return a report of each process that failed, in order."""
        state = self._state
        reports = [self._report(f) for f in state.failures.values()]
        reports += [
            events.FailureReport(
                event.process,
                f'{event.process.label} cannot be stopped, not even by '
                f'SIGKILL; pid {event.pid} is left behind',
            )
            for event in state.left_behind.values()
        ]
        reports += [
            events.FailureReport(
                event.process,
                f'{event.process.label} was {event.outcome}',
                tuple(self._tail(event.process.label)),
                self._log_file(event.process.label),
            )
            for event in state.lost
        ]
        reports += [events.FailureReport(None, text) for text in self._others]
        return tuple(reports)

    def reasons(self) -> tuple[str, ...]:
        """Return a text for each failure, in the order of the summary."""
        failures = self._state.failures.values()
        return (*map(self._description, failures), *self._others)

    def summary(self) -> tuple[str, ...]:
        """Return the lines that name the first failure and those after it."""
        others = tuple(f'failed: {text}' for text in self._others)
        if not self._state.failures:
            return others
        first, *following = self._state.failures.values()
        label = _failed_member(first).label
        report = self._report(first)
        lines = [f'failed: {self._description(first)}']
        if report.tail and not self._stands_above(first):
            lines.append(f'  the last lines of {label}:')
            lines.extend(f'  | {line}' for line in report.tail)
        if report.advice is not None:
            lines.append(f'  {report.advice}')
        if report.log_file is not None:
            lines.append(f'  all of its output: {report.log_file}')
        if core_dump := self._core_dumps.get(label):
            lines.append(f'  its core dump: {core_dump}')
        lines += [f'then failed: {self._description(f)}' for f in following]
        return (*lines, *others)

    def _report(self, failure: Failure) -> events.FailureReport:
        if not isinstance(failure, events.Exited):
            text = _what_failed(failure)
            return events.FailureReport(_failed_member(failure), text)
        process = failure.process
        tail = tuple(self._tail(process.label))
        return events.FailureReport(
            process,
            _what_failed(failure),
            tail,
            self._log_file(process.label),
            self._advise(failure, tail),
        )

    def _description(self, failure: Failure) -> str:
        position = events.shown(_failed_member(failure).position)
        what = _what_failed(failure)
        if self._stands_above(failure) and not isinstance(
            failure, events.Exited
        ):
            what = what.removesuffix(f': {failure.reason}')
        return f'{what} (from {position})'

    def _stands_above(self, failure: Failure) -> bool:
        """Return whether the last lines already show the failure."""
        shown_at = self._shown_at.get(_failed_member(failure).label)
        return (
            shown_at is not None
            and self._lines_after - shown_at <= limits.TAIL_LINES
        )

    def _look_for_core_dump(self, event: events.Exited) -> None:
        label = event.process.label
        member = self._state.by_label.get(label)
        is_here = member is None or member.machine is None
        self._core_dumps[label] = None
        if event.outcome.core_dumped and is_here:
            # imported late, as few processes crash
            from colcon_yamllaunch.engine.debugging import find_core_dump

            self._core_dumps[label] = find_core_dump(
                event.pid, event.process.cwd, event.seconds
            )

    def _log_file(self, label: str) -> Path | None:
        log = self._state.log_files.get(label)
        return None if log is None else Path(log)

    def _tail(self, label: str) -> list[str]:
        data = self._tails.get(label, b'')
        lines = bare(data).rstrip().split('\n')
        if len(data) == limits.TAIL_BYTES and len(lines) > 1:
            # its beginning is missing
            del lines[0]
        return lines[-limits.TAIL_LINES :] if data.strip() else []


def _failed_member(failure: Failure) -> Member:
    member = events.member_of(failure)
    assert member is not None
    return member


def _what_failed(failure: Failure) -> str:
    label = _failed_member(failure).label
    match failure:
        case events.StartFailed():
            return f'{label} could not be started: {failure.reason}'
        case events.LoadFailed():
            where = failure.component.container
            return (
                f'{label} could not be loaded into {where}: {failure.reason}'
            )
        case events.TransitionFailed():
            return f'{label}: {failure.text}'
        case events.Exited():
            return f'{label} {failure.outcome} after {failure.seconds:.1f} s'
