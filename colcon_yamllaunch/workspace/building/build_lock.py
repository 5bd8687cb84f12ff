# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One build at a time in a workspace."""

from collections.abc import Callable
from collections.abc import Iterator
from contextlib import contextmanager
from contextlib import suppress
import errno
import fcntl
import os
from pathlib import Path

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.workspace.building.orphan_builds import end_orphans

#: The name of the lock file, below the build folder.
LOCK_NAME = '.colcon_launch.lock'
#: What the user is told while another one builds.
WAITING = 'waiting for another build in this workspace'
#: How much of what the other one builds is told (characters).
_SHOWN = 200
#: Where nobody can build, and what is up to date stays so.
_NOT_WRITABLE = frozenset(
    (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM)
)


class BuildLock:
    """
    The lock of a workspace, while it is held.

    :param build_base: The build folder of the workspace
    :param descriptor: The lock file, or -1 where it cannot be opened: then
      nobody can build, and nothing is locked
    :param waited: Whether another process held it before
    :param problem: Why nothing can be built, if so
    """

    def __init__(
        self,
        build_base: Path,
        descriptor: int,
        waited: bool,
        problem: OSError | None = None,
    ) -> None:
        self._build_base = build_base
        self._descriptor = descriptor
        self._problem = problem
        self.waited = waited
        # nothing is to be built yet, so a full disk does not matter
        with suppress(WorkspaceError):
            self.tell('checks what is to be built')

    def tell(self, what: str) -> None:
        """
        Let those who wait know what this process does.

        :raises WorkspaceError: when nothing can be built
        """
        try:
            if self._problem is not None:
                raise self._problem
            self.clear()
            text = f'{os.getpid()} {what[:_SHOWN]}'
            os.pwrite(self._descriptor, text.encode(), 0)
        except OSError as e:
            raise _refusal(self._build_base, e) from e

    def clear(self) -> None:
        """Leave no trace of this process."""
        if self._descriptor != -1:
            os.ftruncate(self._descriptor, 0)


@contextmanager
def build_lock(
    build_base: Path, announce: Callable[[str], None]
) -> Iterator[BuildLock]:
    """
    Keep other launches from building in a workspace at the same time.

    The lock ends with the process at the latest, however it ends. Where the
    disk is full or read-only, there is none, and nothing can be built.

    :param build_base: The build folder of the workspace; made if necessary
    :param announce: Is called with one line if there is something to wait for
    :raises WorkspaceError: when there cannot be a build folder
    """
    try:
        build_base.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(build_base / LOCK_NAME, os.O_RDWR | os.O_CREAT)
    except OSError as e:
        if e.errno not in _NOT_WRITABLE:
            raise _refusal(build_base, e) from e
        yield BuildLock(build_base, -1, False, e)
        return
    try:
        waited = False
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            waited = True
            announce(_waiting(descriptor))
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        if os.pread(descriptor, 1, 0):
            # who held it before was killed
            end_orphans(build_base, announce)
        lock = BuildLock(build_base, descriptor, waited)
        yield lock
        lock.clear()
    finally:
        os.close(descriptor)


def _refusal(build_base: Path, error: OSError) -> WorkspaceError:
    return WorkspaceError(
        f'cannot build in {build_base}: {error.strerror}. Make it writable, '
        'or give --no-build'
    )


def _waiting(descriptor: int) -> str:
    text = os.pread(descriptor, 4 * _SHOWN, 0).decode(errors='replace')
    pid, _, what = text.partition(' ')
    if not pid.isdecimal() or not what:
        return WAITING
    return f'{WAITING}: process {pid} {what}…'
