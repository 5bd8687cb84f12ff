# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What process groups use of the machine."""

from collections.abc import Callable
from collections.abc import Collection
from dataclasses import dataclass
import os
import time

from colcon_yamllaunch.common.process_scan import running_processes

#: Seconds between two looks that a share of a processor is computed from.
INTERVAL = 0.2

_TICKS = os.sysconf('SC_CLK_TCK')
_PAGE = os.sysconf('SC_PAGE_SIZE')


@dataclass(frozen=True, slots=True)
class Usage:
    """
    What a process group uses.

    :param cpu: Its share of one processor, 1.0 for all of it
    :param memory: Its resident memory in bytes; what its processes
      share counts for each
    """

    cpu: float
    memory: int


@dataclass(slots=True)
class _Sum:
    ticks: int = 0
    pages: int = 0


def usage_of(
    groups: Collection[int],
    sleep: Callable[[float], None] = time.sleep,
    clock: Callable[[], float] = time.monotonic,
) -> dict[int, Usage]:
    """
    Return for each process group that runs what it uses.

    :param groups: The ids of the groups
    :param sleep: Waits between two looks
    :param clock: Returns the time in seconds
    """
    if not groups:
        return {}
    begin = clock()
    first = _sums(groups)
    sleep(INTERVAL)
    second = _sums(groups)
    seconds = max(clock() - begin, INTERVAL)
    return {
        group: Usage(
            # a process that ended meanwhile took its time with it
            max(0, now.ticks - first.get(group, now).ticks) / _TICKS / seconds,
            now.pages * _PAGE,
        )
        for group, now in second.items()
    }


def _sums(groups: Collection[int]) -> dict[int, _Sum]:
    result: dict[int, _Sum] = {}
    for process in running_processes():
        if process.group in groups:
            total = result.setdefault(process.group, _Sum())
            total.ticks += process.ticks
            total.pages += process.pages
    return result
