# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Serving the control socket from the engine's loop."""

from collections.abc import Mapping
from contextlib import ExitStack
from contextlib import suppress
import errno
import os

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.client_connection import Client
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
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.stopping.guard_link import GuardLink
from colcon_yamllaunch.plan.plan import Process


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
    engine.listen(service.handle)
    engine.listen(service.journal.handle)
    server = Server(address, engine.loop, service)
    engine.listen(server.handle)
    stack.callback(server.close)


class Server:
    """Takes clients as they come."""

    def __init__(self, address: Address, loop: Loop, service: Service) -> None:
        self._address = address
        self._loop = loop
        self._service = service
        self._clients: list[Client] = []
        # given up for a moment to turn a client away when no other is left
        self._spare = _null()
        loop.add_reader(address.socket.fileno(), self._accept)

    def handle(self, event: Event) -> None:
        """Listen to an event, when all others have."""
        if isinstance(event, Ended):
            for client in list(self._clients):
                client.drain()
            # so that what was told last finds room before what was written
            self._service.journal.drop_output()
            for client in list(self._clients):
                client.end()

    def close(self) -> None:
        """
        Remove the socket, and send all clients away.

        Only those that have subscribed stay until they are told the end.
        """
        self._loop.remove_reader(self._address.socket.fileno())
        for client in list(self._clients):
            if not client.has_subscribed:
                client.close()
        self._address.close()
        os.close(self._spare)

    def _accept(self) -> None:
        try:
            connection, _ = self._address.socket.accept()
        except OSError as error:
            if error.errno in (errno.EMFILE, errno.ENFILE):
                self._turn_away()
            return
        if not is_own(connection):
            connection.close()
            return
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
            connection, _ = self._address.socket.accept()
            connection.close()
        self._spare = _null()


def _null() -> int:
    return os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
