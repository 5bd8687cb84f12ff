# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The checks of readiness conditions, one class each.

A check begins when its member starts, calls `met` when its condition holds,
and is cancelled when the member ends or is ready.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
import errno
import os
from pathlib import Path
import shlex
import signal
import socket
from typing import TYPE_CHECKING

from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.line_pattern import LinePattern, SearchTimeError
from colcon_yamllaunch.engine.lines import bare
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.spawn import StartError
from colcon_yamllaunch.plan.member_settings import ReadyCondition, ReadyKind
from colcon_yamllaunch.plan.plan import Member, Process

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.engine import Engine

# of /proc/net/tcp (proc_net_tcp in the documentation of Linux)
_LISTENING = '0A'
_TCP_TABLES = (Path('/proc/net/tcp'), Path('/proc/net/tcp6'))


class ReadyCheck:
    """
    Checks one condition of a member; this one holds at once.

    :param met: Is called with the check when the condition holds
    """

    def __init__(
        self,
        engine: 'Engine',
        member: Member,
        condition: ReadyCondition,
        met: 'Callable[[ReadyCheck], object]',
    ) -> None:
        self.condition = condition
        self._engine = engine
        self._member = member
        self._met = met
        self._timer: TimerHandle | None = None

    def begin(self) -> None:
        """Begin to check."""
        self._succeed()

    def handle(self, event: events.Event) -> None:
        """Receive an event about the member, or its output."""

    def explain(self, explained: Callable[[str], object]) -> None:
        """
        Find out what exists instead of what the condition waits for.

        :param explained: Is called with that as a part of a sentence, or
          with an empty text; maybe later
        """
        explained('')

    def cancel(self) -> None:
        """End the check."""
        if self._timer is not None:
            self._timer.cancel()

    def _succeed(self) -> None:
        self._met(self)

    def _call_later(
        self, seconds: float, action: Callable[[], object]
    ) -> None:
        self._timer = self._engine.loop.call_later(seconds, action)


class AfterCheck(ReadyCheck):
    """Checks that a member has been running for some time."""

    def begin(self) -> None:
        """Begin to wait."""
        self._call_later(self.condition.seconds, self._succeed)


class LogCheck(ReadyCheck):
    """Checks that a line of output matches an expression."""

    def begin(self) -> None:
        """Prepare the expression."""
        self._pattern = LinePattern(self.condition.name)

    def handle(self, event: events.Event) -> None:
        """Search output."""
        if not isinstance(event, events.Output):
            return
        with suppress(SearchTimeError):
            if self._pattern.is_in(bare(event.data)):
                self._succeed()


class LifecycleCheck(ReadyCheck):
    """Checks that a lifecycle node is in a state."""

    def begin(self) -> None:
        """Wait for events only."""

    def handle(self, event: events.Event) -> None:
        """Look at a new state."""
        if (
            isinstance(event, events.StateChanged)
            and event.state == self.condition.name
        ):
            self._succeed()


class PolledCheck(ReadyCheck):
    """Checks a condition that the system reports to nobody, by polling."""

    def begin(self) -> None:
        """Look at once, and then again and again."""
        if self._holds():
            self._succeed()
        else:
            self._call_later(limits.READY_POLL_DELAY, self.begin)

    def _holds(self) -> bool:
        raise NotImplementedError


class FileCheck(PolledCheck):
    """Checks that a path exists."""

    def _holds(self) -> bool:
        path = os.path.expanduser(self.condition.name)
        return os.path.exists(os.path.join(_folder_of(self._member), path))


class PortCheck(PolledCheck):
    """
    Checks that something listens on a TCP port.

    On this computer, nothing connects to it: the system lists its ports.
    """

    _socket: socket.socket | None = None

    def cancel(self) -> None:
        """End the check."""
        super().cancel()
        if self._socket is not None:
            self._socket.close()

    def _holds(self) -> bool:
        host, _, port = self.condition.name.rpartition(':')
        if host in ('', 'localhost', '127.0.0.1'):
            return int(port) in _listening_ports()
        return self._is_connected(host, int(port))

    def _is_connected(self, host: str, port: int) -> bool:
        """Connect without waiting; return whether an earlier try has."""
        if self._socket is None:
            self._socket = socket.socket()
            self._socket.setblocking(False)
        with suppress(OSError):
            code = self._socket.connect_ex((host, port))
            if code in (errno.EINPROGRESS, errno.EALREADY):
                return False
            if code in (0, errno.EISCONN):
                return True
        self._socket.close()
        self._socket = None
        return False


class CommandCheck(ReadyCheck):
    """Checks that a command succeeds; it is run each second until it does."""

    _group: int | None = None

    def begin(self) -> None:
        """Run the command."""
        member = self._member
        assert isinstance(member, Process)
        words = shlex.split(self.condition.name)
        try:
            self._group = self._engine.run_command(words, member, self._ended)
        except StartError as error:
            text = f"{member.label}: '{self.condition.name}': {error}"
            self._engine.emit(events.Warned(text))

    def cancel(self) -> None:
        """End the command."""
        super().cancel()
        if self._group is not None:
            with suppress(ProcessLookupError):
                os.killpg(self._group, signal.SIGKILL)
            self._group = None

    def _ended(self, code: int) -> None:
        if self._group is None:
            # it was cancelled
            return
        self._group = None
        if code == 0:
            self._succeed()
        else:
            self._call_later(limits.READY_COMMAND_DELAY, self.begin)


def _folder_of(member: Member) -> str:
    return member.cwd if isinstance(member, Process) else '/'


def _listening_ports() -> set[int]:
    """Return the TCP ports that something on this computer listens on."""
    return set(_ports_in_tables())


def _ports_in_tables() -> Iterator[int]:
    for table in _TCP_TABLES:
        try:
            lines = table.read_text().splitlines()[1:]
        except OSError:
            # a kernel without IPv6 has only one
            continue
        for line in lines:
            _, local, _, state, *_ = line.split()
            if state == _LISTENING:
                yield int(local.rpartition(':')[2], 16)


#: The checks of those conditions that need no ROS.
CHECKS: dict[ReadyKind, type[ReadyCheck]] = {
    'running': ReadyCheck,
    'after': AfterCheck,
    'log': LogCheck,
    'lifecycle': LifecycleCheck,
    'file': FileCheck,
    'port': PortCheck,
    'command': CommandCheck,
}
