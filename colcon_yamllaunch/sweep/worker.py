# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The child processes of a sweep: workers, and the guards of their runs.

They are forks of a process that has imported all modules and knows the
workspace, as a new program takes longer to import these than a short run
costs. A worker launches one run after the other, and its guard guards them, as
each fork makes both processes copy their memory.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import closing
from contextlib import suppress
import json
import os
import signal
import socket
import sys
from typing import Any

from colcon_yamllaunch.common.codec import to_json
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.prctl import end_with_parent
from colcon_yamllaunch.engine.process.cgroup import expect_moves
from colcon_yamllaunch.engine.stopping.guard import DISMISSED
from colcon_yamllaunch.engine.stopping.guard import guard
from colcon_yamllaunch.engine.stopping.guard_link import Guards
from colcon_yamllaunch.sweep.isolation import enter_own_network
from colcon_yamllaunch.sweep.isolation import VARIABLE
from colcon_yamllaunch.sweep.results import failed_run
from colcon_yamllaunch.sweep.run import first_error
from colcon_yamllaunch.sweep.run import NotBuiltError
from colcon_yamllaunch.sweep.run import perform
from colcon_yamllaunch.sweep.run import PlanError
from colcon_yamllaunch.sweep.run import Sweep
from colcon_yamllaunch.sweep.table import Run

#: Sent to a worker when its run may start processes.
GO = b'g'
#: Bytes that are kept of the messages of the planning of a run.
MESSAGES_SIZE = 64 * 1024
#: Files in the message of a run that is planned.
_MOST_USES = 500
#: Runs of a worker, so that it does not grow without end.
_RUNS = 100
#: Bytes of the number of a run, and of the identity of a launch.
_NUMBER = 32
_IDENTITY = 1024
_BLOCKED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: The title of a guard in `ps`: no word of it names us, as `pkill -9 -f
#: colcon` ends launchers and leaves their guards to stop the processes.
_TITLE = b'guard of a launch'


def fork(
    action: Callable[[], int | None],
    streams: tuple[int, int, int],
    *,
    keep_files: bool = False,
) -> int:
    """
    Call `action` in a child process, and return the child's process id.

    The child has its own session, so keys of the terminal do not reach it, and
    the default signal handlers. The result of `action` is its exit code.

    :param streams: The descriptors for standard input, output and error; -1
      for none
    :param keep_files: Whether the child keeps all other descriptors
    :raises OSError: when there can be no further process
    """
    pid = os.fork()
    if pid:
        return pid
    code = 1
    try:
        signal.set_wakeup_fd(-1)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_DFL)
        os.setsid()
        null = os.open(os.devnull, os.O_RDWR)
        for target, descriptor in enumerate(streams):
            os.dup2(null if descriptor == -1 else descriptor, target)
        os.close(null)
        if not keep_files:
            os.closerange(3, os.sysconf('SC_OPEN_MAX'))
        code = action() or 0
    finally:
        os._exit(code)


class ForkedGuards(Guards):
    """Starts guards as forks; one guard serves one launch after the other."""

    def __init__(self) -> None:
        # the guard receives the sockets of the launches over this one
        self._link: socket.socket | None = None

    def begin(self, connection: int, identity: str) -> int:
        """Send a launch to the guard, and return its process id."""
        words = [identity.encode()]
        if self._link is not None:
            with suppress(OSError):
                socket.send_fds(self._link, words, [connection])
                return self.pid
            # it was killed; if that was between two launches, it is ours
            self._link.close()
            with suppress(ChildProcessError):
                os.waitpid(self.pid, os.WNOHANG)
        self._link, its = socket.socketpair(
            socket.AF_UNIX, socket.SOCK_SEQPACKET
        )
        session = os.getsid(0)
        with its:
            # the other descriptors, above all the other end of its socket,
            # are closed
            self.pid = fork(lambda: _guard(session), (its.fileno(), -1, -1))
        socket.send_fds(self._link, words, [connection])
        return self.pid

    def close(self) -> None:
        """Let the guard end."""
        if self._link is not None:
            self._link.close()
            self._link = None

    def end(self, pid: int, connection: socket.socket) -> None:
        """Dismiss the guard of a launch that has ended."""
        try:
            connection.send(json.dumps([DISMISSED]).encode())
        except OSError:
            super().end(pid, connection)


def _guard(session: int) -> None:
    """Guard each launch whose socket arrives on standard input."""
    signal.pthread_sigmask(signal.SIG_BLOCK, _BLOCKED)
    _rename()
    with socket.socket(fileno=0) as launches:
        while True:
            name, descriptors, _, _ = socket.recv_fds(launches, _IDENTITY, 1)
            if not descriptors:
                return
            with socket.socket(fileno=descriptors[0]) as connection:
                guard(name.decode(), session, connection)


def _rename() -> None:
    """Show a title to `ps` and `pkill -f` in place of our arguments."""
    # fields 48 and 49 of /proc/PID/stat, see proc(5); the name, which may
    # have blanks, is before the last bracket
    with suppress(OSError, ValueError, IndexError):
        with open('/proc/self/stat', 'rb') as file:
            fields = file.read().rpartition(b')')[2].split()
        start, end = int(fields[45]), int(fields[46])
        if 0 < start < end:
            import ctypes

            room = end - start
            title = _TITLE[: room - 1].ljust(room, b'\0')
            ctypes.memmove(start, title, room)


def keep_moves_fast(parent: int) -> None:
    """
    Keep the kernel ready to move processes to control groups.

    Its first move waits for some 10 ms, moves soon after it do not, see
    :func:`.cgroup.expect_moves`. That is a tenth of a run of 0.1 s.
    """
    end_with_parent(signal.SIGTERM, parent)
    while expect_moves():
        pass


class Worker:
    """
    A worker process, in that process: plans and launches runs.

    :param link: The socket to the runner
    :param messages: The file that standard output and error go to
    :param domain: Its ROS_DOMAIN_ID
    """

    def __init__(
        self,
        sweep: Sweep,
        link: socket.socket,
        messages: int,
        domain: int,
        *,
        own_network: bool,
    ) -> None:
        self._sweep = sweep
        self._link = link
        self._messages = messages
        self._domain = domain
        self._own_network = own_network

    def work(self, parent: int, runs: Mapping[int, Run], run: Run) -> int:
        """
        Launch `run`, then those whose numbers arrive; return the exit code.

        :param parent: The runner; the worker ends with it
        """
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            with closing(ForkedGuards()) as guards:
                for left in reversed(range(_RUNS)):
                    if self._own_network:
                        enter_own_network(again=left + 1 < _RUNS)
                    # the new network has undone it
                    end_with_parent(signal.SIGTERM, parent)
                    message = self._launch(run, guards)
                    sys.stdout.flush()
                    sys.stderr.flush()
                    message['idle'] = left > 0 and message.get('idle', True)
                    self._send(message)
                    number = b''
                    if message['idle']:
                        number = self._link.recv(_NUMBER)
                    if not number:
                        break
                    run = runs[int(number)]
        except KeyboardInterrupt:
            return 130
        except Exception as e:  # noqa: BLE001 - the other runs go on
            with suppress(OSError):
                self._send(_error(run, f'internal error: {e!r}'))
            return 1
        finally:
            with suppress(Exception):
                sys.stdout.flush()
                sys.stderr.flush()
        return 0

    def _launch(self, run: Run, guards: Guards) -> dict[str, Any]:
        """Plan a run, wait for its turn, and return its result."""
        sweep = self._sweep
        folder = sweep.folder.run_folder(run.number)
        try:
            planned = sweep.plan(run, folder, {VARIABLE: str(self._domain)})
        except NotBuiltError:
            return {'not built': True}
        except UserError as e:
            return _error(run, str(e))
        except PlanError:
            sys.stderr.flush()
            text = os.pread(self._messages, MESSAGES_SIZE, 0)
            return _error(run, first_error(text.decode(errors='replace')))

        def wait() -> None:
            self._send({'planned': planned.uses[:_MOST_USES]})
            if self._link.recv(len(GO)) != GO:
                raise KeyboardInterrupt

        def over() -> None:
            # a runner that is gone starts no other run
            with suppress(OSError):
                self._send({'over': True})

        try:
            result = perform(
                run.number, planned, folder, sweep.goal, guards, wait, over
            )
        finally:
            planned.close()
        if result is None:
            raise KeyboardInterrupt
        # the worker of a launch file in Python may leave something behind
        return {'result': to_json(result), 'idle': not planned.participants}

    def _send(self, message: dict[str, Any]) -> None:
        self._link.send(json.dumps(message).encode())


def _error(run: Run, reason: str) -> dict[str, Any]:
    return {'result': to_json(failed_run(run.number, reason))}
