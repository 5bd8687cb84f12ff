# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The process that connects with a machine, such as `ssh`, and its watchdog.

`ssh` that waits for a silent machine does not notice that its launcher was
killed. The guard of a launch stops it then, but there is none before the
launch runs. Until then a shell is the watchdog, which waits for the end of the
launcher.

The command runs `sh` there, which reads everything else from its standard
input: that works with any login shell, and with commands that pass their words
on as they are (docker) or through a shell (ssh).
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
import fcntl
import os
import shutil
import signal
import time
from typing import Any

from colcon_yamllaunch.deployment.deployment import Machine

#: How many bytes of its standard error are stored.
_MESSAGES = 8192
#: The size of the pipes, so that few calls transfer much (bytes).
_PIPE = 1024 * 1024
_F_SETPIPE_SZ = 1031
#: How long it may take to end once its input has ended, or by a signal
#: (seconds).
_END_TIMEOUT = 5.0
_READ = 64 * 1024
_TERMINAL = '/dev/tty'
_SHELL = '/bin/sh'
#: Runs a program with a watchdog, which is in its process group, but no child
#: of it, and reads a pipe of the launcher. If that ends without a line, the
#: launcher was killed, and the watchdog stops the group. SIGTERM comes first,
#: so that `ssh` resets the terminal.
_WATCHED = """\
trap '' TERM
( (
  read -r line && exit
  kill -s TERM -- "-$$"
  sleep 2
  kill -s KILL -- "-$$"
) <&3 >/dev/null 2>&1 3<&- & )
trap - TERM
exec 3<&-
exec "$@"
"""
_BATCH = ('-o', 'BatchMode=yes')
#: Slurm sets it within an allocation.
_ALLOCATION = 'SLURM_JOB_ID'


class ConnectProcess:
    """
    A command whose standard input and output lead to another machine.

    It gets neither keys nor signals of our terminal, as Ctrl-C first stops
    the launch.

    :param command: Its command line
    :param kept: Whether the watchdog stops it if the launcher is killed
    :param asks: Whether it may ask the user; then it needs the terminal, see
      :func:`foreground`, and its standard error is ours
    :raises OSError: when it cannot be started
    """

    def __init__(
        self,
        command: Sequence[str],
        environment: Mapping[str, str],
        *,
        asks: bool = False,
        kept: bool = False,
    ) -> None:
        #: Its command line.
        self.command = command
        path = environment.get('PATH', os.defpath)
        program = shutil.which(command[0], path=path)
        if program is None:
            raise FileNotFoundError(2, os.strerror(2), command[0])
        its_input, self.stdin = os.pipe()
        self.stdout, its_output = os.pipe()
        self.stderr, its_errors = os.pipe()
        theirs = [its_input, its_output, its_errors]
        self._watch = -1
        words = [program, *command[1:]]
        actions = [
            (os.POSIX_SPAWN_DUP2, its_input, 0),
            (os.POSIX_SPAWN_DUP2, its_output, 1),
        ]
        if not asks:
            actions.append((os.POSIX_SPAWN_DUP2, its_errors, 2))
        if kept:
            words = [_SHELL, '-c', _WATCHED, _SHELL, *words]
            its_watch, self._watch = os.pipe()
            theirs.append(its_watch)
            actions.append((os.POSIX_SPAWN_DUP2, its_watch, 3))
        group: dict[str, Any] = {'setpgroup': 0} if asks else {'setsid': True}
        try:
            self.pid = os.posix_spawn(
                words[0],
                words,
                environment,
                file_actions=actions,
                setsigmask=(),
                setsigdef=(signal.SIGINT, signal.SIGTERM, signal.SIGPIPE),
                **group,
            )
        except BaseException:
            self.leave_to_guard()
            self.close_pipes()
            raise
        finally:
            for descriptor in theirs:
                os.close(descriptor)
        for descriptor in (self.stdin, self.stdout):
            with suppress(OSError):
                fcntl.fcntl(descriptor, _F_SETPIPE_SZ, _PIPE)
        os.set_blocking(self.stderr, False)
        self._messages = b''
        #: Its wait status, once it has ended and was waited for.
        self.status: int | None = None

    @property
    def messages(self) -> str:
        """The last text that it wrote to standard error."""
        self.read_messages()
        return self._messages.decode(errors='replace')

    def read_messages(self) -> bool:
        """Read its standard error; return whether more may come."""
        while self.stderr != -1:
            try:
                data = os.read(self.stderr, _READ)
            except BlockingIOError:
                return True
            except OSError:
                return False
            if not data:
                return False
            self._messages = (self._messages + data)[-_MESSAGES:]
        return True

    def wait(self, seconds: float) -> int | None:
        """
        Wait for its end; return the exit code, or None if it still runs.

        :return: As :func:`os.waitstatus_to_exitcode` has it
        """
        deadline = time.monotonic() + seconds
        while self.status is None:
            try:
                pid, status = os.waitpid(self.pid, os.WNOHANG)
            except ChildProcessError:
                # another part of the launcher has waited for it
                pid, status = self.pid, 0
            if pid:
                self.status = status
                self.leave_to_guard()
            elif time.monotonic() >= deadline:
                return None
            else:
                time.sleep(0.005)
        return os.waitstatus_to_exitcode(self.status)

    def leave_to_guard(self) -> None:
        """End the watchdog, as the process has, or as the guard watches it."""
        # two threads may end a connection at once
        watch, self._watch = self._watch, -1
        if watch != -1:
            # forked processes may have the pipe open
            with suppress(OSError):
                os.write(watch, b'\n')
            os.close(watch)

    def end(self, timeout: float = _END_TIMEOUT) -> None:
        """
        Wait for its end, and stop it if that takes too long.

        :param timeout: For how long to wait before it is stopped (seconds)
        """
        if self.wait(timeout) is not None:
            return
        for number in (signal.SIGTERM, signal.SIGKILL):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.pid, number)
            if self.wait(_END_TIMEOUT) is not None:
                break

    def close(self, timeout: float = _END_TIMEOUT) -> None:
        """Close the pipes, and :meth:`end` it."""
        self.close_pipes()
        self.end(timeout)

    def close_input(self) -> None:
        """Close its input, so that what runs there ends."""
        if self.stdin != -1:
            os.close(self.stdin)
            self.stdin = -1

    def close_pipes(self) -> None:
        """Close the pipes, so that it ends by itself."""
        for name in ('stdin', 'stdout', 'stderr'):
            descriptor = getattr(self, name)
            if descriptor != -1:
                os.close(descriptor)
                setattr(self, name, -1)


def has_terminal() -> bool:
    """Return whether the user can be asked: our terminal is ours now."""
    with suppress(OSError), open(_TERMINAL, 'rb', 0) as terminal:
        return os.tcgetpgrp(terminal.fileno()) == os.getpgrp()
    return False


@contextmanager
def foreground(group: int) -> Iterator[None]:
    """Put a process group into the foreground meanwhile."""
    try:
        terminal = os.open(_TERMINAL, os.O_RDWR)
    except OSError:
        yield
        return
    # we are in the background when we take it back
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTTOU})
    try:
        with suppress(OSError):
            os.tcsetpgrp(terminal, group)
            # it may have asked before it had the terminal
            os.killpg(group, signal.SIGCONT)
        yield
    finally:
        with suppress(OSError):
            os.tcsetpgrp(terminal, os.getpgrp())
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        os.close(terminal)


def connect_command(
    machine: Machine,
    environment: Mapping[str, str],
    *,
    may_ask: bool = False,
    host: str | None = None,
) -> list[str]:
    """
    Return the command line that connects with a machine.

    :param environment: The variables of the launcher
    :param may_ask: Whether `ssh` may ask for a password, or whether a host
      key is trusted
    :param host: The node of Slurm that a part runs on already
    """
    if machine.kind == 'slurm':
        # the last options, those of the user, take precedence
        words = ['srun', '--nodes=1', '--ntasks=1', '--export=NONE']
        if _ALLOCATION in environment:
            # beside the step that the launcher may run in
            words.append('--overlap')
        words += machine.words
        if host is not None:
            words.append(f'--nodelist={host}')
        return [*words, '/bin/sh']
    if machine.kind == 'ssh':
        batch = () if may_ask else _BATCH
        return ['ssh', '-T', *batch, '--', *machine.words, 'sh']
    program, *words = machine.words
    if os.path.basename(program) == 'ssh' and not may_ask:
        words = [*_BATCH, *words]
    return [program, *words, 'sh']


def connect(
    machine: Machine,
    environment: Mapping[str, str],
    *,
    may_ask: bool = False,
    host: str | None = None,
    kept: bool = False,
) -> ConnectProcess:
    """
    Start the command that connects with a machine.

    The parameters are those of :func:`connect_command` and
    :class:`ConnectProcess`.

    :raises OSError: when it cannot be started
    """
    command = connect_command(machine, environment, may_ask=may_ask, host=host)
    if not may_ask:
        # nor may it open a window (ssh 8.4)
        environment = {**environment, 'SSH_ASKPASS_REQUIRE': 'never'}
    return ConnectProcess(command, environment, asks=may_ask, kept=kept)


def can_connect_again(
    machine: Machine, environment: Mapping[str, str]
) -> bool:
    """Return whether a new connection leads to the same machine."""
    # an allocation ends with the command that has made it
    return machine.kind != 'slurm' or _ALLOCATION in environment
