# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What ends connections that a killed launcher leaves.

`ssh` that waits for a machine which says nothing does not notice that nobody
reads it any more. Before a launch runs there is no guard that would end it, so
a shell does, which gets the process ids and waits for the launcher's end.
"""

from contextlib import suppress
import os
import signal
import threading

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


class ConnectionKeeper:
    """Ends process groups if this process ends before they do."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._pid = 0
        self._pipe = -1
        self._kept: set[int] = set()

    def keep(self, pid: int) -> None:
        """Have the group of a process ended."""
        with self._lock:
            if not self._pid:
                self._start()
            self._kept.add(pid)
            self._write(f'+ {pid}\n')

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
