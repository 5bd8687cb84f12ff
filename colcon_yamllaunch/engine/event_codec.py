# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Reads events from the records that `Event.to_json` makes.

A record comes from a launch on another machine, which is not trusted: it
becomes an event of a known kind with fields of the right types, or is refused.
"""

from collections.abc import Callable
import signal
from typing import Any

from colcon_yamllaunch.common.codec import Codec, CodecError, only, read_float
from colcon_yamllaunch.common.printable import printable
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.outcome import Outcome, signal_name
from colcon_yamllaunch.plan.plan import Component, Member, Process

#: The events of a part on a machine besides `Ended`, by the names of their
#: records. All others are those of the launcher itself, and output is sent in
#: another way.
FROM_MACHINES: dict[str, type[events.Event]] = {
    'planned': events.Planned,
    'dropped': events.Dropped,
    'started': events.Started,
    'start_failed': events.StartFailed,
    'exited': events.Exited,
    'held': events.Suspended,
    'continued': events.Suspended,
    'silent': events.Silent,
    'waiting': events.Waiting,
    'ready': events.Ready,
    'not_ready': events.NotReady,
    'not_started': events.NotStarted,
    'restart_limit': events.RestartLimit,
    'respawned': events.Respawned,
    'signalled': events.Signalled,
    'requested': events.Requested,
    'shutdown': events.ShuttingDown,
    'still_running': events.StillRunning,
    'left_behind': events.LeftBehind,
    'message': events.MessageShown,
    'warning': events.Warned,
    'loaded': events.Loaded,
    'load_failed': events.LoadFailed,
    'unloaded': events.Unloaded,
    'state_changed': events.StateChanged,
    'transition_failed': events.TransitionFailed,
    'member_changed': events.MemberChanged,
    'ros_lost': events.RosLost,
    'idle': events.IdleChanged,
    'cannot_run': events.CannotRun,
}
#: Returns the process or component with a label, None if there is none.
MemberOf = Callable[[str], Member | None]

# JSON keeps smaller numbers exactly, whoever reads it
_LARGEST = 1 << 53
_LARGEST_CODE = 255
# no time in a launch comes near to that, and it can be shown
_LONGEST = 1e12
_LEVELS = frozenset(('DEBUG', 'INFO', 'WARNING', 'ERROR', 'CRITICAL'))
_SIGNALS = {signal_name(number): number for number in range(1, signal.NSIG)}


class EventError(Exception):
    """A record is no event of a machine; the text says why."""


class EventReader:
    """
    Reads the events of one machine.

    :param member_of: Returns what a label of that machine stands for
    """

    def __init__(self, member_of: MemberOf) -> None:
        self._codec = Codec(
            special={
                **{
                    kinds: (None, _member_reader(member_of, kinds))
                    for kinds in (Process, Component, Member)
                },
                Outcome: (None, _read_outcome),
                str: (None, lambda data: printable(only(str, data))),
                int: (None, _read_int),
                float: (None, _read_float),
            },
            accept_unknown=True,
        )

    def read(self, record: object) -> events.Event:
        """
        Return the event of a record.

        :raises EventError: when it is none
        """
        name = record.get('event') if isinstance(record, dict) else None
        if isinstance(record, dict) and name == 'ended':
            return _read_end(record)
        if not isinstance(name, str) or name not in FROM_MACHINES:
            raise EventError('an event is of no known kind')
        assert isinstance(record, dict)
        try:
            event = self._codec.from_json(
                FROM_MACHINES[name], _fields(name, record)
            )
        except CodecError as error:
            field = error.path.lstrip('.')
            problem = f"'{field}' of the event {name} is not what it should be"
            if not field:
                problem = f'the event {name} {error.problem}'
            raise EventError(problem) from error
        if (
            isinstance(event, events.MessageShown)
            and event.level not in _LEVELS
        ):
            raise EventError(f'the event {name} has an unknown level')
        return event


def _read_end(record: dict[str, Any]) -> events.Ended:
    code = record.get('exit_code')
    if type(code) is not int or not 0 <= code <= _LARGEST_CODE:
        raise EventError('the event ended has no exit code')
    return events.Ended(code)


def _fields(name: str, record: dict[str, Any]) -> dict[str, Any]:
    """
    Return the fields of an event as the codec reads them.

    :raises CodecError: when a signal has no known name
    """
    numbers = {
        key: _signal_number(key, record[key])
        for key in ('signal', 'next_signal')
        if record.get(key) is not None
    }
    fields = {**record, **numbers}
    if 'label' in record:
        fields |= dict.fromkeys(events.MEMBER_FIELDS, record['label'])
    if name == 'planned':
        fields['members'] = record.get('labels')
    if name == 'exited':
        fields['outcome'] = [
            fields.get(key)
            for key in ('exit_code', 'signal', 'core_dumped', 'limit')
        ]
    return fields


def _signal_number(key: str, name: Any) -> int:
    if not isinstance(name, str) or name not in _SIGNALS:
        raise CodecError('is no signal', key)
    return _SIGNALS[name]


def _member_reader(member_of: MemberOf, kinds: Any) -> Callable[[Any], Member]:
    def read(label: Any) -> Member:
        member = member_of(only(str, label))
        if member is None or not isinstance(member, kinds):
            raise CodecError('is the label of nothing there')
        return member

    return read


def _read_outcome(data: Any) -> Outcome:
    *how, limit = data
    # a machine with an earlier version says nothing of it
    text = printable(only(str, limit or ''))
    match how:
        case [int(code), None, False] if type(code) is int and (
            0 <= code <= _LARGEST_CODE
        ):
            return Outcome(code, limit=text)
        case [None, int(number), bool(core_dumped)]:
            return Outcome(None, number, core_dumped, limit=text)
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
