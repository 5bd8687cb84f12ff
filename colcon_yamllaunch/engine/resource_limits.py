# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The limits of processes: what is possible here, and how each one is started.

:func:`problems_of` finds out before anything starts what cannot be set, so
that a limit is never ignored. :class:`ProcessLimits` prepares the control
groups (:mod:`.limit_groups`), starts processes (:mod:`.limited_spawn`), and
says which limit ended one.

Only launches with limits import this.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
import os

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.engine.cgroup import LaunchCgroup
from colcon_yamllaunch.engine.limit_groups import (
    adapted,
    CONTROLLERS,
    exceeded,
    group_support,
    GroupSupport,
    has_weights,
    limit_files,
)
from colcon_yamllaunch.engine.limited_spawn import (
    available_cpus,
    can_schedule,
    LimitedSpawn,
    Problem,
    Restrictions,
    tried,
    user_of,
)
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.spawn import StartError
from colcon_yamllaunch.plan.member_settings import ResourceLimits, Scheduling
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position

#: Limits that a process can have without a control group: `memory` by
#: RLIMIT_DATA, `cpus` by sched_setaffinity().
_WITHOUT_GROUP = ('memory', 'cpus')
_SIGKILL = 9


@dataclass(frozen=True, slots=True)
class LimitProblem:
    """
    A setting that this machine cannot give to a process.

    :param key: The key of the deployment file
    :param problem: Why
    :param hint: How to fix it
    """

    label: str
    key: str
    position: Position | None
    problem: str
    hint: str | None = None


def problems_of(
    processes: Iterable[Process], environment: Mapping[str, str]
) -> list[LimitProblem]:
    """
    Return the settings that this machine cannot give to processes.

    A line that several processes have in common is one problem.

    :param environment: The variables of the launch
    """
    check = _Check(environment)
    found: dict[object, LimitProblem] = {}
    for process in processes:
        if process.settings is not None and process.settings.is_restricted:
            for problem in check.problems_of(process):
                found.setdefault((problem.position, problem.problem), problem)
    return list(found.values())


class _Check:
    """Finds settings that cannot be given; asks the system once for each."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = environment
        self._support: GroupSupport | None = None
        self._tried: dict[Restrictions, list[Problem]] = {}

    def problems_of(self, process: Process) -> Iterable[LimitProblem]:
        """Iterate over the settings that a process cannot be given."""
        assert process.settings is not None
        settings = process.settings
        limits = settings.limits or ResourceLimits()
        found = {
            **self._refused(limits, settings.user),
            **self._without_group(limits),
            **self._impossible(limits, settings.user),
        }
        for key, (problem, hint) in sorted(
            found.items(),
            key=lambda item: (
                settings.place(item[0]).line,
                settings.place(item[0]).column,
            ),
        ):
            place = settings.place(key)
            yield LimitProblem(process.label, key, place, problem, hint)

    def _without_group(
        self, limits: ResourceLimits
    ) -> dict[str, tuple[str, str | None]]:
        """Return the limits that need a control group that is not there."""
        found: dict[str, tuple[str, str | None]] = {}
        for key in _group_keys(limits):
            if self._support is None:
                self._support = group_support(self._environment)
            controller = CONTROLLERS[key]
            reason = self._support.problem(controller)
            if reason is not None and key not in _WITHOUT_GROUP:
                found[key] = (
                    f"'{key}' cannot be limited here: {reason}",
                    self._support.hint(controller),
                )
        if limits.io is not None and 'io' not in found and not has_weights():
            found['io'] = (
                "'io' has no effect here: no disk divides its time by weight",
                'let one do so: echo bfq > /sys/block/DISK/queue/scheduler',
            )
        return found

    def _refused(
        self, limits: ResourceLimits, user: str
    ) -> dict[str, tuple[str, str | None]]:
        """Return what the system refuses, as a fork of this process finds."""
        scheduling = limits.scheduling
        if scheduling is not None and not can_schedule(scheduling):
            limits = replace(limits, scheduling=None)
        if not _exists(user):
            user = ''
        wanted = Restrictions(replace(limits, memory=None), user)
        if wanted not in self._tried:
            self._tried[wanted] = tried(wanted)
        return {
            problem[0]: explanation(problem, limits, user)
            for problem in self._tried[wanted]
        }

    def _impossible(
        self, limits: ResourceLimits, user: str
    ) -> dict[str, tuple[str, str | None]]:
        found: dict[str, tuple[str, str | None]] = {}
        if not _exists(user):
            import pwd

            names = [entry.pw_name for entry in pwd.getpwall()]
            found['user'] = (
                f"there is no user '{user}'",
                did_you_mean(user, names) or f'create it: useradd -m {user}',
            )
        if limits.scheduling is not None:
            is_deadline = limits.scheduling.policy == 'deadline'
            if not can_schedule(limits.scheduling):
                found['scheduling'] = (
                    "'deadline' is not known on this kind of machine",
                    'scheduling: {fifo: PRIORITY}',
                )
            elif is_deadline and limits.cpus:
                found['scheduling'] = (
                    "'deadline' and 'cpus' exclude one another in Linux "
                    '(sched_setattr(2))',
                    "remove 'cpus', or use fifo",
                )
        return found


def explanation(
    problem: Problem, limits: ResourceLimits, user: str
) -> tuple[str, str | None]:
    """Return what the system refuses, and what to do about that."""
    key, number = problem
    reason = os.strerror(number)
    match key:
        case 'nice':
            return (
                f'this user may not set the nice value {limits.nice}: '
                f'{reason}',
                _permission(f'nice {limits.nice}', 'ulimit -e'),
            )
        case 'scheduling':
            assert limits.scheduling is not None
            return _scheduling_refused(limits.scheduling, reason)
        case 'oom':
            return (
                f'the launch may not lower oom to {limits.oom}: {reason}',
                'start it with CAP_SYS_RESOURCE, as root does, or give other '
                'processes a higher value',
            )
        case 'cpus':
            there = ', '.join(map(str, sorted(available_cpus())))
            missing = set(limits.cpus) - available_cpus()
            which = ', '.join(map(str, sorted(missing)))
            return (
                f'the launch has no processor {which}',
                f'it may run on {there}',
            )
        case 'user':
            return (
                f"only root may start a process as '{user}': {reason}",
                "remove 'user', or start the launch as root, such as a "
                'service of the system',
            )
        case _:
            return f"'{key}' cannot be set: {reason}", None


def _permission(limit: str, shown_by: str) -> str:
    """
    Return how to get a permission.

    :param limit: An item and a value of limits.conf(5)
    :param shown_by: The command that shows the limit
    """
    if not os.geteuid():
        return (
            'root lacks CAP_SYS_NICE here, as in a container: '
            'docker run --cap-add SYS_NICE'
        )
    return (
        f"allow it by '{_own_name()} - {limit}' in "
        f'/etc/security/limits.d/robot.conf, and log in again ({shown_by}), '
        'or start the launch with CAP_SYS_NICE'
    )


def _scheduling_refused(
    scheduling: Scheduling, reason: str
) -> tuple[str, str]:
    if scheduling.policy == 'deadline':
        return (
            f"the launch may not use 'deadline': {reason}",
            'start it with CAP_SYS_NICE, as root does; all such processes '
            'together may use 95 % of the processors',
        )
    priority = scheduling.priority
    return (
        f'this user may not set the priority {scheduling.policy} {priority}: '
        f'{reason}',
        _permission(f'rtprio {priority}', 'ulimit -r'),
    )


class ProcessLimits:
    """
    The limits of the processes of a launch.

    :param group: The control group of the launch
    :param environment: The variables of the launch
    """

    def __init__(
        self, group: LaunchCgroup, environment: Mapping[str, str]
    ) -> None:
        self._group = group
        self._support = group_support(environment)
        # those that are enabled
        self._controllers: frozenset[str] = frozenset()
        # the groups of processes that run, with their limits
        self._running: dict[int, tuple[str, ResourceLimits]] = {}

    def prepare(self, processes: Mapping[int, Process]) -> list[str]:
        """
        Make the groups of processes with limits, before anything starts.

        Return warnings about limits that are weaker than they seem.

        :param processes: Those with limits, by their numbers in the plan
        :raises UserError: when a limit cannot be set
        """
        limits = {
            number: process.settings.limits
            for number, process in processes.items()
            if process.settings and process.settings.limits
        }
        keys = {key for each in limits.values() for key in _group_keys(each)}
        wanted = {CONTROLLERS[key] for key in keys}
        self._enable(frozenset(wanted & self._support.controllers))
        for number, each in limits.items():
            process = processes[number]
            try:
                self._folder(number, each)
            except OSError as error:
                assert process.settings is not None
                raise UserError(
                    f'the control group of {process.label} does not take its '
                    f'limits: {error.strerror}: {error.filename or ""}',
                    place=str(process.settings.position),
                ) from error
        if 'memory' not in keys or 'memory' in self._controllers:
            return []
        reason = self._support.problem('memory')
        return [
            f"'memory' limits each process by RLIMIT_DATA, and not all that "
            f'belongs to it together, as {reason}; '
            f'{self._support.hint("memory")}'
        ]

    def spawn_of(self, number: int, process: Process) -> LimitedSpawn:
        """
        Return what starts a process with its limits.

        :param number: Its number in the plan
        :raises StartError: when a limit cannot be set
        """
        assert process.settings is not None
        limits = process.settings.limits or ResourceLimits()
        user = process.settings.user
        for key in _group_keys(limits):
            if key not in _WITHOUT_GROUP and (
                CONTROLLERS[key] not in self._controllers
            ):
                # of a process that was added to the launch
                controller = CONTROLLERS[key]
                reason = self._support.problem(controller) or (
                    'no process had such a limit when the launch began'
                )
                raise StartError(f"'{key}' cannot be limited: {reason}")
        try:
            folder = self._folder(number, limits)
        except OSError as error:
            raise StartError(
                f'its control group does not take its limits: {error.strerror}'
            ) from error
        is_own = limits.memory is not None and (
            'memory' not in self._controllers
        )
        restrictions = Restrictions(limits, user, folder, is_own)
        return LimitedSpawn(
            restrictions,
            lambda problem: StartError(*explanation(problem, limits, user)),
        )

    def started(self, number: int, pid: int, process: Process) -> None:
        """Note that a process runs."""
        settings = process.settings
        if self._controllers and settings is not None and settings.limits:
            folder = f'{self._group.folder}/{number}'
            self._running[pid] = folder, settings.limits

    def explained(self, pid: int, outcome: Outcome) -> Outcome:
        """Return how a process ended, with the limit that it exceeded."""
        folder, limits = self._running.pop(pid, ('', ResourceLimits()))
        if not folder or outcome.code == 0:
            return outcome
        killed = outcome.signal == _SIGKILL
        return replace(outcome, limit=exceeded(folder, limits, killed=killed))

    def _enable(self, controllers: frozenset[str]) -> None:
        """
        Enable controllers.

        :raises UserError: when that is not possible
        """
        if not controllers:
            return
        base = self._support.base
        try:
            self._group.use(base, controllers)
        except OSError as error:
            raise UserError(
                f'no control group with limits can be made in {base}: '
                f'{error.strerror}',
                self._support.hint(min(controllers)),
            ) from error
        self._controllers = controllers

    def _folder(self, number: int, limits: ResourceLimits) -> str | None:
        """
        Make the group of a process; return its folder, None for no group.

        :raises OSError: when it does not take a limit
        """
        files = limit_files(limits, self._controllers)
        if files:
            files = adapted(self._group.folder, files)
        return self._group.prepare(number, files)


def _group_keys(limits: ResourceLimits) -> list[str]:
    """Return the keys of limits that a control group can have."""
    return [
        key for key in CONTROLLERS if getattr(limits, key) not in (None, ())
    ]


def _exists(user: str) -> bool:
    try:
        return not user or user_of(user) is not None
    except KeyError:
        return False


def _own_name() -> str:
    import pwd

    try:
        return pwd.getpwuid(os.geteuid()).pw_name
    except KeyError:
        return str(os.geteuid())
