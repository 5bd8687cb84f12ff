# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launcher's side of the worker; see there."""

from collections.abc import Callable
from collections.abc import Iterator
from contextlib import suppress
import gc
import os
import pickle
import signal
import socket
import time
from typing import Any

from colcon_yamllaunch.engine.process.children import has_ended
from colcon_yamllaunch.watch.worker import CANCEL
from colcon_yamllaunch.watch.worker import DO
from colcon_yamllaunch.watch.worker import LENGTH
from colcon_yamllaunch.watch.worker import PID
from colcon_yamllaunch.watch.worker import Prepare
from colcon_yamllaunch.watch.worker import serve

#: Bytes that are read at once.
_READ_SIZE = 1024 * 1024
#: How long the worker has to end after the launch, with what it does
#: (seconds).
_PATIENCE = 8.0


class WorkerLink:
    """
    A worker, and the job that it does.

    To be made before anything runs and any thread is started, as the worker
    is a fork of this process.

    :param prepare: Does a job, in a child of the worker
    :param warm_up: Loads what jobs need, in the worker
    :param clean_up: See :func:`.worker.serve`
    :raises OSError: when there can be no further process
    """

    def __init__(
        self,
        prepare: Prepare,
        warm_up: Callable[[], None],
        clean_up: Callable[[int], None],
    ) -> None:
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        # else the collection of garbage writes to all that both have, and what
        # is written to is shared no more
        gc.freeze()
        #: Its process id, or 0 when there is none any more.
        self.pid = os.fork()
        if not self.pid:
            ours.close()
            _become_worker(its, prepare, warm_up, clean_up)
        its.close()
        ours.setblocking(False)
        self._link = ours
        self._answer: socket.socket | None = None
        self._output = -1
        self._read = b''
        #: What the job has written so far.
        self.written = b''
        #: Is called with a descriptor before it is closed.
        self.closing: Callable[[int], None] = _watch_nothing

    @property
    def descriptor(self) -> int:
        """What can be read when :meth:`take_children` has something."""
        return self._link.fileno()

    @property
    def job_descriptors(self) -> tuple[int, ...]:
        """What can be read when :meth:`take` has something."""
        if self._answer is None:
            return ()
        return self._answer.fileno(), self._output

    def ask(self, request: object) -> None:
        """
        Have a job done; one that is under way is given up.

        :raises OSError: when the worker is gone
        """
        self.forget()
        answer, its_answer = socket.socketpair()
        self._output, its_output = os.pipe()
        file = os.memfd_create('request')
        try:
            with os.fdopen(os.dup(file), 'wb') as stream:
                pickle.dump(request, stream, pickle.HIGHEST_PROTOCOL)
            os.lseek(file, 0, os.SEEK_SET)
            given = [file, its_answer.fileno(), its_output]
            socket.send_fds(self._link, [DO], given)
        finally:
            its_answer.close()
            os.close(its_output)
            os.close(file)
        answer.setblocking(False)
        os.set_blocking(self._output, False)
        self._answer = answer

    def cancel(self) -> None:
        """Give up the job that is under way."""
        if self._answer is not None:
            self.forget()
            with suppress(OSError):
                self._link.send(CANCEL)

    def take_children(self) -> Iterator[int]:
        """Iterate over the groups of jobs that have begun."""
        with suppress(OSError):
            while data := self._link.recv(PID.size):
                yield PID.unpack(data)[0]

    def take(self) -> Iterator[Any]:
        """
        Iterate over what the job has told, its answer as the last.

        :raises EOFError: when it has ended without an answer
        """
        while self._answer is not None:
            try:
                data = self._answer.recv(_READ_SIZE)
            except BlockingIOError:
                # what fills the pipe would hold the job up
                self._take_output()
                return
            except OSError:
                data = b''
            if not data:
                raise EOFError
            self._read += data
            while (message := self._next()) is not None:
                self._take_output()
                yield message

    def forget(self) -> None:
        """Hear no more of the job, which is done or not wanted."""
        if self._answer is not None:
            for descriptor in self.job_descriptors:
                self.closing(descriptor)
            self._answer.close()
            os.close(self._output)
        self._answer, self._output = None, -1
        self._read = self.written = b''

    def lost(self) -> None:
        """Take into account that the worker has ended."""
        self.forget()
        self.pid = 0
        self.closing(self.descriptor)
        self._link.close()

    def close(self) -> None:
        """End the worker with what it does, and wait for that."""
        if not self.pid:
            return
        pid = self.pid
        self.lost()
        # one that is stopped would leave behind what it does
        os.kill(pid, signal.SIGCONT)
        deadline = time.monotonic() + _PATIENCE
        while not has_ended(pid):
            if time.monotonic() > deadline:
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)
                break
            time.sleep(0.002)

    def _next(self) -> Any:
        if len(self._read) < LENGTH.size:
            return None
        (length,) = LENGTH.unpack_from(self._read)
        end = LENGTH.size + length
        if len(self._read) < end:
            return None
        message = pickle.loads(self._read[LENGTH.size : end])
        self._read = self._read[end:]
        return message

    def _take_output(self) -> None:
        with suppress(BlockingIOError):
            while self._output != -1:
                data = os.read(self._output, _READ_SIZE)
                if not data:
                    # all that might write has ended
                    self.closing(self._output)
                    return
                self.written += data


def _become_worker(
    connection: socket.socket,
    prepare: Prepare,
    warm_up: Callable[[], None],
    clean_up: Callable[[int], None],
) -> None:
    """Be the worker, and never come back."""
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
        serve(connection, prepare, clean_up)
    finally:
        os._exit(0)


def _watch_nothing(descriptor: int) -> None:
    """Leave it at that."""
