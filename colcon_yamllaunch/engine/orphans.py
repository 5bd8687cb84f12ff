# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Orphans: processes of a launch that lost the process that started them."""

from collections.abc import Collection
from collections.abc import Mapping
from dataclasses import replace
import os
import time

from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.common.escalation import WHOLE
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.engine.launch_settings import Settings
from colcon_yamllaunch.engine.process_starter import ProcessStarter
from colcon_yamllaunch.engine.stopping.guard_link import GuardLink
from colcon_yamllaunch.engine.stopping.launch_scan import Adopter
from colcon_yamllaunch.engine.stopping.launch_scan import find_orphans
from colcon_yamllaunch.engine.stopping.launch_scan import Known

#: Processes older than any launch of ours; see `young_processes`.
_ELDERS: set[tuple[str, int]] = set()


class OrphanFinder:
    """
    Finds the orphans of a launch.

    :param guard: Receives those that became children of the launcher
    """

    def __init__(
        self, settings: Settings, guard: GuardLink, starter: ProcessStarter
    ) -> None:
        self._settings = settings
        self._guard = guard
        self._starter = starter
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

    def adopted(
        self, ours: Collection[int], helpers: Collection[int]
    ) -> set[int]:
        """
        Return the children that we adopted, and tell the guard of them.

        :param ours: Those that we have started
        :param helpers: Those of them that are no processes of the plan
        """
        self.looked = self._settings.clock()
        adopted, new = self._settings.adoption.look(ours)
        if new:
            adopter = self._adopter(helpers)
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
        helpers: Collection[int],
    ) -> list[Orphan]:
        """
        Find processes of the launch; see `launch_scan.find_orphans`.

        :param numbers: Those of the processes of the plan
        :param helpers: Our children that are no processes of the plan
        """
        found = find_orphans(
            self._settings.identity,
            self._session,
            groups,
            with_leader,
            known=self._known,
            adopter=self._adopter(helpers),
            since=self._birth,
            elders=_ELDERS,
        )
        # what a helper that has ended left behind, or who was dropped
        return [
            orphan
            if orphan.number in numbers or orphan.group in helpers
            else replace(orphan, number=WHOLE)
            for orphan in found
        ]

    def _adopter(self, helpers: Collection[int]) -> Adopter:
        """Return what is known of our children."""
        is_exact = self._settings.adoption.is_exact
        others = set(helpers) if is_exact else None
        return Adopter(os.getpid(), self._starter.writers(), others)
