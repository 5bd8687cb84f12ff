# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What failed in a launch, and the closing lines about it."""

import os
from pathlib import Path

from colcon_yamllaunch.language.position import Position
from colcon_yamllaunch.runtime import limits
from colcon_yamllaunch.runtime.events import Event
from colcon_yamllaunch.runtime.events import Exited
from colcon_yamllaunch.runtime.events import LeftBehind
from colcon_yamllaunch.runtime.events import Output
from colcon_yamllaunch.runtime.events import Started
from colcon_yamllaunch.runtime.events import StartFailed
from colcon_yamllaunch.runtime.lines import bare

Failure = Exited | StartFailed


class Failures:
    """
    Listens for failures, and keeps the last output of each process.

    A failure is forgotten when its process is started again.

    :param log_files: The log file of a process by its label, if it has one
    """

    def __init__(self, log_files: dict[str, Path]) -> None:
        self._log_files = log_files
        self._failures: dict[str, Failure] = {}
        self._tails: dict[str, bytes] = {}
        self._left_behind = False

    def handle(self, event: Event) -> None:
        """Listen to an event."""
        match event:
            case Output():
                self._keep(event)
            case Started():
                self._failures.pop(event.process.label, None)
                self._tails.pop(event.process.label, None)
            case Exited(failed=True) | StartFailed():
                self._failures[event.process.label] = event
            case LeftBehind():
                self._left_behind = True
            case _:
                return

    @property
    def exit_code(self) -> int:
        """1 if something failed, else 0."""
        return int(bool(self._failures) or self._left_behind)

    def summary(self) -> tuple[str, ...]:
        """Return the lines that name the first failure and those after it."""
        if not self._failures:
            return ()
        first, *others = self._failures.values()
        label = first.process.label
        lines = [f'failed: {_description(first)}']
        tail = self._tail(label)
        if isinstance(first, Exited) and tail:
            lines.append(f'  the last lines of {label}:')
            lines.extend(f'  | {line}' for line in tail)
        if isinstance(first, Exited) and label in self._log_files:
            lines.append(f'  all of its output: {self._log_files[label]}')
        lines.extend(f'then failed: {_description(f)}' for f in others)
        return tuple(lines)

    def _keep(self, event: Output) -> None:
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


def _description(failure: Failure) -> str:
    process = failure.process
    place = f'(from {_shown(process.position)})'
    if isinstance(failure, StartFailed):
        return (
            f'{process.label} could not be started: {failure.reason} {place}'
        )
    return f'{what_happened(failure)} {place}'


def what_happened(event: Exited) -> str:
    """Say how a process ended, and when."""
    return f'{event.process.label} {event.outcome} after {event.seconds:.1f} s'


def _shown(position: Position) -> str:
    try:
        relative = os.path.relpath(position.path)
    except (OSError, ValueError):
        return str(position)
    if relative.startswith('..'):
        return str(position)
    return str(Position(relative, position.line, position.column))
