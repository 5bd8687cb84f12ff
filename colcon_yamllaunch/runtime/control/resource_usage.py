# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What process groups use of the machine."""

from collections import Counter
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


def usage_of(
    groups: Collection[int],
    sleep: Callable[[float], None] = time.sleep,
    clock: Callable[[], float] = time.monotonic,
) -> dict[int, Usage]:
    """Return for each process group that runs what it uses."""
    if not groups:
        return {}
    begin = clock()
    first, _ = _totals(groups)
    sleep(INTERVAL)
    ticks, pages = _totals(groups)
    seconds = max(clock() - begin, INTERVAL)
    return {
        group: Usage(
            # a process that ended meanwhile took its time with it
            max(0, now - first.get(group, now)) / _TICKS / seconds,
            pages[group] * _PAGE,
        )
        for group, now in ticks.items()
    }


def _totals(groups: Collection[int]) -> tuple[Counter[int], Counter[int]]:
    """Return the processor time in ticks and the memory in pages."""
    ticks, pages = Counter[int](), Counter[int]()
    for process in running_processes():
        if process.group in groups:
            ticks[process.group] += process.ticks
            pages[process.group] += process.pages
    return ticks, pages
