# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running launches, as other terminals see them."""

from collections import deque
from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Mapping
import os
import socket
from typing import Any

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.messages import MessageReader
from colcon_yamllaunch.control.protocol import launch_of
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.control.socket_address import connections
from colcon_yamllaunch.control.socket_address import peer_pid
from colcon_yamllaunch.control.subscription import Point
from colcon_yamllaunch.control.subscription import Subscription
from colcon_yamllaunch.engine.output.readiness import readable
from colcon_yamllaunch.engine.state import LaunchState

#: Seconds that a launch may take to answer; one that is suspended,
#: does not answer.
PATIENCE = 3.0
#: Seconds after which it is said what is waited for.
PROGRESS_INTERVAL = 1.0
_CHUNK = 64 * 1024


class ControlError(Exception):
    """A launch does not do what it was asked; the text says why."""


class LaunchEndedError(ControlError):
    """The launch ended meanwhile."""

    def __init__(self) -> None:
        super().__init__('the launch has ended')


class RunningLaunch:
    """A launch that another terminal runs."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self._reader = MessageReader()
        self._received: deque[dict[str, Any]] = deque()
        connection.settimeout(PATIENCE)

    def fileno(self) -> int:
        """Return the descriptor of the connection."""
        return self.connection.fileno()

    @property
    def pid(self) -> int:
        """The process id of the launcher."""
        return peer_pid(self.connection)

    def close(self) -> None:
        """Leave it alone."""
        self.connection.close()

    def status(self) -> LaunchState:
        """
        Return its state.

        :raises ControlError: when it does not answer
        """
        answer = self.request('status')
        try:
            return launch_of(answer)
        except ProtocolError as error:
            raise ControlError(str(error)) from error

    def request(
        self,
        name: str,
        *,
        waiting: Callable[[], None] | None = None,
        **more: Any,
    ) -> dict[str, Any]:
        """
        Have something done, and return the answer; see `protocol`.

        :param waiting: For what may take any time: is called when the answer
          does not come at once
        :raises ControlError: when it refuses, or does not answer
        """
        self.send(protocol.request(name, **more))
        if waiting is not None:
            self._wait(waiting)
        answer = self.receive()
        if not answer.get('ok'):
            raise ControlError(str(answer.get('error')))
        return answer

    def subscribe(
        self,
        since: Point | None = None,
        *,
        events: bool = True,
        output: bool = True,
        processes: Collection[str] | None = None,
        behind: int | None = None,
        holder: str | None = None,
        lease: float | None = None,
    ) -> Subscription:
        """
        Be told what happens from now on.

        The connection is the subscription's then.

        :param since: Where to begin, as far as that is remembered, if not now
        :param events: Whether to be told events
        :param output: Whether to be told what the processes write
        :param processes: The labels of those; None for all
        :param behind: How many bytes of their output we may be behind before
          we miss some, None for as many as the launch allows
        :param holder: The token of the holder, whose subscription goes on by
          another connection without missing anything; see `protocol`
        :param lease: Seconds of its silence after which the launch is stopped
        :raises ControlError: when that is refused
        """
        point = None if since is None else since.as_json()
        answer = self.request(
            'subscribe',
            since=point,
            events=events,
            output=output,
            processes=None if processes is None else list(processes),
            behind=behind,
            raw=True,
            holder=holder,
            lease=lease,
        )
        try:
            return Subscription(self, since, answer)
        except ProtocolError as error:
            raise ControlError(str(error)) from error

    def send(self, message: Mapping[str, Any]) -> None:
        """
        Send a message.

        :raises ControlError: when it does not take it
        """
        try:
            self.connection.sendall(protocol.encode(message))
        except TimeoutError as error:
            raise ControlError(_no_answer(self.connection)) from error
        except OSError as error:
            raise LaunchEndedError from error

    def receive(self) -> dict[str, Any]:
        """
        Return the next message, and wait for it.

        :raises ControlError: when there is none
        """
        while (message := self.received()) is None:
            self.read()
        return message

    def received(self) -> dict[str, Any] | None:
        """
        Return the next message if it has been read in whole.

        Output that follows its message is its `data`.
        """
        return self._received.popleft() if self._received else None

    def read(self) -> None:
        """
        Read what has been sent, and wait for something.

        :raises ControlError: when nothing comes
        """
        try:
            data = self.connection.recv(_CHUNK)
        except TimeoutError as error:
            raise ControlError(_no_answer(self.connection)) from error
        except OSError as error:
            raise LaunchEndedError from error
        if not data:
            raise LaunchEndedError
        try:
            self._received += self._reader.feed(data)
        except ProtocolError as error:
            raise ControlError(str(error)) from error

    def _wait(self, waiting: Callable[[], None]) -> None:
        """Wait for an answer, however long it takes."""
        connections = [self.connection]
        if not readable(connections, PROGRESS_INTERVAL):
            waiting()
            readable(connections)

    def wait_for_end(self, pid: int) -> None:
        """Wait until the launch ended, its launcher included."""
        self.connection.settimeout(None)
        try:
            while True:
                self.read()
        except LaunchEndedError:
            wait_for_exit(pid)


def running_launches(
    environment: Mapping[str, str], warn: Callable[[str], None]
) -> list[RunningLaunch]:
    """
    Return all running launches of the user.

    What a launch left that was killed is removed.

    :param warn: Is told of a folder that others may enter
    """
    return [RunningLaunch(c) for c in connections(environment, warn)]


def wait_for_exit(pid: int) -> None:
    """Wait until a process ended, for some seconds at most."""
    try:
        descriptor = os.pidfd_open(pid)
    except OSError:
        # it is gone, or the system has no such descriptors
        return
    try:
        readable([descriptor], PATIENCE)
    finally:
        os.close(descriptor)


def _no_answer(connection: socket.socket) -> str:
    pid = peer_pid(connection)
    return f'the launch with pid {pid} does not answer; it may be suspended'
