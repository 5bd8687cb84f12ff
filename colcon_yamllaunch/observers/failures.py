# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What failed in a launch, and the closing lines about it."""

from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from pathlib import Path

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.output.lines import bare
from colcon_yamllaunch.engine.output_modes import SHOWN
from colcon_yamllaunch.engine.process.core_dumps import find_core_dump
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Process

Failure = (
    events.Exited
    | events.StartFailed
    | events.LoadFailed
    | events.TransitionFailed
)
#: Returns the package that has a Python module and that another package does
#: not declare, or None; it gets the module and that other package.
OwnerOf = Callable[[str, str | None], str | None]


class Failures:
    """
    Listens for failures, and keeps the last output of each process.

    A failure is forgotten when its process is started again, its component
    loaded after all, or its lifecycle node activated. None is once the launch
    stops: a machine may start a process again until it is told to stop.

    :param log_files: The log file of a process by its label, if it has one
    :param advise: Returns the way out of a failure, if it tells one; it gets
      the last lines that the process wrote
    :param is_elsewhere: Tells whether a process, by its label, runs on
      another machine, where no core dump is looked for
    """

    def __init__(
        self,
        log_files: Mapping[str, Path],
        advise: Callable[[events.Exited, Sequence[str]], str | None] = (
            lambda _event, _tail: None
        ),
        is_elsewhere: Callable[[str], bool] = lambda _label: False,
    ) -> None:
        self._advise = advise
        self._is_elsewhere = is_elsewhere
        self._log_files = log_files
        self._failures: dict[str, Failure] = {}
        self._tails: dict[str, bytes] = {}
        self._core_dumps: dict[str, str | None] = {}
        # what failed that is no process, component or node
        self._others: list[str] = []
        # machines that are gone, with what is to be told of that
        self._gone: dict[str, str] = {}
        self._lost: list[events.Exited] = []
        self._left_behind: dict[tuple[str, int], events.LeftBehind] = {}
        # how many lines of ours were shown after the last output of a
        # process, in all and until something was told about whom
        self._lines_after = 0
        self._told: dict[str, int] = {}
        self._is_stopping = False

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        self._lines_after += len(event.lines())
        match event:
            case events.Output():
                self._keep(event)
                if event.stream in SHOWN[event.process.output]:
                    self._lines_after = 0
                    self._told = {event.process.label: 0}
            case events.ShuttingDown():
                self._is_stopping = True
            case events.Dropped():
                self._forget(event.process.label)
            case events.Started():
                self._forget(event.process.label)
                self._tails.pop(event.process.label, None)
            case events.Exited(outcome=outcome) if outcome.lost:
                # that the machine is gone is said once
                if not event.asked:
                    self._lost.append(event)
            case events.Exited(failed=True) | events.StartFailed():
                self._failures[event.process.label] = event
                self._look_for_core_dump(event)
                self._note_reason(event)
            case events.LoadFailed():
                self._failures[event.component.label] = event
                self._note_reason(event)
            case events.Loaded():
                self._forget(event.component.label)
            case events.TransitionFailed():
                # that its process failed says more
                self._failures.setdefault(event.process.label, event)
                self._note_reason(event)
            case events.StateChanged(state='active'):
                self._forget(event.process.label)
            case events.RosLost():
                self._others.append(event.reason)
            case events.HostLost():
                self._others.append(event.text)
            case events.MachineGone():
                self._gone[event.machine] = event.text
            case events.LinkBack(machine=name) if not self._is_stopping:
                self._gone.pop(name, None)
                self._lost = [e for e in self._lost if e.outcome.lost != name]
            case events.PlanFailed():
                self._others.append(event.problems[0])
            case events.LeftBehind():
                key = event.process.label, event.pid
                self._left_behind[key] = event
            case _:
                return

    @property
    def exit_code(self) -> int:
        """1 if something failed, else 0."""
        failed = self._failures or self._left_behind or self._all_others
        return int(bool(failed))

    @property
    def _all_others(self) -> list[str]:
        return [*self._others, *self._gone.values()]

    def reports(self) -> tuple[events.FailureReport, ...]:
        """Return what is known of each process that failed, in order."""
        reports = [self._report(f) for f in self._failures.values()]
        reports += [
            events.FailureReport(
                event.process,
                f'{event.process.label} cannot be stopped, not even by '
                f'SIGKILL; pid {event.pid} is left behind',
            )
            for event in self._left_behind.values()
        ]
        reports += [
            events.FailureReport(
                event.process,
                f'{event.process.label} was {event.outcome}',
                tuple(self._tail(event.process.label)),
                self._log_files.get(event.process.label),
            )
            for event in self._lost
        ]
        others = self._all_others
        reports += [events.FailureReport(None, text) for text in others]
        return tuple(reports)

    def summary(self) -> tuple[str, ...]:
        """Return the lines that name the first failure and those after it."""
        others = tuple(f'failed: {text}' for text in self._all_others)
        if not self._failures:
            return others
        first, *following = self._failures.values()
        label = _owner(first).label
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

    def _forget(self, label: str) -> None:
        if not self._is_stopping:
            self._failures.pop(label, None)

    def _report(self, failure: Failure) -> events.FailureReport:
        if not isinstance(failure, events.Exited):
            text = _what_failed(failure)
            return events.FailureReport(_owner(failure), text)
        process = failure.process
        tail = tuple(self._tail(process.label))
        return events.FailureReport(
            process,
            _what_failed(failure),
            tail,
            self._log_files.get(process.label),
            self._advise(failure, tail),
        )

    def _description(self, failure: Failure) -> str:
        position = events.shown(_owner(failure).position)
        what = _what_failed(failure)
        if self._stands_above(failure):
            what = what.removesuffix(f': {_reason(failure)}')
        return f'{what} (from {position})'

    def _note_reason(self, failure: Failure) -> None:
        if _reason(failure) is not None:
            self._told[_owner(failure).label] = self._lines_after

    def _stands_above(self, failure: Failure) -> bool:
        """Tell whether what would be told stands right above already."""
        told = self._told.get(_owner(failure).label)
        return (
            told is not None and self._lines_after - told <= limits.TAIL_LINES
        )

    def _look_for_core_dump(
        self, event: events.Exited | events.StartFailed
    ) -> None:
        found = None
        is_here = not self._is_elsewhere(event.process.label)
        if (
            isinstance(event, events.Exited)
            and event.outcome.core_dumped
            and is_here
        ):
            cwd = event.process.cwd
            found = find_core_dump(event.pid, cwd, event.seconds)
        self._core_dumps[event.process.label] = found

    def _keep(self, event: events.Output) -> None:
        label = event.process.label
        data = event.data
        if len(data) < limits.TAIL_BYTES:
            data = self._tails.get(label, b'') + data
        self._tails[label] = data[-limits.TAIL_BYTES :]

    def _tail(self, label: str) -> list[str]:
        data = self._tails.get(label, b'')
        lines = bare(data).rstrip().split('\n')
        if len(data) == limits.TAIL_BYTES and len(lines) > 1:
            # its beginning is missing
            del lines[0]
        return lines[-limits.TAIL_LINES :] if data.strip() else []


def _owner(failure: Failure) -> Process | Component:
    if isinstance(failure, events.LoadFailed):
        return failure.component
    return failure.process


def _reason(failure: Failure) -> str | None:
    return None if isinstance(failure, events.Exited) else failure.reason


def _what_failed(failure: Failure) -> str:
    label = _owner(failure).label
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
