# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Which processes of the machine belong to a launch.

A process belongs to a launch when it is in the control group of the launch,
when its environment carries the launch's mark, when it is in a process group
that the launch made, when its parent belongs, or when it lost its parent and
became a child of the launcher. In the control group is all that there is, but
not every launch can have one. The mark finds those that left their group by
setsid() after their parent ended; it needs no privileges, and works for the
guard, too, which is no parent of theirs.

This module is part of the guard and imports little.
"""

from collections.abc import Collection, Mapping
from contextlib import suppress
import os
import re
import time
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.escalation import Orphan, WHOLE
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.process_scan import (
    arguments_of,
    read_process,
    running_processes,
    RunningProcess,
    variable_of,
    young_processes,
)
from colcon_yamllaunch.engine.cgroup import number_of

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.engine import EngineSettings
    from colcon_yamllaunch.engine.guard_link import GuardLink

#: The environment variable that marks the processes of a launch; its value is
#: the identity of the launch, a dot, and the number of the process.
LAUNCH_ID_VARIABLE = 'COLCON_LAUNCH_ID'

# a process id has 22 bits on Linux; so many are left for the time of birth,
# which repeats after a week
_BIRTHS = 1 << 26
_IDENTITY = re.compile('[0-9a-f]{16}').fullmatch

#: Processes with their numbers, by process id and birth.
Known = dict[tuple[int, int], int]


def new_identity() -> str:
    """
    Return an identity that no other launch has, of 16 hexadecimal digits.

    It identifies the launcher, see :func:`launcher_of`.
    """
    pid = os.getpid()
    process = read_process(pid)
    birth = 0 if process is None else process.birth % _BIRTHS
    chance = int.from_bytes(os.urandom(2), 'big')
    return f'{(pid * _BIRTHS + birth) << 16 | chance:016x}'


def launcher_of(identity: str) -> tuple[int, bool] | None:
    """
    Return the process id of a launcher, and whether it still runs.

    None is returned for what is no identity.
    """
    if not _IDENTITY(identity):
        return None
    pid, birth = divmod(int(identity, 16) >> 16, _BIRTHS)
    process = read_process(pid)
    return pid, process is not None and process.birth % _BIRTHS == birth


def is_guarded(identity: str) -> bool:
    """Return whether a guard stops, or will stop, what is left of a launch."""
    for process in running_processes():
        with suppress(OSError):
            # the last two are the identity and a session, see `guard`
            if arguments_of(process.pid)[-2:-1] == [identity]:
                return process.pid != os.getpid()
    return False


@dataclass(frozen=True, slots=True)
class Adopter:
    """
    The process that becomes the parent of orphans.

    :param pid: Its process id
    :param outputs: The ends that processes of the launch write to, as the
      links in /proc/PID/fd have them, with the numbers of the processes
    :param others: Its children that are none of the launch, or None if it may
      have any; then those are of the launch that write to an output
    """

    pid: int
    outputs: Mapping[str, int]
    others: Collection[int] | None

    def number_of(self, child: RunningProcess) -> int | None:
        """Return the number of what a child comes from; None if not ours."""
        if self.others is not None and child.pid in self.others:
            return None
        for descriptor in (1, 2):
            with suppress(OSError):
                link = os.readlink(f'/proc/{child.pid}/fd/{descriptor}')
                if link in self.outputs:
                    return self.outputs[link]
        return None if self.others is None else WHOLE


def find_orphans(
    identity: str,
    session: int,
    groups: Mapping[int, int],
    with_leader: Collection[int] = (),
    *,
    known: Known | None = None,
    adopter: Adopter | None = None,
    since: int = 0,
    elders: set[tuple[str, int]] | None = None,
) -> list[Orphan]:
    """
    Find the running processes of a launch whose group has no leader.

    This process is never one of them. The guard is a child of the launcher
    until that has ended, and a launcher that was killed while it started a
    process is in the control group of the launch.

    :param session: The session of the launcher, as the id of a group may be
      reused after its end
    :param groups: The process groups that it made, with their numbers
    :param with_leader: The groups whose leader runs; a signal to the group
      reaches their processes, so they are left out
    :param known: What was found before; brought up to date
    :param adopter: The parent of those that lost their own
    :param since: The birth of the launcher, if it is known; most processes of
      the machine are older and cannot belong to the launch
    :param elders: The older ones, see :func:`.young_processes`
    """
    known = {} if known is None else known
    numbers: dict[int, int] = {}
    found: list[RunningProcess] = []
    children: dict[int, list[RunningProcess]] = {}
    for process in young_processes(since, set() if elders is None else elders):
        if process.pid == os.getpid():
            continue
        number = number_of(process.pid, identity)
        if number is None:
            owner, marked = mark_of(process.pid)
            number = marked if owner == identity else None
        if number is None and process.session == session:
            number = groups.get(process.group)
        if number is None:
            number = known.get((process.pid, process.birth))
        if number is None:
            children.setdefault(process.parent, []).append(process)
        else:
            numbers[process.pid] = number
            found.append(process)
    if adopter is not None:
        for child in children.get(adopter.pid, ()):
            number = adopter.number_of(child)
            if number is not None:
                numbers[child.pid] = number
                found.append(child)
    # the list grows by the children of those that it has
    for parent in found:
        for child in children.pop(parent.pid, ()):
            if child.pid not in numbers:
                numbers[child.pid] = numbers[parent.pid]
                found.append(child)
    known.clear()
    known.update({(p.pid, p.birth): numbers[p.pid] for p in found})
    return [
        Orphan(p.pid, p.birth, p.group, numbers[p.pid])
        for p in found
        if p.group not in with_leader
    ]


def mark_of(pid: int) -> tuple[str, int | None]:
    """Return the launch that a process has the mark of, and its number."""
    value = variable_of(pid, LAUNCH_ID_VARIABLE) or ''
    owner, _, number = value.partition('.')
    return owner, int(number) if number.isdecimal() else None


#: Processes older than any launch of ours; see `young_processes`.
_ELDERS: set[tuple[str, int]] = set()


class OrphanFinder:
    """
    Finds the orphans of a launch.

    :param guard: Receives those that became children of the launcher
    :param helpers: Our children that are no processes of the plan; it changes
      with them
    """

    def __init__(
        self,
        settings: 'EngineSettings',
        guard: 'GuardLink',
        helpers: Collection[int],
    ) -> None:
        self._settings = settings
        self._guard = guard
        self._helpers = helpers
        self._session = os.getsid(0)
        own = read_process(os.getpid())
        self._birth = 0 if own is None else own.birth
        if self._birth and not settings.adoption.has_helpers:
            # nothing of the launch is there yet
            now = time.clock_gettime(time.CLOCK_BOOTTIME)
            self._birth = int(now * os.sysconf('SC_CLK_TCK')) - 1
        self._known: Known = {}
        #: When children were looked for last, by the clock.
        self.looked = settings.clock()

    def adopted(self, ours: Collection[int]) -> set[int]:
        """
        Return the children that we adopted; the guard receives new ones.

        :param ours: Those that we have started
        """
        self.looked = self._settings.clock()
        adopted, new = self._settings.adoption.check_children(ours)
        if new:
            adopter = self._adopter()
            for child in filter(None, map(read_process, new)):
                number = adopter.number_of(child)
                if number is not None:
                    self._guard.adopted(child.pid, child.birth, number)
        return adopted

    def orphans(
        self,
        groups: Mapping[int, int],
        with_leader: Collection[int],
        numbers: Collection[int],
    ) -> list[Orphan]:
        """
        Find processes of the launch; see :func:`find_orphans`.

        :param numbers: Those of the processes of the plan
        """
        found = find_orphans(
            self._settings.identity,
            self._session,
            groups,
            with_leader,
            known=self._known,
            adopter=self._adopter(),
            since=self._birth,
            elders=_ELDERS,
        )
        # left behind by a helper or a dropped process that has ended
        return [
            orphan
            if orphan.number in numbers or orphan.group in self._helpers
            else Orphan(orphan.pid, orphan.birth, orphan.group, WHOLE)
            for orphan in found
        ]

    def _adopter(self) -> Adopter:
        """Return what is known of our children."""
        is_exact = self._settings.adoption.is_exact
        others = set(self._helpers) if is_exact else None
        return Adopter(os.getpid(), self._guard.writers(), others)
