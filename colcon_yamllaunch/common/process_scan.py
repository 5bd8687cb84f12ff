# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The processes of the machine, read from /proc; see proc(5).

This module is part of the guard and imports little.
"""

from collections.abc import Iterator
import os

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass

_ENVIRONMENT_SIZE = 1 << 22
#: What is read of /proc/PID/stat at least; a single call returns all of it.
_STAT_SIZE = 1


@dataclass(frozen=True, slots=True)
class RunningProcess:
    """
    A process that runs; zombies do not.

    :param parent: The process id of its parent
    :param ticks: The time that processors have spent on it, in clock ticks
    :param birth: When it started, in ticks after boot; with the process id
      it names one process for good
    :param pages: Its resident memory
    """

    pid: int
    parent: int
    group: int
    session: int
    ticks: int
    birth: int
    pages: int


def need_proc() -> None:
    """
    See to it that there is /proc.

    :raises UserError: when it is not mounted
    """
    if not os.path.isdir('/proc/self/fd'):
        raise UserError(
            '/proc is not mounted, where the processes of a launch are found',
            'mount -t proc proc /proc',
        )


def running_processes() -> Iterator[RunningProcess]:
    """Read all processes that run."""
    try:
        names = os.listdir('/proc')
    except OSError:
        return
    for name in names:
        if name.isdigit():
            process = read_process(int(name))
            if process is not None:
                yield process


def young_processes(
    since: int, elders: set[tuple[str, int]]
) -> Iterator[RunningProcess]:
    """
    Read the processes that run and were born at some time or later.

    :param since: The time, in ticks after boot
    :param elders: Entries of /proc that are known to be older, with their
      inodes, which a later process does not get; brought up to date
    """
    try:
        with os.scandir('/proc') as entries:
            found = [(e.name, e.inode()) for e in entries if e.name.isdigit()]
    except OSError:
        return
    elders.intersection_update(found)
    for entry in found:
        process = None if entry in elders else read_process(int(entry[0]))
        if process is not None and process.birth >= since:
            yield process
        elif process is not None:
            elders.add(entry)


def read_process(pid: int) -> RunningProcess | None:
    """Read one process, or return None if it does not run."""
    values = _status(pid)
    if len(values) < 22 or values[0] in (b'Z', b'X'):
        return None
    parent, group, session = map(int, values[1:4])
    ticks = int(values[11]) + int(values[12])
    birth, pages = int(values[19]), int(values[21])
    return RunningProcess(pid, parent, group, session, ticks, birth, pages)


def is_alive(pid: int, birth: int) -> bool:
    """Return whether a process still runs that was started at a time."""
    process = read_process(pid)
    return process is not None and process.birth == birth


def is_suspended(pid: int) -> bool:
    """Return whether a process was stopped, as Ctrl-Z does it."""
    return _status(pid)[:1] in ([b'T'], [b't'])


def foreground_group(pid: int) -> int:
    """Return the group that has the terminal of a process, -1 for none."""
    values = _status(pid)
    return int(values[5]) if len(values) > 5 else -1


def variable_of(pid: int, name: str) -> str | None:
    """Return a variable that a process was started with, or None."""
    start = f'\0{name}='.encode()
    environment = b'\0' + _read(f'/proc/{pid}/environ', _ENVIRONMENT_SIZE)
    _, found, rest = environment.partition(start)
    return os.fsdecode(rest.partition(b'\0')[0]) if found else None


def arguments_of(pid: int) -> list[str]:
    """Return the command line of a process; empty if it does not run."""
    data = _read(f'/proc/{pid}/cmdline', _ENVIRONMENT_SIZE)
    return [os.fsdecode(word) for word in data.split(b'\0')[:-1]]


def cgroup_of(pid: int | str) -> str | None:
    """
    Return the path of the control group of a process; see cgroups(7).

    :param pid: The process, or `self`
    :return: Its path in the hierarchy of version 2, None if there is none
    """
    for line in _read(f'/proc/{pid}/cgroup', 1 << 16).splitlines():
        if line.startswith(b'0::'):
            return os.fsdecode(line[3:])
    return None


def _status(pid: int) -> list[bytes]:
    """Return what /proc/PID/stat has behind the name of the program."""
    # the name in parentheses may itself hold spaces and parentheses
    _, _, fields = _read(f'/proc/{pid}/stat', _STAT_SIZE).rpartition(b') ')
    return fields.split()


def _read(path: str, size: int) -> bytes:
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return b''
    try:
        data = chunk = os.read(descriptor, 4096)
        # /proc returns a page at a time
        while chunk and len(data) < size:
            chunk = os.read(descriptor, 1 << 16)
            data += chunk
        return data
    except OSError:
        return b''
    finally:
        os.close(descriptor)
