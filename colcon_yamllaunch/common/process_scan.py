# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The processes of a launch, found in /proc.

A process belongs to a launch when its environment carries the launch's mark,
when it is in a process group that the launch made, or when its parent
belongs. The mark finds those that left their group by setsid() after their
parent ended; it needs no privileges, and works for the guard, too, which is
no parent of theirs.

This module is part of the guard and imports little.
"""

from collections.abc import Iterable
from collections.abc import Mapping
import os

from colcon_yamllaunch.common.frozen import dataclass

#: The environment variable that marks the processes of a launch; its value is
#: the identity of the launch, a dot, and the number of the process.
MARK = 'COLCON_LAUNCH_ID'

_ENVIRONMENT_SIZE = 1 << 22


@dataclass(frozen=True, slots=True)
class Member:
    """
    A running process of a launch.

    :param pid: Its process id
    :param birth: When it started, in ticks after boot; with the process id
      it names one process for good
    :param group: Its process group
    :param number: The process of the plan that it comes from, or -1
    """

    pid: int
    birth: int
    group: int
    number: int


@dataclass(frozen=True, slots=True)
class _Entry:
    pid: int
    parent: int
    group: int
    session: int
    birth: int


def new_identity() -> str:
    """Return an identity that no other launch has."""
    return os.urandom(8).hex()


def find_members(
    identity: str, groups: Mapping[int, int], session: int
) -> list[Member]:
    """
    Find the running processes of a launch; zombies do not count.

    :param identity: The identity of the launch
    :param groups: The process groups that it made, with their numbers
    :param session: The session of the launcher, as a group's id may have been
      given to somebody else after the group's end
    """
    mark = f'{MARK}={identity}.'.encode()
    numbers: dict[int, int] = {}
    others: list[_Entry] = []
    found: list[_Entry] = []
    for entry in _running():
        number = _marked_number(entry.pid, mark)
        if number is None and entry.session == session:
            number = groups.get(entry.group)
        if number is None:
            others.append(entry)
        else:
            numbers[entry.pid] = number
            found.append(entry)
    found.extend(_descendants(others, numbers))
    return [Member(e.pid, e.birth, e.group, numbers[e.pid]) for e in found]


def is_alive(member: Member) -> bool:
    """Tell whether a process still runs."""
    entry = _read_entry(member.pid)
    return entry is not None and entry.birth == member.birth


def _descendants(
    others: Iterable[_Entry], numbers: dict[int, int]
) -> list[_Entry]:
    children: dict[int, list[_Entry]] = {}
    for entry in others:
        children.setdefault(entry.parent, []).append(entry)
    found: list[_Entry] = []
    pending = list(numbers)
    while pending:
        parent = pending.pop()
        for entry in children.pop(parent, ()):
            numbers[entry.pid] = numbers[parent]
            found.append(entry)
            pending.append(entry.pid)
    return found


def _running() -> Iterable[_Entry]:
    try:
        names = [e.name for e in os.scandir('/proc') if e.name.isdigit()]
    except OSError:
        return
    for name in names:
        entry = _read_entry(int(name))
        if entry is not None:
            yield entry


def _read_entry(pid: int) -> _Entry | None:
    # the name in parentheses may itself hold spaces and parentheses
    _, _, fields = _read(f'/proc/{pid}/stat', 1024).rpartition(b') ')
    values = fields.split()
    if len(values) < 20 or values[0] in (b'Z', b'X'):
        return None
    return _Entry(
        pid, int(values[1]), int(values[2]), int(values[3]), int(values[19])
    )


def _marked_number(pid: int, mark: bytes) -> int | None:
    environment = b'\0' + _read(f'/proc/{pid}/environ', _ENVIRONMENT_SIZE)
    start = environment.find(b'\0' + mark)
    if start == -1:
        return None
    start += 1 + len(mark)
    digits = environment[start : start + 20].partition(b'\0')[0]
    return int(digits) if digits.isdigit() else -1


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
