# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One build at a time in a workspace."""

from collections.abc import Callable
from collections.abc import Iterator
from contextlib import contextmanager
import fcntl
import os
from pathlib import Path
from typing import IO

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.building.orphan_builds import end_orphans

#: The name of the lock file, below the build folder.
LOCK_NAME = '.colcon_launch.lock'
#: What the user is told while another one builds.
WAITING = 'waiting for another build in this workspace'
#: How much of what the other one builds is told (characters).
_SHOWN = 200


class BuildLock:
    """
    The lock of a workspace, while it is held.

    :param waited: Whether another process held it before
    """

    def __init__(self, handle: IO[str], waited: bool) -> None:
        self._handle = handle
        self.waited = waited
        self.tell('checks what is to be built')

    def tell(self, what: str) -> None:
        """Let those who wait know what this process does."""
        self.clear()
        self._handle.write(f'{os.getpid()} {what[:_SHOWN]}')
        self._handle.flush()

    def clear(self) -> None:
        """Leave no trace of this process."""
        self._handle.seek(0)
        self._handle.truncate()


@contextmanager
def build_lock(
    build_base: Path, announce: Callable[[str], None]
) -> Iterator[BuildLock]:
    """
    Keep other launches from building in a workspace at the same time.

    The lock ends with the process at the latest, however it ends.

    :param build_base: The build folder of the workspace; made if necessary
    :param announce: Is called with one line if there is something to wait for
    :raises WorkspaceError: when the folder cannot be written to
    """
    try:
        build_base.mkdir(parents=True, exist_ok=True)
        handle = (build_base / LOCK_NAME).open('a+', encoding='utf-8')
    except OSError as e:
        raise WorkspaceError(
            f'cannot build in {build_base}: {e.strerror}. Make it writable, '
            'or give --no-build'
        ) from e
    with handle:
        waited = False
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            waited = True
            announce(_waiting(handle))
            fcntl.flock(handle, fcntl.LOCK_EX)
        handle.seek(0)
        if handle.read(1):
            # who held it before was killed
            end_orphans(build_base, announce)
        lock = BuildLock(handle, waited)
        yield lock
        lock.clear()


def _waiting(handle: IO[str]) -> str:
    handle.seek(0)
    pid, _, what = handle.read(2 * _SHOWN).partition(' ')
    if not pid.isdecimal() or not what:
        return WAITING
    return f'{WAITING}: process {pid} {what}…'
