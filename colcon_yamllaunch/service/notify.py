# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Reports the state of a launch to systemd, as `sd_notify(3)` has it.

`READY=1` is sent when all members are ready, and `STATUS=` says what is not.
The watchdog is pinged by the loop of the launch, and only while no critical
member has a problem.
"""

from collections.abc import Mapping
from contextlib import suppress
import os
import socket

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.engine.state import MemberState
from colcon_yamllaunch.plan.plan import Plan

#: What systemd sets for the launcher alone.
VARIABLES = ('NOTIFY_SOCKET', 'WATCHDOG_USEC', 'WATCHDOG_PID')
#: How often the watchdog is pinged within its time; after a problem that is
#: solved in half of the time, there is a ping early enough.
PINGS = 4
_PROBLEMS = ('failed', 'held', 'respawn')


class Notifier(Participant):
    """
    Reports a launch to systemd.

    :param environment: See :data:`VARIABLES`
    """

    _engine: Engine

    def __init__(self, plan: Plan, environment: Mapping[str, str]) -> None:
        self._settings = {m.label: m.settings for m in plan.members()}
        address = environment.get('NOTIFY_SOCKET', '')
        # '@' stands for the abstract namespace (unix(7))
        self._address = address.replace('@', '\0', 1)
        self._socket = socket.socket(
            socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK
        )
        self._seconds = _watchdog_seconds(environment) / PINGS
        self._version = -1
        self._status = ''
        self._is_ready = False
        # critical members that were not ready in time
        self._late: set[str] = set()

    def join(self, engine: Engine) -> None:
        """Report this launch."""
        self._engine = engine

    def begin(self) -> None:
        """Begin to ping the watchdog."""
        if self._seconds:
            self._ping()

    def handle(self, event: events.Event) -> None:
        """Note members that are not ready in time, and report the end."""
        match event:
            case events.NotReady(member=member):
                self._late.add(member.label)
            case events.Ready(member=member):
                self._late.discard(member.label)
            case events.Started(process=process):
                self._late.discard(process.label)
            case events.Planned(members=members):
                self._settings |= {m.label: m.settings for m in members}
            case events.ShuttingDown(reason=reason):
                self._send('STOPPING=1', f'STATUS=stopping: {reason}')
            case events.Ended(reason=reason) if reason:
                self._send(f'STATUS={reason}')
            case _:
                pass

    def end_turn(self) -> None:
        """Report what has changed in this turn."""
        state = self._engine.state
        if state.version == self._version or state.stopping:
            return
        self._version = state.version
        members = list(state.members())
        pending = [m for m in members if self._is_pending(m)]
        status = self._text(members, pending)
        if status != self._status:
            self._status = status
            self._send(f'STATUS={status}')
        if not (pending or self._is_ready):
            self._is_ready = True
            self._send('READY=1')

    def finish(self) -> None:
        """Close the socket."""
        self._socket.close()

    def _is_pending(self, member: MemberState) -> bool:
        """Return whether a member is still to become ready, or to start."""
        settings = self._settings.get(member.label)
        is_optional = settings is not None and settings.optional
        if is_optional and member.condition == 'failed':
            return False
        if self._engine.state.has_readiness:
            return bool(self._engine.state.missing_of([member.label]))
        return member.phase in ('waiting', 'loading')

    def _text(
        self, members: list[MemberState], pending: list[MemberState]
    ) -> str:
        """Return the state of the launch in one line."""
        done = 'ready' if self._engine.state.has_readiness else 'started'
        text = f'{len(members) - len(pending)} of {len(members)} {done}'
        # what waits for others says less than these do
        first = [m for m in pending if not m.waits_for]
        if first:
            text += f'; waiting for {events.listed([*map(self._wait, first)])}'
        if problems := self._problems():
            text += f'; not healthy: {events.listed(problems)}'
        return text

    def _wait(self, member: MemberState) -> str:
        """Return a member with what it waits for, as a part of a sentence."""
        settings = self._settings.get(member.label)
        conditions = () if settings is None else settings.ready
        reason = member.ending or ' and '.join(map(str, conditions))
        return f'{member.label} ({reason})' if reason else member.label

    def _problems(self) -> list[str]:
        """Return the critical members that have a problem."""
        return [
            member.label
            for member in self._engine.state.members()
            if (settings := self._settings.get(member.label)) is not None
            and settings.critical
            and (member.condition in _PROBLEMS or member.label in self._late)
        ]

    def _ping(self) -> None:
        if not self._problems():
            self._send('WATCHDOG=1')
        self._engine.loop.call_later(self._seconds, self._ping)

    def _send(self, *lines: str) -> None:
        # a value is one line
        text = '\n'.join(' '.join(line.splitlines()) for line in lines)
        with suppress(OSError):
            self._socket.sendto(text.encode(errors='replace'), self._address)


def _watchdog_seconds(environment: Mapping[str, str]) -> float:
    """Return how often systemd expects a ping at least, 0 for never."""
    microseconds = environment.get('WATCHDOG_USEC', '')
    pid = environment.get('WATCHDOG_PID') or str(os.getpid())
    if not microseconds.isdecimal() or pid != str(os.getpid()):
        return 0
    return int(microseconds) / 1e6
