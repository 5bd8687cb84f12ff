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
import signal
import sys
from typing import Any

from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.output.json_pipes import JsonPipes
from colcon_yamllaunch.engine.process.restarts import Restarts
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


class WatcherClient:
    """
    The watching process of a launch.

    It is started again when it ends, up to some times in a row.

    :param loop: Waits for what it says
    :param take: Is called with changes
    :param warn: Is called with what the user should know about the watching
    :param log: The file for its standard error, or None
    """

    def __init__(
        self,
        loop: Loop,
        take: Callable[[Batch], None],
        warn: Callable[[str], None],
        log: Path | None = None,
    ) -> None:
        self._pipes = JsonPipes(loop, self._read, log)
        self._take = take
        self._warn = warn
        self._restarts = Restarts(loop, self.start)
        #: The process, or 0 while there is none.
        self.pid = 0
        self._is_wanted = True
        self._request: dict[str, Any] | None = None
        self._heard = 0

    def start(self) -> None:
        """Start the process; it comes up while the caller goes on."""
        self._restarts.begin()
        streams = self._pipes.open()
        code = _START.format([path for path in sys.path if path], PROGRAM)
        try:
            self.pid = os.posix_spawn(
                sys.executable,
                # it is told where modules are
                [sys.executable, '-S', '-c', code],
                os.environ,
                file_actions=[
                    (os.POSIX_SPAWN_DUP2, descriptor, standard)
                    for standard, descriptor in enumerate(streams)
                ],
                # Ctrl-C is not for it
                setpgroup=0,
                setsigmask=(),
                setsigdef=(signal.SIGPIPE,),
            )
        except OSError as e:
            self._pipes.close()
            self._lost(f'could not be started: {e.strerror}')
            return
        finally:
            for descriptor in streams:
                os.close(descriptor)
        if self._request is not None:
            self._pipes.send(self._request)

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
        self._pipes.send(self._request)

    def ended(self, outcome: Outcome) -> None:
        """Take into account that the process ended."""
        self.pid = 0
        # what it said last counts
        self._read()
        self._pipes.close()
        if self._is_wanted:
            self._lost(str(outcome))

    def hang_up(self) -> None:
        """Have the process end, as nothing is to follow from changes."""
        self._restarts.cancel()
        self._is_wanted = False
        self._pipes.close()

    def close(self) -> None:
        """End the process."""
        self.hang_up()
        if self.pid:
            self._kill()
            with suppress(ChildProcessError):
                os.waitpid(self.pid, 0)
        self.pid = 0

    def _lost(self, reason: str) -> None:
        """Take into account that there is no process, and what follows."""
        if not self._restarts.plan():
            self._warn(
                f'the process that watches files {reason}: nothing is watched '
                'any more' + self._last_words()
            )
            return
        if self._request is not None and self._heard:
            # what happens meanwhile is told by the next one
            self._request['since'] = self._heard

    def _last_words(self) -> str:
        last = self._pipes.last_line()
        return f' ({last})' if last else ''

    def _kill(self) -> None:
        with suppress(ProcessLookupError):
            # it has nothing to put in order
            os.kill(self.pid, signal.SIGKILL)

    def _read(self) -> None:
        for line in self._pipes.read():
            self._take_line(line)
        if self._pipes.is_at_end and self.pid:
            self._kill()

    def _take_line(self, line: bytes) -> None:
        message = json.loads(line)
        changes = tuple(Change(*fields) for fields in message['changes'])
        self._heard = message['at']
        for note in message['notes']:
            self._warn(note)
        if changes:
            self._take(Batch(changes, message['seen']))
