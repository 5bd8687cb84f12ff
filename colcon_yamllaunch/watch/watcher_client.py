# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The launcher's side of the process that watches files."""

from collections.abc import Callable
from collections.abc import Iterable
import importlib.util
import os
from pathlib import Path
import sys
from typing import Any

from colcon_yamllaunch.engine.helper_process import HelperProcess
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.spawn import spawn_process
from colcon_yamllaunch.watch.changes import Batch
from colcon_yamllaunch.watch.changes import Change

#: How to install the library that watches.
INSTALL = "pip install 'colcon-yamllaunch[watch]'"
#: The error without it.
MISSING = f"--watch needs the Python package 'watchfiles': {INSTALL}"
#: The module that the process runs.
PROGRAM = 'colcon_yamllaunch.watch.watcher'

_LIBRARY = 'watchfiles'
#: Finds the modules that the launcher finds, and none in the current folder.
_START = 'import sys; sys.path[:] = {!r}; from {} import main; main()'


def is_installed() -> bool:
    """Return whether the library that watches is installed."""
    return importlib.util.find_spec(_LIBRARY) is not None


class WatcherClient:
    """
    The watcher of a launch.

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
        self._process = HelperProcess(
            loop, self._spawn, self._receive, self._lost, log
        )
        self._take = take
        self._warn = warn
        self._request: dict[str, Any] = {}
        self._reported_at = 0

    def start(self) -> None:
        """Start the process, without waiting until it watches."""
        self._process.start()

    def watch(
        self, folders: Iterable[str], files: Iterable[str], since: int
    ) -> None:
        """
        Watch folders and files from now on, and no others.

        :param since: Files that were not watched before and were written
          after this time count as changed (nanoseconds since the epoch)
        """
        self._request = {
            'folders': list(folders),
            'files': list(files),
            'since': since,
        }
        self._process.send(self._request)

    def hang_up(self) -> None:
        """Let the process end, and do not start it again."""
        self._process.stop()

    def close(self) -> None:
        """End the process, and wait for that."""
        self._process.close()

    def _spawn(self, streams: tuple[int, int, int]) -> int:
        code = _START.format([path for path in sys.path if path], PROGRAM)
        # the code sets the path, so the site module is not needed
        argv = [sys.executable, '-S', '-c', code]
        pid = spawn_process(argv, os.environ, '/', streams)
        if self._request:
            self._process.send(self._request)
        return pid

    def _lost(self, reason: str, _was_killed: bool) -> None:
        if not self._process.restart_later():
            last = self._process.last_line()
            details = f' ({last})' if last else ''
            self._warn(
                f'the process that watches files {reason}: nothing is watched '
                f'any more{details}'
            )
        elif self._request and self._reported_at:
            # the next process reports what happens meanwhile
            self._request['since'] = self._reported_at

    def _receive(self, message: dict[str, Any]) -> None:
        self._reported_at = message['at']
        for note in message['notes']:
            self._warn(note)
        changes = tuple(Change(*fields) for fields in message['changes'])
        if changes:
            self._take(Batch(changes, message['seen']))
