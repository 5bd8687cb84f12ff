# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The process that connects with a machine, and the pipes to it."""

from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
import os
import shutil
import signal
import time
from typing import Any

from colcon_yamllaunch.remote.connection.connection_keeper import KEEPER

#: Bytes of its standard error that are kept.
_MESSAGES = 8192
#: Bytes that the pipes hold, so that few calls carry much.
_PIPE = 1024 * 1024
_F_SETPIPE_SZ = 1031
#: Seconds that it gets to end by itself, as its input has ended.
_PATIENCE = 5.0
_READ = 64 * 1024


class ConnectProcess:
    """
    A command whose standard input and output lead to another machine.

    It gets neither keys nor signals of our terminal, as the launch is to end
    in order when somebody presses Ctrl-C.

    :param command: Its command line
    :param kept: Whether it is ended if the launcher is killed, see
      `connection_keeper`; a guard does so later
    :param asks: Whether it is to ask on the terminal; it must be given that
      then, see `foreground`, and its standard error is ours
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
        path = environment.get('PATH', os.defpath)
        program = shutil.which(command[0], path=path)
        if program is None:
            raise FileNotFoundError(2, os.strerror(2), command[0])
        its_input, self.stdin = os.pipe()
        self.stdout, its_output = os.pipe()
        self.stderr, its_errors = os.pipe()
        actions = [
            (os.POSIX_SPAWN_DUP2, its_input, 0),
            (os.POSIX_SPAWN_DUP2, its_output, 1),
        ]
        if not asks:
            actions.append((os.POSIX_SPAWN_DUP2, its_errors, 2))
        more: dict[str, Any] = {
            'setsigmask': (),
            'setsigdef': (signal.SIGINT, signal.SIGTERM, signal.SIGPIPE),
            **({'setpgroup': 0} if asks else {'setsid': True}),
        }
        try:
            if kept:
                self.pid = KEEPER.spawn(
                    program, command[1:], environment, actions, **more
                )
            else:
                self.pid = os.posix_spawn(
                    program,
                    list(command),
                    environment,
                    file_actions=actions,
                    **more,
                )
        except BaseException:
            self._close()
            raise
        finally:
            for descriptor in (its_input, its_output, its_errors):
                os.close(descriptor)
        for descriptor in (self.stdin, self.stdout):
            with suppress(OSError):
                _enlarge(descriptor)
        os.set_blocking(self.stderr, False)
        self._messages = b''
        #: Its wait status, once it has ended and was waited for.
        self.status: int | None = None

    @property
    def messages(self) -> str:
        """What it wrote last to standard error."""
        self.read_messages()
        return self._messages.decode(errors='replace')

    def read_messages(self) -> bool:
        """Read what it has written; return whether more may come."""
        with suppress(BlockingIOError):
            while self.stderr != -1:
                try:
                    data = os.read(self.stderr, _READ)
                except BlockingIOError:
                    raise
                except OSError:
                    data = b''
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
            with suppress(ChildProcessError):
                pid, status = os.waitpid(self.pid, os.WNOHANG)
                if pid:
                    self.status = status
                    self.leave_to_guard()
                    break
                if time.monotonic() >= deadline:
                    return None
                time.sleep(0.005)
                continue
            self.status = 0
            self.leave_to_guard()
        return os.waitstatus_to_exitcode(self.status)

    def leave_to_guard(self) -> None:
        """Have it ended no more if the launcher is killed."""
        KEEPER.release(self.pid)

    def end(self, patience: float = _PATIENCE) -> None:
        """
        Wait for its end, and see to that in the end.

        :param patience: Seconds that it gets to end by itself
        """
        if self.wait(patience) is not None:
            return
        for number in (signal.SIGTERM, signal.SIGKILL):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.pid, number)
            if self.wait(_PATIENCE) is not None:
                break

    def close(self, patience: float = _PATIENCE) -> None:
        """
        End it, and wait for that.

        :param patience: Seconds that it gets to end by itself
        """
        self._close()
        self.end(patience)

    def close_input(self) -> None:
        """Close its input, so that what runs there ends."""
        if self.stdin != -1:
            os.close(self.stdin)
            self.stdin = -1

    def close_pipes(self) -> None:
        """Close the pipes, so that it ends by itself."""
        self._close()

    def disown(self) -> None:
        """Have nothing to do with it, in a fork of this process."""
        self._close()

    def _close(self) -> None:
        for name in ('stdin', 'stdout', 'stderr'):
            descriptor = getattr(self, name)
            if descriptor != -1:
                os.close(descriptor)
                setattr(self, name, -1)


def _enlarge(descriptor: int) -> None:
    import fcntl

    fcntl.fcntl(descriptor, _F_SETPIPE_SZ, _PIPE)
