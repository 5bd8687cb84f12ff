# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Events of a part on another machine, as JSON and back.

An event is an object with the name of its class, and its fields by their
names. Processes and components stand there by their labels: what they are is
known here, and not to be told by another machine. What comes from there is
not trusted: it becomes an event of a known kind with fields of the right
types, or is refused.
"""

from collections.abc import Callable
from collections.abc import Mapping
import dataclasses
from functools import cache
import math
import signal
import types
import typing
from typing import Any

from colcon_yamllaunch.common.printable import printable
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Process

#: What a machine has to tell; all else is the launcher's own affair, and
#: output goes another way.
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
    events.RosLost,
)
#: Returns the process or component with a label, None if there is none.
PartOf = Callable[[str], Process | Component | None]

_BY_NAME = {kind.__name__: kind for kind in FROM_MACHINES}
_KIND = 'event'
# those that JSON keeps exactly, whoever reads it
_LARGEST = 1 << 53
# no time in a launch comes near to that, and it can be shown
_LONGEST = 1e12
_SIGNALS = frozenset(('signal', 'next_signal'))
_LEVELS = frozenset(('DEBUG', 'INFO', 'WARNING', 'ERROR', 'CRITICAL'))


class EventError(Exception):
    """An object is no event of a machine; the text says why."""


def event_to_json(event: events.Event) -> dict[str, Any] | None:
    """Return an event as an object for JSON, None if it is not to be told."""
    kind = type(event).__name__
    if type(event) not in FROM_MACHINES:
        return None
    fields = {name: _encoded(getattr(event, name)) for name in _types(kind)}
    return {_KIND: kind, **fields}


def event_from_json(data: object, part_of: PartOf) -> events.Event:
    """
    Return the event that an object stands for.

    :param part_of: Tells what the labels of that machine stand for
    :raises EventError: when it is none
    """
    if not isinstance(data, Mapping):
        raise EventError('an event is no object')
    name = data.get(_KIND)
    if not isinstance(name, str) or name not in _BY_NAME:
        raise EventError('an event is of no known kind')
    wanted = _types(name)
    given = {key: value for key, value in data.items() if key != _KIND}
    if not _required(name) <= given.keys() <= wanted.keys():
        raise EventError(f'the event {name} has other fields')
    values = {}
    for key, value in given.items():
        try:
            values[key] = _decoded(value, wanted[key], part_of)
            _check(key, values[key])
        except (TypeError, ValueError, OverflowError) as error:
            raise EventError(
                f"'{key}' of the event {name} is not what it should be"
            ) from error
    kind: Any = _BY_NAME[name]
    event: events.Event = kind(**values)
    return event


@cache
def _types(event: str) -> dict[str, Any]:
    """Return the types of the fields of an event, by their names."""
    kind: Any = _BY_NAME[event]
    hints = typing.get_type_hints(kind)
    return {
        field.name: hints[field.name] for field in dataclasses.fields(kind)
    }


@cache
def _required(event: str) -> frozenset[str]:
    kind: Any = _BY_NAME[event]
    return frozenset(
        field.name
        for field in dataclasses.fields(kind)
        if field.default is dataclasses.MISSING
    )


def _encoded(value: Any) -> Any:
    match value:
        case Process() | Component():
            return value.label
        case Outcome():
            return [value.code, value.signal, value.core_dumped]
        case tuple():
            return [_encoded(one) for one in value]
        # signals have names in Python, and are numbers
        case int() if not isinstance(value, bool):
            return int(value)
        case _:
            return value


def _decoded(value: Any, wanted: Any, part_of: PartOf) -> Any:
    """
    Return a value of a type.

    :raises TypeError: when it is of another one
    :raises ValueError: when it is out of bounds
    """
    origin = typing.get_origin(wanted)
    arguments = typing.get_args(wanted)
    if origin in (types.UnionType, typing.Union):
        if value is None:
            return _only(None, types.NoneType in arguments)
        kinds = [a for a in arguments if a is not types.NoneType]
        if set(kinds) <= {Process, Component}:
            return _part(value, tuple(kinds), part_of)
        (kind,) = kinds
        return _decoded(value, kind, part_of)
    if origin is tuple:
        whole = _only(value, isinstance(value, list))
        return tuple(_decoded(v, arguments[0], part_of) for v in whole)
    if origin is typing.Literal:
        return _only(value, isinstance(value, str) and value in arguments)
    if wanted in (Process, Component):
        return _part(value, (wanted,), part_of)
    if wanted is Outcome:
        return _outcome(value)
    if wanted is float:
        is_number = type(value) in (int, float) and math.isfinite(value)
        return float(_only(value, is_number and abs(value) < _LONGEST))
    if wanted is int:
        return _only(value, type(value) is int and abs(value) <= _LARGEST)
    if wanted is str:
        return printable(_only(value, isinstance(value, str)))
    return _only(value, type(value) is wanted)


def _only(value: Any, is_right: bool) -> Any:
    if not is_right:
        raise TypeError
    return value


def _part(
    label: Any, kinds: tuple[type, ...], part_of: PartOf
) -> Process | Component:
    part = part_of(_only(label, isinstance(label, str)))
    if part is None or not isinstance(part, kinds):
        raise ValueError
    return part


def _outcome(value: Any) -> Outcome:
    code, number, core_dumped = _only(value, isinstance(value, list))
    _only(core_dumped, isinstance(core_dumped, bool))
    if number is None:
        return Outcome(_only(code, type(code) is int and 0 <= code <= 255))
    _check('signal', _only(number, type(number) is int and code is None))
    return Outcome(None, number, core_dumped)


def _check(key: str, value: Any) -> None:
    """
    Refuse what has the right type and no meaning.

    :raises ValueError: when that is so
    """
    if key in _SIGNALS and value is not None:
        is_right = 0 < value < signal.NSIG
    elif key == 'level':
        is_right = value in _LEVELS
    else:
        is_right = True
    if not is_right:
        raise ValueError
