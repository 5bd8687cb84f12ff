# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What happens in a launch that another terminal runs, as it happens."""

from collections.abc import Iterator
from collections.abc import Mapping
from typing import Any
from typing import Protocol

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.protocol import launch_of
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.engine.output.readiness import readable
from colcon_yamllaunch.engine.state import LaunchState


@dataclass(frozen=True, slots=True)
class Point:
    """
    A moment in the course of a launch.

    :param events: How many events there have been before
    :param bytes: How many bytes of output there have been before
    """

    events: int = 0
    bytes: int = 0

    def as_json(self) -> dict[str, int]:
        """Return it as the protocol has it."""
        return {'events': self.events, 'bytes': self.bytes}


#: The beginning of any launch.
BEGINNING = Point()


@dataclass(frozen=True, slots=True)
class Happened:
    """
    An event.

    :param name: Its name in `events.jsonl`
    :param fields: All that `events.jsonl` has of it, `time` and `event` too
    """

    name: str
    fields: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Wrote:
    """
    A process wrote something.

    :param process: Its label
    :param stream: `stdout` or `stderr`
    :param data: Whole lines, unless it is in the middle of one for long, or
      the line is very long
    :param time: When, in seconds since the epoch
    """

    process: str
    stream: str
    data: bytes
    time: float


@dataclass(frozen=True, slots=True)
class Missed:
    """
    Something is lost, as it is too long ago, or we were too slow.

    :param events: How many events
    :param bytes: How many bytes of output
    """

    events: int
    bytes: int


@dataclass(frozen=True, slots=True)
class Answered:
    """
    The answer to a request of ours.

    :param number: The number that :meth:`Subscription.ask` returned
    :param error: Why it was refused, None where it was not
    :param answer: All of it
    """

    number: int
    error: str | None
    answer: Mapping[str, Any]


#: What a subscription brings.
News = Happened | Wrote | Missed | Answered


class Connection(Protocol):
    """What a subscription needs of `client.RunningLaunch`."""

    def fileno(self) -> int:
        """Return its descriptor."""

    def send(self, message: Mapping[str, Any]) -> None:
        """Send a message."""

    def received(self) -> dict[str, Any] | None:
        """Return the next message if it has been read in whole."""

    def read(self) -> None:
        """Read what has been sent, and wait for something."""

    def close(self) -> None:
        """Leave it alone."""


class Subscription:
    """
    News of a launch.

    Whoever waits for other things, too, waits until it is readable, and then
    calls :meth:`read` and takes the :meth:`news`; whoever does not, iterates
    over it. Both end with `client.LaunchEndedError`.

    :param since: What was asked for
    :param answer: The answer to `subscribe`
    :raises ProtocolError: when the answer makes no sense
    """

    def __init__(
        self,
        connection: Connection,
        since: Point | None,
        answer: Mapping[str, Any],
    ) -> None:
        self._connection = connection
        self._number = 0
        #: The launch as it was when it answered.
        self.state: LaunchState = launch_of(answer)
        #: The moment of that. What comes first may have happened before.
        self.now = _point(answer.get('now'))
        #: The moment that the news have come to; with another connection, it
        #: goes on from there.
        self.point = self.now if since is None else since

    def fileno(self) -> int:
        """Return the descriptor that is readable when there are news."""
        return self._connection.fileno()

    def close(self) -> None:
        """Want no more of it."""
        self._connection.close()

    def ask(self, name: str, **more: Any) -> int:
        """
        Have something done; see `protocol`.

        Return the number that its `Answered` will have.

        :raises ControlError: when it does not take the request
        """
        self._number += 1
        self._connection.send(protocol.request(name, id=self._number, **more))
        return self._number

    def read(self) -> None:
        """
        Read what has been sent.

        :raises ControlError: when nothing comes
        """
        self._connection.read()

    def news(self) -> Iterator[News]:
        """
        Iterate over what has been read.

        :raises ControlError: when it makes no sense
        """
        while (message := self._connection.received()) is not None:
            one = self._understood(message)
            if one is not None:
                yield one

    def __iter__(self) -> Iterator[News]:
        while True:
            yield from self.news()
            readable([self])
            self.read()

    def _understood(self, message: Mapping[str, Any]) -> News | None:
        """Return a message as news, None for one of a later version."""
        match message:
            case {'event': {'event': str(name)} as fields}:
                self._pass(events=1)
                return Happened(name, fields)
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
                # it may have passed what we did not ask for
                self._pass(size=before + len(data) - self.point.bytes)
                return Wrote(process, stream, data, time)
            case {'missed': {'events': int(events), 'bytes': int(size)}}:
                self._pass(events, size)
                return Missed(events, size)
            case {'ok': ok, 'id': int(number)}:
                error = None if ok else str(message.get('error'))
                return Answered(number, error, message)
        return None

    def _pass(self, events: int = 0, size: int = 0) -> None:
        before = self.point
        self.point = Point(before.events + events, before.bytes + size)


def _point(data: object) -> Point:
    match data:
        case {'events': int(events), 'bytes': int(size)}:
            return Point(events, size)
    raise ProtocolError('the answer has no point')
