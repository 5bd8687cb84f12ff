# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The processes of a build, found by a variable that they inherit.

When a launch is killed while it builds, its make and its compilers go on, and
would write into the folders of the next build.
"""

from collections.abc import Callable
from collections.abc import Collection
import os
from pathlib import Path
import signal
import time

from colcon_yamllaunch.common.adoption import Adoption
from colcon_yamllaunch.common.escalation import Escalation
from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.common.escalation import Targets
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.common.process_scan import running_processes
from colcon_yamllaunch.common.process_scan import RunningProcess
from colcon_yamllaunch.common.process_scan import variable_of

#: The variable that the processes of a build have; its value is the process
#: id of the launch, a colon, and the build folder.
BUILD_ID_VARIABLE = 'COLCON_LAUNCH_BUILD'
#: How long they have after SIGTERM, with which their end begins (seconds).
PATIENCE = 2.0


class BuildProcesses(Targets):
    """
    The running processes of builds.

    They have the variable, or their parent is one of them. Who has neither
    any more is a child of this process, where that adopts orphans.

    :param build_base: The build folder whose builds are meant; without it,
      those that this process has started
    :param adoption: What knows the children of this process
    :param builder: The process whose builds are meant, if it is another
    """

    def __init__(
        self,
        build_base: Path | None = None,
        adoption: Adoption | None = None,
        builder: int | None = None,
    ) -> None:
        self._adoption = adoption
        self._start, self._end = f'{builder or os.getpid()}:', ''
        if build_base is not None:
            self._start, self._end = '', f':{build_base}'

    def search(self, groups: Collection[int] = ()) -> list[Orphan]:  # noqa: ARG002
        """Find all of them."""
        found = []
        others: dict[int, list[RunningProcess]] = {}
        children: Collection[int] = ()
        if self._adoption is not None and self._adoption.is_exact:
            children, _ = self._adoption.look(())
        for process in running_processes():
            value = variable_of(process.pid, BUILD_ID_VARIABLE) or ''
            if process.pid in children or (
                value.startswith(self._start) and value.endswith(self._end)
            ):
                found.append(process)
            else:
                others.setdefault(process.parent, []).append(process)
        # the list grows by the children of those that it has
        for parent in found:
            found.extend(others.pop(parent.pid, ()))
        return [Orphan(p.pid, p.birth, p.group, 0) for p in found]

    def recheck(self, orphans: list[Orphan]) -> list[Orphan]:
        """Find all of them, as a build goes on to start some."""
        if not orphans:
            return []
        found = dict.fromkeys([*super().recheck(orphans), *self.search()])
        return list(found)

    def end(self) -> None:
        """End all of them, and wait for that."""
        timeouts = {0: Timeouts(0.0, PATIENCE)}
        now = time.monotonic()
        Escalation(self, timeouts, now, first=signal.SIGTERM).run()


def mark(build_base: Path) -> dict[str, str]:
    """Return the variable for what this process builds."""
    return {BUILD_ID_VARIABLE: f'{os.getpid()}:{build_base}'}


def end_orphans(build_base: Path, announce: Callable[[str], None]) -> None:
    """
    End the processes of earlier builds in a workspace, and wait for that.

    To be called while no other launch builds there.

    :param announce: Is called with one line if there are some
    """
    processes = BuildProcesses(build_base)
    if found := processes.search():
        pids = sorted(process.pid for process in found)
        announce(
            'ending what is left of a build that was killed: process '
            + ', '.join(map(str, pids))
        )
        processes.end()
