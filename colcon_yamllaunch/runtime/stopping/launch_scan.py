# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Which processes of the machine belong to a launch.

A process belongs to a launch when its environment carries the launch's mark,
when it is in a process group that the launch made, or when its parent
belongs. The mark finds those that left their group by setsid() after their
parent ended; it needs no privileges, and works for the guard, too, which is
no parent of theirs.

This module is part of the guard and imports little.
"""

from collections.abc import Collection
from collections.abc import Mapping
import os

from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.common.process_scan import running_processes
from colcon_yamllaunch.common.process_scan import RunningProcess
from colcon_yamllaunch.common.process_scan import variable_of

#: The environment variable that marks the processes of a launch; its value is
#: the identity of the launch, a dot, and the number of the process.
LAUNCH_ID_VARIABLE = 'COLCON_LAUNCH_ID'


def new_identity() -> str:
    """Return an identity that no other launch has."""
    return os.urandom(8).hex()


def find_orphans(
    identity: str,
    session: int,
    groups: Mapping[int, int],
    with_leader: Collection[int] = (),
) -> list[Orphan]:
    """
    Find the running processes of a launch, but those whose leader runs.

    :param session: The session of the launcher, as a group's id may have been
      given to somebody else after the group's end
    :param groups: The process groups that it made, with their numbers
    :param with_leader: The groups whose leader runs; a signal to the group
      reaches their processes, so these are left out
    """
    numbers: dict[int, int] = {}
    found: list[RunningProcess] = []
    children: dict[int, list[RunningProcess]] = {}
    for process in running_processes():
        number = _marked_number(process.pid, identity)
        if number is None and process.session == session:
            number = groups.get(process.group)
        if number is None:
            children.setdefault(process.parent, []).append(process)
        else:
            numbers[process.pid] = number
            found.append(process)
    # the list grows by the children of those that it has
    for parent in found:
        for child in children.pop(parent.pid, ()):
            numbers[child.pid] = numbers[parent.pid]
            found.append(child)
    return [
        Orphan(p.pid, p.birth, p.group, numbers[p.pid])
        for p in found
        if p.group not in with_leader
    ]


def _marked_number(pid: int, identity: str) -> int | None:
    value = variable_of(pid, LAUNCH_ID_VARIABLE) or ''
    owner, _, number = value.partition('.')
    if owner != identity:
        return None
    return int(number) if number.isdecimal() else None
