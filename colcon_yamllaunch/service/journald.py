# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Sends output to the journal of systemd, with an identifier for each process.

The protocol is systemd's "Native Journal Protocol"; the fields are those of
`systemd.journal-fields(7)`.
"""

from collections import deque
from collections.abc import Mapping
import errno
import socket
import struct

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.lines import colourless
from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.observers.log_levels import Level, level_of

#: Where the journal receives messages.
SOCKET = '/run/systemd/journal/socket'
#: Bytes of a message; longer lines are split (as `LineMax=` in journald.conf).
LONGEST = 48 * 1024
#: Bytes that may wait for the journal before processes wait, too.
PENDING_BYTES = 1 << 20
#: Seconds that the last messages may take.
FINISH_TIMEOUT = 2.0

_INFO = 6
# the priorities of syslog(3)
_PRIORITIES: Mapping[Level, int] = {
    Level.DEBUG: 7,
    Level.INFO: _INFO,
    Level.WARN: 4,
    Level.ERROR: 3,
    Level.FATAL: 2,
}


class JournalOutput(Participant):
    """
    Sends the output of processes and the lines of the launcher.

    A process waits while the journal is slow, as it does for a slow screen.

    :raises OSError: when there is no journal at `path`
    """

    _engine: Engine

    def __init__(self, path: str) -> None:
        self._socket = socket.socket(
            socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK
        )
        try:
            self._socket.connect(path)
        except OSError:
            self._socket.close()
            raise
        self._pending: deque[bytes] = deque()
        self._size = 0

    def join(self, engine: Engine) -> None:
        """Send the output of this launch."""
        self._engine = engine

    def handle(self, event: events.Event) -> None:
        """Send the lines of an event."""
        level = Level.__members__.get(event.severity)
        priority = _INFO if level is None else _PRIORITIES[level]
        for line in event.lines():
            self._add(event.label, priority, line.encode(errors='replace'))

    def handle_output(self, event: events.Output) -> None:
        """Send what a process wrote."""
        label = event.process.label
        process = self._engine.state.process(label)
        pid = None if process is None else process.pid
        for line in colourless(event.data).split(b'\n'):
            level = level_of(line)
            priority = _INFO if level is None else _PRIORITIES[level]
            for start in range(0, len(line), LONGEST):
                part = line[start : start + LONGEST]
                self._add(label, priority, part, pid)

    def accepts(self, label: str) -> bool:  # noqa: ARG002
        """Return whether more may be written."""
        return self._size < PENDING_BYTES

    def end_turn(self) -> None:
        """Send what was collected in this turn."""
        self._send()
        loop, descriptor = self._engine.loop, self._socket.fileno()
        if self._pending:
            loop.add_writer(descriptor, self._send)
        else:
            loop.remove_writer(descriptor)

    def finish(self) -> None:
        """Send the rest."""
        self._socket.settimeout(FINISH_TIMEOUT)
        self._send()
        self._socket.close()

    def _add(
        self, label: str, priority: int, text: bytes, pid: int | None = None
    ) -> None:
        message = b''.join(
            (
                _field('MESSAGE', text),
                _field('PRIORITY', b'%d' % priority),
                _field('SYSLOG_IDENTIFIER', label.encode(errors='replace')),
                b'' if pid is None else _field('SYSLOG_PID', b'%d' % pid),
            )
        )
        self._pending.append(message)
        self._size += len(message)

    def _send(self) -> None:
        while self._pending:
            try:
                self._socket.send(self._pending[0])
            except OSError as error:
                if error.errno in (errno.EAGAIN, errno.ENOBUFS):
                    return
                # without a journal there is nobody to tell
            self._size -= len(self._pending.popleft())


def _field(name: str, value: bytes) -> bytes:
    if b'\n' in value:
        size = struct.pack('<Q', len(value))
        return b'%b\n%b%b\n' % (name.encode(), size, value)
    return b'%b=%b\n' % (name.encode(), value)
