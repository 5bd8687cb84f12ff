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
child has as its output. It is told the process id of the child, which leads a
group of its own. When the launcher is gone, the job ends, and so does the
worker.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
import gc
import os
import pickle
import select
import signal
import socket
import struct
import sys
from typing import Any
from typing import Literal
from typing import NoReturn

from colcon_yamllaunch.common.file_sync import catch_up
from colcon_yamllaunch.common.file_sync import put_off
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.watch.knowledge import Knowledge

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


@dataclass(frozen=True, slots=True)
class Job:
    """
    The launch is to be prepared again, as one that begins now would be.

    :param built: What the builds were that the running processes have, see
      `build_effects`
    :param libraries: What is mapped into each process, by its label
    """

    built: Mapping[str, Any]
    libraries: Mapping[str, frozenset[str] | None]


@dataclass(frozen=True, slots=True)
class Announced:
    """A line that the user should see while a job is done."""

    text: str


@dataclass(frozen=True, slots=True)
class Prepared:
    """
    A launch as it would begin now.

    :param environment: That of its processes
    :param knowledge: What it uses
    :param built: What its builds are
    :param changed: What differs in the install space from what the running
      processes were started with
    :param packages: The packages that the job has built
    :param since_ns: When it began, by the clock of the files
    :param grown_from: The files that it was made from, with their contents,
      if it grows while it runs
    """

    plan: Plan
    environment: Mapping[str, str]
    knowledge: Knowledge
    built: Mapping[str, Any]
    changed: Mapping[str, str]
    packages: tuple[str, ...]
    since_ns: int
    grown_from: Mapping[str, str] | None = None


@dataclass(frozen=True, slots=True)
class Failed:
    """
    A launch would not begin now; the output of the job tells why.

    :param what: What failed: the build, or else what the launch file says, or
      the job itself, as it was killed
    :param packages: The packages that were built all the same
    """

    what: Literal['build', 'plan', 'job']
    packages: tuple[str, ...] = ()


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


def frame(message: object) -> bytes:
    """Return a message of a job as it is sent."""
    data = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
    return LENGTH.pack(len(data)) + data


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
        # the child, or 0 while there is none
        self._pid = 0
        # what can be read when it has ended
        self._end_of_it = -1

    def turn(self) -> bool:
        """Wait for something and do it; return whether to go on."""
        link = self._connection.fileno()
        waits_for = [link, self._end_of_it] if self._pid else [link]
        ready, _, _ = select.select(waits_for, (), ())
        if self._end_of_it in ready:
            self._reap()
        if link not in ready:
            return True
        try:
            data, descriptors, _, _ = socket.recv_fds(self._connection, 1, 3)
        except OSError:
            data, descriptors = b'', []
        self._end()
        if data == DO:
            self._begin(*descriptors)
        for descriptor in descriptors:
            os.close(descriptor)
        return bool(data)

    def _begin(self, request: int, answer: int, output: int) -> None:
        self._end_of_it, held = os.pipe()
        self._pid = os.fork()
        if not self._pid:
            os.close(self._end_of_it)
            self._connection.close()
            _do(self._prepare, request, answer, output)
        os.close(held)
        with suppress(OSError):
            # it does that, too; whoever is first
            os.setpgid(self._pid, self._pid)
        with suppress(OSError):
            self._connection.send(PID.pack(self._pid))

    def _end(self) -> None:
        """End the job that is under way, if there is one."""
        if not self._pid:
            return
        pid = self._pid
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            # it is not reaped yet, so the group is no other's
            with suppress(OSError):
                os.killpg(pid, number)
            if select.select([self._end_of_it], (), (), GRACE)[0]:
                break
        with suppress(OSError):
            os.killpg(pid, signal.SIGKILL)
        self._reap()
        self._clean_up(pid)

    def _reap(self) -> None:
        os.waitpid(self._pid, 0)
        os.close(self._end_of_it)
        self._pid, self._end_of_it = 0, -1


def _do(prepare: Prepare, request: int, answer: int, output: int) -> NoReturn:
    """Do a job in a child, which ends with it."""
    try:
        os.setpgid(0, 0)
        # it ends soon, and nobody is to wait for the disks
        gc.disable()
        put_off()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.default_int_handler)
        for stream in (1, 2):
            os.dup2(output, stream)
        os.close(output)
        with os.fdopen(request, 'rb') as file:
            asked = pickle.load(file)
        link = socket.socket(fileno=answer)

        def tell(message: object) -> None:
            link.sendall(frame(message))

        prepared = prepare(asked, tell)
        # who has the answer has all output
        sys.stdout.flush()
        sys.stderr.flush()
        tell(prepared)
    finally:
        try:
            catch_up()
        finally:
            os._exit(0)
    raise AssertionError
