# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launcher's side of the guard."""

import os
from pathlib import Path
import signal
import sys

from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.runtime.core import limits

# -c, as a file that is run has to be compiled anew each time. Its words do not
# name us: `pkill -9 -f colcon` ends the launcher and leaves the guard to stop
# the processes.
_PROGRAM = (
    'import os, sys; sys.path.append(os.environ["FOLDER"]); '
    '__import__(os.environ["GUARD"], fromlist=["main"]).main()'
)
_MODULE = 'colcon_yamllaunch.runtime.stopping.guard'
_BLOCKED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


class GuardLink:
    """
    A guard, and the pipe to it.

    :param identity: The identity of the launch
    """

    def __init__(self, identity: str) -> None:
        self._identity = identity
        self._lines: dict[int | str, str] = {}
        self._pending = b''
        self._pipe = -1
        self._restarts = 0
        #: The process id of the guard, or 0 while there is none.
        self.pid = 0

    def start(self) -> None:
        """
        Start the guard; it comes up while the caller goes on.

        :raises OSError: when it cannot be started
        """
        reader, self._pipe = os.pipe()
        try:
            self.pid = _spawn(reader, self._identity)
        except OSError:
            os.close(self._pipe)
            self._pipe = -1
            raise
        finally:
            os.close(reader)
        os.set_blocking(self._pipe, False)
        self._pending = ''.join(self._lines.values()).encode(
            errors='surrogateescape'
        )
        self._write()

    def restart(self) -> bool:
        """
        Start another guard after this one ended.

        Return whether there is one; after some there is no other.

        :raises OSError: when it cannot be started
        """
        self._close()
        self._restarts += 1
        if self._restarts > limits.GUARD_RESTARTS:
            return False
        self.start()
        return True

    def started(self, number: int, group: int, timeouts: Timeouts) -> None:
        """
        Tell of a new process group, with the next :meth:`flush`.

        Until then the guard would find it by its mark.
        """
        line = (
            f'start {number} {group} {timeouts.sigterm} {timeouts.sigkill}\n'
        )
        self._lines[group] = line
        self._tell(line)

    def ended(self, group: int) -> None:
        """
        Tell that nothing runs in a process group any more.

        It is told with the next :meth:`flush`.
        """
        if self._lines.pop(group, None) is not None:
            self._tell(f'end {group}\n')

    def folder(self, path: Path) -> None:
        """Tell of a folder that is to be removed."""
        self._tell_at_once('folder', path)

    def socket(self, path: Path) -> None:
        """Tell of a socket that is to be removed."""
        self._tell_at_once('socket', path)

    def flush(self) -> None:
        """
        Tell what there is to tell.

        Once for several processes, as each wakes the guard up.
        """
        if self._pending and self._pipe != -1:
            self._write()

    def dismiss(self) -> None:
        """End the guard without any work for it."""
        if self.pid:
            # the guard has not been waited for, so the id is still its own
            os.kill(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)
        self._close()

    def abandon(self) -> None:
        """Leave the launch to the guard."""
        self.flush()
        self._close()

    def _tell_at_once(self, kind: str, path: Path) -> None:
        self._lines[kind] = line = f'{kind} {path}\n'
        self._tell(line)
        self.flush()

    def _tell(self, line: str) -> None:
        if self._pipe != -1:
            self._pending += line.encode(errors='surrogateescape')

    def _write(self) -> None:
        try:
            while self._pending:
                written = os.write(self._pipe, self._pending)
                self._pending = self._pending[written:]
        except (BlockingIOError, BrokenPipeError):
            # a guard that is slow hears the rest with the next line, one that
            # is gone is replaced when its end is noticed
            return

    def _close(self) -> None:
        if self._pipe != -1:
            os.close(self._pipe)
        self._pipe = -1
        self.pid = 0


def _spawn(reader: int, identity: str) -> int:
    root = str(Path(__file__).parents[3])
    null = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
    try:
        return os.posix_spawn(
            sys.executable,
            [
                sys.executable,
                *('-I', '-S', '-E', '-c'),
                _PROGRAM,
                identity,
                str(os.getsid(0)),
            ],
            {'FOLDER': root, 'GUARD': _MODULE},
            file_actions=[
                (os.POSIX_SPAWN_DUP2, reader, 0),
                (os.POSIX_SPAWN_DUP2, null, 1),
                (os.POSIX_SPAWN_DUP2, null, 2),
            ],
            setsid=True,
            setsigmask=_BLOCKED,
        )
    finally:
        os.close(null)
