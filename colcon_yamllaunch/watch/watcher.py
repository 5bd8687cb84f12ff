# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The process that watches files for a launch.

It is one of its own, as what watches has threads, and a launcher must have
none. It reads lines of JSON: `{"folders": […], "files": […], "since": N}`
says what to watch from now on. It writes such lines, too: `{"changes": [[KIND,
PATH, REAL], …], "seen": N, "at": N, "notes": [TEXT, …]}`; the times are in
nanoseconds, by the clock that never goes back and since the epoch. It ends
with its input, which is closed when the launcher ends, however that came.

The kernel tells of changes (inotify), and a look at all files now and then
finds what it did not tell. Where it cannot tell, there are only the looks,
and more of them.
"""

from collections.abc import Callable
from collections.abc import Iterable
from contextlib import suppress
import errno
import fcntl
import importlib.util
import json
import os
import select
import signal
import sys
import time
from typing import Any
from typing import TYPE_CHECKING

from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.watched_files import WatchedFiles

if TYPE_CHECKING:
    from watchfiles._rust_notify import RustNotify

#: Set as for the library itself, so that it need not be set twice.
POLLING_VARIABLE = 'WATCHFILES_FORCE_POLLING'
#: Milliseconds without an event after which those before are taken together.
STEP = 2
#: The same once there were some files, as one after the other is saved.
LONG_STEP = 25
SOME = 3
#: Milliseconds that are waited for an event that a signal announced.
PATIENCE = 15
#: Seconds that a file may be empty or missing in the middle of being saved.
TORN = 0.15
#: Seconds without a change after which git does not write the work tree, but
#: waits for its user, who writes the message of a commit.
CHECKOUT = 3.0
#: Events so many that the kernel may have dropped some.
FLOOD = 1000
#: Seconds between two looks at all files, and how many times as long as one
#: takes that is at least.
PAUSE = 60.0
RARITY = 1000
#: The same where nothing else tells.
SHORT_PAUSE = 0.5
SHORT_RARITY = 10
#: How often folders are looked up again that are gone in the meantime.
ATTEMPTS = 5
#: File systems that others may write to, of which the kernel does not tell.
REMOTE = frozenset(
    (
        *('9p', 'afs', 'ceph', 'cifs', 'fakeowner', 'gfs2', 'lustre', 'ncpfs'),
        *('nfs', 'nfs4', 'ocfs2', 'prl_fs', 'smb3', 'smbfs', 'vboxsf'),
        *('virtiofs', 'vmhgfs'),
    )
)
_READ_SIZE = 1 << 16
_LIMITS = '/proc/sys/fs/inotify'


class Watcher:
    """
    Watches what it is told to.

    :param source: The descriptor that says what
    :param tell: Is called with changes, those of the kind `again` among them,
      when they were noticed, and notes
    :param clock: Returns seconds that never go back
    """

    def __init__(
        self,
        source: int,
        tell: Callable[[list[Change], int, list[str]], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._source = source
        self._tell = tell
        self._clock = clock
        self._unread = b''
        self._files = WatchedFiles()
        self._notify: RustNotify | None = None
        # the folders that the kernel tells of, with what they are behind
        # their names
        self._watched: dict[str, tuple[int, int]] = {}
        self._notes: list[str] = []
        self._told: set[str] = set()
        self._is_polling = False
        self._due = clock() + PAUSE
        # by the times at which git has made them
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
                self._take()
            elif self._clock() >= self._due:
                self._wait_for_git()
                self._say(self._look())

    def _read(self, data: bytes) -> None:
        *lines, self._unread = (self._unread + data).split(b'\n')
        if not lines:
            return
        # only the last one counts, but for when it all began
        requests = [json.loads(line) for line in lines]
        since = min(int(request['since']) for request in requests)
        seen = time.monotonic_ns()
        changes = self._files.watch(
            requests[-1]['folders'], requests[-1]['files'], since
        )
        self._say([*changes, *self._renew()], seen)
        self._plan_look(0.0)

    def _take(self) -> None:
        """Take what the kernel tells of, until it is quiet again."""
        seen = time.monotonic_ns()
        paths = self._collect(STEP)
        if not paths:
            return
        if len(paths) >= SOME:
            paths |= self._collect(LONG_STEP)
        deadline = self._clock() + TORN
        while self._clock() < deadline and any(
            map(self._files.is_torn, paths)
        ):
            paths |= self._collect(STEP)
        paths |= self._wait_for_git()
        if len(paths) >= FLOOD or any(map(self._files.needs_look, paths)):
            # another folder has its name, maybe with the same number
            is_other = not self._watched.keys().isdisjoint(paths)
            self._say(self._look(anew=is_other), seen)
        else:
            self._say(self._files.changes(paths), seen)

    def _collect(self, step: int) -> set[str]:
        patience = max(PATIENCE, step)
        if self._notify is None:
            time.sleep(patience / 1000)
            return set()
        found = self._notify.watch(4 * step, step, patience, None)
        if isinstance(found, str):
            return set()
        return {path for _, path in found}

    def _wait_for_git(self) -> set[str]:
        """Wait until git has written what it is to write."""
        paths: set[str] = set()
        for lock in self._files.git_locks:
            deadline = self._clock() + CHECKOUT
            while self._is_held(lock):
                found = self._collect(STEP)
                if found:
                    paths |= found
                    deadline = self._clock() + CHECKOUT
                elif self._clock() > deadline:
                    self._stale_locks[lock] = _written(lock)
        return paths

    def _is_held(self, lock: str) -> bool:
        return _written(lock) not in (0, self._stale_locks.get(lock))

    def _look(self, *, anew: bool = False) -> list[Change]:
        """
        Look at all files.

        :param anew: As for :meth:`_renew`
        """
        begun = time.process_time()
        changes = self._files.look_again()
        changes += self._renew(anew=anew)
        self._plan_look(time.process_time() - begun)
        return changes

    def _plan_look(self, took: float) -> None:
        pause = max(PAUSE, took * RARITY)
        if self._is_polling:
            pause = max(SHORT_PAUSE, took * SHORT_RARITY)
        self._due = self._clock() + pause

    def _renew(self, *, anew: bool = False) -> list[Change]:
        """
        Have the kernel tell of the folders that there are now.

        :param anew: Whether to do so though they seem to be the same
        """
        changes: list[Change] = []
        for _ in range(ATTEMPTS):
            places = _identities(self._files.places)
            if places == self._watched and not anew:
                break
            anew = False
            self._watched = places
            if not self._listen():
                break
            # what was written before anybody listened
            changes += self._files.look_again()
        return changes

    def _listen(self) -> bool:
        """Have the kernel tell of all folders; return whether they differ."""
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
        from watchfiles._rust_notify import RustNotify
        from watchfiles._rust_notify import WatchfilesRustInternalError

        before = set(_inotify_descriptors())
        try:
            # the last flag would pass over limits, too
            self._notify = RustNotify(places, False, False, 0, False, False)
        except (FileNotFoundError, PermissionError):
            # one was removed or closed just now
            self._files.look_again()
            self._watched = {}
            return True
        except (OSError, WatchfilesRustInternalError) as e:
            self._is_polling = True
            self._note(_limit_reached(e))
            return False
        for descriptor in set(_inotify_descriptors()) - before:
            # it wakes us, so that we need not ask again and again
            fcntl.fcntl(descriptor, fcntl.F_SETOWN, os.getpid())
            flags = fcntl.fcntl(descriptor, fcntl.F_GETFL)
            fcntl.fcntl(descriptor, fcntl.F_SETFL, flags | os.O_ASYNC)
        return True

    def _note(self, text: str) -> None:
        if text not in self._told:
            self._told.add(text)
            self._notes.append(text)

    def _say(self, changes: list[Change], seen: int = 0) -> None:
        notes, self._notes = self._notes, []
        told = [*changes, *self._files.take_again()]
        if told or notes:
            self._tell(told, seen or time.monotonic_ns(), notes)


#: What the library takes for no polling.
_FALSE = ('', 'false', 'disable', 'disabled')


def _identities(folders: Iterable[str]) -> dict[str, tuple[int, int]]:
    """Return what tells folders apart that had the same name."""
    found = {}
    for folder in folders:
        with suppress(OSError):
            status = os.stat(folder)
            found[folder] = status.st_dev, status.st_ino
    return found


def _written(path: str) -> int:
    """Return when a file was written (nanoseconds), 0 if it is not there."""
    try:
        return os.stat(path).st_mtime_ns
    except OSError:
        return 0


def _is_text(path: str) -> bool:
    try:
        path.encode()
    except UnicodeEncodeError:
        # the library takes no other
        return False
    return True


def _inotify_descriptors() -> Iterable[int]:
    for name in os.listdir('/proc/self/fd'):
        with suppress(OSError):
            if 'inotify' in os.readlink(f'/proc/self/fd/{name}'):
                yield int(name)


def _limit_reached(reason: Exception) -> str:
    """Say why the kernel does not tell, and the way out."""
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
    """Tell whether a folder is on a file system that others write to."""
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
    return kind in REMOTE or kind.startswith('fuse')


def _write(changes: list[Change], seen: int, notes: list[str]) -> None:
    message: dict[str, Any] = {
        'changes': [[c.kind, c.path, c.real] for c in changes],
        'seen': seen,
        'at': time.time_ns() - (time.monotonic_ns() - seen),
        'notes': notes,
    }
    # paths that are no text, too
    data = json.dumps(message).encode() + b'\n'
    while data:
        data = data[os.write(sys.stdout.fileno(), data) :]


def _import_less() -> None:
    """Have the part of the library imported that is needed, and no other."""
    spec = importlib.util.find_spec('watchfiles')
    if spec is not None:
        # its front imports asyncio and more, which takes 4 MiB
        sys.modules['watchfiles'] = importlib.util.module_from_spec(spec)


def main() -> None:
    """Watch until standard input is closed."""
    _import_less()
    # Ctrl-C is for the launcher
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(BrokenPipeError):
        Watcher(sys.stdin.fileno(), _write).run()
    # the thread that listens must not outlive what it tells
    os._exit(0)


if __name__ == '__main__':
    main()
