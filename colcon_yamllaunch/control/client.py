# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running launches, as other terminals see them."""

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
import os
import socket
from typing import Any, cast, TYPE_CHECKING

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.protocol import MessageReader, ProtocolError
from colcon_yamllaunch.control.socket_folder import connections, peer_pid
from colcon_yamllaunch.control.subscription import (
    Point,
    Received,
    received,
    ReceivedEvent,
)
from colcon_yamllaunch.engine.events import (
    ChangeReported,
    Event,
    StateReceived,
)
from colcon_yamllaunch.engine.loop import do_nothing, readable
from colcon_yamllaunch.engine.state import from_json, LaunchState, StateError

if TYPE_CHECKING:
    # completion sends none
    from colcon_yamllaunch.engine.commands import Command, Refused, Response

#: Takes the answer to a request.
Reply = Callable[[Mapping[str, Any]], object]

#: Seconds that a launch may take to answer; a suspended one does not answer.
ANSWER_TIMEOUT = 3.0
#: The same where a suspended launch must not hold up another one.
SHORT_TIMEOUT = 0.2
#: Seconds of waiting after which a line says what is waited for.
PROGRESS_INTERVAL = 1.0
_CHUNK = 64 * 1024


class ControlError(Exception):
    """A launch does not do what it was asked; the text says why."""


class LaunchEndedError(ControlError):
    """The launch ended meanwhile."""

    def __init__(self) -> None:
        super().__init__('the launch has ended')


class RunningLaunch:
    """
    A launch of another process, by its control socket; see `Engine`.

    Without :meth:`subscribe`, its state is that of the last :meth:`status`.
    After it, :meth:`events` returns events and calls replies. A caller that
    also waits for other things uses :meth:`read` and :meth:`received` instead.
    """

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self._reader = MessageReader()
        self._received: deque[dict[str, Any]] = deque()
        self._state: LaunchState | None = None
        self._replies: dict[int, Reply] = {}
        self._number = 0
        self._is_subscribed = False
        #: The point where the launch had the state that `subscribe` returned.
        self.now = Point()
        #: The point up to which everything was received; another connection
        #: can go on from there.
        self.point = Point()
        connection.settimeout(ANSWER_TIMEOUT)

    def fileno(self) -> int:
        """Return the descriptor of the connection."""
        return self.connection.fileno()

    @property
    def pid(self) -> int:
        """The process id of the launcher."""
        return peer_pid(self.connection)

    @property
    def state(self) -> LaunchState:
        """
        Its state as far as it was received; the first time, it is asked for.

        :raises ControlError: when it does not answer
        """
        return self._state or self.refresh()

    def close(self) -> None:
        """Close the connection; the launch runs on."""
        self.connection.close()

    # -- commands and other requests

    def ask(
        self,
        command: 'Command[Response]',
        reply: 'Callable[[Response | Refused], object]' = do_nothing,
    ) -> None:
        """
        Send a command.

        :param reply: Is called with the response when it is received
        :raises ControlError: when the launch does not take it
        """

        def answered(answer: Mapping[str, Any]) -> None:
            reply(_response(command, answer))

        self.send_request(command.name, answered, **_fields(command))

    def do(
        self,
        command: 'Command[Response]',
        waiting: Callable[[], None] | None = None,
    ) -> 'Response':
        """
        Send a command, and wait for the response.

        :param waiting: See :meth:`request`
        :raises ControlError: when it is refused, or not answered
        """
        answer = self.request(
            command.name, waiting=waiting, **_fields(command)
        )
        return cast('Response', _response(command, answer))

    def send_request(self, name: str, reply: Reply, **more: Any) -> None:
        """
        Send a request; see `protocol`.

        :param reply: Is called with the answer when it is received
        :raises ControlError: when the launch does not take it
        """
        self._number += 1
        self._replies[self._number] = reply
        self.send(protocol.request(name, id=self._number, **more))

    def request(
        self,
        name: str,
        *,
        waiting: Callable[[], None] | None = None,
        **more: Any,
    ) -> dict[str, Any]:
        """
        Send a request, and wait for the answer; see `protocol`.

        :param waiting: For what may take any time: is called when the answer
          does not come at once
        :raises ControlError: when it is refused, or not answered
        """
        self.send(protocol.request(name, **more))
        if waiting is not None and not readable(
            [self.fileno()], PROGRESS_INTERVAL
        ):
            waiting()
            readable([self.fileno()])
        answer = self.receive()
        if not answer.get('ok'):
            raise ControlError(str(answer.get('error')))
        return answer

    def refresh(self) -> LaunchState:
        """
        Request its state, and return it.

        :raises ControlError: when it does not answer
        """
        return self._set_state(self.request('status'))

    # -- events

    def subscribe(
        self,
        since: Point | None = None,
        *,
        states: bool = False,
        **more: Any,
    ) -> None:
        """
        Receive events and output from now on; see `protocol`.

        :param since: The point to begin at, as far as that is remembered;
          None for now
        :param states: Whether to keep the state up to date
        :param more: Further fields of the request
        :raises ControlError: when it is refused
        """
        point = None if since is None else since.as_json()
        answer = self.request(
            'subscribe', since=point, states=states, raw=True, **more
        )
        self._set_state(answer)
        with self._errors():
            self.now = Point.from_json(answer.get('now'))
        self.point = self.now if since is None else since
        self._is_subscribed = True

    def events(
        self, since: Point | None = None, **more: Any
    ) -> Iterator[Received]:
        """
        Iterate over events and output, from a point on; wait for them.

        The state is up to date with each of them.

        :param since: See :meth:`subscribe`; after that, None goes on
        :param more: Fields of the request
        :raises ControlError: at the end, `LaunchEndedError`
        """
        if not self._is_subscribed or since is not None or more:
            self.subscribe(since, states=True, **more)
        while True:
            yield from self.received()
            readable([self.fileno()])
            self.read()

    def received(self) -> Iterator[Received]:
        """
        Iterate over events and output that were read; call replies.

        :raises ControlError: when a message is malformed
        """
        while (message := self.next_message()) is not None:
            match message:
                case {'state': data}:
                    self._apply(StateReceived(data))
                case {'id': int(number), 'ok': _}:
                    self._replies.pop(number, do_nothing)(message)
            with self._errors():
                one = received(message)
            if one is None:
                continue
            self.point = self.point.after(one)
            if isinstance(one, ReceivedEvent) and one.name == 'watched':
                self._apply(_watched(one.fields))
            yield one

    def read(self) -> None:
        """
        Read what was sent, and wait for something.

        :raises ControlError: when nothing comes
        """
        with self._errors():
            data = self.connection.recv(_CHUNK)
            self._received += self._reader.feed(data)
        if not data:
            raise LaunchEndedError

    def wait_for_end(self, pid: int) -> None:
        """Wait until the launch ended, its launcher included."""
        self.connection.settimeout(None)
        try:
            while True:
                self.read()
        except LaunchEndedError:
            wait_for_exit(pid)

    # -- messages

    def send(self, message: Mapping[str, Any]) -> None:
        """
        Send a message.

        :raises ControlError: when the launch does not take it
        """
        with self._errors():
            self.connection.sendall(protocol.encode(message))

    def receive(self) -> dict[str, Any]:
        """
        Return the next message, and wait for it.

        :raises ControlError: when there is none
        """
        while (message := self.next_message()) is None:
            self.read()
        return message

    def next_message(self) -> dict[str, Any] | None:
        """
        Return the next message if it has been read in whole.

        Output that follows its message is its `data`.
        """
        return self._received.popleft() if self._received else None

    def _set_state(self, answer: Mapping[str, Any]) -> LaunchState:
        with self._errors():
            self._state = from_json(answer.get('launch'))
        return self.state

    def _apply(self, event: Event) -> None:
        with self._errors():
            self.state.apply(event)

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """Raise errors of the connection and of messages as ControlError."""
        try:
            yield
        except TimeoutError as error:
            raise ControlError(
                f'the launch with pid {self.pid} does not answer; it may be '
                'suspended'
            ) from error
        except OSError as error:
            raise LaunchEndedError from error
        except (ProtocolError, StateError) as error:
            raise ControlError(str(error)) from error


def running_launches(
    environment: Mapping[str, str], warn: Callable[[str], None]
) -> list[RunningLaunch]:
    """
    Return all running launches of the user.

    What a launch left that was killed is removed.

    :param warn: Is called with a problem, such as a folder that others may
      enter
    """
    return [RunningLaunch(c) for c in connections(environment, warn)]


def answering_launches(
    environment: Mapping[str, str],
) -> Iterator[LaunchState]:
    """Iterate over the states of running launches that answer at once."""
    for launch in running_launches(environment, do_nothing):
        launch.connection.settimeout(SHORT_TIMEOUT)
        try:
            yield launch.refresh()
        except ControlError:
            continue
        finally:
            launch.close()


def find_launch(
    pid: int, environment: Mapping[str, str]
) -> RunningLaunch | None:
    """Return the launch with the launcher `pid`, None if there is none."""
    found = None
    for launch in running_launches(environment, do_nothing):
        if found is None and launch.pid == pid:
            found = launch
        else:
            launch.close()
    return found


def wait_for_exit(pid: int) -> None:
    """Wait until a process ended, for some seconds at most."""
    try:
        descriptor = os.pidfd_open(pid)
    except OSError:
        # it is gone, or the system has no such descriptors
        return
    try:
        readable([descriptor], ANSWER_TIMEOUT)
    finally:
        os.close(descriptor)


def _fields(command: 'Command[Any]') -> dict[str, Any]:
    from colcon_yamllaunch.control.command_codec import fields_of

    return fields_of(command)


def _response(command: 'Command[Any]', answer: Mapping[str, Any]) -> Any:
    from colcon_yamllaunch.control.command_codec import response_of

    return response_of(command, answer)


def _watched(fields: Mapping[str, Any]) -> ChangeReported:
    """Return an event about a change from its line in `events.jsonl`."""
    return ChangeReported(
        str(fields.get('text')),
        failed=bool(fields.get('failed')),
        details='\n'.join(map(str, fields.get('errors', ())[1:])),
        is_final=bool(fields.get('final', True)),
    )
