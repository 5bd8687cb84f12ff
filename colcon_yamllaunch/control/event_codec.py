# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Events of a launch as JSON and back, for a launcher of the same version.

An event is an object with the name of its class, and its fields by their
names. Processes and components are their labels, as the launcher knows what
they are. It does not trust what comes from a machine: that becomes an event
of a known kind with fields of the right types, or is refused.
"""

from collections.abc import Callable
import signal
from typing import Any

from colcon_yamllaunch.common.codec import Codec
from colcon_yamllaunch.common.codec import CodecError
from colcon_yamllaunch.common.codec import only
from colcon_yamllaunch.common.codec import read_float
from colcon_yamllaunch.common.printable import printable
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Process

#: The events that a launcher gets of a part on a machine, besides `Ended`; all
#: others are its own, and output is sent in another way.
FROM_MACHINES: tuple[type[events.Event], ...] = (
    events.Planned,
    events.Dropped,
    events.Started,
    events.StartFailed,
    events.Exited,
    events.Suspended,
    events.Silent,
    events.Respawned,
    events.Signalled,
    events.Requested,
    events.ShuttingDown,
    events.StillRunning,
    events.LeftBehind,
    events.Said,
    events.Warned,
    events.Loaded,
    events.LoadFailed,
    events.Unloaded,
    events.StateChanged,
    events.TransitionFailed,
    events.PartChanged,
    events.RosLost,
    events.Idle,
    events.CannotRun,
)
#: Returns the process or component with a label, None if there is none.
PartOf = Callable[[str], Process | Component | None]

_KIND = 'event'
_ENDED = events.Ended.__name__
_LARGEST_CODE = 255
_BY_NAME = {kind.__name__: kind for kind in FROM_MACHINES}
# JSON keeps smaller numbers exactly, whoever reads it
_LARGEST = 1 << 53
# no time in a launch comes near to that, and it can be shown
_LONGEST = 1e12
_LEVELS = frozenset(('DEBUG', 'INFO', 'WARNING', 'ERROR', 'CRITICAL'))
_PARTS: tuple[tuple[Any, tuple[type, ...]], ...] = (
    (Process, (Process,)),
    (Component, (Component,)),
    (Process | Component, (Process, Component)),
)


class EventError(Exception):
    """An object is no event of a machine; the text says why."""


class EventReader:
    """
    Reads the events of one machine.

    :param part_of: Returns what a label of that machine stands for
    """

    def __init__(self, part_of: PartOf) -> None:
        self._codec = _codec(part_of)

    def read(self, data: object) -> events.Event:
        """
        Return the event that an object stands for.

        :raises EventError: when it is none
        """
        name = data.get(_KIND) if isinstance(data, dict) else None
        if name == _ENDED and isinstance(data, dict):
            code = data.get('exit_code')
            if type(code) is not int or not 0 <= code <= _LARGEST_CODE:
                raise EventError('the end has no exit code')
            return events.Ended(code)
        if not isinstance(name, str) or name not in _BY_NAME:
            raise EventError('an event is of no known kind')
        try:
            event = self._codec.from_json(_BY_NAME[name], data)
        except CodecError as error:
            field = error.path.lstrip('.')
            problem = f"'{field}' of the event {name} is not what it should be"
            if not field:
                problem = f'the event {name} {error.problem}'
            raise EventError(problem) from error
        number = getattr(event, 'signal', None)
        numbers = number, getattr(event, 'next_signal', None)
        if not all(n is None or 0 < n < signal.NSIG for n in numbers):
            raise EventError(f'the event {name} has an unknown signal')
        if getattr(event, 'level', 'INFO') not in _LEVELS:
            raise EventError(f'the event {name} has an unknown level')
        return event


def event_to_json(event: events.Event) -> dict[str, Any]:
    """Return an event as an object for JSON; empty if it is not for others."""
    if isinstance(event, events.Ended):
        # a launcher has its own failures and verdicts
        return {_KIND: _ENDED, 'exit_code': event.exit_code}
    if type(event) not in FROM_MACHINES:
        return {}
    data: dict[str, Any] = _WRITER.to_json(event)
    return data


def _codec(part_of: PartOf) -> Codec:
    def reader(kinds: tuple[type, ...]) -> Callable[[Any], Any]:
        def read(data: Any) -> Any:
            part = part_of(only(str, data))
            if not isinstance(part, kinds):
                raise CodecError('is the label of nothing there')
            return part

        return read

    parts = {hint: (_label_of, reader(kinds)) for hint, kinds in _PARTS}
    return Codec(
        {kind: kind.__name__ for kind in FROM_MACHINES},
        tag=_KIND,
        special={
            **parts,
            Outcome: (_write_outcome, _read_outcome),
            str: (None, lambda data: printable(only(str, data))),
            # signals have names in Python, and are numbers
            int: (int, _read_int),
            float: (None, _read_float),
        },
    )


def _label_of(part: Process | Component) -> str:
    return part.label


def _write_outcome(outcome: Outcome) -> list[Any]:
    return [outcome.code, outcome.signal, outcome.core_dumped]


def _read_outcome(data: Any) -> Outcome:
    match only(list, data):
        case [int(code), None, False] if type(code) is int and (
            0 <= code <= 255
        ):
            return Outcome(code)
        case [None, int(number), bool(core_dumped)] if (
            type(number) is int and 0 < number < signal.NSIG
        ):
            return Outcome(None, number, core_dumped)
    raise CodecError('is no outcome')


def _read_int(data: Any) -> int:
    if abs(only(int, data)) > _LARGEST:
        raise CodecError('is too large a number')
    return int(data)


def _read_float(data: Any) -> float:
    number = read_float(data)
    if abs(number) >= _LONGEST:
        raise CodecError('is too large a number')
    return number


_WRITER = _codec(lambda _: None)
