# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The descriptors that the engine's loop waits for."""

from collections.abc import Callable
import select

from colcon_yamllaunch.engine import limits

#: Is called with what a descriptor is ready for, as :mod:`select` names it.
Handler = Callable[[int], None]


class Watches:
    """
    Descriptors with their handlers.

    A handler must not wait for anything. It may be called for nothing, as a
    descriptor's number may have changed hands in the same turn.
    """

    def __init__(self) -> None:
        self._poll = select.epoll()
        self._handlers: dict[int, Handler] = {}
        self._masks: dict[int, int] = {}

    def add(
        self, descriptor: int, handler: Handler, mask: int = select.EPOLLIN
    ) -> None:
        """
        Have a handler called whenever a descriptor is ready.

        :raises PermissionError: when it is an ordinary file
        """
        self._poll.register(descriptor, mask)
        self._handlers[descriptor] = handler
        self._masks[descriptor] = mask

    def change(self, descriptor: int, mask: int) -> None:
        """Wait for something else from now on, if it is watched at all."""
        if self._masks.get(descriptor, mask) != mask:
            self._poll.modify(descriptor, mask)
            self._masks[descriptor] = mask

    def remove(self, descriptor: int) -> None:
        """Watch a descriptor no more; before it is closed."""
        if self._handlers.pop(descriptor, None) is not None:
            del self._masks[descriptor]
            self._poll.unregister(descriptor)

    def wait(self, seconds: float | None) -> bool:
        """
        Call the handlers of the descriptors that are ready.

        Return whether there is any.

        :param seconds: How long to wait for one, but for a day at most; None
          is for ever
        """
        if seconds is not None:
            seconds = min(seconds, limits.LONGEST_WAIT)
        ready = self._poll.poll(seconds)
        for descriptor, mask in ready:
            handler = self._handlers.get(descriptor)
            if handler is not None:
                handler(mask)
        return bool(ready)

    def close(self) -> None:
        """Watch nothing any more."""
        self._poll.close()
