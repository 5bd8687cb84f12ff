# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One build at a time in a workspace."""

from collections.abc import Callable
from collections.abc import Iterator
from contextlib import contextmanager
import fcntl
from pathlib import Path

from colcon_yamllaunch.workspace.error import WorkspaceError

#: The name of the lock file, below the build folder.
LOCK_NAME = '.colcon_launch.lock'
#: What the user is told while another one builds.
WAITING = 'waiting for another colcon launch in this workspace…'


@contextmanager
def build_lock(
    build_base: Path, announce: Callable[[str], None]
) -> Iterator[None]:
    """
    Keep other launches from building in a workspace at the same time.

    The lock ends with the process at the latest, however it ends.

    :param build_base: The build folder of the workspace; made if necessary
    :param announce: Is called with one line if there is something to wait for
    :raises WorkspaceError: when the folder cannot be written to
    """
    try:
        build_base.mkdir(parents=True, exist_ok=True)
        handle = (build_base / LOCK_NAME).open('a')
    except OSError as e:
        raise WorkspaceError(
            f'cannot build in {build_base}: {e.strerror}. Make it writable, '
            'or launch with --no-build'
        ) from e
    with handle:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            announce(WAITING)
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
