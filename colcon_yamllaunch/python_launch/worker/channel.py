# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The lines between the launcher and this program."""

from __future__ import annotations

from collections.abc import Callable
import contextlib
import fcntl
import io
from itertools import count
from json import dumps, loads
import os
import queue
import signal
import threading
import time
from typing import Any

Json = dict[str, Any]

READ_SIZE = 1 << 16
#: Seconds in which a line may follow another without being written.
LONGEST_DELAY = 0.02
#: The first descriptor for the lines: launch files that make themselves
#: daemons close or write to low ones.
DESCRIPTOR = 200


def log_output(descriptor: int) -> io.TextIOWrapper:
    """Return a text stream to a log; each line is written when it is made."""
    return io.TextIOWrapper(
        io.BufferedWriter(_Log(descriptor, 'w', closefd=False)),
        errors='backslashreplace',
        line_buffering=True,
    )


class _Log(io.FileIO):
    """A log that ignores write errors, such as a full disk."""

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except OSError:
            return len(data)


class Channel:
    """
    Reads lines in a thread of its own, and writes lines.

    The descriptors 0 and 1 are nothing and standard error from then on, for
    whatever launch files read, print and start. When there is no more to
    read, this program ends with all that it started, whatever it does then.
    A process that a launch file forks has no channel: it ends where it would
    answer.
    """

    def __init__(self) -> None:
        #: Does a request that comes while an answer is waited for.
        self.serve: Callable[[Json], object] = bool
        #: Returns what the main thread is doing, as frames.
        self.where: Callable[[], object] = list
        #: Is called before this program ends.
        self.at_end: Callable[[], object] = bool
        self._input = _moved(0)
        self._output = _moved(1)
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)
        self._asks = count(1)
        self._unwritten = b''
        self._written_at = 0.0
        self._writing = threading.Lock()
        self._lines: queue.SimpleQueue[Json] = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()
        os.register_at_fork(after_in_child=self._leave)

    def say(self, what: str, **fields: object) -> None:
        """
        Write a line; end where nobody reads.

        What closely follows another line is written with the next one, or
        before this program waits: each write may wake the launcher.
        """
        if self._output == -1:
            os._exit(0)
        line = (dumps({'say': what, **fields}) + '\n').encode()
        now = time.monotonic()
        with self._writing:
            self._unwritten += line
            if (
                now - self._written_at > LONGEST_DELAY
                or threading.current_thread() is not threading.main_thread()
            ):
                self._written_at = now
                self._write()

    def _write(self) -> None:
        data, self._unwritten = self._unwritten, b''
        try:
            while data:
                data = data[os.write(self._output, data) :]
        except OSError:
            self._end()

    def receive(self) -> Json:
        """Wait for a line."""
        with self._writing:
            self._write()
        line = self._lines.get()
        self._written_at = 0.0
        return line

    def ask(self, what: str, **fields: object) -> Json:
        """Write a line and wait for its answer, doing requests meanwhile."""
        number = next(self._asks)
        self.say(what, ask=number, **fields)
        while True:
            line = self.receive()
            if line.get('answer') == number:
                return line
            self.serve(line)

    def _read(self) -> None:
        rest = b''
        while True:
            try:
                data = os.read(self._input, READ_SIZE)
            except OSError:
                data = b''
            if not data:
                self._end()
            *lines, rest = (rest + data).split(b'\n')
            for line in lines:
                request = loads(line)
                if request.get('do') == 'where':
                    # now, whatever else is being done
                    self.say('where', frames=self.where())
                else:
                    self._lines.put(request)

    def _leave(self) -> None:
        """Close the channel in a forked child."""
        for descriptor in (self._input, self._output):
            with contextlib.suppress(OSError):
                os.close(descriptor)
        self._input = self._output = -1

    def _end(self) -> None:
        try:
            self.at_end()
        finally:
            for process in _started():
                with contextlib.suppress(OSError):
                    os.kill(process, signal.SIGKILL)
            os._exit(0)


def _moved(descriptor: int) -> int:
    try:
        return fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, DESCRIPTOR)
    except OSError:
        # so many are not allowed
        return os.dup(descriptor)


def _started() -> list[int]:
    """Return the processes that this one, or one of those, has started."""
    children: dict[int, list[int]] = {}
    group = []
    for name in os.listdir('/proc'):
        if name.isdigit():
            try:
                with open(f'/proc/{name}/stat', 'rb') as file:
                    fields = file.read().rpartition(b')')[2].split()
            except OSError:
                continue
            children.setdefault(int(fields[1]), []).append(int(name))
            if int(fields[2]) == os.getpid():
                # whoever started it may have ended
                group.append(int(name))
    pending = [os.getpid()]
    found = set(group)
    while pending:
        inner = children.get(pending.pop(), [])
        found.update(inner)
        pending += inner
    return sorted(found - {os.getpid()})
