# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The guard: a small process that stops a launch whose launcher is gone.

Its standard input is a pipe that only the launcher can write to, so the end
of the input means that the launcher ended without dismissing the guard: by
SIGKILL, or by a crash. Then it takes the launcher's place: the control socket
goes, then SIGINT, SIGTERM and SIGKILL with each process's time-outs, also for
processes that left their group, and the folder with the parameter files goes.
It has its own session, takes no signal but SIGKILL, and never outlives its
work.

The launcher writes lines: `start NUMBER GROUP SIGTERM_TIMEOUT
SIGKILL_TIMEOUT`, `end GROUP`, `folder PATH` and `socket PATH`.

This module imports little: the guard has to be small, and up at once.
"""

from collections.abc import Collection
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from dataclasses import field
import os
import sys
import time

from colcon_yamllaunch.common.escalation import Escalation
from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.common.escalation import Targets
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.common.process_scan import read_process
from colcon_yamllaunch.runtime.core import limits
from colcon_yamllaunch.runtime.stopping.launch_scan import find_orphans


@dataclass
class GuardedLaunch(Targets):
    """
    What the guard has been told, and what is left of it.

    :param session: The session of the launcher
    :param made: The process groups that run, with their numbers
    :param timeouts: The time-outs of every process that was ever started
    """

    identity: str
    session: int
    made: dict[int, int] = field(default_factory=dict)
    timeouts: dict[int, Timeouts] = field(default_factory=dict)
    folder: str | None = None
    socket: str | None = None

    def note(self, line: str) -> None:
        """Take one line of the launcher into account."""
        word, _, rest = line.partition(' ')
        if word == 'start':
            number, group, sigterm, sigkill = rest.split()
            self.made[int(group)] = int(number)
            self.timeouts[int(number)] = Timeouts(
                float(sigterm), float(sigkill)
            )
        elif word == 'end':
            self.made.pop(int(rest), None)
        elif word == 'folder':
            self.folder = rest
        elif word == 'socket':
            self.socket = rest

    def groups(self) -> dict[int, int]:
        """Return the groups whose leader runs, and is not somebody else."""
        return {
            group: number
            for group, number in self.made.items()
            if (leader := read_process(group)) is not None
            and leader.session == self.session
        }

    def search(self, groups: Collection[int]) -> list[Orphan]:
        """Find the other processes of the launch."""
        return find_orphans(self.identity, self.session, self.made, groups)


def main() -> None:
    """
    Guard a launch.

    The arguments are the identity of the launch and the session of the
    launcher.
    """
    identity, session = sys.argv[1:]
    launch = GuardedLaunch(identity, int(session))
    # a line that the launcher could not finish says nothing
    for line in _whole_lines():
        launch.note(line)
    if launch.socket is not None:
        with suppress(OSError):
            os.unlink(launch.socket)
    Escalation(launch, launch.timeouts, time.monotonic()).run()
    if launch.folder is not None:
        import shutil

        shutil.rmtree(launch.folder, ignore_errors=True)


def _whole_lines() -> Iterator[str]:
    rest = b''
    while chunk := os.read(0, limits.READ_SIZE):
        *lines, rest = (rest + chunk).split(b'\n')
        for line in lines:
            yield os.fsdecode(line)
