# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The process that watches files for a launch, and the pipes to it."""

from collections.abc import Callable
from collections.abc import Iterable
from contextlib import suppress
import importlib.util
import json
import os
from pathlib import Path
import select
import signal
import sys
from typing import Any

from colcon_yamllaunch.runtime.core import limits
from colcon_yamllaunch.runtime.streams.watches import Watches
from colcon_yamllaunch.watch.changes import Batch
from colcon_yamllaunch.watch.changes import Change

#: What brings the library that watches.
INSTALL = "pip install 'colcon-yamllaunch[watch]'"
#: What to say without it.
MISSING = f"--watch needs the Python package 'watchfiles': {INSTALL}"
#: What the process runs.
PROGRAM = 'colcon_yamllaunch.watch.watcher'

_LIBRARY = 'watchfiles'
#: So that it finds the modules that we find, and none in the current folder.
_START = 'import sys; sys.path[:] = {!r}; from {} import main; main()'


def is_installed() -> bool:
    """Tell whether the library is there that watches."""
    return importlib.util.find_spec(_LIBRARY) is not None


class WatcherLink:
    """
    The watching process of a launch.

    It is started again when it ends, up to some times in a row.

    :param watches: What waits for what it says
    :param take: Is called with changes
    :param warn: Is called with what the user should know about the watching
    :param clock: Returns seconds that never go back
    :param log: The file for its standard error, or None
    """

    def __init__(
        self,
        watches: Watches,
        take: Callable[[Batch], None],
        warn: Callable[[str], None],
        clock: Callable[[], float],
        log: Path | None = None,
    ) -> None:
        self._watches = watches
        self._take = take
        self._warn = warn
        self._clock = clock
        self._log = log
        #: The process, or 0 while there is none.
        self.pid = 0
        self._input = self._output = -1
        self._unsent = self._unread = b''
        self._request: dict[str, Any] | None = None
        self._heard = 0
        self._begun = 0.0
        self._ends = 0
        self._due: float | None = None

    def start(self) -> None:
        """Start the process; it comes up while the caller goes on."""
        self._due = None
        self._begun = self._clock()
        its_input, self._input = os.pipe()
        self._output, its_output = os.pipe()
        error = self._open_log()
        code = _START.format([path for path in sys.path if path], PROGRAM)
        try:
            self.pid = os.posix_spawn(
                sys.executable,
                # it is told where modules are
                [sys.executable, '-S', '-c', code],
                os.environ,
                file_actions=[
                    (os.POSIX_SPAWN_DUP2, its_input, 0),
                    (os.POSIX_SPAWN_DUP2, its_output, 1),
                    (os.POSIX_SPAWN_DUP2, error, 2),
                ],
                # Ctrl-C is not for it
                setpgroup=0,
                setsigmask=(),
                setsigdef=(signal.SIGPIPE,),
            )
        except OSError as e:
            self._close_pipes()
            self._lost(f'could not be started: {e.strerror}')
            return
        finally:
            for descriptor in (its_input, its_output, error):
                os.close(descriptor)
        os.set_blocking(self._input, False)
        os.set_blocking(self._output, False)
        self._watches.add(self._output, self._readable)
        self._watches.add(self._input, lambda _: self._write(), 0)
        if self._request is not None:
            self._send()

    def watch(
        self, folders: Iterable[str], files: Iterable[str], since: int
    ) -> None:
        """
        Watch folders and files from now on, and no others.

        :param since: What was written after that is told as changed, if it was
          not watched before (nanoseconds since the epoch)
        """
        self._request = {
            'folders': list(folders),
            'files': list(files),
            'since': since,
        }
        self._send()

    def advance(self) -> None:
        """Start the process again when that is due."""
        if self._due is not None and self._due <= self._clock():
            self.start()

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until :meth:`advance` is to be called again."""
        if self._due is None:
            return None
        return max(0.0, self._due - self._clock())

    def close(self) -> None:
        """End the process."""
        self._due = None
        self._close_pipes()
        if self.pid:
            with suppress(ProcessLookupError):
                # it has nothing to put in order
                os.kill(self.pid, signal.SIGKILL)
            with suppress(ChildProcessError):
                os.waitpid(self.pid, 0)
        self.pid = 0

    def _lost(self, reason: str) -> None:
        """Take into account that there is no process, and what follows."""
        if self._clock() - self._begun > limits.CLIENT_STEADY:
            self._ends = 0
        self._ends += 1
        if self._ends > limits.CLIENT_RESTARTS:
            self._warn(
                f'the process that watches files {reason}: nothing is watched '
                'any more' + self._last_words()
            )
            return
        pause = limits.SHORTEST_PAUSE * 2.0 ** (self._ends - 1)
        self._due = self._clock() + pause
        if self._request is not None and self._heard:
            # what happens meanwhile is told by the next one
            self._request['since'] = self._heard

    def _last_words(self) -> str:
        if self._log is None:
            return ''
        with suppress(OSError):
            text = self._log.read_bytes()[-limits.TAIL_BYTES :]
            lines = text.decode(errors='replace').split('\n')
            last = next((s for s in reversed(lines) if s.strip()), '')
            return f' ({last.strip()}; see {self._log})' if last else ''
        return ''

    def _open_log(self) -> int:
        if self._log is not None:
            with suppress(OSError):
                flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC
                return os.open(self._log, flags, 0o666)
        return os.open(os.devnull, os.O_WRONLY | os.O_CLOEXEC)

    def _close_pipes(self) -> None:
        for descriptor in (self._input, self._output):
            if descriptor != -1:
                self._watches.remove(descriptor)
                os.close(descriptor)
        self._input = self._output = -1
        self._unsent = self._unread = b''

    def _send(self) -> None:
        if self._input != -1:
            self._unsent += json.dumps(self._request).encode() + b'\n'
            self._write()

    def _write(self) -> None:
        try:
            while self._unsent:
                count = os.write(self._input, self._unsent)
                self._unsent = self._unsent[count:]
        except BlockingIOError:
            pass
        except OSError:
            # its end is noticed soon
            self._unsent = b''
        self._watches.change(
            self._input, select.EPOLLOUT if self._unsent else 0
        )

    def _readable(self, _: int) -> None:
        try:
            data = os.read(self._output, limits.READ_SIZE)
        except BlockingIOError:
            return
        if not data:
            self.close()
            self._lost('ended')
            return
        *lines, self._unread = (self._unread + data).split(b'\n')
        for line in lines:
            self._take_line(line)

    def _take_line(self, line: bytes) -> None:
        message = json.loads(line)
        changes = tuple(Change(*fields) for fields in message['changes'])
        self._heard = message['at']
        for note in message['notes']:
            self._warn(note)
        if changes:
            self._take(Batch(changes, message['seen']))
