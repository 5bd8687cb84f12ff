# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
One launch at a time that builds, sources and starts in a workspace.

Another one could pull the install space away in between, as a build with
other arguments begins by removing it.
"""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Iterator
from contextlib import contextmanager
from contextlib import ExitStack
from contextlib import suppress
import errno
import fcntl
import os
from pathlib import Path
import time
from typing import Any

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.common.process_scan import is_suspended
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.workspace.building.build_processes import end_orphans

#: The name of the lock file, below the build folder.
LOCK_NAME = '.colcon_launch.lock'
#: What the user is told while another one builds that is not known.
WAITING = 'waiting for another launch in this workspace'
#: How much is told of what the other one is and builds (characters).
_SHOWN = 200
#: How long it may take until who holds it has said its name (seconds).
_UNNAMED = 1.0
#: How what it does begins when it builds.
_BUILDS = 'builds'
#: Where nobody can build, and what is up to date stays so.
_NOT_WRITABLE = frozenset(
    (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM)
)


class BuildLock:
    """
    The lock of a workspace, while it is held.

    :param build_base: The build folder of the workspace
    :param descriptor: Its file; or -1 for a process that one which holds it
      has called and waits for, and where there can be none
    :param title: The command of this process
    :param waited: Whether another process held it before
    :param problem: Why nothing can be built, if so
    """

    def __init__(
        self,
        build_base: Path,
        descriptor: int,
        title: str,
        waited: bool,
        problem: OSError | None = None,
    ) -> None:
        self._build_base = build_base
        self._descriptor = descriptor
        self._title = _shown(title)
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
            if self._descriptor != -1:
                parts = (str(os.getpid()), self._title, _shown(what))
                line = ('\t'.join(parts) + '\n').encode()
                # never empty in between, as others read it meanwhile
                os.pwrite(self._descriptor, line, 0)
                os.ftruncate(self._descriptor, len(line))
        except OSError as e:
            raise _refusal(self._build_base, e) from e

    def tell_of_build(self, names: Iterable[str]) -> None:
        """
        Let those who wait know what this process builds.

        :raises WorkspaceError: when nothing can be built
        """
        self.tell(f'{_BUILDS} {", ".join(names)}')

    def clear(self) -> None:
        """Leave no trace of this process."""
        if self._descriptor != -1:
            os.ftruncate(self._descriptor, 0)


class WorkspaceLock:
    """
    The lock of a workspace for one launch, which takes it when it decides.

    It keeps it until it lets it go, which is when its processes have started.

    :param title: The command, for those who wait
    """

    def __init__(self, title: str = '') -> None:
        self._title = title
        self._stack = ExitStack()
        self._held: BuildLock | None = None
        self._seen: int | None = None

    def __enter__(self) -> 'WorkspaceLock':
        return self

    def __exit__(self, *error: Any) -> None:
        self._held = None
        self._stack.__exit__(*error)

    def look(self, build_base: Path) -> None:
        """Remember when it was last taken, before the workspace is read."""
        self._seen = _last_taken(build_base)

    def take(self, build_base: Path, announce: Callable[[str], None]) -> bool:
        """
        Take it, unless it is held already.

        The parameters are those of :func:`build_lock`. Return whether another
        process may have built since the last :meth:`look`.
        """
        if self._held is not None:
            return False
        now = _last_taken(build_base)
        lock = build_lock(build_base, announce, self._title)
        self._held = self._stack.enter_context(lock)
        return self._held.waited or self._seen not in (None, now)

    def tell_of_build(self, names: Iterable[str]) -> None:
        """
        Let those who wait know what this process builds.

        :raises WorkspaceError: when nothing can be built
        """
        if self._held is not None:
            self._held.tell_of_build(names)

    def tell_of_start(self) -> None:
        """Let those who wait know that this process has built."""
        if self._held is not None:
            # what was built is there, even if the disk is full now
            with suppress(WorkspaceError):
                self._held.tell('is about to start')

    def hand_over(self) -> None:
        """Leave no trace: this process becomes another, which ends it."""
        if self._held is not None:
            self._held.clear()

    def release(self) -> None:
        """Let it go."""
        self._held = None
        self._stack.close()


@contextmanager
def build_lock(
    build_base: Path, announce: Callable[[str], None], title: str = ''
) -> Iterator[BuildLock]:
    """
    Keep other launches from building in a workspace at the same time.

    The lock ends with the process at the latest, however it ends. One that is
    called by the process that holds it, by `$(command …)` for instance, does
    not wait, as that one waits for it. Where the disk is full or read-only,
    there is none, and nothing can be built.

    :param build_base: The build folder of the workspace; made if necessary
    :param announce: Is called with one line if there is something to wait for
    :param title: The command, for those who wait
    :raises WorkspaceError: when there cannot be a build folder, or the build
      that goes on there has called this process
    """
    try:
        build_base.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(build_base / LOCK_NAME, os.O_RDWR | os.O_CREAT)
    except OSError as e:
        if e.errno not in _NOT_WRITABLE:
            raise _refusal(build_base, e) from e
        yield BuildLock(build_base, -1, title, False, e)
        return
    try:
        taken = _take(descriptor)
        waited = not taken
        holder = None
        patience = time.monotonic() + _UNNAMED
        while not taken and holder is None and time.monotonic() < patience:
            holder = _holder(descriptor)
            if holder is None:
                time.sleep(0.01)
                taken = _take(descriptor)
        if not taken:
            if holder is not None and holder.pid in _ancestors():
                if holder.what.startswith(_BUILDS):
                    raise WorkspaceError(
                        f'{holder} in this workspace and has called this '
                        'command, which cannot build there at the same time',
                        'give it --no-build',
                    )
                yield BuildLock(build_base, -1, title, False)
                return
            announce(
                WAITING if holder is None else f'waiting for {holder.told()}'
            )
            fcntl.flock(descriptor, fcntl.LOCK_EX)
        if os.pread(descriptor, 1, 0):
            # who held it before was killed
            waited = True
            end_orphans(build_base, announce)
        lock = BuildLock(build_base, descriptor, title, waited)
        yield lock
        lock.clear()
        # also where the file was inherited
        fcntl.flock(descriptor, fcntl.LOCK_UN)
    finally:
        os.close(descriptor)


def _take(descriptor: int) -> bool:
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


def is_taken(build_base: Path) -> bool:
    """Tell whether a process holds the lock of a workspace."""
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
        return f'{self._name}, which {self.what}'

    @property
    def _name(self) -> str:
        if not self.title:
            return f'process {self.pid}'
        return f"'{self.title}' (process {self.pid})"

    def told(self) -> str:
        """Return what is told to who waits for it."""
        if not is_suspended(self.pid):
            return f'{self}…'
        return f"{self} and is suspended: 'kill -CONT {self.pid}' goes on"


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


def _last_taken(build_base: Path) -> int:
    try:
        return (build_base / LOCK_NAME).stat().st_mtime_ns
    except OSError:
        return 0


def _shown(text: str) -> str:
    # it may be on somebody else's terminal in the end
    return one_line(text[:_SHOWN])
