# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The log files of a launch.

`NAME/stdout.log`, `NAME/stderr.log` and `NAME/stdout_stderr.log` hold what a
process wrote, byte by byte, as soon as it is read; `launch.log` has the
lines of all of them, and the launcher's own, with the time in seconds since
the epoch and the label.

`events.jsonl` has one JSON object a line; docs/logs.md describes them all.

A file that is full is renamed as logrotate does it: `stdout.log` becomes
`stdout.log.1`, `stdout.log.1` becomes `stdout.log.2`, and so on. It is full
when it reaches its share, which is so small that the files without a number
take no more than half of the limit; and not before it has an eighth of the
size of its rotated files, so that there are never many to rename. When the
limit is reached, the oldest of all files with a number is deleted.
"""

from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
import fcntl
import json
import os
from pathlib import Path
import re
import sys
import time
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.files import names_in
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.lines import normalised, prefixed
from colcon_yamllaunch.observers.screen import Layout
from colcon_yamllaunch.plan.plan import IN_COMMON_LOG, IN_OWN_LOG, Process

if TYPE_CHECKING:
    from colcon_yamllaunch.observers.log_store import LogStore

#: The log file of the whole launch, each line with a time stamp.
COMMON_LOG = 'launch.log'
#: The events of the launch, one JSON object a line.
EVENT_LOG = 'events.jsonl'
#: The log file of the process that speaks with ROS, where there is one.
CLIENT_LOG = 'ros_client.log'
#: The log file of a process that has both of its streams, as colcon names it.
COMBINED_LOG = 'stdout_stderr.log'

_NUMBER = re.compile(r'-\d+$')
_FLAGS = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW


class LogQuota:
    """
    The bytes that the log files of a launch may take together.

    :param limit: In bytes, or None for no limit
    :param files: How many log files there may be besides rotated ones
    :param warn: Is called once when rotated files are deleted
    :param allowed: Given the bytes that the files take and need, returns how
      many they may take on this disk; see :meth:`.log_store.LogStore.allowed`
    """

    def __init__(
        self,
        limit: int | None,
        files: int,
        warn: Callable[[str], None],
        allowed: Callable[[int, int], int] | None = None,
    ) -> None:
        self._limit = sys.maxsize if limit is None else limit
        self._files = files
        self._warn = warn
        self._has_warned = False
        self._allowed = allowed
        # bytes that may be written before the disk is looked at again
        self._left = limits.MINIMUM_LOG_BYTES if allowed else sys.maxsize
        #: Bytes that all files have now.
        self.used = 0
        self._rotated: deque[LogFile] = deque()
        self._restrict(self._limit)

    def expect(self, files: int) -> None:
        """Allow for more files."""
        self._files += files
        self._restrict(self._bound)

    def rotated(self, file: 'LogFile') -> None:
        """Note that `file` was rotated once more."""
        self._rotated.append(file)

    def make_room(self, size: int) -> None:
        """Delete rotated files so that files can grow by `size` bytes."""
        self._left -= size
        if self._left < 0 and self._allowed is not None:
            step = size + min(limits.DISK_CHECK_BYTES, self._even_share)
            allowed = self._allowed(self.used, self.used + step)
            self._restrict(min(self._limit, allowed))
            self._left = step - size
        while self.used + size > self._bound and self._rotated:
            self.used -= self._rotated.popleft().forget_oldest()
            if not self._has_warned:
                self._has_warned = True
                self._warn(self._warning())

    def _restrict(self, bound: int) -> None:
        self._bound = bound
        self._even_share = bound // (
            2 * max(self._files, limits.MINIMUM_LOG_SHARES)
        )
        #: Bytes at which a file is full unless its rotated files are large.
        self.share = max(self._even_share, limits.MINIMUM_LOG_FILE_BYTES)

    def _warning(self) -> str:
        # imported late, as few launches write so much
        from colcon_yamllaunch.common.table import decimal_size

        if self._bound == self._limit:
            return (
                'the log files have reached the limit of '
                f'{decimal_size(self._limit)}: from now on the oldest parts '
                'are deleted; --log-limit gives them more room'
            )
        return (
            'the logs of all launches have reached their limit, or the disk '
            f'is nearly full: with {decimal_size(self._bound)}, the oldest '
            'parts of the log files are deleted; COLCON_LAUNCH_LOG_TOTAL '
            'gives more room'
        )


class LogFile:
    """
    A log file, which is rotated when it is full.

    A file that somebody deleted is created again, with its folder, so that
    users find what is written, and it counts.

    :param path: The file, which is appended to
    :param quota: The bytes that it may take with others
    :raises OSError: when it cannot be opened
    """

    def __init__(self, path: Path, quota: LogQuota) -> None:
        self.path = path
        self._quota = quota
        self._descriptor = _opened(path)
        self._size = os.fstat(self._descriptor).st_size
        quota.used += self._size
        # the sizes of its rotated files, the latest first
        self._rotated_sizes: deque[int] = deque()
        self._is_mid_line = False
        # a rotation that failed is tried again with this size
        self._retry_size = 0
        # whether the file was rotated, and no other could be made
        self._is_renamed = False

    def write(self, data: bytes) -> None:
        """
        Append to the file at once.

        :param data: Whole lines, or any piece of what comes; a line that is
          no longer than :data:`.limits.LOG_LINE_BYTES` is not torn by a
          rotation
        :raises OSError: when the disk is full, for instance
        """
        # this check takes only a microsecond
        if self._is_renamed or not os.fstat(self._descriptor).st_nlink:
            self._reopen()
        excess = self._size + len(data) - self._full
        if self._size and excess > 0 and not self._is_renamed:
            end = data.find(b'\n') + 1 if self._is_mid_line else 0
            if end:
                self._append(data[:end])
                data = data[end:]
            if not self._is_mid_line or excess > limits.LOG_LINE_BYTES:
                self._rotate()
        if data:
            self._append(data)

    def forget_oldest(self) -> int:
        """Delete the oldest rotated file, and return the size that it had."""
        if not self._rotated_sizes:
            # somebody deleted them all
            return 0
        with suppress(OSError):
            self._path_of(len(self._rotated_sizes)).unlink()
        return self._rotated_sizes.pop()

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)

    @property
    def _full(self) -> int:
        return max(
            self._quota.share,
            sum(self._rotated_sizes) // limits.ROTATED_LOG_DIVISOR,
            self._retry_size,
        )

    def _append(self, data: bytes) -> None:
        self._quota.make_room(len(data))
        view = memoryview(data)
        while view:
            written = os.write(self._descriptor, view)
            self._size += written
            self._quota.used += written
            view = view[written:]
        self._is_mid_line = not data.endswith(b'\n')

    def _rotate(self) -> None:
        try:
            for number in range(len(self._rotated_sizes), -1, -1):
                # somebody may have deleted it to have more room
                with suppress(FileNotFoundError):
                    os.rename(self._path_of(number), self._path_of(number + 1))
        except OSError:
            # another program changes the folder
            self._retry_size = self._size + limits.MINIMUM_LOG_FILE_BYTES
            return
        self._rotated_sizes.appendleft(self._size)
        self._size = 0
        self._retry_size = 0
        self._quota.rotated(self)
        self._is_renamed = True
        self._reopen()

    def _reopen(self) -> None:
        """Open a new file at the path, if that is possible now."""
        try:
            descriptor = _opened(self.path)
        except OSError:
            return
        os.close(self._descriptor)
        self._descriptor = descriptor
        if self._is_renamed and self._rotated_sizes:
            # output since then went into the rotated file
            self._rotated_sizes[0] += self._size
        else:
            self._quota.used -= self._size
            if self._rotated_sizes and not self._path_of(1).exists():
                # they were deleted with it
                self._quota.used -= sum(self._rotated_sizes)
                self._rotated_sizes.clear()
        self._is_renamed = False
        self._size = 0
        self._is_mid_line = False

    def _path_of(self, number: int) -> Path:
        if not number:
            return self.path
        return self.path.with_name(f'{self.path.name}.{number}')


def with_rotated(path: Path) -> list[Path]:
    """Return a log file with its rotated files, the oldest first."""
    prefix = f'{path.name}.'
    numbers = [
        int(number)
        for name in names_in(path.parent)
        if name.startswith(prefix)
        and (number := name.removeprefix(prefix)).isdecimal()
    ]
    old = (f'{prefix}{number}' for number in sorted(numbers, reverse=True))
    return [*map(path.with_name, old), path]


def _opened(path: Path) -> int:
    """Open a log file; its folder is made when it is missing."""
    try:
        return os.open(path, _FLAGS, 0o644)
    except FileNotFoundError:
        path.parent.mkdir(parents=True, exist_ok=True)
        return os.open(path, _FLAGS, 0o644)


def lock_folder(folder: Path, operation: int = fcntl.LOCK_SH) -> int | None:
    """
    Return a descriptor that holds a lock on a folder, None for no lock.

    Each launch holds one on its own folder, so that no other deletes it.
    """
    flags = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
    try:
        descriptor = os.open(folder, flags)
    except OSError:
        return None
    try:
        fcntl.flock(descriptor, operation)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor


class Logs:
    """
    The logs of a launch.

    The launch goes on if they cannot be written.

    :param folder: The folder of the launch; made when it is missing
    :param processes: The processes of the plan
    :param warn: Is called once when logs cannot be written
    :param limit: The bytes that all files may take together, or None
    :param layout: The format of the launcher's own lines in `launch.log`, or
      None for the default
    :param store: The folders of other launches, of which old ones are deleted
      when there is time, or None
    """

    def __init__(
        self,
        folder: Path,
        processes: Iterable[Process],
        warn: Callable[[str], None],
        now: Callable[[], float] = time.time,
        limit: int | None = None,
        layout: Layout | None = None,
        store: 'LogStore | None' = None,
    ) -> None:
        processes = tuple(processes)
        self._folder = folder
        self._folders: dict[str, str] = {}
        #: For each label the log file that has both streams; it grows with
        #: the plan.
        self.combined_files: dict[str, Path] = {}
        self._store = store
        self._quota = LogQuota(
            limit,
            2 + 3 * len(processes),
            warn,
            None if store is None else store.allowed,
        )
        self._expect(processes)
        self._layout = layout
        self._warn = warn
        self._has_warned = False
        self._now = now
        self._files: dict[str, tuple[LogFile | None, ...]] = {}
        self._unopened: deque[Process] = deque()
        # beginnings of lines for the files with both streams: those that came
        # in this turn, and those of the turn before
        self._begun: dict[tuple[str, events.Stream], bytes] = {}
        self._waiting: dict[tuple[str, events.Stream], bytes] = {}
        self._common_pending: list[bytes] = []
        self._pending_size = 0
        self._event_pending: list[bytes] = []
        self._common = self._open(COMMON_LOG)
        self._events = self._open(EVENT_LOG)
        self._lock = lock_folder(folder)

    def record(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        """
        Write what a process wrote to its own logs at once.

        Only in the file with both streams, the beginning of a line waits for
        the next turn, so that the lines of the two are not mixed unless one
        of them stops in the middle.
        """
        if process.output not in IN_OWN_LOG:
            return
        self._open_own(process)
        stdout, stderr, combined = self._files[process.label]
        self._write(stdout if stream == 'stdout' else stderr, data)
        key = process.label, stream
        begun = self._begun.pop(key, None) or self._waiting.pop(key, b'')
        end = data.rfind(b'\n') + 1
        if len(begun) + len(data) - end > limits.READ_BYTES:
            end = len(data)
        if not end:
            self._begun[key] = begun + data
            return
        if end < len(data):
            self._begun[key] = data[end:]
        self._write(combined, b''.join((begun, memoryview(data)[:end])))

    def handle(self, event: events.Event) -> None:
        """Record an event of the launch."""
        if isinstance(event, events.Output):
            process = event.process
            if process.output in IN_COMMON_LOG and self._common is not None:
                # a user who sets a format of ROS 2 expects its names
                plain = self._layout is None
                name = process.label if plain else process.ros_name
                prefix = f'{self._stamp()}[{one_line(name)}] '
                lines = prefixed(
                    normalised(event.data), prefix.encode(errors='replace')
                )
                self._common_pending.append(lines)
                self._pending_size += len(lines)
                if self._pending_size > limits.PENDING_LOG_BYTES:
                    self._write_collected()
            return
        if isinstance(event, events.Started):
            self._unopened.append(event.process)
        elif isinstance(event, events.Planned):
            processes = [p for p in event.members if isinstance(p, Process)]
            self._quota.expect(3 * len(processes))
            self._expect(processes)
        for line in self._common_lines(event):
            self._common_pending.append(line.encode(errors='replace'))
        fields = event.record()
        if fields:
            record = {'time': round(self._now(), 6), **fields}
            text = json.dumps(record, ensure_ascii=False) + '\n'
            self._event_pending.append(text.encode(errors='replace'))

    def flush(self) -> bool:
        """
        Write what has been collected, and open files of quiet processes.

        Return whether there is more to do with the next call.
        """
        for _ in range(min(limits.LOGS_OPENED_PER_TURN, len(self._unopened))):
            self._open_own(self._unopened.popleft())
        for (label, _), data in self._waiting.items():
            self._write(self._files[label][-1], data)
        self._waiting, self._begun = self._begun, {}
        self._write_collected()
        self._renew_lock()
        if self._unopened or self._waiting:
            return True
        if self._store is not None and not self._store.tidy():
            self._store = None
        return self._store is not None

    def close(self) -> None:
        """Write everything, and close all files."""
        while self.flush():
            continue
        every = [self._common, self._events]
        for files in self._files.values():
            every.extend(files)
        for file in every:
            if file is not None:
                file.close()
        if self._lock is not None:
            os.close(self._lock)

    def _expect(self, processes: Iterable[Process]) -> None:
        """Name the folders of processes."""
        processes = tuple(processes)
        known = self._folders
        new = [p for p in processes if p.label not in known]
        known |= folder_names(new, known.values())
        for process in processes:
            label = process.label
            self.combined_files.pop(label, None)
            if process.output in IN_OWN_LOG:
                path = self._folder / known[label] / COMBINED_LOG
                self.combined_files[label] = path

    def _write_collected(self) -> None:
        self._write(self._common, b''.join(self._common_pending))
        self._write(self._events, b''.join(self._event_pending))
        self._pending_size = 0
        self._common_pending.clear()
        self._event_pending.clear()

    def _renew_lock(self) -> None:
        """Lock the folder again after somebody deleted it."""
        if self._lock is not None:
            if os.fstat(self._lock).st_nlink:
                return
            os.close(self._lock)
        self._lock = lock_folder(self._folder)

    def _common_lines(self, event: events.Event) -> list[str]:
        name, tag = event.label, f'[{event.label}]'
        if isinstance(event, events.MessageShown):
            name = events.MESSENGER
            tag = f'[{event.level}] [{name}]:'
        texts = event.lines()
        if self._layout is not None:
            severity = event.severity
            return [self._layout(name, severity, t) + '\n' for t in texts]
        lines = (line for text in texts for line in text.split('\n'))
        return [f'{self._stamp()}{tag} {line}\n' for line in lines]

    def _stamp(self) -> str:
        return f'{self._now():.6f} '

    def _open_own(self, process: Process) -> None:
        label = process.label
        if process.output in IN_OWN_LOG and label not in self._files:
            folder = self._folders[label]
            self._files[label] = tuple(
                self._open(f'{folder}/{name}')
                for name in ('stdout.log', 'stderr.log', COMBINED_LOG)
            )

    def _open(self, name: str) -> LogFile | None:
        path = self._folder / name
        try:
            return LogFile(path, self._quota)
        except OSError as error:
            self._fail(path, error)
            return None

    def _write(self, file: LogFile | None, data: bytes) -> None:
        if file is not None and data:
            try:
                file.write(data)
            except OSError as error:
                self._fail(file.path, error)

    def _fail(self, path: Path, error: OSError) -> None:
        if not self._has_warned:
            self._has_warned = True
            self._warn(
                f'the log {path} cannot be written: {error.strerror}; '
                'the launch goes on, and its logs are incomplete'
            )


def folder_names(
    processes: Iterable[Process], known: Iterable[str] = ()
) -> dict[str, str]:
    """
    Return for each label the name of the folder of its process.

    It is the label and the number that the process has in the launch, as the
    logs of a build are in folders that have the names of packages. A slash
    becomes a dot, as in the names of rclcpp's and rclpy's loggers; what else a
    label holds that a file name cannot is replaced. Names differ all the same.

    :param known: Names that others have
    """
    names: dict[str, str] = {}
    taken = {COMMON_LOG, EVENT_LOG, CLIENT_LOG, *known}
    for process in processes:
        label = text = process.label
        number = _NUMBER.search(process.ros_name)
        if number is not None and not text.endswith(number[0]):
            text += number[0]
        text = text.replace('/', '.').lstrip('.')
        base = ''.join(c if c.isprintable() else '_' for c in text)
        data = base.encode(errors='replace')[: limits.FOLDER_NAME_BYTES]
        name = base = data.decode(errors='ignore') or '_'
        count = 1
        while name in taken:
            count += 1
            name = f'{base}-{count}'
        taken.add(name)
        names[label] = name
    return names
