# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
One launch at a time that builds, sources and starts in a workspace.

Another one could pull the install space away in between, as a build with
other arguments begins by removing it.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
import errno
import fcntl
import os
from pathlib import Path
import time

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.process_scan import is_suspended, read_process
from colcon_yamllaunch.workspace.building.build_processes import end_orphans

#: The name of the lock file, below the build folder.
LOCK_NAME = '.colcon_launch.lock'
#: What the user is told while another one builds that is not known.
WAITING = 'waiting for another launch in this workspace'
#: How much is told of what the other one is and builds (characters).
_SHOWN = 200
#: How long it may take until who holds it has written its name (seconds).
_NAME_TIMEOUT = 1.0
#: How what it does begins when it builds.
_BUILDS = 'builds'
#: Where nobody can build, and what is up to date stays so.
_NOT_WRITABLE = (
    *(errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM),
)


class WorkspaceLock:
    """
    The lock of a workspace, which one process has at a time.

    It ends with the process at the latest, however that ends. One that is
    called by the process that holds it, by `$(command …)` for instance, does
    not wait, as that one waits for it.

    :param title: The command of this process, for those who wait
    """

    def __init__(self, title: str = '') -> None:
        self._title = _shown(title)
        self._build_base = Path()
        #: The open lock file; None where there can be none.
        self._descriptor: int | None = None
        #: Why nothing can be built, if so.
        self._problem: OSError | None = None
        self._is_held = False
        self._seen: int | None = None

    def __enter__(self) -> 'WorkspaceLock':
        return self

    def __exit__(self, kind: object, *error: object) -> None:
        # what a failed build has left is looked for by who takes it next
        self.release(clear=kind is None)

    def look(self, build_base: Path) -> None:
        """Remember when the lock was last acquired, for :meth:`acquire`."""
        self._seen = _last_acquired(build_base)

    def acquire(
        self, build_base: Path, announce: Callable[[str], None]
    ) -> bool:
        """
        Acquire the lock, unless it is held already.

        Return whether another process may have built since the last
        :meth:`look`. Where the disk is full or read-only, there is no lock,
        and nothing can be built.

        :param build_base: The build folder; made if necessary
        :param announce: Is called with a line if there is something to wait
          for
        :raises WorkspaceError: when there cannot be a build folder, or the
          build that goes on there has called this process
        """
        if self._is_held:
            return False
        before = _last_acquired(build_base)
        self._build_base = build_base
        self._problem = None
        try:
            build_base.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(
                build_base / LOCK_NAME, os.O_RDWR | os.O_CREAT
            )
        except OSError as e:
            if e.errno not in _NOT_WRITABLE:
                raise _refusal(build_base, e) from e
            self._problem = e
            self._is_held = True
            return self._seen not in (None, before)
        try:
            has_waited = _wait(descriptor, announce)
            if has_waited is not None and os.pread(descriptor, 1, 0):
                # who held it before was killed
                has_waited = True
                end_orphans(build_base, announce)
        except BaseException:
            os.close(descriptor)
            raise
        if has_waited is None:
            os.close(descriptor)
        else:
            self._descriptor = descriptor
        self._is_held = True
        # nothing is to be built yet, so a full disk does not matter
        with suppress(WorkspaceError):
            self._describe('checks what is to be built')
        return bool(has_waited) or self._seen not in (None, before)

    def publish_build(self, names: Iterable[str]) -> None:
        """
        Tell waiting launches what this process builds.

        :raises WorkspaceError: when nothing can be built
        """
        self._describe(f'{_BUILDS} {", ".join(names)}')

    def publish_start(self) -> None:
        """Tell waiting launches that this process has built."""
        # what was built is there, even if the disk is full now
        with suppress(WorkspaceError):
            self._describe('is about to start')

    def hand_over(self) -> None:
        """Clear the lock file before this process becomes another program."""
        if self._descriptor is not None:
            os.ftruncate(self._descriptor, 0)

    def release(self, *, clear: bool = True) -> None:
        """
        Release the lock.

        :param clear: Whether all that this process started has ended
        """
        self._is_held = False
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            if clear:
                os.ftruncate(descriptor, 0)
            # also where the file was inherited
            fcntl.flock(descriptor, fcntl.LOCK_UN)
            os.close(descriptor)

    def _describe(self, what: str) -> None:
        try:
            if self._problem is not None:
                raise self._problem
            if self._descriptor is not None:
                parts = (str(os.getpid()), self._title, _shown(what))
                line = ('\t'.join(parts) + '\n').encode()
                # never empty in between, as others read it meanwhile
                os.pwrite(self._descriptor, line, 0)
                os.ftruncate(self._descriptor, len(line))
        except OSError as e:
            raise _refusal(self._build_base, e) from e


def _wait(descriptor: int, announce: Callable[[str], None]) -> bool | None:
    """
    Wait for the lock, and return whether another process held it.

    Return None if that process has called this one and waits for it.
    """
    if _try_lock(descriptor):
        return False
    deadline = time.monotonic() + _NAME_TIMEOUT
    while (holder := _holder(descriptor)) is None:
        if time.monotonic() > deadline:
            break
        time.sleep(0.01)
        if _try_lock(descriptor):
            return True
    if holder is not None and holder.pid in _ancestors():
        if holder.what.startswith(_BUILDS):
            raise WorkspaceError(
                f'{holder} in this workspace and has called this command, '
                'which cannot build there at the same time',
                'give it --no-build',
            )
        return None
    if holder is None:
        announce(WAITING)
    elif is_suspended(holder.pid):
        announce(
            f'waiting for {holder} and is suspended: '
            f"'kill -CONT {holder.pid}' goes on"
        )
    else:
        announce(f'waiting for {holder}…')
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    return True


def _try_lock(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _refusal(build_base: Path, error: OSError) -> WorkspaceError:
    return WorkspaceError(
        f'cannot build in {build_base}: {error.strerror}',
        'make it writable, or give --no-build',
    )


def is_locked(build_base: Path) -> bool:
    """Return whether a process holds the lock of a workspace."""
    try:
        with (build_base / LOCK_NAME).open('rb') as handle:
            # let go at once
            fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        pass
    return False


@dataclass(frozen=True, slots=True)
class _Holder:
    """
    Another process that holds the lock.

    :param what: What it does, such as `builds flow, my_pkg`
    """

    pid: int
    title: str
    what: str

    def __str__(self) -> str:
        name = f'process {self.pid}'
        if self.title:
            name = f"'{self.title}' (process {self.pid})"
        return f'{name}, which {self.what}'


def _holder(descriptor: int) -> _Holder | None:
    text = os.pread(descriptor, 16 * _SHOWN, 0).decode(errors='replace')
    line, ended, _ = text.partition('\n')
    parts = line.split('\t') if ended else []
    if len(parts) != 3 or not parts[0].isdecimal():
        return None
    pid, title, what = map(_shown, parts)
    return _Holder(int(pid), title, what)


def _ancestors() -> Iterator[int]:
    pid = os.getpid()
    while (process := read_process(pid)) is not None and process.parent:
        pid = process.parent
        yield pid


def _last_acquired(build_base: Path) -> int:
    try:
        return (build_base / LOCK_NAME).stat().st_mtime_ns
    except OSError:
        return 0


def _shown(text: str) -> str:
    # it may be on somebody else's terminal in the end
    return one_line(text[:_SHOWN])
