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

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from dataclasses import field
import os
import sys
import time

from colcon_yamllaunch.common.process_scan import find_members
from colcon_yamllaunch.common.process_scan import Member
from colcon_yamllaunch.runtime.core import limits
from colcon_yamllaunch.runtime.stopping.escalation import send
from colcon_yamllaunch.runtime.stopping.escalation import Stopping
from colcon_yamllaunch.runtime.stopping.escalation import Timeouts


@dataclass(slots=True)
class Charge:
    """
    What the guard has been told.

    :param groups: The process groups that run, with their numbers
    :param timeouts: The time-outs of every process that was ever started
    :param folder: The folder to remove, if there is one
    :param socket: The socket to remove, if there is one
    """

    groups: dict[int, int] = field(default_factory=dict)
    timeouts: dict[int, Timeouts] = field(default_factory=dict)
    folder: str | None = None
    socket: str | None = None

    def note(self, line: str) -> None:
        """Take one line of the launcher into account."""
        word, _, rest = line.partition(' ')
        if word == 'start':
            number, group, sigterm, sigkill = rest.split()
            self.groups[int(group)] = int(number)
            self.timeouts[int(number)] = Timeouts(
                float(sigterm), float(sigkill)
            )
        elif word == 'end':
            self.groups.pop(int(rest), None)
        elif word == 'folder':
            self.folder = rest
        elif word == 'socket':
            self.socket = rest


def main() -> None:
    """
    Guard a launch.

    The arguments are the identity of the launch and the session of the
    launcher.
    """
    identity, session = sys.argv[1:]
    charge = Charge()
    # a line that the launcher could not finish says nothing
    for line in _whole_lines():
        charge.note(line)
    if charge.socket is not None:
        with suppress(OSError):
            os.unlink(charge.socket)
    stop(charge, identity, int(session))
    if charge.folder is not None:
        import shutil

        shutil.rmtree(charge.folder, ignore_errors=True)


def stop(charge: Charge, identity: str, session: int) -> None:
    """Stop what is left of a launch."""
    stopping = Stopping(charge.timeouts, time.monotonic())
    given_up = float('inf')
    # at once, as looking for all others takes a while
    led = {g: n for g, n in charge.groups.items() if _is_led(g, session)}
    for order in stopping.orders(led, ()):
        send(order)
    while True:
        members = find_members(identity, charge.groups, session)
        now = time.monotonic()
        if not members or now >= given_up:
            return
        stopping.advance(now)
        groups, strays = divide(members, charge.groups)
        for order in stopping.orders(groups, strays):
            send(order)
        numbers = {m.number for m in members}
        if stopping.is_final(numbers):
            given_up = min(given_up, now + limits.KILL_PATIENCE)
        wait = stopping.next_deadline(numbers) - now
        time.sleep(max(0.0, min(wait, limits.STRAY_CHECK_INTERVAL)))


def divide(
    members: list[Member], groups: dict[int, int]
) -> tuple[dict[int, int], list[Member]]:
    """Tell the groups that still have members from the other processes."""
    alive = {m.group for m in members}
    return (
        {g: number for g, number in groups.items() if g in alive},
        [m for m in members if m.group not in groups],
    )


def _is_led(group: int, session: int) -> bool:
    """Tell whether the leader of a group runs, and is not somebody else."""
    try:
        return os.getsid(group) == session
    except OSError:
        return False


def _whole_lines() -> Iterator[str]:
    rest = b''
    while chunk := os.read(0, limits.READ_SIZE):
        *lines, rest = (rest + chunk).split(b'\n')
        for line in lines:
            yield os.fsdecode(line)
