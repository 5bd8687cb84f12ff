# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Serving the control socket from the engine's loop."""

from collections.abc import Mapping
from contextlib import ExitStack
from contextlib import suppress
import errno
import os
import socket
from typing import TYPE_CHECKING

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.launch_record import LaunchRecord
from colcon_yamllaunch.control.service import Service
from colcon_yamllaunch.control.socket_address import Address
from colcon_yamllaunch.control.socket_address import is_own
from colcon_yamllaunch.control.socket_folder import FolderError
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.events import Ended
from colcon_yamllaunch.engine.events import Event
from colcon_yamllaunch.engine.events import Planned
from colcon_yamllaunch.engine.events import Warned
from colcon_yamllaunch.engine.guard_link import GuardLink
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.plan.plan import Process

if TYPE_CHECKING:
    from colcon_yamllaunch.control.client_connection import Client


def serve(
    engine: Engine,
    service: Service,
    environment: Mapping[str, str],
    guard: GuardLink,
    record: LaunchRecord,
    stack: ExitStack,
) -> None:
    """
    Let other terminals of the user look at a launch.

    Where that cannot be, it is said, and the launch goes on.

    :param guard: Removes the socket of a launch that is killed
    :param record: Tells of one whose guard was killed, too
    """
    # before anybody can see the launch
    supervisor = engine.supervisor
    place = record.begin(environment, engine.state, supervisor.tasks)
    stack.callback(record.end)

    def note(event: Event) -> None:
        if isinstance(event, Planned):
            labels = {p.label for p in event.parts if isinstance(p, Process)}
            # others run on another machine
            tasks = [t for t in supervisor.tasks if t.process.label in labels]
            record.note(engine.state, tasks)

    engine.listen(note)
    if place is not None:
        guard.record(place)
    try:
        address = Address(environment)
    except FolderError as error:
        engine.tell(
            Warned(
                f'other terminals cannot see this launch: {error}; '
                '`colcon launch --status` will not list it'
            )
        )
        return
    for trouble in address.troubles:
        engine.tell(Warned(f'{trouble}; the socket is in {address.path}'))
    guard.socket(address.place)
    listen(engine, service)
    server = Server(address.socket, engine.loop, service)
    engine.listen(server.handle)
    stack.callback(address.close)
    stack.callback(server.close)


def listen(engine: Engine, service: Service) -> None:
    """Have a service listen to all events of a launch."""
    engine.listen(service.handle)
    engine.listen(service.journal.handle)


class Server:
    """
    Accepts clients.

    :param listener: The socket that they connect to
    """

    def __init__(
        self, listener: socket.socket, loop: Loop, service: Service
    ) -> None:
        self._listener = listener
        self._loop = loop
        #: Whether a client has connected.
        self.was_used = False
        self._service = service
        self._clients: list[Client] = []
        # given up for a moment to turn a client away when no other is left
        self._spare = _null()
        loop.add_reader(listener.fileno(), self._accept)

    @property
    def is_left(self) -> bool:
        """Whether all clients have left that have connected."""
        return self.was_used and not self._clients

    def handle(self, event: Event) -> None:
        """Listen to an event, when all others have."""
        if isinstance(event, Ended):
            for client in list(self._clients):
                client.drain()
            # so that the latest events find room before output
            self._service.journal.drop_output()
            for client in list(self._clients):
                client.end()

    def close(self) -> None:
        """
        Accept no more clients, and disconnect them.

        Those that have subscribed stay until they have received the end.
        """
        self._loop.remove_reader(self._listener.fileno())
        for client in list(self._clients):
            if not client.has_subscribed:
                client.close()
        os.close(self._spare)

    def _accept(self) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError as error:
            if error.errno in (errno.EMFILE, errno.ENFILE):
                self._turn_away()
            return
        if not is_own(connection):
            connection.close()
            return
        # most launches are not looked at
        from colcon_yamllaunch.control.client_connection import Client

        self.was_used = True
        connection.setblocking(False)
        if len(self._clients) >= protocol.MAXIMUM_CLIENTS:
            self._make_room()
        self._clients.append(
            Client(connection, self._loop, self._service, self._clients.remove)
        )

    def _make_room(self) -> None:
        waiting = [
            c for c in self._clients if not (c.is_attached or c.has_subscribed)
        ]
        (waiting or self._clients)[0].close()

    def _turn_away(self) -> None:
        """Take a client and send it away, as it would wait for ever."""
        os.close(self._spare)
        with suppress(OSError):
            connection, _ = self._listener.accept()
            connection.close()
        self._spare = _null()


def _null() -> int:
    return os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
