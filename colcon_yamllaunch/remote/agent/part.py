# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A part of a launch on a machine: a launch that its launcher holds.

The launcher is a client of its control socket, on a connection that a relay
passes on. The part begins when the launcher has subscribed, and ends when the
launcher has asked for that, or is lost.
"""

from contextlib import suppress
from pathlib import Path
import socket
import termios
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control import resource_usage
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.server import listen
from colcon_yamllaunch.control.server import Server
from colcon_yamllaunch.control.service import Service
from colcon_yamllaunch.control.subscribers import Holder
from colcon_yamllaunch.engine import commands
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.commands import Command
from colcon_yamllaunch.engine.commands import DONE
from colcon_yamllaunch.engine.commands import Done
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.participants import Execute
from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.engine.participants import Reply
from colcon_yamllaunch.remote.part_commands import Finish
from colcon_yamllaunch.remote.part_commands import Hide
from colcon_yamllaunch.remote.part_commands import Measure
from colcon_yamllaunch.remote.part_commands import Show
from colcon_yamllaunch.remote.part_commands import Usage
from colcon_yamllaunch.remote.part_settings import heartbeat_of
from colcon_yamllaunch.remote.part_settings import LINK_LOST
from colcon_yamllaunch.remote.part_settings import PartSettings

#: Seconds in which the launcher must subscribe.
FIRST_TIMEOUT = 60.0
#: Seconds for which the loop may stand still, as a machine that sleeps does,
#: without that being silence of the launcher; less where that is short.
_STANDSTILL = 2.0
#: Seconds that the launcher gets to acknowledge what it has not, at the end.
LAST_TIMEOUT = 5.0
#: Seconds that a part which has ended waits for a launcher that is away, if it
#: is to be kept.
KEPT_FOR = 3600.0
#: Bytes of output that the launcher has not acknowledged, after which
#: processes wait; while it is away, output goes to the journal.
WINDOW = 8 * 1024 * 1024
#: Seconds between two looks at how a terminal reads that somebody types at.
_MODES_INTERVAL = 0.05


class Part(Participant):
    """
    Keeps a part of a launch running as long as its launcher holds it.

    :param listener: The socket where the launcher connects
    :param log_folder: The folder of the logs there, or None for none
    """

    def __init__(
        self,
        listener: socket.socket,
        settings: PartSettings,
        log_folder: Path | None,
    ) -> None:
        self._listener = listener
        self._journal = Journal(log_folder, settings.log_limit, record=_record)
        self._keeps = settings.on_lost == 'keep'
        self._lost_after = settings.lost_after
        self._heartbeat = heartbeat_of(settings.lost_after)
        self._standstill = min(_STANDSTILL, settings.lost_after / 2)
        self._is_finished = self._is_lost = self._is_held = False
        # whether the launch there has ended
        self._is_over = False
        self._connection: Holder | None = None
        # whether nothing runs, and what the launcher knows of that
        self._is_idle = self._told_idle = False
        self._checked_at = time.monotonic()
        self._check: TimerHandle | None = None
        # those that are shown, with what shows them
        self._shown: dict[str, _Shown] = {}

    def join(self, engine: Engine) -> None:
        """Serve the launcher, and execute what only that may ask for."""
        self._engine, self._loop = engine, engine.loop
        service = Service(engine, self._journal, engine.lease)
        self._subscribers = service.subscribers
        self._subscribers.when_held = self._holder_changed
        self._server = Server(self._listener, engine.loop, service)
        listen(engine, service)
        dispatcher = engine.dispatcher
        dispatcher.add(Finish, self._finish)
        dispatcher.add(Measure, self._measure)
        dispatcher.add(Show, self._show)
        dispatcher.add(Hide, self._hide)

    def begin(self) -> None:
        """
        Wait until the launcher has subscribed.

        :raises UserError: when it does not
        """
        deadline = self._loop.time() + FIRST_TIMEOUT
        while self._subscribers.connection is None:
            is_late = self._loop.time() >= deadline
            if is_late or self._server.is_left or self._engine.is_stopping:
                self._is_lost = True
                raise UserError('the launcher is gone')
            self._run_loop()
        if self._check is None:
            self._check_silence()

    def accepts(self, label: str) -> bool:  # noqa: ARG002
        """Return whether a process may write more for now."""
        return (
            self._subscribers.connection is None
            or self._subscribers.unacknowledged <= WINDOW
        )

    def end_turn(self) -> None:
        """Emit whether the part is idle, if that changed in this turn."""
        is_idle, self._is_idle = self._is_idle, False
        if is_idle != self._told_idle:
            self._told_idle = is_idle
            self._engine.tell(events.Idle(is_idle))

    def is_waiting(self) -> bool:
        """Return whether the part goes on, though nothing runs."""
        self._is_idle = True
        if not self._told_idle:
            self._loop.wake()
        if self._subscribers.connection is None and self._engine.is_stopping:
            # somebody has stopped it on its machine
            return False
        return not (self._is_finished or self._is_lost)

    def failed(self, error: Exception) -> None:
        """Send why the part cannot run, and wait until that has arrived."""
        if self._is_lost:
            return
        reason = str(error)
        if not isinstance(error, UserError):
            # a fault of ours, which takes one line all the same
            reason = f'{type(error).__name__}: {error}'
        with suppress(UserError):
            self.begin()
            self._engine.tell(events.CannotRun(reason))
            self.finish()

    def finish(self) -> None:
        """Wait until the launcher has everything, as the part has ended."""
        # who keeps it for a launcher that is away waits for that
        is_kept = self._keeps and not self._is_finished
        timeout = KEPT_FOR if is_kept else LAST_TIMEOUT
        deadline = self._loop.time() + timeout
        self._is_over = True
        while not self._subscribers.has_all and self._loop.time() < deadline:
            if self._subscribers.connection is None and not self._keeps:
                # a lost part leaves nothing behind
                break
            self._run_loop()

    def _run_loop(self) -> None:
        """Run the loop for a moment."""
        alarm = self._loop.call_later(self._heartbeat, self._loop.wake)
        self._loop.run_once()
        alarm.cancel()

    # the launcher

    def _holder_changed(self, connection: Holder | None) -> None:
        before, self._connection = self._connection, connection
        if connection is not None and before is not None:
            # the launcher has given it up
            before.close()
        for shown in self._shown.values():
            shown.connection = connection
        if connection is None and not self._subscribers.is_reconnecting:
            self._lose('the connection to the launcher has ended')

    def _check_silence(self) -> None:
        """Stop the part if nothing was heard of the launcher for long."""
        now = time.monotonic()
        gap = now - self._checked_at
        if gap > self._heartbeat + self._standstill or (
            # nor does the launcher do anything
            self._is_held and self._connection is not None
        ):
            # what was sent meanwhile is still to be read
            self._subscribers.heard_at += gap
        self._checked_at = now
        silence = now - self._subscribers.heard_at
        if silence >= self._lost_after:
            if self._connection is not None:
                self._subscribers.is_reconnecting = True
                self._connection.close()
            self._lose('nothing is heard of the launcher')
            if self._told_idle and silence >= KEPT_FOR:
                self._is_lost = True
        self._check = self._loop.call_later(
            self._heartbeat, self._check_silence
        )

    def _lose(self, reason: str) -> None:
        """Stop the part, unless it is to be kept or has been stopped."""
        if self._is_lost or self._is_finished or self._is_over:
            return
        # nobody else can show it now
        self._engine.serve()
        if not self._keeps:
            self._is_lost = True
            shutdown = commands.Shutdown(f'{LINK_LOST}: {reason}')
            self._engine.dispatcher.do(shutdown)

    # commands

    def execute(
        self, command: Command[Any], reply: Reply, proceed: Execute
    ) -> Any:
        """Note that the whole launch is suspended, or goes on."""
        if isinstance(command, commands.Hold):
            self._is_held = command.is_held
        return proceed(command, reply)

    def _finish(self, _: Finish, _reply: Reply) -> Done:
        self._is_finished = True
        return DONE

    def _measure(self, _: Measure, reply: Reply) -> None:
        groups = dict(self._engine.groups())
        before = resource_usage.look(groups.values())

        def measured() -> None:
            now = resource_usage.look(groups.values())
            used = resource_usage.usage_between(before, now)
            reply(
                Usage(
                    {
                        label: (used[group].cpu, used[group].memory)
                        for label, group in groups.items()
                        if group in used
                    }
                )
            )

        self._loop.call_later(resource_usage.INTERVAL, measured)

    def _show(self, command: Show, _: Reply) -> Done:
        label = command.process
        if label not in self._shown:
            shown = _Shown(self._engine, label)
            shown.connection = self._connection
            self._shown[label] = shown
            self._engine.terminals.add_sink(label, shown.show)
            shown.send_modes()
        return DONE

    def _hide(self, command: Hide, _: Reply) -> Done:
        shown = self._shown.pop(command.process, None)
        if shown is not None:
            self._engine.terminals.remove_sink(command.process, shown.show)
            shown.close()
        return DONE


def _record(event: events.Event) -> dict[str, Any]:
    """Return the record of an event, also of one that is internal."""
    return event.to_json() if event.name else {}


class _Shown:
    """Sends what one process writes, and how its terminal reads keys."""

    def __init__(self, engine: Engine, label: str) -> None:
        self._engine = engine
        self._label = label
        #: The connection of the launcher.
        self.connection: Holder | None = None
        self._modes: int | None = None
        self._timer: TimerHandle | None = None

    def show(self, stream: events.Stream, data: bytes) -> None:
        """Send what the process wrote, or what its terminal echoed."""
        if self.connection is not None:
            fields = {'process': self._label, 'stream': stream}
            message = protocol.encode_raw('shown', fields, data)
            self.connection.send(message + b'\n')

    def send_modes(self) -> None:
        """Send how its terminal reads keys, whenever that has changed."""
        modes = self._engine.terminals.input_modes(self._label)
        if (
            modes is not None
            and modes != self._modes
            and self.connection is not None
        ):
            self._modes = modes
            told = {
                'process': self._label,
                'lines': bool(modes & termios.ICANON),
                'echo': bool(modes & termios.ECHO),
            }
            self.connection.send(protocol.encode({'modes': told}))
        self._timer = self._engine.loop.call_later(
            _MODES_INTERVAL, self.send_modes
        )

    def close(self) -> None:
        """Send nothing more."""
        if self._timer is not None:
            self._timer.cancel()
