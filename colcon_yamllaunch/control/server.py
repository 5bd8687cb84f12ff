# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The control socket of a launch, and the record beside it.

The record describes the launch in case that its launcher is killed.
"""

from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack, suppress
import errno
from functools import cached_property
import json
import os
import socket
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.control import protocol, socket_folder
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.events import Ended, Event, Planned, Warned
from colcon_yamllaunch.engine.guard_link import GuardLink
from colcon_yamllaunch.engine.own_files import OwnFile
from colcon_yamllaunch.engine.process_stop import ProcessTask
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.plan.plan import Process

if TYPE_CHECKING:
    from colcon_yamllaunch.control.client_connection import Client
    from colcon_yamllaunch.control.service import Service

#: The ending of a record's name.
RECORD_SUFFIX = '.json'

_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC
_LAUNCH = ('title', 'package', 'file', 'folder', 'log_folder')
_PROCESS = ('label', 'name', 'executable', 'node', 'package')


class LaunchRecord:
    """
    The record of a launch; where it cannot be written there is none.

    :param identity: The identity of the launch
    """

    def __init__(self, identity: str) -> None:
        self._content: dict[str, Any] = {'identity': identity}
        # as JSON by their number; there may be thousands, one after another
        self._processes: list[str] = []
        self._descriptor = -1
        self._folder = -1
        self._name = f'{os.getpid()}{RECORD_SUFFIX}'

    def begin(
        self, environment: Mapping[str, str], engine: Engine
    ) -> OwnFile | None:
        """
        Write the record, and return where it is.

        :param environment: The variables that say where it may be
        """
        self._content |= {n: getattr(engine.state, n) for n in _LAUNCH}
        self.note(engine.state, engine.supervisor.tasks)
        for folder in socket_folder.folders(environment):
            # the reason is reported with the missing socket
            with suppress(OSError, socket_folder.FolderError):
                self._folder = socket_folder.open_folder(folder, make=True)
                return self._make(os.path.abspath(folder / self._name))
        return None

    def note(self, launch: LaunchState, tasks: Iterable[ProcessTask]) -> None:
        """Write processes that are new in the launch, or changed."""
        for task in tasks:
            missing = task.number + 1 - len(self._processes)
            self._processes += ['{}'] * missing
            process = task.process
            state = launch.process(process.label)
            assert state is not None
            known = {n: getattr(state, n) for n in _PROCESS}
            known['log'] = launch.log_of(state)
            known['timeouts'] = (
                process.sigterm_timeout,
                process.sigkill_timeout,
            )
            self._processes[task.number] = json.dumps(known)
        self._write()

    def note_parameters(self, folder: OwnFile) -> None:
        """Add where the parameter files are."""
        self._content['parameters'] = [
            folder.path,
            folder.device,
            folder.inode,
        ]
        self._write()

    def end(self) -> None:
        """Remove the record."""
        if self._folder != -1:
            with suppress(OSError):
                os.unlink(self._name, dir_fd=self._folder)
            os.close(self._folder)
            self._folder = -1
        if self._descriptor != -1:
            os.close(self._descriptor)
            self._descriptor = -1

    def _make(self, path: str) -> OwnFile:
        try:
            # of an ended process with our process id
            with suppress(FileNotFoundError):
                os.unlink(self._name, dir_fd=self._folder)
            self._descriptor = os.open(
                self._name, _FLAGS, 0o600, dir_fd=self._folder
            )
            self._write()
            return OwnFile.of(path)
        except OSError:
            self.end()
            raise

    def _write(self) -> None:
        if self._descriptor == -1:
            return
        known = json.dumps(self._content)[:-1]
        text = f'{known}, "processes": [{", ".join(self._processes)}]}}'
        data = text.encode()
        # the launch goes on without it
        with suppress(OSError):
            os.pwrite(self._descriptor, data, 0)
            os.ftruncate(self._descriptor, len(data))


def serve(
    engine: Engine,
    journal: Journal,
    environment: Mapping[str, str],
    guard: GuardLink,
    record: LaunchRecord,
    stack: ExitStack,
) -> None:
    """
    Serve a launch to other terminals of the user.

    If that is not possible, it warns, and the launch goes on.

    :param guard: Removes the socket of a launch that is killed
    :param record: Describes one whose guard was killed, too
    """
    # before anybody can see the launch
    file = record.begin(environment, engine)
    stack.callback(record.end)

    def note(event: Event) -> None:
        if isinstance(event, Planned):
            labels = {p.label for p in event.members if isinstance(p, Process)}
            # others run on another machine
            tasks = engine.supervisor.tasks
            record.note(
                engine.state, [t for t in tasks if t.process.label in labels]
            )

    engine.listen(note)
    if file is not None:
        guard.remove_later('record', file)
    try:
        address = socket_folder.Address(environment)
    except socket_folder.FolderError as error:
        engine.emit(
            Warned(
                f'other terminals cannot see this launch: {error}; '
                '`colcon launch --status` will not list it'
            )
        )
        return
    for trouble in address.troubles:
        engine.emit(Warned(f'{trouble}; the socket is in {address.path}'))
    guard.remove_later('socket', address.file)
    server = Server(address.socket, engine, journal, guard.lease)
    engine.listen(server.handle)
    stack.callback(address.close)
    stack.callback(server.close)


class Server:
    """
    Accepts clients.

    :param listener: The socket that they connect to
    :param journal: Gets all events from now on
    :param lease: Stops the launch when it is not renewed
    """

    def __init__(
        self,
        listener: socket.socket,
        engine: Engine,
        journal: Journal,
        lease: Callable[[float | None], object],
    ) -> None:
        self._listener = listener
        self._engine = engine
        self._loop = engine.loop
        self._journal = journal
        self._lease = lease
        #: Whether a client has connected.
        self.was_used = False
        self._clients: list[Client] = []
        # given up for a moment to turn a client away when no other is left
        self._spare = _null()
        engine.listen(journal.handle)
        engine.loop.add_reader(listener.fileno(), self._accept)

    @cached_property
    def service(self) -> 'Service':
        """What answers clients; most launches have none."""
        from colcon_yamllaunch.control.service import Service

        service = Service(self._engine, self._journal, self._lease)
        self._engine.listen(service.handle)
        return service

    @property
    def was_left(self) -> bool:
        """Whether all clients have left that have connected."""
        return self.was_used and not self._clients

    def handle(self, event: Event) -> None:
        """Listen to an event, when all others have."""
        if isinstance(event, Ended):
            for client in list(self._clients):
                client.drain()
            # so that the latest events find room before output
            self._journal.drop_output()
            for client in list(self._clients):
                client.end()

    def close(self) -> None:
        """
        Accept no more clients, and disconnect them.

        Those that have subscribed stay until they have received the end.
        """
        self._loop.remove_reader(self._listener.fileno())
        for client in list(self._clients):
            if client.cursor is None:
                client.close()
        os.close(self._spare)

    def _accept(self) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError as error:
            if error.errno in (errno.EMFILE, errno.ENFILE):
                self._turn_away()
            return
        if not socket_folder.is_permitted(connection):
            connection.close()
            return
        # most launches are not looked at
        from colcon_yamllaunch.control.client_connection import Client

        self.was_used = True
        connection.setblocking(False)
        if len(self._clients) >= protocol.MAXIMUM_CLIENTS:
            self._make_room()
        self._clients.append(
            Client(connection, self._loop, self.service, self._clients.remove)
        )

    def _make_room(self) -> None:
        waiting = [
            c for c in self._clients if c.label is None and c.cursor is None
        ]
        (waiting or self._clients)[0].close()

    def _turn_away(self) -> None:
        """Close the connection of a client, as no descriptor is free."""
        os.close(self._spare)
        with suppress(OSError):
            connection, _ = self._listener.accept()
            connection.close()
        self._spare = _null()


def _null() -> int:
    return os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
