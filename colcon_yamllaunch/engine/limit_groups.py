# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Control groups that limit processes: where they can be made, and their files.

Linux accounts and limits by controllers (`cgroups(7)`, "Control Group v2" of
the kernel's documentation). A controller has to be enabled group by group,
from the root on, and no group but the root has both processes and enabled
controllers. Whoever manages the groups of a system, mostly systemd, delegates
some of them to others.

Only launches with limits import this.
"""

from collections.abc import Iterable, Mapping
import os
from pathlib import Path

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.table import size
from colcon_yamllaunch.engine import cgroup
from colcon_yamllaunch.plan.member_settings import ResourceLimits

#: The controllers that limits need, by the key of the limit.
CONTROLLERS = {
    'memory': 'memory',
    'memory_high': 'memory',
    'cpu': 'cpu',
    'cpus': 'cpuset',
    'io': 'io',
    'tasks': 'pids',
}
# of cpu.max, in microseconds; the kernel's default
_PERIOD = 100_000
# exists where systemd is the first process (sd_booted(3))
_SYSTEMD = '/run/systemd/system'
_DELEGATED = ('user.delegate', 'trusted.delegate')
# the names of controllers that have another one in version 1
_VERSION_1 = {'io': 'blkio'}
_HELP = 'see docs/deployment.md#limits'


@dataclass(frozen=True, slots=True)
class GroupSupport:
    """
    Which control groups with limits a launch can have.

    :param base: The folder of the group that they are made in; empty for none
    :param controllers: What can limit them
    :param reason: Why there are none, as a part of a sentence
    """

    base: str = ''
    controllers: frozenset[str] = frozenset()
    reason: str = ''

    def problem(self, controller: str) -> str | None:
        """Return why a controller cannot be used; None if it can."""
        if controller in self.controllers:
            return None
        return self.reason or (
            f"the control group of this launch lacks the controller '"
            f"{controller}'"
        )

    def hint(self, controller: str) -> str:
        """Return how a launch gets a controller on this machine."""
        if cgroup.CGROUP_VARIABLE in self.reason:
            return 'unset this variable'
        if _VERSION_1.get(controller, controller) in _mounted_in_version_1():
            return (
                f"this system has the controller '{controller}' in version 1: "
                f'boot it with systemd.unified_cgroup_hierarchy=1; {_HELP}'
            )
        if not os.path.isdir(_SYSTEMD):
            return (
                'in a container, let /sys/fs/cgroup be its own and writable '
                f'(docker run --privileged --cgroupns=private); {_HELP}'
            )
        user = os.geteuid()
        manager = (
            f'/sys/fs/cgroup/user.slice/user-{user}.slice/user@{user}.service'
        )
        if user and controller not in _controllers(manager):
            return (
                'let systemd delegate it: Delegate=cpu cpuset io memory pids '
                'in /etc/systemd/system/user@.service.d/delegate.conf, and '
                f'log in again; {_HELP}'
            )
        scope = 'systemd-run --user' if user else 'systemd-run'
        return (
            'launch in a scope of its own: '
            f'{scope} --scope -p Delegate=yes colcon launch …; {_HELP}'
        )


def group_support(environment: Mapping[str, str]) -> GroupSupport:
    """Return which control groups with limits a launch can have here."""
    if not cgroup.is_wanted(environment):
        return GroupSupport(
            reason=f'{cgroup.CGROUP_VARIABLE}=0 switches control groups off'
        )
    home = cgroup.own_folder()
    if home is None:
        return GroupSupport(
            reason='this system shows no control group of version 2'
        )
    for base in (os.path.dirname(home), home):
        if _is_ours(base, is_parent=base != home):
            return GroupSupport(base, _controllers(base))
    return GroupSupport(
        reason='no control group is delegated to this launch alone'
    )


def limit_files(
    limits: ResourceLimits, controllers: Iterable[str]
) -> dict[str, str]:
    """
    Return the files of a control group with limits, and their contents.

    :param controllers: Those that are enabled
    """
    files: dict[str, str] = {}
    if limits.memory is not None:
        files['memory.max'] = str(limits.memory)
        # all of it ends, as half of a program would hang
        files['memory.oom.group'] = '1'
    if limits.memory_high is not None:
        files['memory.high'] = str(limits.memory_high)
    if limits.cpu is not None:
        files['cpu.max'] = f'{round(limits.cpu * _PERIOD)} {_PERIOD}'
    if limits.cpus:
        files['cpuset.cpus'] = ','.join(map(str, limits.cpus))
    if limits.io is not None:
        files['io.weight'] = str(limits.io)
    if limits.tasks is not None:
        files['pids.max'] = str(limits.tasks)
    return {
        name: value
        for name, value in files.items()
        if name.partition('.')[0] in controllers
    }


def adapted(folder: str, files: Mapping[str, str]) -> dict[str, str]:
    """
    Return the limits under the names of the files that a group has.

    :param folder: The folder of a group with the same controllers
    """
    found = dict(files)
    bfq = 'io.bfq.weight'
    if 'io.weight' in files and os.path.exists(f'{folder}/{bfq}'):
        # of the scheduler bfq; the other one is of iocost
        found[bfq] = files['io.weight']
        if not os.path.exists(f'{folder}/io.weight'):
            del found['io.weight']
    swap = 'memory.swap.max'
    if 'memory.max' in files and os.path.exists(f'{folder}/{swap}'):
        # else a process over its limit would only become slow
        found[swap] = '0'
    return found


def exceeded(folder: str, limits: ResourceLimits, *, killed: bool) -> str:
    """
    Return which limit of its group a process has exceeded, or an empty text.

    :param killed: Whether SIGKILL ended it
    """
    events = _numbers(f'{folder}/memory.events')
    if killed and events.get('oom_kill'):
        peak = cgroup.number_in(f'{folder}/memory.peak')
        # Linux before 5.19 does not know it
        shown = '' if peak is None else f', peak {_size(peak)}'
        if limits.memory is not None and events.get('oom'):
            return f'over its {_size(limits.memory)} limit{shown}'
        return f'the system ran out of memory{shown}'
    refused = _numbers(f'{folder}/pids.events').get('max')
    if limits.tasks is not None and refused and not killed:
        return f'at its limit of {limits.tasks} tasks'
    return ''


def has_weights() -> bool:
    """Return whether any disk is divided by weights (`io`)."""
    schedulers = Path('/sys/block').glob('*/queue/scheduler')
    if any('[bfq]' in cgroup.words_in(str(path)) for path in schedulers):
        return True
    return 'enable=1' in cgroup.words_in('/sys/fs/cgroup/io.cost.qos')


def _is_ours(folder: str, *, is_parent: bool) -> bool:
    """
    Return whether we may make groups with limits in a group.

    :param is_parent: Whether we are in a group inside it, not in itself
    """
    control = f'{folder}/cgroup.subtree_control'
    if not (os.access(control, os.W_OK) and os.access(folder, os.W_OK)):
        return False
    is_root = cgroup.is_root(folder)
    is_delegated = _is_delegated(folder) or not os.path.isdir(_SYSTEMD)
    if is_parent:
        # that of a launch has the limits of this process
        is_free = is_root or not cgroup.own_members(folder)
        inside = cgroup.is_of_launch(folder)
        return is_free and is_delegated and not inside
    return (
        is_root
        or is_delegated
        or cgroup.is_of_launch(folder)
        or cgroup.own_members(folder) <= _family()
    )


def _is_delegated(folder: str) -> bool:
    """Return whether systemd has delegated a group (Delegate=yes)."""
    # to the manager of a user, which is no one else's
    if os.path.basename(folder).startswith('user@'):
        return False
    for name in _DELEGATED:
        try:
            if os.getxattr(folder, name) == b'1':
                return True
        except OSError:
            continue
    return False


def _family() -> set[int]:
    """Return this process, and all that it has started."""
    # few launches need it
    from colcon_yamllaunch.common.process_scan import running_processes

    parents = {p.pid: p.parent for p in running_processes()}
    found = {os.getpid()}
    while more := {p for p, q in parents.items() if q in found} - found:
        found |= more
    return found


def _mounted_in_version_1() -> set[str]:
    try:
        with open('/proc/self/cgroup') as file:
            lines = file.read().splitlines()
    except OSError:
        return set()
    return {
        name
        for line in lines
        for name in line.split(':')[1].split(',')
        if name
    }


def _controllers(folder: str) -> frozenset[str]:
    return frozenset(cgroup.words_in(f'{folder}/cgroup.controllers'))


def _numbers(path: str) -> dict[str, int]:
    words = cgroup.words_in(path)
    return dict(zip(words[::2], map(int, words[1::2]), strict=False))


def _size(number: int) -> str:
    return size(number).replace('.0 ', ' ')
