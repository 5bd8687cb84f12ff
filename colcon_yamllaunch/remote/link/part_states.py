# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the processes and components of a machine are doing."""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Mapping
from dataclasses import dataclass
import math
import time
from typing import Any

from colcon_yamllaunch.common.printable import printable
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import ending_of
from colcon_yamllaunch.engine.state import UNKNOWN

_PROCESS_PHASES = frozenset(
    ('waiting', 'running', 'stopping', 'respawn', 'ended')
)
_COMPONENT_PHASES = frozenset(
    ('waiting', 'loading', 'loaded', 'unloading', 'unloaded', 'failed')
)
# numbers beyond that are not of this world
_LARGEST = 1 << 53


class StateError(Exception):
    """What a machine tells is no state; the text says why."""


@dataclass(slots=True)
class _State:
    """
    What is known of a process or component.

    :param since: When that began, by the clock here
    :param started: When it was started last, likewise
    :param before: Its restarts before its machine began anew
    :param terminal: Whether it has a keyboard, None where that is not told
    """

    phase: str = 'waiting'
    pid: int | None = None
    since: float = 0.0
    started: float = 0.0
    starts: int = 0
    restarts: int = 0
    before: int = 0
    ending: str = ''
    node: str | None = None
    lifecycle: str | None = None
    terminal: bool | None = None
    is_kept_stopped: bool = False
    cpu: float | None = None
    memory: int | None = None


class PartStates:
    """
    Follows what happens on a machine, and takes what that tells besides.

    :param clock: Returns seconds that never go back
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._states: dict[str, _State] = {}

    def handle(self, event: events.Event) -> None:
        """Follow an event of that machine."""
        match event:
            case events.Started(process=process, pid=pid):
                state = self._state(process.label)
                state.restarts += state.starts > 0
                state.starts += 1
                state.pid, state.ending = pid, ''
                state.lifecycle = UNKNOWN if process.is_lifecycle else None
                state.terminal = None
                state.is_kept_stopped = False
                state.started = self._clock()
                self._turn(state, 'running')
            case events.Exited(process=process):
                state = self._state(process.label)
                again = event.respawn_delay is not None
                is_stopped = event.asked and not event.failed
                self._end(state, 'respawn' if again else 'ended')
                state.ending = (
                    'stopped'
                    if is_stopped
                    else ending_of(event.outcome, event.asked)
                )
            case events.StartFailed(process=process, reason=reason):
                state = self._state(process.label)
                state.starts = max(state.starts, 1)
                again = event.respawn_delay is not None
                self._end(state, 'respawn' if again else 'ended')
                state.ending = f'could not be started: {reason}'
            case events.Requested(process=part, action=action):
                state = self._state(part.label)
                if action != 'change':
                    state.is_kept_stopped = action in ('stop', 'kill')
                if state.phase == 'running':
                    self._turn(state, 'stopping')
                elif state.phase == 'respawn':
                    self._turn(state, 'ended')
            case events.StateChanged(process=part):
                state = self._state(part.label)
                state.lifecycle, state.node = event.state, event.node
            case events.Loaded(component=component):
                state = self._state(component.label)
                state.starts += 1
                state.node, state.ending = event.full_name, ''
                state.is_kept_stopped = False
                self._turn(state, 'loaded')
            case events.LoadFailed(component=component):
                state = self._state(component.label)
                state.ending = event.reason
                self._turn(state, 'failed')
            case events.Unloaded(component=component):
                state = self._state(component.label)
                state.ending = ''
                self._turn(state, 'unloaded')
            case _:
                return

    def take(self, told: object, parts: Collection[str]) -> None:
        """
        Take rows as :func:`dataclasses.asdict` makes them of states.

        :param told: An object with `processes` and `components`
        :param parts: The labels that there are
        :raises StateError: when they are none
        """
        if not isinstance(told, Mapping):
            raise StateError('the states are no object')
        kinds = (
            ('processes', _PROCESS_PHASES),
            ('components', _COMPONENT_PHASES),
        )
        for kind, phases in kinds:
            rows = told.get(kind, ())
            if not isinstance(rows, list | tuple):
                raise StateError(f'the {kind} are no list')
            for row in rows:
                self._take_row(row, phases, parts)

    def take_usage(self, told: object, parts: Collection[str]) -> None:
        """
        Take what processes use: by label their share of a processor and bytes.

        What makes no sense is passed over; it is not more than figures.
        """
        if not isinstance(told, Mapping):
            return
        for state in self._states.values():
            state.cpu = state.memory = None
        for label, usage in told.items():
            match usage:
                case [float() | int() as cpu, int(memory)] if (
                    label in parts
                    and math.isfinite(cpu)
                    and 0 <= cpu < _LARGEST
                    and 0 <= memory < _LARGEST
                ):
                    state = self._state(label)
                    state.cpu, state.memory = float(cpu), memory
                case _:
                    continue

    def usage(self) -> dict[str, tuple[float, int]]:
        """Return the use of processors and memory as told last, by label."""
        return {
            label: (state.cpu, state.memory)
            for label, state in self._states.items()
            if state.cpu is not None
            and state.memory is not None
            and state.pid is not None
        }

    def lost(self, label: str, machine: str) -> None:
        """Take into account that nobody knows what became of a process."""
        state = self._state(label)
        self._end(state, 'ended')
        state.ending = f'lost with {machine}'

    def begin_again(self, label: str) -> None:
        """Take into account that it is started anew on its machine."""
        state = self._state(label)
        state.before = state.restarts + (state.starts > 0)
        state.is_kept_stopped = False
        self._turn(state, 'waiting')

    def is_kept_stopped(self, label: str) -> bool:
        """Tell whether somebody has stopped it."""
        return self._state(label).is_kept_stopped

    def forget(self, label: str) -> None:
        """Forget a process or component."""
        self._states.pop(label, None)

    def runs(self, label: str) -> bool:
        """Tell whether a process runs, as far as that is known."""
        state = self._states.get(label)
        return state is not None and state.pid is not None

    def run_of(self, label: str) -> tuple[int, float]:
        """Return the process id of one that runs, and for how long it has."""
        state = self._state(label)
        return state.pid or 0, self._clock() - state.started

    def may_restart(self, label: str) -> bool:
        """Tell whether a change has it started anew; see `Supervisor`."""
        state = self._states.get(label)
        return (
            state is not None
            and state.starts > 0
            and not state.is_kept_stopped
        )

    def label_of_node(self, name: str) -> str | None:
        """Return the label of the component that has a node of a full name."""
        return next(
            (
                label
                for label, state in self._states.items()
                if state.node == name
            ),
            None,
        )

    def _take_row(
        self, row: Any, phases: Collection[str], parts: Collection[str]
    ) -> None:
        if not isinstance(row, Mapping):
            raise StateError('a state is no object')
        label = row.get('label')
        if not isinstance(label, str) or label not in parts:
            raise StateError('a state is of nothing that is there')
        phase: Any = row.get('phase')
        seconds: Any = row.get('seconds')
        pid: Any = row.get('pid')
        restarts: Any = row.get('restarts', 0)
        if (
            not isinstance(phase, str)
            or phase not in phases
            or type(seconds) not in (int, float)
            or not 0 <= seconds < _LARGEST
            or not (pid is None or (type(pid) is int and 0 < pid < _LARGEST))
            or type(restarts) is not int
            or not 0 <= restarts < _LARGEST
        ):
            raise StateError('a state has fields that make no sense')
        state = self._state(label)
        state.phase, state.pid = phase, pid
        state.restarts = state.before + restarts
        state.since = self._clock() - seconds
        state.ending = printable(str(row.get('ending') or ''))
        state.starts = max(state.starts, int(phase != 'waiting'))
        for name in ('node', 'lifecycle'):
            text = row.get(name)
            setattr(state, name, text and printable(str(text)))
        if 'terminal' in row:
            state.terminal = row['terminal'] is True

    def _state(self, label: str) -> _State:
        return self._states.setdefault(label, _State())

    def _turn(self, state: _State, phase: str) -> None:
        state.phase = phase
        state.since = self._clock()

    def _end(self, state: _State, phase: str) -> None:
        state.pid = state.cpu = state.memory = None
        self._turn(state, phase)
