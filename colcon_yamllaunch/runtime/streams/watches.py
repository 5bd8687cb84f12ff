# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Descriptors that the engine's loop watches for others."""

from collections.abc import Callable
import select

#: Is called with what a descriptor is ready for, as :mod:`select` names it.
Handler = Callable[[int], None]


class Watches:
    """
    Descriptors with their handlers.

    A handler must not wait for anything. It may be called for nothing, as a
    descriptor's number may have changed hands in the same turn.

    :param poll: Where the descriptors are registered
    """

    def __init__(self, poll: select.epoll) -> None:
        self._poll = poll
        self._handlers: dict[int, Handler] = {}

    def add(
        self, descriptor: int, handler: Handler, mask: int = select.EPOLLIN
    ) -> None:
        """
        Have a handler called whenever a descriptor is ready.

        :raises PermissionError: when it is an ordinary file
        """
        self._poll.register(descriptor, mask)
        self._handlers[descriptor] = handler

    def change(self, descriptor: int, mask: int) -> None:
        """Wait for something else from now on."""
        self._poll.modify(descriptor, mask)

    def remove(self, descriptor: int) -> None:
        """Watch a descriptor no more; before it is closed."""
        if self._handlers.pop(descriptor, None) is not None:
            self._poll.unregister(descriptor)

    def handle(self, descriptor: int, mask: int) -> None:
        """Call the handler of a descriptor, if it has one."""
        handler = self._handlers.get(descriptor)
        if handler is not None:
            handler(mask)
