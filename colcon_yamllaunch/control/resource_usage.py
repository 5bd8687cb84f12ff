# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The CPU share and memory of the processes of launches."""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
import os
import time

from colcon_yamllaunch.common.process_scan import running_processes
from colcon_yamllaunch.engine import cgroup
from colcon_yamllaunch.engine.state import ProcessState

#: Seconds between the two measurements of a CPU share.
INTERVAL = 0.2

_TICKS = os.sysconf('SC_CLK_TCK')
_PAGE = os.sysconf('SC_PAGE_SIZE')


@dataclass(frozen=True, slots=True)
class Usage:
    """
    What a process of a launch uses, with all that it started.

    Where there is a control group, that is all in it. Otherwise it is what
    is in its process group.

    :param cpu: Its share of one processor, 1.0 for all of it
    :param memory: Its memory in bytes: what its control group is charged
      with, or else the resident memory of its processes; what these
      share counts for each then
    """

    cpu: float
    memory: int


def use_of(process: ProcessState, usage: Mapping[int, Usage]) -> Usage | None:
    """
    Return what a process uses, as far as that is known.

    :param usage: What the process groups of this machine use
    """
    if process.machine is None:
        return None if process.pid is None else usage.get(process.pid)
    if process.cpu is None or process.memory is None:
        return None
    return Usage(process.cpu, process.memory)


def usage_of(
    groups: Collection[int],
    sleep: Callable[[float], None] = time.sleep,
    clock: Callable[[], float] = time.monotonic,
) -> dict[int, Usage]:
    """
    Return what processes use that run.

    :param groups: The process groups that they lead
    """
    if not groups:
        return {}
    begin = sample_usage(groups, clock)
    sleep(INTERVAL)
    return usage_between(begin, sample_usage(groups, clock))


@dataclass(frozen=True, slots=True)
class UsageSample:
    """
    What processes had used until a time.

    :param time: The seconds of a clock
    :param seconds: The seconds of processors by process group
    :param sizes: The bytes of memory, likewise
    """

    time: float
    seconds: Mapping[int, float]
    sizes: Mapping[int, int]


def sample_usage(
    groups: Iterable[int], clock: Callable[[], float] = time.monotonic
) -> UsageSample:
    """Return what process groups have used until now."""
    now = clock()
    cgroups = {group: cgroup.process_folder(group) for group in groups}
    ticks, sizes, resident = Counter[int](), Counter[int](), Counter[int]()
    for process in running_processes():
        resident[process.pid] = process.pages * _PAGE
        if process.group in cgroups:
            ticks[process.group] += process.ticks
            sizes[process.group] += resident[process.pid]
    seconds = {group: count / _TICKS for group, count in ticks.items()}
    for group, folder in cgroups.items():
        if folder is None or group not in seconds:
            continue
        spent = cgroup.processor_time(folder)
        if spent is None:
            # it ended, and its group with it
            continue
        seconds[group] = spent
        charged = cgroup.memory(folder)
        if charged is None:
            charged = sum(resident[pid] for pid in cgroup.members(folder))
        sizes[group] = charged
    return UsageSample(now, seconds, sizes)


def usage_between(first: UsageSample, second: UsageSample) -> dict[int, Usage]:
    """Return what those that ran at a second look used since the first."""
    passed = max(second.time - first.time, INTERVAL)
    return {
        group: Usage(
            # a process that ended meanwhile took its time with it
            max(0.0, now - first.seconds.get(group, now)) / passed,
            second.sizes[group],
        )
        for group, now in second.seconds.items()
    }
