# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The watcher: a process that watches files for a launch.

It is a separate process because the library that watches uses threads, and a
launcher must have none. It reads lines of JSON: `{"folders": […], "files":
[…], "since": N}` says what to watch from now on. It writes lines of JSON, too:
`{"changes": [[KIND, PATH, REAL], …], "seen": N, "at": N, "notes": [TEXT, …]}`;
the times are in nanoseconds, `seen` by the monotonic clock and `at` since the
epoch. It ends at the end of its input, which the kernel closes when the
launcher ends.

The kernel reports changes (inotify), and an occasional scan of all files finds
changes that it did not report. Where it cannot report any, the watcher only
scans, and more often.
"""

from collections.abc import Callable, Iterable
from contextlib import suppress
import errno
import fcntl
import importlib.util
import json
import os
from pathlib import Path
import select
import signal
import sys
import time
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.watch.watched_files import Batch, Change, WatchedFiles

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.loop import Loop
    from watchfiles._rust_notify import RustNotify

#: The error without the library that watches.
MISSING = (
    "--watch needs the Python package 'watchfiles': pip install watchfiles"
)
#: The module that the process runs.
PROGRAM = 'colcon_yamllaunch.watch.watcher'

#: The variable of the library that asks for polling.
POLLING_VARIABLE = 'WATCHFILES_FORCE_POLLING'
#: Milliseconds without an event that end a batch of events.
QUIET_TIME = 2
#: The same after some files, as editors save one file after the other.
LONG_QUIET_TIME = 25
BURST = 3
#: Milliseconds to wait for an event after its signal.
EVENT_TIMEOUT = 15
#: Seconds that a file may be empty or missing while it is being saved.
PARTLY_WRITTEN_TIMEOUT = 0.15
#: Seconds without a change after which git is not writing the work tree, but
#: waiting for the message of a commit.
GIT_TIMEOUT = 3.0
#: The number of events from which the kernel may have dropped some.
EVENT_OVERFLOW = 1000
#: The seconds between two scans, and the least ratio of this interval to the
#: time of a scan.
SCAN_INTERVAL = 60.0
SCAN_FACTOR = 1000
#: The same where the kernel reports no changes.
POLLING_INTERVAL = 0.5
POLLING_FACTOR = 10
#: How often to look up folders again that were removed in the meantime.
LISTEN_ATTEMPTS = 5
#: File systems whose changes by other computers the kernel does not report.
NETWORK_FILE_SYSTEMS = frozenset(
    (
        *('9p', 'afs', 'ceph', 'cifs', 'fakeowner', 'gfs2', 'lustre', 'ncpfs'),
        *('nfs', 'nfs4', 'ocfs2', 'prl_fs', 'smb3', 'smbfs', 'vboxsf'),
        *('virtiofs', 'vmhgfs'),
    )
)
_READ_SIZE = 1 << 16
_LIMITS = '/proc/sys/fs/inotify'
_LIBRARY = 'watchfiles'
#: Finds the modules that the launcher finds, and none in the current folder.
_START = 'import sys; sys.path[:] = {!r}; from {} import main; main()'
#: The values of the variable that ask for no polling.
_FALSE = ('', 'false', 'disable', 'disabled')


def is_installed() -> bool:
    """Return whether the library that watches is installed."""
    return importlib.util.find_spec(_LIBRARY) is not None


class WatcherClient:
    """
    The watcher of a launch.

    :param handle: Is called with changes
    :param warn: Is called with what the user should know about the watching
    :param log: The file for its standard error, or None
    """

    def __init__(
        self,
        loop: 'Loop',
        handle: Callable[[Batch], None],
        warn: Callable[[str], None],
        log: Path | None = None,
    ) -> None:
        # the watcher itself needs less memory without it
        from colcon_yamllaunch.engine.helper_process import HelperProcess

        self._process = HelperProcess(
            loop, self._spawn, self._receive, self._lost, log
        )
        self._handle = handle
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
        """Stop the process without starting it again."""
        self._process.stop()

    def close(self) -> None:
        """End the process, and wait for that."""
        self._process.close()

    def _spawn(self, streams: tuple[int, int, int]) -> int:
        from colcon_yamllaunch.engine.spawn import spawn_process

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
            self._handle(Batch(changes, message['seen']))


class Watcher:
    """
    Watches files as its input says.

    :param source: The descriptor of the input
    :param report: Is called with changes, the time when they were noticed, and
      notes for the user
    :param clock: The monotonic clock
    """

    def __init__(
        self,
        source: int,
        report: Callable[[list[Change], int, list[str]], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._source = source
        self._report = report
        self._clock = clock
        self._unread = b''
        self._files = WatchedFiles()
        self._notify: RustNotify | None = None
        # the folders that the kernel watches, each with its identity
        self._watched: dict[str, tuple[int, int]] = {}
        self._notes: list[str] = []
        self._noted: set[str] = set()
        self._is_polling = False
        self._due = clock() + SCAN_INTERVAL
        # locks of git that are not waited for, each with its creation time
        self._stale_locks: dict[str, int] = {}
        self._wakeup, waker = os.pipe()
        os.set_blocking(self._wakeup, False)
        os.set_blocking(waker, False)
        signal.set_wakeup_fd(waker, warn_on_full_buffer=False)
        signal.signal(signal.SIGIO, lambda *_: None)

    def run(self) -> None:
        """Watch until the source is closed."""
        poll = select.poll()
        poll.register(self._source, select.POLLIN)
        poll.register(self._wakeup, select.POLLIN)
        while True:
            wait = max(0.0, self._due - self._clock())
            ready = {d for d, _ in poll.poll(wait * 1000)}
            if self._source in ready:
                data = os.read(self._source, _READ_SIZE)
                if not data:
                    return
                self._read(data)
            if self._wakeup in ready:
                with suppress(BlockingIOError):
                    os.read(self._wakeup, _READ_SIZE)
                self._handle_events()
            elif self._clock() >= self._due:
                self._wait_for_git()
                self._send(self._scan())

    def _read(self, data: bytes) -> None:
        *lines, self._unread = (self._unread + data).split(b'\n')
        if not lines:
            return
        # the last request counts, with the earliest time
        requests = [json.loads(line) for line in lines]
        since = min(int(request['since']) for request in requests)
        seen = time.monotonic_ns()
        changes = self._files.watch(
            requests[-1]['folders'], requests[-1]['files'], since
        )
        self._send([*changes, *self._watch_folders()], seen)
        self._plan_scan(0.0)

    def _handle_events(self) -> None:
        """Handle the events of the kernel, until there are no more."""
        seen = time.monotonic_ns()
        paths = self._collect(QUIET_TIME)
        if not paths:
            return
        if len(paths) >= BURST:
            paths |= self._collect(LONG_QUIET_TIME)
        deadline = self._clock() + PARTLY_WRITTEN_TIMEOUT
        while self._clock() < deadline and any(
            map(self._files.is_partly_written, paths)
        ):
            paths |= self._collect(QUIET_TIME)
        paths |= self._wait_for_git()
        if len(paths) >= EVENT_OVERFLOW or any(
            map(self._files.needs_scan, paths)
        ):
            # a new folder may have the name and inode number of a removed one
            is_other = not self._watched.keys().isdisjoint(paths)
            self._send(self._scan(force=is_other), seen)
        else:
            self._send(self._files.changes(paths), seen)

    def _collect(self, step: int) -> set[str]:
        patience = max(EVENT_TIMEOUT, step)
        if self._notify is None:
            time.sleep(patience / 1000)
            return set()
        found = self._notify.watch(4 * step, step, patience, None)
        if isinstance(found, str):
            return set()
        return {path for _, path in found}

    def _wait_for_git(self) -> set[str]:
        """Wait until git has written the work tree; return changed paths."""
        paths: set[str] = set()
        for lock in self._files.git_locks:
            deadline = self._clock() + GIT_TIMEOUT
            while _written(lock) not in (0, self._stale_locks.get(lock)):
                found = self._collect(QUIET_TIME)
                if found:
                    paths |= found
                    deadline = self._clock() + GIT_TIMEOUT
                elif self._clock() > deadline:
                    self._stale_locks[lock] = _written(lock)
        return paths

    def _scan(self, *, force: bool = False) -> list[Change]:
        """
        Scan all files.

        :param force: As for :meth:`_watch_folders`
        """
        begun = time.process_time()
        changes = self._files.scan()
        changes += self._watch_folders(force=force)
        self._plan_scan(time.process_time() - begun)
        return changes

    def _plan_scan(self, took: float) -> None:
        pause = max(SCAN_INTERVAL, took * SCAN_FACTOR)
        if self._is_polling:
            pause = max(POLLING_INTERVAL, took * POLLING_FACTOR)
        self._due = self._clock() + pause

    def _watch_folders(self, *, force: bool = False) -> list[Change]:
        """
        Watch the folders that exist now; return what changed meanwhile.

        :param force: Whether to do so even if they seem to be the same
        """
        changes: list[Change] = []
        for _ in range(LISTEN_ATTEMPTS):
            places = _identities(self._files.watched_folders)
            if places == self._watched and not force:
                break
            force = False
            self._watched = places
            if not self._listen():
                break
            # files may have been written before
            changes += self._files.scan()
        return changes

    def _listen(self) -> bool:
        """Make the kernel watch the folders; return False if it cannot."""
        if self._notify is not None:
            self._notify.close()
            self._notify = None
        places = sorted(filter(_is_text, self._watched))
        self._is_polling = is_remote = _has_remote(places)
        if is_remote:
            self._note(
                'the sources are on a network file system, which does not '
                'tell of all changes: looking at them again and again'
            )
        if os.environ.get(POLLING_VARIABLE, 'false') not in _FALSE:
            self._is_polling = True
            return False
        if not places:
            return False
        from watchfiles._rust_notify import (
            RustNotify,
            WatchfilesRustInternalError,
        )

        before = set(_inotify_descriptors())
        try:
            # the last flag would hide that a limit is reached
            self._notify = RustNotify(places, False, False, 0, False, False)
        except (FileNotFoundError, PermissionError):
            # a folder was just removed, or made inaccessible
            self._files.scan()
            self._watched = {}
            return True
        except (OSError, WatchfilesRustInternalError) as e:
            self._is_polling = True
            self._note(_limit_reached(e))
            return False
        for descriptor in set(_inotify_descriptors()) - before:
            # it sends a signal, so that nothing has to poll
            fcntl.fcntl(descriptor, fcntl.F_SETOWN, os.getpid())
            flags = fcntl.fcntl(descriptor, fcntl.F_GETFL)
            fcntl.fcntl(descriptor, fcntl.F_SETFL, flags | os.O_ASYNC)
        return True

    def _note(self, text: str) -> None:
        if text not in self._noted:
            self._noted.add(text)
            self._notes.append(text)

    def _send(self, changes: list[Change], seen: int = 0) -> None:
        notes, self._notes = self._notes, []
        changes = [*changes, *self._files.pop_rewritten()]
        if changes or notes:
            self._report(changes, seen or time.monotonic_ns(), notes)


def _identities(folders: Iterable[str]) -> dict[str, tuple[int, int]]:
    """Return the identities of folders, which names may change."""
    found = {}
    for folder in folders:
        with suppress(OSError):
            status = os.stat(folder)
            found[folder] = status.st_dev, status.st_ino
    return found


def _written(path: str) -> int:
    """Return when a file was written (nanoseconds), 0 if it is missing."""
    try:
        return os.stat(path).st_mtime_ns
    except OSError:
        return 0


def _is_text(path: str) -> bool:
    try:
        path.encode()
    except UnicodeEncodeError:
        # the library accepts only text
        return False
    return True


def _inotify_descriptors() -> Iterable[int]:
    for name in os.listdir('/proc/self/fd'):
        with suppress(OSError):
            if 'inotify' in os.readlink(f'/proc/self/fd/{name}'):
                yield int(name)


def _limit_reached(reason: Exception) -> str:
    """Return a note that says why the kernel cannot watch, and the fix."""
    text = str(reason)
    name = 'max_user_watches'
    if 'Too many open files' in text or f'os error {errno.EMFILE}' in text:
        name = 'max_user_instances'
    elif 'limit' not in text and f'os error {errno.ENOSPC}' not in text:
        return (
            f'the kernel does not tell of changes ({text}): looking at the '
            'files again and again'
        )
    value = 0
    with suppress(OSError, ValueError), open(f'{_LIMITS}/{name}') as file:
        value = int(file.read())
    more = max(2 * value, 1024 if 'instances' in name else 524_288)
    return (
        f'the limit of inotify is reached (fs.inotify.{name} is {value}), so '
        'the files are looked at again and again, which takes longer; raise '
        f'it: sudo sysctl fs.inotify.{name}={more}'
    )


def _has_remote(places: Iterable[str]) -> bool:
    """Return whether a folder is on a network file system."""
    mounts: dict[str, str] = {}
    with suppress(OSError), open('/proc/self/mountinfo') as file:
        for line in file:
            before, _, after = line.partition(' - ')
            point = before.split()[4].replace('\\040', ' ')
            mounts[point.rstrip('/')] = after.split()[0]
    return any(_is_remote(place, mounts) for place in places)


def _is_remote(place: str, mounts: dict[str, str]) -> bool:
    while place not in mounts and place:
        place = place.rpartition(os.sep)[0]
    kind = mounts.get(place, '')
    return kind in NETWORK_FILE_SYSTEMS or kind.startswith('fuse')


def _write(changes: list[Change], seen: int, notes: list[str]) -> None:
    message: dict[str, Any] = {
        'changes': [[c.kind, c.path, c.real] for c in changes],
        'seen': seen,
        'at': time.time_ns() - (time.monotonic_ns() - seen),
        'notes': notes,
    }
    # paths need not be text
    data = json.dumps(message).encode() + b'\n'
    while data:
        data = data[os.write(sys.stdout.fileno(), data) :]


def main() -> None:
    """Watch until standard input is closed."""
    spec = importlib.util.find_spec(_LIBRARY)
    if spec is not None:
        # only its extension module is imported, as the package itself imports
        # asyncio, which takes 4 MiB
        sys.modules[_LIBRARY] = importlib.util.module_from_spec(spec)
    # Ctrl-C is for the launcher
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(BrokenPipeError):
        Watcher(sys.stdin.fileno(), _write).run()
    # do not wait for the thread of the library
    os._exit(0)


if __name__ == '__main__':
    main()
