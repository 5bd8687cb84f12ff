# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What processes write whose launcher is gone, on its way to the logs.

Nobody else reads their pipes: without this a process that says what it does
while it stops would die of that, or wait for ever.

This module is part of the guard and imports little.
"""

from collections.abc import Iterable
from contextlib import suppress
import math
import os
import select
import time

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.output.lines import LineBuffer
from colcon_yamllaunch.engine.output.lines import normalised
from colcon_yamllaunch.engine.output.lines import prefixed

_FLAGS = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW
# as the launcher's own lines have it
_TAG = 'launch'


@dataclass(frozen=True, slots=True)
class HeldOutput:
    """
    What a process writes, not to be read as long as the launcher does.

    :param descriptor: The end to read from
    :param number: The number of the process
    :param files: The logs that have each byte
    :param common: The log that has the lines, with time and label
    """

    descriptor: int
    number: int
    label: str
    files: tuple[str, ...]
    common: str | None


class OrphanedOutput:
    """
    The outputs of a launch.

    Logs that cannot be written are done without. They do not rotate, and get
    a fixed number of bytes at most, as the end of a launch is short.
    """

    def __init__(self, outputs: Iterable[HeldOutput]) -> None:
        self._outputs = {o.descriptor: o for o in outputs}
        self._lines = {d: LineBuffer() for d in self._outputs}
        self._commons = {o.common for o in self._outputs.values()} - {None}
        self._files: dict[str, int | None] = {}
        self._left = limits.GUARD_LOG
        self._poll = select.poll()
        for descriptor in self._outputs:
            os.set_blocking(descriptor, False)
            self._poll.register(descriptor, select.POLLIN)

    def pass_on(self, seconds: float) -> None:
        """Pass on what is written for some time."""
        deadline = time.monotonic() + seconds
        left = seconds
        while left > 0:
            # what no process writes to any more is not polled
            for descriptor, _ in self._poll.poll(math.ceil(left * 1000)):
                self._read(descriptor)
            left = deadline - time.monotonic()

    def finish(self) -> None:
        """Pass on what is left."""
        for descriptor in tuple(self._outputs):
            # what is there, and no more: somebody may write for ever
            rounds = limits.LARGE_PIPE // limits.READ_SIZE + 1
            while rounds and self._read(descriptor):
                rounds -= 1
            if descriptor in self._outputs:
                self._close(descriptor)

    def say(self, text: str) -> None:
        """Have a line of our own where the lines of all processes go."""
        for common in self._commons:
            self._append(str(common), _stamped(_TAG, f'{text}\n'.encode()))

    def _read(self, descriptor: int) -> bool:
        """Read once, and return whether there may be more."""
        try:
            data = os.read(descriptor, limits.READ_SIZE)
        except BlockingIOError:
            return False
        except OSError:
            # a terminal that nobody has open any more
            data = b''
        if not data:
            self._close(descriptor)
            return False
        output = self._outputs[descriptor]
        for file in output.files:
            self._append(file, data)
        self._append_lines(output, self._lines[descriptor].feed(data))
        return True

    def _close(self, descriptor: int) -> None:
        self._poll.unregister(descriptor)
        lines = self._lines.pop(descriptor)
        self._append_lines(self._outputs.pop(descriptor), lines.flush())
        os.close(descriptor)

    def _append_lines(self, output: HeldOutput, lines: bytes) -> None:
        if lines and output.common is not None:
            self._append(output.common, _stamped(output.label, lines))

    def _append(self, path: str, data: bytes) -> None:
        if path not in self._files:
            self._files[path] = _open(path)
        descriptor = self._files[path]
        if descriptor is not None and len(data) <= self._left:
            self._left -= len(data)
            # whatever does not fit on the disk is lost
            with suppress(OSError):
                os.write(descriptor, data)


def _stamped(label: str, lines: bytes) -> bytes:
    prefix = f'{time.time():.6f} [{label}] '.encode(errors='replace')
    return prefixed(normalised(lines), prefix)


def _open(path: str) -> int | None:
    with suppress(OSError):
        os.mkdir(os.path.dirname(path))
    try:
        return os.open(path, _FLAGS, 0o644)
    except OSError:
        return None
