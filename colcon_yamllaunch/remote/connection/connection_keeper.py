# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What ends connections that a killed launcher leaves.

`ssh` that waits for a machine which says nothing does not notice that nobody
reads it any more. Before a launch runs there is no guard that would end it, so
a shell does, which gets the process ids and waits for the launcher's end.
"""

from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import suppress
import os
import signal
import threading
from typing import Any

#: Reads lines `+ PID` and `- PID`; at their end it stops the groups that are
#: left. A line `.` ends it, as processes that were forked may have the pipe
#: open. SIGTERM comes first, as `ssh` leaves a terminal in order then.
_SCRIPT = """\
pids=' '
while read -r sign pid; do
  case $sign in
    +) pids="$pids$pid " ;;
    -) pids="${pids%% $pid *} ${pids#* $pid }" ;;
    .) exit ;;
  esac
done
for pid in $pids; do kill -s TERM -- "-$pid"; done 2>/dev/null
sleep 2
for pid in $pids; do kill -s KILL -- "-$pid"; done 2>/dev/null
"""
_SHELL = '/bin/sh'
#: Registers a process before it becomes its program, so that there is no
#: moment at which only the launcher knows it.
_REGISTER = """\
trap '' PIPE
echo "+ $$" >&3
exec 3>&-
trap - PIPE
exec "$@"
"""


class ConnectionKeeper:
    """Ends process groups if this process ends before they do."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._pid = 0
        self._pipe = -1
        self._kept: set[int] = set()

    def spawn(
        self,
        program: str,
        arguments: Sequence[str],
        environment: Mapping[str, str],
        file_actions: Sequence[tuple[int, int, int]],
        **more: Any,
    ) -> int:
        """
        Start a process whose group is ended, and return its id.

        :param more: Further arguments of :func:`os.posix_spawn`
        :raises OSError: when it cannot be started
        """
        with self._lock:
            if not self._pid:
                self._start()
            pid = os.posix_spawn(
                _SHELL,
                [_SHELL, '-c', _REGISTER, _SHELL, program, *arguments],
                environment,
                file_actions=[
                    *file_actions,
                    (os.POSIX_SPAWN_DUP2, self._pipe, 3),
                ],
                **more,
            )
            self._kept.add(pid)
            return pid

    def release(self, pid: int) -> None:
        """Leave a process alone, as it has ended and was waited for."""
        with self._lock:
            if pid not in self._kept:
                return
            self._kept.remove(pid)
            self._write(f'- {pid}\n')
            if not self._kept:
                self._end()

    def _start(self) -> None:
        its_end, self._pipe = os.pipe()
        null = os.open(os.devnull, os.O_WRONLY | os.O_CLOEXEC)
        try:
            self._pid = os.posix_spawn(
                _SHELL,
                [_SHELL, '-c', _SCRIPT],
                {'PATH': os.environ.get('PATH', os.defpath)},
                file_actions=[
                    (os.POSIX_SPAWN_DUP2, its_end, 0),
                    (os.POSIX_SPAWN_DUP2, null, 1),
                    (os.POSIX_SPAWN_DUP2, null, 2),
                ],
                # neither Ctrl-C nor a signal to our group is meant for it
                setsid=True,
                setsigmask=(),
                setsigdef=(signal.SIGPIPE,),
            )
        finally:
            os.close(its_end)
            os.close(null)

    def _write(self, line: str) -> None:
        # somebody may have killed it
        with suppress(OSError):
            os.write(self._pipe, line.encode())

    def _end(self) -> None:
        self._write('.\n')
        os.close(self._pipe)
        pid, self._pid, self._pipe = self._pid, 0, -1
        with suppress(ChildProcessError):
            os.waitpid(pid, 0)


#: The one of this process.
KEEPER = ConnectionKeeper()
