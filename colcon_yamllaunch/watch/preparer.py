# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The preparer: a process that prepares the launch again, each time in a child.

The launcher forks the preparer before it starts any process, and the preparer
loads the modules of a build in advance. Each job runs in a new child of the
preparer, so it starts with all modules loaded and with no state of earlier
jobs: its answer is what a launch that begins now would be. A cancelled job is
interrupted as Ctrl-C interrupts a build.

For each job the launcher sends one byte with three descriptors: a file with
the request, in which the child leaves its answer; a socket for messages; and
a file for the output of the child. Messages are pickled: :class:`Begun`,
:class:`Announced`, and at the end None. When the launcher ends, so do the
preparer and its job.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import field
import gc
import io
import os
import pickle
import signal
import socket
import sys
import time
from typing import Any, Literal, NamedTuple, NoReturn

from colcon_yamllaunch.common.files import catch_up, put_off
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.loop import has_ended, Loop, readable
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.watch.dependencies import Dependencies, Products

_START = b's'
_CANCEL = b'c'
_READ_SIZE = 1024 * 1024
_CANCELLING = (signal.SIGINT, signal.SIGTERM)
#: Seconds until a cancelled job gets SIGTERM after SIGINT, and then SIGKILL.
_GRACE = 3.0
#: Seconds until a preparer that should end is killed.
_CLOSE_TIMEOUT = 8.0


@dataclass(frozen=True, slots=True)
class Begun:
    """A job has begun; `pid` leads its process group."""

    pid: int


@dataclass(frozen=True, slots=True)
class Announced:
    """A line that the user should see while a job runs."""

    text: str


@dataclass(frozen=True, slots=True)
class Prepared:
    """
    A launch as it would begin now.

    :param environment: The environment of its processes
    :param built: The products of its builds
    :param packages: The packages that the job has built
    :param since_ns: When the job began (nanoseconds since the epoch)
    :param grown_from: The files that the plan was made from, with their
      hashes, if event handlers may extend it while it runs
    :param deployment: Identifies the deployment; empty without one
    :param machines: The machines that parts of it run on
    :param broken: The errors of Python files that do not compile, by path
    """

    plan: Plan
    environment: Mapping[str, str]
    dependencies: Dependencies
    built: Products
    packages: tuple[str, ...]
    since_ns: int
    grown_from: Mapping[str, str] | None = None
    deployment: str = ''
    machines: frozenset[str] = frozenset()
    broken: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Failed:
    """
    A launch would not begin now; the output of the job says why.

    :param what: What failed: the build, the evaluation of the launch file, or
      the job itself, as it was killed
    :param packages: The packages that were built nevertheless
    """

    what: Literal['build', 'plan', 'job']
    packages: tuple[str, ...] = ()


#: Reports a line of progress.
Announce = Callable[[str], None]
#: Does a job: gets the request and returns the answer.
Prepare = Callable[[Any, Announce], object]


class Preparer:
    """
    A preparer, and the job that it does, as the launcher sees them.

    Create it before any process and any thread is started, as the preparer is
    a fork of this process.

    :param prepare: Does a job, in a child of the preparer
    :param warm_up: Loads what jobs need, in the preparer
    :param clean_up: Ends what a killed job left running; gets the process ID
      of its child
    :raises OSError: when no process can be started
    """

    def __init__(
        self,
        prepare: Prepare,
        warm_up: Callable[[], None],
        clean_up: Callable[[int], None],
    ) -> None:
        self._connection, its_end = socket.socketpair(
            socket.AF_UNIX, socket.SOCK_SEQPACKET
        )
        # otherwise the garbage collector writes to shared memory pages, which
        # copies them
        gc.freeze()
        #: Its process ID, or 0 once it has ended.
        self.pid = os.fork()
        if not self.pid:
            self._connection.close()
            _become_preparer(its_end, prepare, warm_up, clean_up)
        its_end.close()
        self._loop: Loop
        self._handle: Callable[[object], None]
        self._messages: socket.socket | None = None
        self._answer = self._output = -1

    def begin(self, loop: Loop, handle: Callable[[object], None]) -> None:
        """
        Use the event loop of the launch from now on.

        :param handle: Is called with what a job reports: :class:`Begun`,
          :class:`Announced`, then its answer or :class:`Failed`
        """
        self._loop = loop
        self._handle = handle

    def ask(self, request: object) -> None:
        """
        Start a job; one that is still running is cancelled.

        :raises OSError: when the preparer has ended
        """
        self.forget()
        self._messages, its_messages = socket.socketpair(
            socket.AF_UNIX, socket.SOCK_SEQPACKET
        )
        self._output = os.memfd_create('output')
        self._answer = os.memfd_create('job')
        self._messages.setblocking(False)
        descriptor = self._messages.fileno()
        self._loop.add_reader(descriptor, self._read_messages)
        with its_messages:
            try:
                with open(self._answer, 'wb', closefd=False) as file:
                    pickle.dump(request, file, pickle.HIGHEST_PROTOCOL)
                given = (self._answer, its_messages.fileno(), self._output)
                socket.send_fds(self._connection, [_START], given)
            except OSError:
                self.forget()
                raise

    @property
    def written(self) -> bytes:
        """What the job has written so far."""
        if self._messages is None:
            return b''
        return os.pread(self._output, os.fstat(self._output).st_size, 0)

    def cancel(self) -> None:
        """Cancel the job that is running, if any."""
        if self._messages is not None:
            self.forget()
            with suppress(OSError):
                self._connection.send(_CANCEL)

    def forget(self) -> None:
        """Ignore the rest of the job, which is done or not wanted."""
        if self._messages is not None:
            self._loop.remove_reader(self._messages.fileno())
            self._messages.close()
            os.close(self._output)
            os.close(self._answer)
        self._messages = None

    def ended(self) -> None:
        """Note that the preparer has ended."""
        self.forget()
        self.pid = 0
        self._connection.close()

    def close(self) -> None:
        """End the preparer with its job, and wait for that."""
        if not self.pid:
            return
        pid = self.pid
        self.ended()
        # a stopped preparer would leave its job running
        os.kill(pid, signal.SIGCONT)
        deadline = time.monotonic() + _CLOSE_TIMEOUT
        while not has_ended(pid):
            if time.monotonic() > deadline:
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)
                break
            time.sleep(0.002)

    def _read_messages(self) -> None:
        while self._messages is not None:
            try:
                data = self._messages.recv(_READ_SIZE)
            except BlockingIOError:
                return
            except OSError:
                data = b''
            message = pickle.loads(data) if data else Failed('job')
            if message is None:
                os.lseek(self._answer, 0, os.SEEK_SET)
                with open(self._answer, 'rb', closefd=False) as file:
                    message = pickle.load(file)
            self._handle(message)
            if not isinstance(message, Begun | Announced):
                return


def _become_preparer(
    connection: socket.socket,
    prepare: Prepare,
    warm_up: Callable[[], None],
    clean_up: Callable[[int], None],
) -> NoReturn:
    try:
        # Ctrl-C is for the launcher
        os.setpgid(0, 0)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        for number in (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
            signal.signal(number, signal.SIG_DFL)
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        os.close(null)
        warm_up()
        _serve(connection, prepare, clean_up)
    finally:
        os._exit(0)


class _Child(NamedTuple):
    """A child that does one job; `end` can be read once it has ended."""

    pid: int
    end: int

    def reap(self) -> None:
        os.close(self.end)
        os.waitpid(self.pid, 0)


def _serve(
    connection: socket.socket,
    prepare: Prepare,
    clean_up: Callable[[int], None],
) -> None:
    """Do what the launcher asks for until it ends."""
    child: _Child | None = None
    data = _CANCEL
    while data:
        ends = [] if child is None else [child.end]
        ready = readable([connection.fileno(), *ends])
        if child is not None and child.end in ready:
            child.reap()
            child = None
        if connection.fileno() not in ready:
            continue
        try:
            data, descriptors, _, _ = socket.recv_fds(connection, 1, 3)
        except OSError:
            data, descriptors = b'', []
        if child is not None:
            _cancel(child)
            clean_up(child.pid)
            child = None
        if data == _START:
            # signals to the child wait until it has installed its handlers
            signal.pthread_sigmask(signal.SIG_BLOCK, _CANCELLING)
            pid = os.fork()
            if not pid:
                connection.close()
                _do(prepare, descriptors)
            signal.pthread_sigmask(signal.SIG_UNBLOCK, _CANCELLING)
            with suppress(OSError):
                # parent and child both do this, whichever runs first
                os.setpgid(pid, pid)
            child = _Child(pid, os.pidfd_open(pid))
        for descriptor in descriptors:
            os.close(descriptor)


def _cancel(child: _Child) -> None:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        # it is not reaped yet, so no other process has its number
        with suppress(OSError):
            os.killpg(child.pid, number)
        if readable([child.end], _GRACE):
            break
    with suppress(OSError):
        os.killpg(child.pid, signal.SIGKILL)
    child.reap()


def _do(prepare: Prepare, descriptors: Sequence[int]) -> NoReturn:
    """Do a job, in a child that ends with it."""
    try:
        os.setpgid(0, 0)
        for number in _CANCELLING:
            signal.signal(number, signal.default_int_handler)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, _CANCELLING)
        # the child ends soon, and its answer need not wait for the disks
        gc.disable()
        put_off()
        try:
            _answer(prepare, *descriptors)
        finally:
            catch_up()
    finally:
        os._exit(0)


def _answer(
    prepare: Prepare, request: int, messages: int, output: int
) -> None:
    for stream in (1, 2):
        os.dup2(output, stream)
    os.close(output)
    if isinstance(sys.stdout, io.TextIOWrapper):
        # so that output and errors keep their order
        sys.stdout.reconfigure(line_buffering=True)
    link = socket.socket(fileno=messages)

    def send(message: Begun | Announced | None) -> None:
        link.send(pickle.dumps(message))

    send(Begun(os.getpid()))
    os.lseek(request, 0, os.SEEK_SET)
    with open(request, 'r+b') as file:
        asked = pickle.load(file)
        answer = prepare(asked, lambda text: send(Announced(text)))
        file.seek(0)
        pickle.dump(answer, file, pickle.HIGHEST_PROTOCOL)
    sys.stdout.flush()
    sys.stderr.flush()
    send(None)
