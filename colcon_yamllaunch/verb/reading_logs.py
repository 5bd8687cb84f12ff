# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`--logs`: show the logs of a running launch."""

from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise
import os
from pathlib import Path
import sys
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import say, show_bytes
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.control.client import ControlError, LaunchEndedError
from colcon_yamllaunch.control.selection import Candidate
from colcon_yamllaunch.engine.lines import (
    legible,
    LineBuffer,
    normalised,
    prefixed,
)
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.observers.log_files import with_rotated

#: Lines of each process that are shown before those to come, as by tail(1).
LINES = 10
#: Seconds between two reads of what is more.
POLL_INTERVAL = 0.1
#: Seconds between two questions whether the launch still runs.
ASK_INTERVAL = 1.0

_CHUNK = 1 << 16
_TAIL = 1 << 16
#: How often to look for the next part while parts are being renamed.
_ROTATION_TRIES = 10


def show_logs(
    chosen: Candidate, processes: Sequence[ProcessState], *, follow: bool
) -> int:
    """
    Show the logs of processes, and return the exit code.

    :param follow: Whether to show the last lines only, and then new ones
      until the launch ends
    :raises UserError: when there are no logs
    """
    state = chosen.state
    if state.log_folder is None:
        raise UserError(
            f'{state.title} writes no logs; it does in a workspace, and '
            'where --log-base names a folder'
        )
    logs = [
        LogReader(p.label if len(processes) > 1 else None, Path(p.log))
        for p in processes
        if p.log is not None
    ]
    without = ', '.join(p.label for p in processes if p.log is None)
    if without and not logs:
        raise UserError(
            f'{without}: no log of its own, as the launch file says '
            "'output: screen'; with 'output: both' it has one"
        )
    if without:
        say(f'colcon launch: no log of its own: {without}')
    if follow:
        for log in logs:
            log.skip_to_tail()
    for log in logs:
        log.show()
    if follow:
        _follow(chosen, logs)
    for log in logs:
        log.finish()
    return 0


class LogReader:
    """
    The log of a process, followed by its name as `tail -F` does.

    Other than there, all parts that were rotated are read, the oldest first.

    :param label: What its lines begin with, or None for nothing
    :param path: The log; it need not exist yet
    """

    def __init__(self, label: str | None, path: Path) -> None:
        shown = '' if label is None else f'[{one_line(label)}] '
        self._prefix = shown.encode(errors='replace')
        self._path = path
        self._descriptor = -1
        self._lines = LineBuffer()
        self._open(self._parts()[0])

    def skip_to_tail(self) -> None:
        """Begin with the last lines."""
        self._close()
        self._open(self._path)
        if self._descriptor == -1:
            return
        end = os.fstat(self._descriptor).st_size
        start = max(0, end - _TAIL)
        data = os.pread(self._descriptor, end - start, start)
        tail = b''.join(data.splitlines(keepends=True)[-LINES:])
        os.lseek(self._descriptor, end - len(tail), os.SEEK_SET)

    def show(self) -> None:
        """Show what there is; another file of the same name goes on."""
        self._read()
        while self._has_changed():
            # what was written until it changed
            self._read()
            self._go_on()
            self._read()

    def finish(self) -> None:
        """Show the rest, also of a line that has not ended, and close."""
        self.show()
        self._print(self._lines.flush())
        self._close()

    def _read(self) -> None:
        if self._descriptor == -1:
            self._open(self._parts()[0])
        while self._descriptor != -1:
            data = os.read(self._descriptor, _CHUNK)
            if not data:
                return
            self._print(self._lines.feed(data))

    def _print(self, data: bytes) -> None:
        if data:
            terminal = sys.stdout.isatty()
            if terminal or self._prefix:
                data = legible(normalised(data), terminal)
                data = prefixed(data, self._prefix)
            show_bytes(data)

    def _has_changed(self) -> bool:
        if self._descriptor == -1:
            return False
        own = os.fstat(self._descriptor)
        try:
            now = os.stat(self._path)
        except OSError:
            return False
        if not os.path.samestat(own, now):
            return True
        position = os.lseek(self._descriptor, 0, os.SEEK_CUR)
        return now.st_size < position

    def _go_on(self) -> None:
        """Open the part that was written after this one."""
        own = self._descriptor
        for _ in range(_ROTATION_TRIES):
            following = self._following(own)
            self._open(following)
            # parts may get other names at any moment
            if self._descriptor != -1 and following == self._following(own):
                break
            self._close()
        os.close(own)

    def _following(self, descriptor: int) -> Path:
        own = os.fstat(descriptor)
        parts = self._parts()
        for part, following in pairwise(parts):
            with suppress(OSError):
                if os.path.samestat(part.stat(), own):
                    return following
        # it was deleted, so those that came before it were, too
        return self._path if own.st_nlink else parts[0]

    def _parts(self) -> list[Path]:
        """Return the parts of the log, the oldest first."""
        return with_rotated(self._path)

    def _open(self, path: Path) -> None:
        try:
            self._descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        except OSError:
            # the process has not been started yet
            self._descriptor = -1

    def _close(self) -> None:
        if self._descriptor != -1:
            os.close(self._descriptor)
            self._descriptor = -1


def _follow(chosen: Candidate, logs: Sequence[LogReader]) -> None:
    asked = time.monotonic()
    while True:
        time.sleep(POLL_INTERVAL)
        for log in logs:
            log.show()
        if time.monotonic() - asked > ASK_INTERVAL:
            asked = time.monotonic()
            try:
                chosen.launch.refresh()
            except LaunchEndedError:
                return
            except ControlError:
                # it is suspended, and may go on
                continue
