# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Serving the control socket from the engine's loop."""

import errno
import os

from colcon_yamllaunch.runtime.control import protocol
from colcon_yamllaunch.runtime.control.client_connection import Visitor
from colcon_yamllaunch.runtime.control.service import Service
from colcon_yamllaunch.runtime.control.socket_address import Address
from colcon_yamllaunch.runtime.control.socket_address import is_own
from colcon_yamllaunch.runtime.streams.watches import Watches


class Server:
    """
    Takes clients as they come.

    :param address: Where it listens
    :param watches: Where sockets are watched
    :param service: Answers requests
    """

    def __init__(
        self, address: Address, watches: Watches, service: Service
    ) -> None:
        self._address = address
        self._watches = watches
        self._service = service
        self._visitors: list[Visitor] = []
        # given up for a moment to turn a client away when no other is left
        self._spare = _null()
        watches.add(address.socket.fileno(), self._accept)

    def close(self) -> None:
        """Send all clients away, and remove the socket."""
        if self._spare == -1:
            return
        self._watches.remove(self._address.socket.fileno())
        for visitor in list(self._visitors):
            visitor.close()
        self._address.close()
        os.close(self._spare)
        self._spare = -1

    def _accept(self, mask: int) -> None:  # noqa: ARG002
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
        if len(self._visitors) >= protocol.MAXIMUM_CLIENTS:
            self._make_room()
        self._visitors.append(
            Visitor(
                connection, self._watches, self._service, self._visitors.remove
            )
        )

    def _make_room(self) -> None:
        waiting = [v for v in self._visitors if not v.is_attached]
        (waiting or self._visitors)[0].close()

    def _turn_away(self) -> None:
        """Take a client and send it away, as it would wait for ever."""
        os.close(self._spare)
        try:
            connection, _ = self._address.socket.accept()
            connection.close()
        except OSError:
            pass
        self._spare = _null()


def _null() -> int:
    return os.open(os.devnull, os.O_RDONLY | os.O_CLOEXEC)
