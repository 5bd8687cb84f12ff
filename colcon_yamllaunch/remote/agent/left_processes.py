# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Ending what is left of a part whose engine, and perhaps guard, is gone."""

from collections.abc import Collection
from collections.abc import Mapping
from contextlib import suppress
import os
import signal
import time

from colcon_yamllaunch.common.escalation import Escalation
from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.common.escalation import Targets
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.common.escalation import WHOLE
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.engine.cgroup import LaunchCgroup
from colcon_yamllaunch.engine.launch_scan import find_orphans
from colcon_yamllaunch.engine.launch_scan import is_guarded
from colcon_yamllaunch.engine.launch_scan import Known
from colcon_yamllaunch.plan.plan import DEFAULT_SIGKILL_TIMEOUT
from colcon_yamllaunch.plan.plan import DEFAULT_SIGTERM_TIMEOUT

_TIMEOUTS = Timeouts(DEFAULT_SIGTERM_TIMEOUT, DEFAULT_SIGKILL_TIMEOUT)
_LOOK = 0.05


class _Left(Targets):
    """
    Processes with the mark of a launch, and their descendants.

    :param leader: A child of ours that leads a group and a session, or 0
    """

    def __init__(self, identity: str, leader: int) -> None:
        self._identity = identity
        self._leader = leader
        self._known: Known = {}
        pids = [orphan.pid for orphan in self.search(())]
        self._cgroup = LaunchCgroup.of_members(identity, pids)

    def groups(self) -> Mapping[int, int]:
        if self._leader and read_process(self._leader) is not None:
            return {self._leader: WHOLE}
        return {}

    def search(self, groups: Collection[int]) -> list[Orphan]:
        session = self._leader or -1
        made = {self._leader: WHOLE} if self._leader else {}
        return find_orphans(
            self._identity, session, made, groups, known=self._known
        )

    def kill(self, number: int) -> None:
        self._cgroup.kill(number)

    def remove(self) -> None:
        """Remove the control group."""
        self._cgroup.remove()


def end_what_is_left(
    identity: str, *, leader: int = 0, timeouts: Timeouts = _TIMEOUTS
) -> None:
    """
    End all processes of a launch, and wait for that.

    A guard is left to its work as long as there is one: it knows the
    time-outs of each process.

    :param leader: A child of ours that is to be ended, too
    """
    while is_guarded(identity):
        time.sleep(_LOOK)
    left = _Left(identity, leader)
    Escalation(left, {WHOLE: timeouts}, time.monotonic()).run()
    left.remove()


def end_in_any_case(identity: str, leader: int, timeouts: Timeouts) -> None:
    """
    End all processes of a request, even if this process is ended meanwhile.

    :param leader: A child of ours that is to be ended, too
    """
    pid = os.fork()
    if not pid:
        with suppress(BaseException):
            os.setsid()
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            end_what_is_left(identity, leader=leader, timeouts=timeouts)
        os._exit(0)
    os.waitpid(pid, 0)
