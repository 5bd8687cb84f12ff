# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Waiting for descriptors, however high their numbers are."""

from collections.abc import Iterable
import select
from typing import Protocol
from typing import TypeVar


class HasDescriptor(Protocol):
    """A file, a socket or the like."""

    def fileno(self) -> int:
        """Return the descriptor."""


T = TypeVar('T', bound=int | HasDescriptor)


def readable(files: Iterable[T], seconds: float | None = None) -> list[T]:
    """
    Wait until there is something to read, and return where.

    The end of a file counts. `select` refuses descriptors from 1024 on, and a
    shell may hand on that many (select(2), FD_SETSIZE).

    :param seconds: How long to wait at most, None for ever
    """
    poll = select.poll()
    by_descriptor = {}
    for file in files:
        number = file if isinstance(file, int) else file.fileno()
        by_descriptor[number] = file
        poll.register(number, select.POLLIN)
    found = poll.poll(None if seconds is None else seconds * 1000)
    return [by_descriptor[number] for number, _ in found]
