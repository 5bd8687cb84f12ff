# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The process that prepares a launch anew, each time in a child of its own.

It is forked from the launcher before anything runs, and loads in advance what
a build takes. Each job is done by a child of it, which so has all loaded and
knows nothing of the jobs before: what comes of it is what a launch that
begins now would come to. A job that nobody wants any more is interrupted as a
build is by Ctrl-C.

The launcher sends one byte for each message, and with a job three
descriptors: a file with what is asked, where the answer goes, and what the
child has as its output. They go to a child that waits for them, as a fork
takes time. The launcher is told the process id of the child, which leads a
group of its own. When the launcher is gone, the job ends, and so does the
worker with the child that waits.
"""

from collections.abc import Callable
from collections.abc import Sequence
from contextlib import suppress
import gc
import io
import os
import pickle
import signal
import socket
import struct
import sys
from typing import Any
from typing import NamedTuple
from typing import NoReturn

from colcon_yamllaunch.common.file_sync import catch_up
from colcon_yamllaunch.common.file_sync import put_off
from colcon_yamllaunch.engine.output.readiness import readable

#: Asks for a job, and ends the one that is under way.
DO = b'd'
CANCEL = b'c'
#: How the process id of a child is told.
PID = struct.Struct('=q')
#: How long a message of a job is: that stands in front of each.
LENGTH = struct.Struct('=q')
#: How long a job has to end by SIGINT, and then by SIGTERM (seconds).
GRACE = 3.0

#: Tells something while a job is done.
Tell = Callable[[object], None]
#: Does a job: gets what is asked, and returns the answer.
Prepare = Callable[[Any, Tell], object]


def serve(
    connection: socket.socket,
    prepare: Prepare,
    clean_up: Callable[[int], None],
) -> None:
    """
    Do what the launcher asks for until it is gone.

    :param prepare: Does a job, in a child
    :param clean_up: Ends what a job that was killed left running; gets the
      process id of its child
    """
    worker = _Worker(connection, prepare, clean_up)
    while worker.turn():
        pass
    worker.close()


def frame(message: object) -> bytes:
    """Return a message of a job as it is sent."""
    data = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
    return LENGTH.pack(len(data)) + data


class _Child(NamedTuple):
    """
    A child that does one job.

    :param link: Where it gets that; can be read when it has ended
    """

    pid: int
    link: socket.socket

    def reap(self) -> None:
        self.link.close()
        os.waitpid(self.pid, 0)


class _Worker:
    def __init__(
        self,
        connection: socket.socket,
        prepare: Prepare,
        clean_up: Callable[[int], None],
    ) -> None:
        self._connection = connection
        self._prepare = prepare
        self._clean_up = clean_up
        self._busy: _Child | None = None
        # who does the next job; a fork takes some milliseconds
        self._next: _Child | None = None

    def turn(self) -> bool:
        """Wait for something and do it; return whether to go on."""
        if self._next is None:
            self._next = self._forked()
        sockets = [self._connection]
        if self._busy is not None:
            sockets.append(self._busy.link)
        ready = readable(sockets)
        if self._busy is not None and self._busy.link in ready:
            self._busy.reap()
            self._busy = None
        if self._connection not in ready:
            return True
        try:
            data, descriptors, _, _ = socket.recv_fds(self._connection, 1, 3)
        except OSError:
            data, descriptors = b'', []
        self._end()
        if data == DO:
            self._begin(self._next, descriptors)
        for descriptor in descriptors:
            # no other child may have them
            os.close(descriptor)
        return bool(data)

    def close(self) -> None:
        """End the child that waits for a job."""
        if self._next is not None:
            self._next.reap()

    def _forked(self) -> _Child:
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        pid = os.fork()
        if not pid:
            ours.close()
            self._connection.close()
            if self._busy is not None:
                self._busy.link.close()
            _do(self._prepare, its)
        its.close()
        with suppress(OSError):
            # it does that, too; whoever is first
            os.setpgid(pid, pid)
        return _Child(pid, ours)

    def _begin(self, child: _Child, descriptors: Sequence[int]) -> None:
        self._busy, self._next = child, None
        with suppress(OSError):
            # one that was killed is found to have ended
            socket.send_fds(child.link, [DO], descriptors)
        with suppress(OSError):
            self._connection.send(PID.pack(child.pid))

    def _end(self) -> None:
        """End the job that is under way, if there is one."""
        if self._busy is None:
            return
        pid, link = self._busy
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            # it is not reaped yet, so the group is no other's
            with suppress(OSError):
                os.killpg(pid, number)
            if readable([link], GRACE):
                break
        with suppress(OSError):
            os.killpg(pid, signal.SIGKILL)
        self._busy.reap()
        self._busy = None
        self._clean_up(pid)


def _do(prepare: Prepare, link: socket.socket) -> NoReturn:
    """Wait for a job and do it, in a child which ends with it."""
    try:
        os.setpgid(0, 0)
        # it ends soon, and nobody is to wait for the disks
        gc.disable()
        put_off()
        _, descriptors, _, _ = socket.recv_fds(link, 1, 3)
        if descriptors:
            try:
                _do_now(prepare, *descriptors)
            finally:
                catch_up()
    finally:
        os._exit(0)
    raise AssertionError


def _do_now(prepare: Prepare, request: int, answer: int, output: int) -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    for stream in (1, 2):
        os.dup2(output, stream)
    os.close(output)
    if isinstance(sys.stdout, io.TextIOWrapper):
        # so that errors stand where they belong
        sys.stdout.reconfigure(line_buffering=True)
    with os.fdopen(request, 'rb') as file:
        asked = pickle.load(file)
    told = socket.socket(fileno=answer)

    def tell(message: object) -> None:
        told.sendall(frame(message))

    prepared = prepare(asked, tell)
    # who has the answer has all output
    sys.stdout.flush()
    sys.stderr.flush()
    tell(prepared)
