# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launcher's side of the guard."""

from collections.abc import Mapping
from contextlib import suppress
import errno
import json
import os
from pathlib import Path
import signal
import socket
import sys
from typing import Any, Literal

from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.channels import as_numbers, writer_link
from colcon_yamllaunch.engine.own_files import OwnFile
from colcon_yamllaunch.plan.plan import IN_COMMON_LOG, Process

# -c, as a file that is run has to be compiled anew each time. Its words do not
# name us: `pkill -9 -f colcon` ends the launcher and leaves the guard to stop
# the processes.
_PROGRAM = (
    'import os, sys; sys.path.append(os.environ["FOLDER"]); '
    '__import__(os.environ["GUARD"], fromlist=["main"]).main()'
)
_MODULE = 'colcon_yamllaunch.engine.guard'
_BLOCKED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

#: A part of a message to the guard: an array, whose first item is its kind,
#: see `guard`; and at most one descriptor.
Frame = tuple[list[Any], int | None]


class GuardProcess:
    """
    A guard, and the socket to it.

    It is no `HelperProcess`: it receives descriptors, sends nothing, and must
    outlive the launcher.

    :param is_kept: Whether it guards further launches, one after the other
    """

    def __init__(self, *, is_kept: bool = False) -> None:
        self._is_kept = is_kept
        self._socket: socket.socket | None = None
        #: Its process id, or 0 before the first launch.
        self.pid = 0

    def begin(self, identity: str) -> socket.socket:
        """
        Guard a launch; it comes up while the caller goes on.

        :raises OSError: when it cannot be started
        """
        if self._socket is not None:
            with suppress(OSError):
                self._socket.send(identity.encode())
                return self._socket
            # it was killed; if that was between two launches, it is ours
            self.close()
            with suppress(ChildProcessError):
                os.waitpid(self.pid, os.WNOHANG)
        self._socket, its = socket.socketpair(
            socket.AF_UNIX, socket.SOCK_SEQPACKET
        )
        with its:
            try:
                self.pid = _spawn(its.fileno(), identity)
            except OSError:
                self.close()
                raise
        self._socket.setblocking(False)
        return self._socket

    def end(self) -> None:
        """End its work, as the launch has ended."""
        if self._is_kept and self._socket is not None:
            with suppress(OSError):
                self._socket.send(json.dumps([['dismissed']]).encode())
                return
        # it has not been waited for, so the id is still its own
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        self.close()

    def close(self) -> None:
        """Leave a launch that has not ended to the guard."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class GuardLink:
    """
    The guard of a launch, as the launcher sees it.

    :param process: The guard, by default one for this launch alone
    """

    def __init__(
        self, identity: str, process: GuardProcess | None = None
    ) -> None:
        self._identity = identity
        self._process = process or GuardProcess()
        # what holds now, which is sent to another guard
        self._state: dict[tuple[str, object], Frame] = {}
        self._pending: list[Frame] = []
        self._socket: socket.socket | None = None
        self._restarts = 0
        self._log_files: Mapping[str, Path] = {}
        self._common_log: Path | None = None
        #: The process id of the guard, or 0 while there is none.
        self.pid = 0

    def start(self) -> None:
        """
        Start the guard; it comes up while the caller goes on.

        :raises OSError: when it cannot be started
        """
        self._socket = self._process.begin(self._identity)
        self.pid = self._process.pid
        self._pending = list(self._state.values())
        self.flush()

    def restart(self) -> bool:
        """
        Start another guard after this one ended.

        Return whether there is one; after some there is no other.

        :raises OSError: when it cannot be started
        """
        self._process.close()
        self._forget()
        self._restarts += 1
        if self._restarts > limits.GUARD_RESTARTS:
            return False
        self.start()
        return True

    def logs(self, folder: Path, files: Mapping[str, Path]) -> None:
        """
        Record the logs that the guard continues.

        :param folder: The file for the lines of all processes
        :param files: For each label the file with both streams
        """
        self._common_log = folder
        self._log_files = files

    def started(self, number: int, group: int, timeouts: Timeouts) -> None:
        """
        Add a process group, with the next :meth:`flush`.

        Until then the guard would find it by its mark.
        """
        times = [timeouts.sigterm, timeouts.sigkill]
        self._send(('start', group), ['start', number, group, *times])

    def ended(self, group: int) -> None:
        """Remove a process group in which nothing runs any more."""
        self._revoke(('start', group), ['end', group])

    def output(
        self, number: int, process: Process, stream: str | None, reader: int
    ) -> None:
        """
        Hand over another descriptor of what a process writes to.

        As long as the guard has it, the process can write, even if the
        launcher is gone; then the guard reads. It goes with the next
        :meth:`flush`.

        :param stream: `stdout` or `stderr`, or None for what is echoed
        """
        files: list[str] = []
        common = None
        if stream is not None and self._common_log is not None:
            both = self._log_files.get(process.label)
            if both is not None:
                files = [f'{both.parent}/{stream}.log', str(both)]
            if process.output in IN_COMMON_LOG:
                common = str(self._common_log)
        self._send(
            ('output', reader),
            ['output', reader, number, process.label, files, common],
            reader,
        )

    def writers(self) -> dict[str, int]:
        """
        Return which process of the plan writes to each pipe or terminal.

        :returns: The numbers of the processes by the link that /proc/PID/fd
          shows for their end
        """
        return {
            writer_link(frame[1]) or '': frame[2]
            for frame, _ in self._state.values()
            if frame[0] == 'output'
        }

    def closed(self, reader: int) -> None:
        """Withdraw a descriptor that is being closed."""
        key = 'output', reader
        frame = self._state.get(key)
        if frame is not None and frame in self._pending:
            # its number may be that of something else when it is sent
            self._pending.remove(frame)
            del self._state[key]
        else:
            self._revoke(key, ['closed', reader])

    def adopted(self, pid: int, birth: int, number: int) -> None:
        """
        Add a process that lost its parent, with the next :meth:`flush`.

        If the launcher is gone, nothing shows that it belongs to the launch.
        """
        self._send(('adopted', pid), ['adopted', pid, birth, number])

    def terminal(
        self, descriptor: int, modes: tuple[list[Any], list[Any]] | None
    ) -> None:
        """
        Hand over a terminal that has something of ours below the cursor.

        :param modes: The modes that it had before us and those that it has
          now, as :mod:`termios` has them, or None if these are the same
        """
        before, now = (None, None) if modes is None else map(as_numbers, modes)
        frame = ['terminal', before, now]
        self._send(('terminal', None), frame, descriptor)
        self.flush()

    def typing(self, is_typing: bool) -> None:
        """Note whether the cursor is below where the output ends."""
        if is_typing:
            self._send(('typing', None), ['typing', True])
        else:
            self._revoke(('typing', None), ['typing', False])
        self.flush()

    def no_terminal(self) -> None:
        """Withdraw the terminal, as its modes are restored."""
        self._revoke(('terminal', None), ['no terminal'])
        self.flush()

    def reaped(self, pid: int) -> None:
        """Record that a process that lost its parent has ended."""
        self._state.pop(('adopted', pid), None)

    def remove_later(
        self, kind: Literal['socket', 'folder', 'record'], file: OwnFile
    ) -> None:
        """
        Register a file or folder to be removed if the launcher is killed.

        A socket is removed first of all, then the folder with the parameter
        files, and a record of the launch last.
        """
        frame = [kind, file.path, file.device, file.inode]
        self._send((kind, file.path), frame)
        self.flush()

    def lease(self, seconds: float | None) -> None:
        """
        Renew the lease of the launch; without `seconds`, it has none.

        The guard stops a launch whose lease has expired, also if the launcher
        hangs.
        """
        if seconds is not None:
            self._send(('lease', None), ['lease', seconds])
        else:
            self._revoke(('lease', None), ['lease', None])
        self.flush()

    def flush(self) -> None:
        """
        Send what the guard does not know yet.

        Once for several processes, as each message wakes the guard up.
        """
        count = limits.GUARD_MESSAGE_FRAMES
        while self._pending and self._socket is not None:
            frames = self._pending[:count]
            data = json.dumps([frame for frame, _ in frames]).encode()
            descriptors = [d for _, d in frames if d is not None]
            try:
                socket.send_fds(self._socket, [data], descriptors)
            except OSError as error:
                if error.errno == errno.EMSGSIZE and count > 1:
                    count //= 2
                    continue
                if error.errno not in _LATER:
                    # it is gone, and replaced when its end is noticed
                    self._pending.clear()
                return
            del self._pending[: len(frames)]

    def dismiss(self) -> None:
        """End the guard without any work for it."""
        if self._socket is not None:
            self._process.end()
        self._forget()

    def abandon(self) -> None:
        """Leave the launch to the guard."""
        if self._socket is not None:
            self.flush()
            self._process.close()
        self._forget()

    def _send(
        self,
        key: tuple[str, object],
        frame: list[Any],
        descriptor: int | None = None,
    ) -> None:
        self._state[key] = frame, descriptor
        if self._socket is not None:
            self._pending.append(self._state[key])

    def _revoke(self, key: tuple[str, object], frame: list[Any]) -> None:
        known = self._state.pop(key, None)
        if known is not None and self._socket is not None:
            self._pending.append((frame, None))

    def _forget(self) -> None:
        self._socket = None
        self._pending.clear()
        self.pid = 0


# it has not taken what was sent before
_LATER = (errno.EAGAIN, errno.ENOBUFS, errno.ENOMEM, errno.ETOOMANYREFS)


def _spawn(connection: int, identity: str) -> int:
    root = str(Path(__file__).parents[2])
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
                (os.POSIX_SPAWN_DUP2, connection, 0),
                (os.POSIX_SPAWN_DUP2, null, 1),
                (os.POSIX_SPAWN_DUP2, null, 2),
            ],
            setsid=True,
            setsigmask=_BLOCKED,
        )
    finally:
        os.close(null)
