# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a client receives of a launch: its events, its output, and gaps."""

from collections.abc import Mapping
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.protocol import ProtocolError


@dataclass(frozen=True, slots=True)
class Point:
    """
    A point in the journal of a launch.

    :param events: How many events there were before
    :param bytes: How many bytes of output there were before
    """

    events: int = 0
    bytes: int = 0

    @classmethod
    def from_json(cls, data: object) -> 'Point':
        """
        Return a point that the protocol has.

        :raises ProtocolError: when it is none
        """
        match data:
            case {'events': int(events), 'bytes': int(size)}:
                return cls(events, size)
        raise ProtocolError('the answer has no point')

    def as_json(self) -> dict[str, int]:
        """Return it as the protocol has it."""
        return {'events': self.events, 'bytes': self.bytes}

    def after(self, received: 'Received') -> 'Point':
        """Return the point after what was received at this one."""
        match received:
            case ReceivedEvent():
                return Point(self.events + 1, self.bytes)
            case ReceivedOutput():
                # output of other processes may have been passed over
                return Point(self.events, received.at + len(received.data))
            case LostData():
                return Point(
                    self.events + received.events, self.bytes + received.bytes
                )


#: The beginning of any launch.
BEGINNING = Point()


@dataclass(frozen=True, slots=True)
class ReceivedEvent:
    """
    An event.

    :param name: Its name in `events.jsonl`
    :param fields: All its fields in `events.jsonl`, `time` and `event` too
    """

    name: str
    fields: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class ReceivedOutput:
    """
    Output of a process.

    :param process: Its label
    :param stream: `stdout` or `stderr`
    :param data: Whole lines, unless it is in the middle of one for long, or
      the line is very long
    :param time: When, in seconds since the epoch
    :param at: How many bytes of output there were before
    """

    process: str
    stream: str
    data: bytes
    time: float
    at: int = 0


@dataclass(frozen=True, slots=True)
class LostData:
    """
    A gap: events or output that are lost.

    They were too long ago, or the client was too slow.

    :param events: How many events
    :param bytes: How many bytes of output
    """

    events: int
    bytes: int


#: What a client receives.
Received = ReceivedEvent | ReceivedOutput | LostData


def received(message: Mapping[str, Any]) -> Received | None:
    """
    Return what a message has for a client; None for other messages.

    :raises ProtocolError: when its output is malformed
    """
    match message:
        case {'event': {'event': str(name)} as fields}:
            return ReceivedEvent(name, fields)
        case {
            'output': {
                'process': str(process),
                'stream': str(stream),
                'data': str() | bytes() as data,
                'time': float(time),
                'at': int(before),
            }
        }:
            if isinstance(data, str):
                data = protocol.bytes_of(data)
            return ReceivedOutput(process, stream, data, time, before)
        case {'missed': {'events': int(events), 'bytes': int(size)}}:
            return LostData(events, size)
    return None
