# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Launches whose launcher was killed, as other terminals see them.

Their processes have a mark that identifies the launcher. The record beside the
socket, which the launcher wrote, describes them. Usually the guard of the
launch stops them; if that was killed, too, they run until a user stops them.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
import json
import os
from pathlib import Path
import time
from typing import Any

from colcon_yamllaunch.common.escalation import (
    Escalation,
    Orphan,
    Targets,
    Timeouts,
)
from colcon_yamllaunch.common.process_scan import (
    running_processes,
    variable_of,
)
from colcon_yamllaunch.control.client import ControlError, LaunchEndedError
from colcon_yamllaunch.control.server import RECORD_SUFFIX
from colcon_yamllaunch.control.socket_folder import (
    FolderError,
    folders,
    open_folder,
)
from colcon_yamllaunch.engine.cgroup import LaunchCgroup
from colcon_yamllaunch.engine.commands import Command, Shutdown, Stop
from colcon_yamllaunch.engine.launch_scan import (
    find_orphans,
    is_guarded,
    Known,
    launcher_of,
    mark_of,
)
from colcon_yamllaunch.engine.own_files import (
    OwnFile,
    remove_file,
    remove_parameter_files,
)
from colcon_yamllaunch.engine.state import About, LaunchState, ProcessState
from colcon_yamllaunch.plan.plan import (
    DEFAULT_SIGKILL_TIMEOUT,
    DEFAULT_SIGTERM_TIMEOUT,
)

#: Why a launch without launcher refuses a command.
ONLY_STOPS = 'its launcher was killed; all that can be done is --stop'
#: Seconds between two looks while the guard stops the processes.
INTERVAL = 0.05
#: Bytes of the longest record that is read.
_RECORD = 1 << 24
_FLAGS = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
_TICKS = os.sysconf('SC_CLK_TCK')


class OrphanedLaunch(Targets):
    """
    A launch without launcher; it is asked as a `RunningLaunch` is.

    :param record: What the launcher has written, as far as it can be read
    :param remains: What is to be removed at the end
    """

    def __init__(
        self,
        identity: str,
        pid: int,
        record: Mapping[str, Any],
        remains: Sequence[OwnFile],
    ) -> None:
        self._identity = identity
        self._remains = remains
        self._parameters = _own_file(record.get('parameters'))
        self._stops: dict[int, Escalation] = {}
        self._chosen: set[int] = set()
        # what loses its parent by a signal may have nothing else that tells
        self._seen: Known = {}
        self._known: Sequence[Mapping[str, Any]] = record.get('processes', ())
        found = self.search()
        pids = (orphan.pid for orphan in found)
        self._cgroup = LaunchCgroup.of_members(identity, pids)
        self._numbers: dict[str, int] = {}
        about = About(
            str(record.get('title', 'a launch')),
            record.get('package'),
            str(record.get('file', '')),
            str(record.get('folder', '')),
        )
        self._state = state = LaunchState(about, pid, time.monotonic())
        state.log_folder = record.get('log_folder')
        state.log_files = {}
        self._note_guard()
        for number in sorted({o.number for o in found}):
            own = [o for o in found if o.number == number]
            process = _state(number, own, self._record(number))
            state.by_label[process.label] = process
            self._numbers[process.label] = number
            if process.log is not None:
                state.log_files[process.label] = process.log
            state.started = min(state.started, process.since)

    def close(self) -> None:
        """Do nothing, as there is no connection."""

    def refresh(self) -> LaunchState:
        """
        Take the steps of stopping that are due, and return its state.

        :raises LaunchEndedError: when nothing of it runs any more
        """
        now = time.monotonic()
        guarded = self._note_guard()
        if not guarded:
            self._begin_stops(now)
        for stop in self._stops.values():
            stop.advance(now)
        running = {o.number for o in self.search()}
        if not running:
            self.remove()
            raise LaunchEndedError
        over = {n for n, stop in self._stops.items() if stop.is_over}
        for process in self._state.processes:
            number = self._numbers[process.label]
            if number not in running:
                process.phase, process.pid = 'ended', None
                process.ending = 'stopped'
            elif number in over:
                process.ending = 'cannot be stopped'
            elif guarded or number in self._chosen:
                process.phase = 'stopping'
        return self._state

    def _note_guard(self) -> bool:
        """Return whether its guard stops it."""
        guarded = is_guarded(self._identity)
        self._state.stop_reason = 'its launcher was killed' if guarded else ''
        return guarded

    def do(
        self,
        command: Command[Any],
        waiting: Callable[[], None] | None = None,  # noqa: ARG002
    ) -> None:
        """
        Stop processes; other commands are refused.

        :raises ControlError: when the command is refused
        """
        match command:
            case Shutdown():
                self._chosen.update(self._numbers.values())
            case Stop():
                self._chosen.add(self._numbers[command.member])
            case _:
                raise ControlError(ONLY_STOPS)

    def wait_for_end(self, pid: int) -> None:  # noqa: ARG002
        """
        Wait until all is stopped.

        :raises ControlError: when something cannot be stopped
        """
        with suppress(LaunchEndedError):
            while True:
                state = self.refresh()
                if all(p.ending for p in state.processes):
                    break
                time.sleep(INTERVAL)
            left = [p for p in state.processes if p.pid is not None]
            labels = ', '.join(f'{p.label} (pid {p.pid})' for p in left)
            raise ControlError(f'not even SIGKILL ends {labels}')

    def search(self, groups: Collection[int] = ()) -> list[Orphan]:
        """Find all of its processes; see `Targets`."""
        # its groups are as good as gone: others may have their ids
        return find_orphans(self._identity, -1, {}, groups, known=self._seen)

    def kill(self, number: int) -> None:
        """Kill all of a process of the plan; see `Targets`."""
        self._cgroup.kill(number)

    def remove(self) -> None:
        """Remove what the launcher could not."""
        self._cgroup.remove()
        if self._parameters is not None:
            remove_parameter_files(self._parameters)
        for file in self._remains:
            remove_file(file)

    def _begin_stops(self, now: float) -> None:
        for number in self._chosen - set(self._stops):
            timeouts = Timeouts(
                *self._record(number).get(
                    'timeouts',
                    (DEFAULT_SIGTERM_TIMEOUT, DEFAULT_SIGKILL_TIMEOUT),
                )
            )
            targets = _OneProcess(self, number)
            self._stops[number] = Escalation(targets, {number: timeouts}, now)

    def _record(self, number: int) -> Mapping[str, Any]:
        """Return what the launcher has written about a process."""
        return self._known[number] if number < len(self._known) else {}


class _OneProcess(Targets):
    """The orphans of one process of a launch."""

    def __init__(self, launch: OrphanedLaunch, number: int) -> None:
        self._launch = launch
        self._number = number

    def search(self, groups: Collection[int]) -> list[Orphan]:
        found = self._launch.search(groups)
        return [o for o in found if o.number == self._number]

    def kill(self, number: int) -> None:
        self._launch.kill(number)


def orphaned_launches(environment: Mapping[str, str]) -> list[OrphanedLaunch]:
    """
    Return the launches of the user whose processes have lost their launcher.

    What others left that have none is removed.
    """
    socket_folders = folders(environment)
    records: _Records = {}
    for folder in socket_folders:
        records |= _records(folder)
    launches = []
    for identity in sorted({*records, *_marked(socket_folders)}):
        launcher = launcher_of(identity)
        # a record that makes no sense was cut off, or is of another version
        if launcher is not None and not launcher[1]:
            record, remains = records.get(identity, ({}, ()))
            launch = OrphanedLaunch(identity, launcher[0], record, remains)
            try:
                launch.refresh()
            except LaunchEndedError:
                continue
            launches.append(launch)
    return launches


def _marked(socket_folders: Collection[Path]) -> set[str]:
    """
    Return the launches that running processes have the mark of.

    They count as those do whose socket is found: if it would be in one of
    some folders.
    """
    found = set()
    for process in running_processes():
        owner, number = mark_of(process.pid)
        if owner and number is not None and owner not in found:
            with suppress(OSError):
                # a process id of a container means another process here
                if (
                    os.stat(f'/proc/{process.pid}').st_uid == os.getuid()
                    and _namespace(process.pid) == _namespace(os.getpid())
                    and folders(_variables(process.pid))[0] in socket_folders
                ):
                    found.add(owner)
    return found


def _namespace(pid: int) -> str:
    return os.readlink(f'/proc/{pid}/ns/pid')


def _variables(pid: int) -> dict[str, str]:
    return {
        # without one, that of this process would count
        'TMPDIR': variable_of(pid, 'TMPDIR') or '/tmp',
        'XDG_RUNTIME_DIR': variable_of(pid, 'XDG_RUNTIME_DIR') or '',
    }


_Records = dict[str, tuple[Mapping[str, Any], list[OwnFile]]]


def _records(folder: Path) -> _Records:
    """Return the records in a folder, by the identity of the launch."""
    found: _Records = {}
    try:
        descriptor = open_folder(folder, make=False)
    except (FileNotFoundError, FolderError):
        # it has no records; the search for sockets reports why
        return found
    try:
        for name in os.listdir(descriptor):
            if name.endswith(RECORD_SUFFIX):
                record = _read(descriptor, name)
                path = os.path.join(os.path.abspath(folder), name)
                with suppress(OSError):
                    found[str(record.get('identity'))] = (
                        record,
                        [OwnFile.of(path)],
                    )
    finally:
        os.close(descriptor)
    return found


def _read(folder: int, name: str) -> Mapping[str, Any]:
    with suppress(OSError, ValueError, RecursionError):
        descriptor = os.open(name, _FLAGS, dir_fd=folder)
        with open(descriptor, 'rb') as file:
            record = json.loads(file.read(_RECORD))
        if isinstance(record, dict):
            return record
    return {}


def _own_file(data: object) -> OwnFile | None:
    match data:
        case [str(path), int(device), int(inode)]:
            return OwnFile(path, device, inode)
    return None


def _state(
    number: int, found: Sequence[Orphan], record: Mapping[str, Any]
) -> ProcessState:
    """Describe what runs of a process of the plan."""
    leader = min(found, key=lambda o: (o.pid != o.group, o.birth))
    name = _name(leader.pid)
    uptime = time.clock_gettime(time.CLOCK_BOOTTIME)
    seconds = max(0.0, round(uptime - leader.birth / _TICKS, 3))
    return ProcessState(
        label=record.get('label', f'{name}-{number + 1}'),
        phase='running',
        pid=leader.pid,
        seconds=seconds,
        since=time.monotonic() - seconds,
        executable=record.get('executable', name),
        node=record.get('node'),
        package=record.get('package'),
        log=record.get('log'),
        name=record.get('name'),
    )


def _name(pid: int) -> str:
    try:
        with open(f'/proc/{pid}/comm', encoding='utf-8') as file:
            return file.read().strip()
    except (OSError, ValueError):
        return 'process'
