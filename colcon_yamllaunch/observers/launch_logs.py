# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The log files of a launch.

`NAME/stdout.log`, `NAME/stderr.log` and `NAME/stdout_stderr.log` hold what a
process wrote, byte by byte, as soon as it is read; `launch.log` has the
lines of all of them, and the launcher's own, with the time in seconds since
the epoch and the label.

`events.jsonl` has one JSON object a line; docs/logs.md describes them all.
"""

from collections import deque
from collections.abc import Callable
from collections.abc import Iterable
import json
import os
from pathlib import Path
import re
import time
from typing import Protocol

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.output.lines import normalised
from colcon_yamllaunch.engine.output.lines import prefixed
from colcon_yamllaunch.engine.output_modes import IN_COMMON_LOG
from colcon_yamllaunch.engine.output_modes import IN_OWN_LOG
from colcon_yamllaunch.observers.line_formats import Layout
from colcon_yamllaunch.observers.log_files import lock_folder
from colcon_yamllaunch.observers.log_files import LogFile
from colcon_yamllaunch.observers.log_files import Quota
from colcon_yamllaunch.plan.plan import Process

#: The log file of the whole launch, each line with a time stamp.
COMMON_LOG = 'launch.log'
#: The events of the launch, one JSON object a line.
EVENT_LOG = 'events.jsonl'
#: The log file of the process that speaks with ROS, where there is one.
CLIENT_LOG = 'ros_client.log'
#: The log file of a process that has both of its streams, as colcon names it.
COMBINED_LOG = 'stdout_stderr.log'

_NUMBER = re.compile(r'-\d+$')


class Store(Protocol):
    """The log folders of other launches; see `log_store`."""

    def tidy(self) -> bool:
        """Do a part of what there is to do; return whether there is more."""

    def allowed(self, used: int, wanted: int) -> int:
        """Make room for what this launch writes; return what it may take."""


class Logs:
    """
    Records what happens.

    What cannot be written is said once; the launch goes on.

    :param folder: The folder of the launch; made when it is missing
    :param processes: All that may be started
    :param complain: Is told that logs cannot be written
    :param limit: What all files may take together, in bytes, or None
    :param layout: How the lines in `launch.log` look that are no output of a
      process, or None for the usual way
    :param store: The folders of other launches, which get tidied up as soon
      as there is time, or None to leave them alone
    """

    def __init__(
        self,
        folder: Path,
        processes: Iterable[Process],
        complain: Callable[[str], None],
        now: Callable[[], float] = time.time,
        limit: int | None = None,
        layout: Layout | None = None,
        store: Store | None = None,
    ) -> None:
        processes = tuple(processes)
        self._folder = folder
        self._folders: dict[str, str] = {}
        #: For each label the log file that has both streams; it grows with
        #: the plan.
        self.combined_files: dict[str, Path] = {}
        self._store = store
        self._quota = Quota(
            limit,
            2 + 3 * len(processes),
            complain,
            None if store is None else store.allowed,
        )
        self._expect(processes)
        self._is_tidy = store is None
        self._layout = layout
        self._complain = complain
        self._complained = False
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
        if len(begun) + len(data) - end > limits.READ_SIZE:
            end = len(data)
        if not end:
            self._begun[key] = begun + data
            return
        if end < len(data):
            self._begun[key] = data[end:]
        self._write(combined, b''.join((begun, memoryview(data)[:end])))

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        if isinstance(event, events.Output):
            self._record_lines(event)
            return
        if isinstance(event, events.Started):
            self._unopened.append(event.process)
        elif isinstance(event, events.Planned):
            processes = [p for p in event.parts if isinstance(p, Process)]
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
        for _ in range(min(limits.OPENED_PER_TURN, len(self._unopened))):
            self._open_own(self._unopened.popleft())
        for (label, _), data in self._waiting.items():
            self._write(self._files[label][-1], data)
        self._waiting, self._begun = self._begun, {}
        self._write_collected()
        self._mind_lock()
        return bool(self._unopened or self._waiting) or self._tidy()

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

    def _record_lines(self, event: events.Output) -> None:
        process = event.process
        if process.output in IN_COMMON_LOG and self._common is not None:
            # who wants the lines of ROS 2 wants its names in them
            plain = self._layout is None
            name = process.label if plain else process.ros_name
            prefix = f'{self._stamp()}[{one_line(name)}] '.encode(
                errors='replace'
            )
            lines = prefixed(normalised(event.data), prefix)
            self._common_pending.append(lines)
            self._pending_size += len(lines)
            if self._pending_size > limits.COLLECTED_LOG:
                self._write_collected()

    def _write_collected(self) -> None:
        self._write(self._common, b''.join(self._common_pending))
        self._write(self._events, b''.join(self._event_pending))
        self._pending_size = 0
        self._common_pending.clear()
        self._event_pending.clear()

    def _tidy(self) -> bool:
        """Tidy up a bit more; return whether there is more to do."""
        if self._store is not None and not self._is_tidy:
            self._is_tidy = not self._store.tidy()
        return not self._is_tidy

    def _mind_lock(self) -> None:
        """Lock the folder again after somebody deleted it."""
        if self._lock is not None:
            if os.fstat(self._lock).st_nlink:
                return
            os.close(self._lock)
        self._lock = lock_folder(self._folder)

    def _common_lines(self, event: events.Event) -> list[str]:
        name, tag = event.label, f'[{event.label}]'
        if isinstance(event, events.Said):
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
            try:
                return LogFile(path, self._quota)
            except FileNotFoundError:
                path.parent.mkdir(parents=True, exist_ok=True)
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
        if not self._complained:
            self._complained = True
            self._complain(
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
        base = _shortened(base) or '_'
        name = base
        count = 1
        while name in taken:
            count += 1
            name = f'{base}-{count}'
        taken.add(name)
        names[label] = name
    return names


def _shortened(name: str) -> str:
    data = name.encode(errors='replace')[: limits.FOLDER_NAME_BYTES]
    return data.decode(errors='ignore')
