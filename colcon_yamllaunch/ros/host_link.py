# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The process that reads launch files in Python, and the pipes to it.

It runs the program in `launch_host` with the Python of the sourced
environment. What passes are JSON objects, one a line; that program says which.

Until the launch runs, a guard of its own ends it when the launcher is killed.
"""

from collections.abc import Collection
from collections.abc import Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
import select
import signal
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.escalation import Escalation
from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.common.escalation import Targets
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.process.descriptors import open_log
from colcon_yamllaunch.engine.process.pythons import pythons
from colcon_yamllaunch.engine.process.spawn import spawn_process
from colcon_yamllaunch.engine.process.spawn import StartError
from colcon_yamllaunch.engine.stopping.guard_link import GuardLink
from colcon_yamllaunch.engine.stopping.launch_scan import find_orphans
from colcon_yamllaunch.engine.stopping.launch_scan import LAUNCH_ID_VARIABLE
from colcon_yamllaunch.language.evaluation.launch_host import HostError
from colcon_yamllaunch.language.evaluation.launch_host import HostMessage
from colcon_yamllaunch.language.evaluation.launch_host import HostTimeoutError
from colcon_yamllaunch.language.evaluation.launch_host import NoHostError
from colcon_yamllaunch.language.host.python_errors import TIMEOUT_VARIABLE

#: What the process runs; it imports nothing of this package.
PROGRAM = Path(__file__).with_name('launch_host')
#: The file in the log folder for what launch files print.
LOG_NAME = 'launch_files.log'
#: Seconds that it may take where the user says nothing else.
TIMEOUT = 60.0
#: The number of the process in the launch: that of no process of the plan.
NUMBER = 1_000_000_000
#: Seconds that it gets to say what it is doing, and to end by itself.
PATIENCE = 1.0
#: Bytes of the longest line.
MAXIMUM_LINE = 64 * 1024 * 1024

_STDERR = 2
_AT_ONCE = Timeouts(0.0, 0.0)
# for what launch files have started in the background
_AT_THE_END = Timeouts(0.0, 1.0)


def timeout_of(environment: Mapping[str, str]) -> float:
    """
    Return the seconds that a host may take until it says something.

    :raises UserError: when the user's wish is no number
    """
    text = environment.get(TIMEOUT_VARIABLE) or str(TIMEOUT)
    with suppress(ValueError):
        if 0 < (seconds := float(text)) < limits.LONGEST_WAIT:
            return seconds
    raise UserError(f"{TIMEOUT_VARIABLE} is a number of seconds, not '{text}'")


class HostLink:
    """
    The host of a launch; it is started when something is sent, or before.

    :param environment: The environment that it runs in
    :param cwd: Its working directory
    :param log: The file for its standard error; None for our own
    :param identity: The identity of the launch, see `launch_scan`
    :param timeout: Seconds that it may take until it says something
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
        #: Its process id and process group, or 0 while there is none.
        self.pid = 0
        #: What is readable when it has said something, or -1.
        self.descriptor = -1
        self._input = -1
        self._unsent = b''
        self._read = bytearray()
        self._lines: list[bytes] = []
        # what was sent before it is known to have what is needed
        self._first: list[bytes] | None = []
        # what was wrong with the first Python
        self._first_reason: HostError | None = None
        self._begun = self._is_entrusted = False
        self._is_over = False
        # why, if there never was one
        self._reason: HostError | None = None

    @property
    def is_spent(self) -> bool:
        """Whether it ended, and another one could do what it did."""
        return self._is_over and self._reason is None

    def send(self, message: HostMessage) -> None:
        """
        Send a message; the host is started for the first one.

        :raises HostError: when there is no host, as `launch` is not there or
          it ended
        """
        data = json.dumps(message).encode() + b'\n'
        self.start()
        if self._is_over:
            raise self._gone()
        if self._first is not None:
            self._first.append(data)
        self._unsent += data
        self.flush()

    def start(self) -> None:
        """
        Start it, unless it was, so that it is ready the sooner.

        If that is impossible, :meth:`send` says so.
        """
        if not self._begun:
            self._begun = True
            with suppress(HostError):
                self._start()

    def receive(self) -> HostMessage:
        """
        Wait for the next message.

        :raises HostTimeoutError: when none comes in time
        :raises HostError: when the host ended
        """
        return self._receive(self._timeout)

    def doing(self) -> HostMessage:
        """
        Return what it is doing, if it says so, and end it.

        After this there is no host any more.
        """
        try:
            self.send({'do': 'where'})
            deadline = time.monotonic() + PATIENCE
            while (left := deadline - time.monotonic()) > 0:
                message = self._receive(left)
                if message.get('say') == 'where':
                    return message
        except HostError:
            pass
        finally:
            self.close()
        return {}

    def poll(self) -> HostMessage | None:
        """
        Return the next message if there is one.

        None at the end of what it says, too; that it ended is reported as of
        each child.

        :raises HostError: when no Python of the environment runs, or none has
          what is needed
        """
        while True:
            self.flush()
            while self._lines:
                message = _decoded(self._lines.pop(0))
                if message is None:
                    continue
                if message.get('say') != 'found':
                    return message
                self._found([str(n) for n in message.get('missing', ())])
            if self._read_more():
                continue
            if self.descriptor != -1 or self._first is None or not self.pid:
                return None
            # not even what it lacks: it may be too old, or a broken one
            self._await_end()
            self._next(HostError(f'{self._end()}{self._last_words()}'))

    def flush(self) -> bool:
        """Write what is to be sent, and return whether all is written."""
        try:
            while self._unsent and self._input != -1:
                count = os.write(self._input, self._unsent)
                self._unsent = self._unsent[count:]
        except BlockingIOError:
            return False
        except OSError:
            # its end is noticed soon
            self._unsent = b''
        return True

    def entrust(self) -> None:
        """
        Leave it to others to end it if we are killed.

        From now on they reap it, too, see :meth:`reaped`.
        """
        self._is_entrusted = True
        if self._guard is not None:
            self._guard.dismiss()
            self._guard = None

    def disown(self) -> None:
        """Have nothing to do with it, in a fork of its launcher."""
        self.pid = 0
        self._is_over = self._is_entrusted = True
        self._close_pipes()

    def reaped(self) -> None:
        """Take note that somebody waited for it."""
        self.pid = 0

    def release(self) -> None:
        """
        End it, but not what launch files have started in the background.

        That goes on until :meth:`close`.
        """
        with suppress(HostError):
            # it removes what it has made for launch files that were read
            self.send({'do': 'start', 'id': 0, 'packages': {}})
            while self._receive(PATIENCE).get('id') != 0:
                continue
        if self.pid:
            os.kill(self.pid, signal.SIGKILL)
        self._end()
        self.entrust()

    def close(self) -> None:
        """End it with all that it has started."""
        strays = _Strays(self.identity, {self.pid: NUMBER} if self.pid else {})
        if self.pid:
            self._close_pipes()
            if self._first == []:
                # it was asked for nothing, so it has nothing to end
                os.kill(self.pid, signal.SIGKILL)
            self._await_end()
            self._end()
        if self._begun and strays.search(()):
            timeouts, now = {NUMBER: _AT_THE_END}, time.monotonic()
            Escalation(strays, timeouts, now, signal.SIGTERM).run()
        self.entrust()

    def _await_end(self) -> None:
        """Let it end by itself, at the latest after a moment."""
        deadline = time.monotonic() + PATIENCE
        while not _has_ended(self.pid) and time.monotonic() < deadline:
            time.sleep(0.002)
        with suppress(ProcessLookupError, PermissionError):
            # it has not been waited for, so the id is still its own
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
        Start it, with the next Python that there is.

        :raises HostError: when none can be started
        """
        its_input, self._input = os.pipe()
        self.descriptor, its_output = os.pipe()
        error = _STDERR if self._log is None else open_log(self._log)
        try:
            self.pid = spawn_process(
                [self._pythons[0], str(PROGRAM)],
                self._environment,
                self._cwd,
                (its_input, its_output, error),
            )
        except StartError as e:
            self._next(NoHostError(str(e)))
            return
        finally:
            os.close(its_input)
            os.close(its_output)
            if error != _STDERR:
                os.close(error)
        # behind it, whose start takes longer; without a guard, the end of
        # its input still ends it
        if self._guard is None:
            self._guard = GuardLink(self.identity)
            with suppress(OSError):
                self._guard.start()
        self._guard.started(NUMBER, self.pid, _AT_ONCE)
        self._guard.flush()
        os.set_blocking(self._input, False)
        os.set_blocking(self.descriptor, False)
        self._unsent = b''.join(self._first or ())

    def _receive(self, timeout: float) -> HostMessage:
        deadline = time.monotonic() + timeout
        while (message := self.poll()) is None:
            if self.descriptor == -1:
                raise self._gone()
            left = deadline - time.monotonic()
            if left <= 0:
                raise HostTimeoutError(f'more than {timeout:g} s')
            waiting = select.poll()
            waiting.register(self.descriptor, select.POLLIN)
            if self._unsent:
                waiting.register(self._input, select.POLLOUT)
            waiting.poll(left * 1000)
        return message

    def _read_more(self) -> bool:
        """Read what has come, and return whether anything has."""
        if self.descriptor == -1:
            return False
        try:
            data = os.read(self.descriptor, limits.READ_SIZE)
        except BlockingIOError:
            return False
        self._read += data
        if not data or len(self._read) > MAXIMUM_LINE:
            self._close_pipes()
            return False
        if b'\n' in data:
            *self._lines, rest = bytes(self._read).split(b'\n')
            self._read = bytearray(rest)
        return True

    def _found(self, missing: list[str]) -> None:
        """
        Take note of what the environment of a Python lacks.

        :raises NoHostError: when all of them lack something
        """
        if not missing:
            self._first = None
            return
        self._next(NoHostError(f'there is no {missing[0]}'))

    def _next(self, reason: HostError) -> None:
        """
        Go on with the next Python.

        :param reason: What is wrong with this one
        :raises HostError: when there is none: what was wrong with the first
          one, as the others matter less
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
        self._read.clear()
        self._start()

    def _gone(self) -> HostError:
        """Return the error of a host that ended, once it did."""
        self._is_over = True
        if self._reason is not None:
            return self._reason
        if not self.pid or self._is_entrusted:
            return HostError('ended')
        self._await_end()
        return HostError(f'{self._end()}{self._last_words()}')

    def _last_words(self) -> str:
        with suppress(OSError):
            if self._log is not None and self._log.stat().st_size:
                return f'; what it wrote is in {self._log}'
        return ''

    def _close_pipes(self) -> None:
        for descriptor in (self._input, self.descriptor):
            if descriptor != -1:
                os.close(descriptor)
        self._input = self.descriptor = -1
        self._unsent = b''
        self._lines.clear()


class _Strays(Targets):
    """What a host has left running."""

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


def _decoded(line: bytes) -> HostMessage | None:
    try:
        message = json.loads(line)
    except (ValueError, RecursionError):
        # somebody else has written it
        return None
    return message if isinstance(message, dict) else None
