# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The worker that reads launch files in Python, and the pipes to it.

The worker runs the program in `worker` with the Python of the sourced
environment. Messages are JSON objects, one a line; that program lists them.

Until the launch runs, the worker has a guard, which ends it when the launcher
is killed.
"""

from collections import deque
from collections.abc import Collection, Mapping
from contextlib import suppress
import os
from pathlib import Path
import select
import signal
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.escalation import (
    Escalation,
    Orphan,
    Targets,
    Timeouts,
)
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.guard_link import GuardLink
from colcon_yamllaunch.engine.helper_process import (
    JsonPipes,
    open_log,
    pythons,
)
from colcon_yamllaunch.engine.launch_scan import (
    find_orphans,
    LAUNCH_ID_VARIABLE,
)
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.spawn import spawn_process, StartError
from colcon_yamllaunch.language.evaluation.request import (
    NoWorkerError,
    WorkerError,
    WorkerMessage,
    WorkerTimeoutError,
)
from colcon_yamllaunch.language.python_files.python_visit import (
    TIMEOUT_VARIABLE,
)

#: The program of the worker; it imports nothing of this package.
PROGRAM = Path(__file__).with_name('worker')
#: The file in the log folder for the output of launch files.
LOG_NAME = 'launch_files.log'
#: The default timeout (seconds).
TIMEOUT = 60.0
#: The number of the worker in the launch; no process of the plan has it.
NUMBER = 1_000_000_000
#: Seconds to wait for its position in a launch file, and for its end.
ANSWER_TIMEOUT = 1.0

_STDERR = 2
_AT_ONCE = Timeouts(0.0, 0.0)
# for processes that launch files have started in the background
_AT_THE_END = Timeouts(0.0, 1.0)


def timeout_of(environment: Mapping[str, str]) -> float:
    """
    Return the seconds that a worker may take until its next message.

    :raises UserError: when the user's value is not a number of seconds
    """
    text = environment.get(TIMEOUT_VARIABLE) or str(TIMEOUT)
    with suppress(ValueError):
        if 0 < (seconds := float(text)) < limits.LONGEST_LOOP_WAIT:
            return seconds
    raise UserError(f"{TIMEOUT_VARIABLE} is a number of seconds, not '{text}'")


class WorkerProcess:
    """
    The worker of a launch; its first message starts it, if nothing did before.

    :param environment: The environment that it runs in
    :param cwd: Its working directory
    :param log: The file for its standard error; None for that of the launcher
    :param identity: The identity of the launch, see `launch_scan`
    :param timeout: Seconds that it may take until its next message
    """

    def __init__(
        self,
        environment: Mapping[str, str],
        cwd: str,
        log: Path | None,
        identity: str,
        timeout: float,
    ) -> None:
        self._environment = {
            **environment,
            LAUNCH_ID_VARIABLE: f'{identity}.{NUMBER}',
        }
        self._cwd = cwd
        self._log = log
        self.identity = identity
        self._timeout = timeout
        self._pythons = pythons(environment.get('PATH', os.defpath))
        self._guard: GuardLink | None = None
        #: Its process ID and process group, or 0 while it does not run.
        self.pid = 0
        self._pipes = JsonPipes()
        self._messages: deque[WorkerMessage] = deque()
        # messages to send again to another Python; None once it needs no other
        self._first: list[WorkerMessage] | None = []
        # the error of the first Python
        self._first_reason: WorkerError | None = None
        self._begun = self._is_entrusted = False
        self._is_over = False
        # why no worker could be started
        self._reason: WorkerError | None = None

    @property
    def descriptor(self) -> int:
        """Is readable when it has sent something; -1 while it is not open."""
        return self._pipes.output

    @property
    def is_spent(self) -> bool:
        """Whether it has ended, and another worker could replace it."""
        return self._is_over and self._reason is None

    def send(self, message: WorkerMessage) -> None:
        """
        Send a message; the first one starts the worker.

        :raises WorkerError: when there is no worker, as `launch` is not
          installed or the worker has ended
        """
        self.start()
        if self._is_over:
            raise self._gone()
        if self._first is not None:
            self._first.append(message)
        self._pipes.send(message)
        self._pipes.flush()

    def start(self) -> None:
        """
        Start it in advance, unless it was started before.

        If that fails, :meth:`send` raises the error.
        """
        if not self._begun:
            self._begun = True
            with suppress(WorkerError):
                self._start()

    def receive(self) -> WorkerMessage:
        """
        Wait for the next message.

        :raises WorkerTimeoutError: when none comes in time
        :raises WorkerError: when the worker has ended
        """
        return self._receive(self._timeout)

    def doing(self) -> WorkerMessage:
        """Return its position in a launch file, if it answers, and end it."""
        try:
            self.send({'do': 'where'})
            deadline = time.monotonic() + ANSWER_TIMEOUT
            while (left := deadline - time.monotonic()) > 0:
                message = self._receive(left)
                if message.get('say') == 'where':
                    return message
        except WorkerError:
            pass
        finally:
            self.close()
        return {}

    def poll(self) -> WorkerMessage | None:
        """
        Return the next message, or None if there is none.

        It is None at the end of its output, too: the engine reaps the worker
        and reports its end.

        :raises WorkerError: when no Python of the environment runs, or all
          lack a needed package
        """
        while True:
            self._pipes.flush()
            while self._messages:
                message = self._messages.popleft()
                if message.get('say') != 'found':
                    return message
                self._found([str(n) for n in message.get('missing', ())])
            self._messages.extend(self._pipes.read())
            if self._messages:
                continue
            if self._pipes.has_ended:
                self._close_pipes()
            if self.descriptor != -1 or self._first is None or not self.pid:
                return None
            # it did not even check its packages: it may be too old, or broken
            self._await_end()
            self._next(WorkerError(f'{self._end()}{self._last_words()}'))

    def flush(self) -> bool:
        """Write pending messages; return whether all are written."""
        return self._pipes.flush()

    def entrust(self) -> None:
        """Let the engine guard and reap the process, see :meth:`reaped`."""
        self._is_entrusted = True
        if self._guard is not None:
            self._guard.dismiss()
            self._guard = None

    def detach(self) -> None:
        """Detach a forked child of the launcher from it."""
        self.pid = 0
        self._is_over = self._is_entrusted = True
        self._close_pipes()

    def reaped(self) -> None:
        """Note that the engine has reaped it."""
        self.pid = 0

    def release(self) -> None:
        """
        End it, but not the background processes of launch files.

        These go on until :meth:`close`.
        """
        with suppress(WorkerError):
            # it removes the temporary files of launch files
            self.send({'do': 'start', 'id': 0, 'packages': {}})
            while self._receive(ANSWER_TIMEOUT).get('id') != 0:
                continue
        if self.pid:
            os.kill(self.pid, signal.SIGKILL)
        self._end()
        self.entrust()

    def close(self) -> None:
        """End it with all processes that it has started."""
        orphans = _Orphans(
            self.identity, {self.pid: NUMBER} if self.pid else {}
        )
        if self.pid:
            self._close_pipes()
            if self._first == []:
                # it had no request, so it has nothing to clean up
                os.kill(self.pid, signal.SIGKILL)
            self._await_end()
            self._end()
        if self._begun and orphans.search(()):
            timeouts, now = {NUMBER: _AT_THE_END}, time.monotonic()
            Escalation(orphans, timeouts, now, signal.SIGTERM).run()
        self.entrust()

    def _await_end(self) -> None:
        """Wait until it ends, and kill it after a timeout."""
        deadline = time.monotonic() + ANSWER_TIMEOUT
        while not _has_ended(self.pid) and time.monotonic() < deadline:
            time.sleep(0.002)
        with suppress(ProcessLookupError, PermissionError):
            # it is not reaped yet, so no other process has its ID
            os.killpg(self.pid, signal.SIGKILL)

    def _end(self) -> str:
        """Reap it, and return how it ended."""
        self._is_over = True
        self._close_pipes()
        ending = 'ended'
        if self.pid:
            with suppress(ChildProcessError):
                status = os.waitpid(self.pid, 0)[1]
                ending = str(Outcome.from_status(status))
            self.pid = 0
        return ending

    def _start(self) -> None:
        """
        Start it with the next Python of the environment.

        :raises WorkerError: when no Python can be started
        """
        its_input, its_output = self._pipes.open()
        error = _STDERR if self._log is None else open_log(self._log)
        try:
            self.pid = spawn_process(
                [self._pythons[0], str(PROGRAM)],
                self._environment,
                self._cwd,
                (its_input, its_output, error),
            )
        except StartError as e:
            self._next(NoWorkerError(str(e)))
            return
        finally:
            os.close(its_input)
            os.close(its_output)
            if error != _STDERR:
                os.close(error)
        # after the worker, whose start takes longer; without a guard, it
        # still ends with its input
        if self._guard is None:
            self._guard = GuardLink(self.identity)
            with suppress(OSError):
                self._guard.start()
        self._guard.started(NUMBER, self.pid, _AT_ONCE)
        self._guard.flush()
        for message in self._first or ():
            self._pipes.send(message)

    def _receive(self, timeout: float) -> WorkerMessage:
        deadline = time.monotonic() + timeout
        while (message := self.poll()) is None:
            if self.descriptor == -1:
                raise self._gone()
            left = deadline - time.monotonic()
            if left <= 0:
                raise WorkerTimeoutError(f'more than {timeout:g} s')
            waiting = select.poll()
            waiting.register(self.descriptor, select.POLLIN)
            if self._pipes.has_unsent:
                waiting.register(self._pipes.input, select.POLLOUT)
            waiting.poll(left * 1000)
        return message

    def _found(self, missing: list[str]) -> None:
        """
        Go on with another Python if this one lacks packages.

        :raises NoWorkerError: when all of them lack a package
        """
        if not missing:
            self._first = None
            return
        self._next(NoWorkerError(f'there is no {missing[0]}'))

    def _next(self, reason: WorkerError) -> None:
        """
        Go on with the next Python.

        :param reason: The error of this one
        :raises WorkerError: when there is no other; it is the error of the
          first Python, which matters most
        """
        if self._first_reason is None:
            self._first_reason = reason
        self._close_pipes()
        if self.pid:
            self._await_end()
        self._end()
        del self._pythons[:1]
        if not self._pythons:
            self._reason = self._first_reason
            raise self._reason
        self._is_over = False
        self._start()

    def _gone(self) -> WorkerError:
        """Wait until the worker has ended, and return its error."""
        self._is_over = True
        if self._reason is not None:
            return self._reason
        if not self.pid or self._is_entrusted:
            return WorkerError('ended')
        self._await_end()
        return WorkerError(f'{self._end()}{self._last_words()}')

    def _last_words(self) -> str:
        with suppress(OSError):
            if self._log is not None and self._log.stat().st_size:
                return f'; what it wrote is in {self._log}'
        return ''

    def _close_pipes(self) -> None:
        self._pipes.close()
        self._messages.clear()


class _Orphans(Targets):
    """The processes that a worker left running."""

    def __init__(self, identity: str, groups: Mapping[int, int]) -> None:
        self._identity = identity
        self._groups = groups

    def search(self, groups: Collection[int]) -> list[Orphan]:
        return find_orphans(self._identity, os.getsid(0), self._groups, groups)


def _has_ended(pid: int) -> bool:
    flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
    try:
        return os.waitid(os.P_PID, pid, flags) is not None
    except ChildProcessError:
        return True
