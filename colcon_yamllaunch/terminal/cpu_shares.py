# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which processes of a launch take much of a processor."""

from collections.abc import Mapping
import os

from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.engine.process import cgroup
from colcon_yamllaunch.terminal.status_model import MUCH_CPU

_TICKS = os.sysconf('SC_CLK_TCK')


class CpuShares:
    """
    Looks from time to time what processes take.

    While nothing takes much, that is one short file: of the control group of
    the launch, or else of the whole machine.
    """

    def __init__(self) -> None:
        self._processors = os.cpu_count() or 1
        # the time, and the seconds of processors that were taken until then
        self._before: tuple[float, float] | None = None
        self._seconds: dict[int, float] = {}
        self._folders: dict[int, str | None] = {}
        # of the whole launch
        self._folder: str | None = None

    def look(self, groups: Mapping[str, int], now: float) -> dict[str, float]:
        """
        Return the shares of one processor since the last look, by label.

        What takes little may be missing.

        :param groups: The process groups that run, by label
        :param now: Seconds of a clock that never goes back
        """
        taken = self._taken(now)
        before, self._before = self._before, (now, taken)
        if before is None:
            self._folder = _launch_folder(groups)
            self._before = (now, self._taken(now))
            return {}
        passed = now - before[0]
        if passed <= 0.0 or taken - before[1] < MUCH_CPU * passed:
            self._seconds = {}
            return {}
        last, self._seconds = self._seconds, {}
        shares = {}
        for label, group in groups.items():
            seconds = self._seconds[group] = self._spent(group)
            if group in last:
                shares[label] = max(0.0, seconds - last[group]) / passed
        self._folders = {g: self._folders[g] for g in self._seconds}
        return shares

    def _taken(self, now: float) -> float:
        """Return the seconds that the launch has taken, or all has."""
        if self._folder is not None:
            taken = cgroup.processor_time(self._folder)
            if taken is not None:
                return taken
        return self._processors * now - _idle_seconds()

    def _spent(self, group: int) -> float:
        """Return the seconds of processors that a process has taken."""
        if group not in self._folders:
            self._folders[group] = cgroup.process_folder(group)
        folder = self._folders[group]
        if folder is not None:
            spent = cgroup.processor_time(folder)
            if spent is not None:
                return spent
        leader = read_process(group)
        return 0.0 if leader is None else leader.ticks / _TICKS


def _launch_folder(groups: Mapping[str, int]) -> str | None:
    """Return the folder of the control group of a launch, if it has one."""
    for group in groups.values():
        folder = cgroup.process_folder(group)
        return None if folder is None else os.path.dirname(folder)
    return None


def _idle_seconds() -> float:
    try:
        with open('/proc/uptime', encoding='ascii') as stream:
            return float(stream.read().split()[1])
    except (OSError, ValueError, IndexError):
        # then it is not known that nothing is busy
        return 0.0
