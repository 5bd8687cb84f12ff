# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A part of a launch on a machine: a launch that its launcher holds.

It runs in a process of its own, as the launcher runs a launch. The launcher
is a client of its control socket, on a connection that a relay passes on. The
part begins when the launcher has subscribed, and ends when the launcher has
asked for that, or is lost.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
import os
from pathlib import Path
import signal
import socket
import termios
import time
from typing import Any

from colcon_yamllaunch.common.codec import CodecError, from_json
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control import protocol, resource_usage
from colcon_yamllaunch.control.client_connection import Client
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.server import Server
from colcon_yamllaunch.engine import commands, events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.launch_scan import new_identity
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.participants import Execute, Participant, Reply
from colcon_yamllaunch.engine.state import About
from colcon_yamllaunch.observers.log_store import LogStore
from colcon_yamllaunch.plan.plan_json import plan_from_json, PlanFormatError
from colcon_yamllaunch.remote import part_protocol
from colcon_yamllaunch.remote.agent.launcher_channel import (
    LauncherChannel,
    redirect_to_null,
)
from colcon_yamllaunch.remote.agent.part_sockets import PartSockets
from colcon_yamllaunch.remote.part_protocol import LINK_LOST, PartSettings
from colcon_yamllaunch.run import run, RunContext
from colcon_yamllaunch.workspace.environment.sourcing import source

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
_COLCON_IGNORE = 'COLCON_IGNORE'


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
        self._heartbeat = part_protocol.heartbeat_of(settings.lost_after)
        self._standstill = min(_STANDSTILL, settings.lost_after / 2)
        self._is_finished = self._is_lost = self._is_held = False
        # whether the launch there has ended
        self._is_over = False
        self._connection: Client | None = None
        # whether nothing runs, and whether the launcher knows it
        self._is_idle = self._sent_idle = False
        self._checked_at = time.monotonic()
        self._check: TimerHandle | None = None
        # the processes whose terminals are shown, with what shows them
        self._shown: dict[str, _Shown] = {}

    def join(self, engine: Engine) -> None:
        """Serve the launcher, and execute what only that may ask for."""
        self._engine, self._loop = engine, engine.loop
        self._server = Server(
            self._listener, engine, self._journal, engine.lease
        )
        self._subscribers = self._server.service.subscribers
        self._subscribers.when_held = self._holder_changed
        dispatcher = engine.dispatcher
        dispatcher.add(part_protocol.Finish, self._finish)
        dispatcher.add(part_protocol.Measure, self._measure)
        dispatcher.add(part_protocol.Show, self._show)
        dispatcher.add(part_protocol.NoteElsewhere, self._note_elsewhere)

    def begin(self) -> None:
        """
        Wait until the launcher has subscribed.

        :raises UserError: when it does not
        """
        deadline = self._loop.time() + FIRST_TIMEOUT
        while self._subscribers.connection is None:
            is_late = self._loop.time() >= deadline
            if is_late or self._server.was_left or self._engine.is_stopping:
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
        if is_idle != self._sent_idle:
            self._sent_idle = is_idle
            self._engine.emit(events.IdleChanged(is_idle))

    def prepare_end(self) -> bool:
        """Note that nothing runs; return whether the part goes on."""
        self._is_idle = True
        if not self._sent_idle:
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
            self._engine.emit(events.CannotRun(reason))
            self.finish()

    def finish(self) -> None:
        """Wait until the launcher has everything, as the part has ended."""
        # while the launcher is away, the one who keeps the part waits for this
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

    def _holder_changed(self, connection: Client | None) -> None:
        before, self._connection = self._connection, connection
        if connection is not None and before is not None:
            # the launcher has given it up
            before.close()
        if connection is None and not self._subscribers.is_reconnecting:
            self._lose('the connection to the launcher has ended')

    def _send(self, data: bytes) -> bool:
        """Send the launcher something; return False if it is away."""
        if self._connection is None:
            return False
        self._connection.send(data)
        return True

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
            if self._sent_idle and silence >= KEPT_FOR:
                self._is_lost = True
        self._check = self._loop.call_later(
            self._heartbeat, self._check_silence
        )

    def _lose(self, reason: str) -> None:
        """Stop the part, unless it is to be kept or has been stopped."""
        if self._is_lost or self._is_finished or self._is_over:
            return
        self._engine.state.running_elsewhere = frozenset()
        # nobody else can show it now
        self._engine.show_to_others()
        if not self._keeps:
            self._is_lost = True
            shutdown = commands.Shutdown(f'{LINK_LOST}: {reason}')
            self._engine.dispatcher.do(shutdown)

    # commands

    def execute(
        self, command: commands.Command[Any], reply: Reply, proceed: Execute
    ) -> Any:
        """Note that the whole launch is suspended, or goes on."""
        if isinstance(command, commands.Hold):
            self._is_held = command.is_held
        return proceed(command, reply)

    def _finish(self, _: part_protocol.Finish, _reply: Reply) -> commands.Done:
        self._is_finished = True
        return commands.DONE

    def _measure(self, _: part_protocol.Measure, reply: Reply) -> None:
        groups = dict(self._engine.groups())
        before = resource_usage.sample_usage(groups.values())

        def measured() -> None:
            now = resource_usage.sample_usage(groups.values())
            used = resource_usage.usage_between(before, now)
            reply(
                part_protocol.MeasuredUsage(
                    {
                        label: (used[group].cpu, used[group].memory)
                        for label, group in groups.items()
                        if group in used
                    }
                )
            )

        self._loop.call_later(resource_usage.INTERVAL, measured)

    def _note_elsewhere(
        self, command: part_protocol.NoteElsewhere, _: Reply
    ) -> commands.Done:
        self._engine.state.note_elsewhere(command.ready, command.running)
        return commands.DONE

    def _show(self, command: part_protocol.Show, _: Reply) -> commands.Done:
        label = command.member
        terminals = self._engine.terminals
        if command.is_shown and label not in self._shown:
            shown = _Shown(self._engine, label, self._send)
            self._shown[label] = shown
            terminals.add_sink(label, shown.show)
            shown.send_modes()
        elif not command.is_shown and label in self._shown:
            shown = self._shown.pop(label)
            terminals.remove_sink(label, shown.show)
            shown.close()
        return commands.DONE


def _record(event: events.Event) -> dict[str, Any]:
    """Return the record of an event, also of one that is internal."""
    return event.to_json() if event.name else {}


class _Shown:
    """Sends what one process writes, and how its terminal reads keys."""

    def __init__(
        self, engine: Engine, label: str, send: Callable[[bytes], bool]
    ) -> None:
        self._engine = engine
        self._label = label
        self._send = send
        self._modes: int | None = None
        self._timer: TimerHandle | None = None

    def show(self, stream: events.Stream, data: bytes) -> None:
        """Send what the process wrote, or what its terminal echoed."""
        fields = {'process': self._label, 'stream': stream}
        self._send(protocol.encode_raw('shown', fields, data) + b'\n')

    def send_modes(self) -> None:
        """Send how its terminal reads keys, whenever that has changed."""
        modes = self._engine.terminals.input_modes(self._label)
        if modes is not None and modes != self._modes:
            fields = {
                'process': self._label,
                'lines': bool(modes & termios.ICANON),
                'echo': bool(modes & termios.ECHO),
            }
            if self._send(protocol.encode({'modes': fields})):
                self._modes = modes
        self._timer = self._engine.loop.call_later(
            _MODES_INTERVAL, self.send_modes
        )

    def close(self) -> None:
        """Send nothing more."""
        if self._timer is not None:
            self._timer.cancel()


def start_engine(
    launcher: LauncherChannel, sockets: PartSockets, content: Mapping[str, Any]
) -> str:
    """
    Start the engine of a part, and return its identity.

    It begins once the launcher has spoken with it.

    :raises LauncherGoneError: when the launcher is gone
    :raises UserError: when it cannot be started
    """
    try:
        plan = plan_from_json(content['plan'])
        settings = from_json(PartSettings, content['settings'], 'settings')
    except (PlanFormatError, CodecError, KeyError) as error:
        raise UserError(f'its part of the plan is wrong: {error}') from error
    ours, its = os.pipe()
    pid = os.fork()
    if not pid:
        code = 1
        try:
            os.close(ours)
            code = _run(launcher, sockets, plan, settings, its)
        finally:
            os._exit(code)
    os.close(its)
    answer = b''
    try:
        while more := launcher.read(ours):
            answer += more
    except BaseException:
        with suppress(OSError):
            # it has started nothing that is not its own
            os.killpg(pid, signal.SIGTERM)
        raise
    finally:
        os.close(ours)
    word, _, text = answer.decode(errors='replace').partition(' ')
    if word != 'ready':
        raise UserError(text or 'its process ended before it was ready')
    # it is removed by the engine
    launcher.program = ''
    return text


def _run(
    launcher: LauncherChannel,
    sockets: PartSockets,
    plan: Any,
    settings: PartSettings,
    starter: int,
) -> int:
    """Run the part, in a process of its own; return the exit code."""
    os.setsid()
    redirect_to_null(0, 1, 2)
    for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    identity = new_identity()
    server = None
    try:
        try:
            environment = environment_of(settings, os.environ)
            log_folder = _log_folder(settings)
            server = sockets.listen(identity)
        except UserError as error:
            os.write(starter, f'failed {error}'.encode())
            return 1
        except OSError as error:
            text = f'{sockets.path} cannot be written: {error.strerror}'
            os.write(starter, f'failed {text}; make room there'.encode())
            return 1
        part = Part(server, settings, log_folder)
        os.write(starter, f'ready {identity}'.encode())
        os.close(starter)
        store = None
        if log_folder is not None and settings.kept_logs is not None:
            store = LogStore(
                log_folder, settings.kept_logs, settings.logs_limit
            )
        title = (
            f'part of a launch on {settings.machine} that lost its launcher'
        )
        where = settings.workspace or os.path.expanduser('~')
        with open(os.devnull, 'w', encoding='utf-8') as nothing:
            context = RunContext(
                environment=environment,
                log_folder=log_folder,
                stream=nothing,
                log_limit=settings.log_limit,
                log_store=store,
                tty=settings.tty,
                identity=identity,
                participants=_participants(part, settings),
                is_hidden=True,
                about=About(title, None, '', where),
            )
            return run(plan, context)
    except Exception:  # noqa: BLE001
        # the launcher has been sent it, see `Part.failed`
        return 1
    finally:
        if server is not None:
            server.close()
            sockets.remove(identity)
            launcher.remove_program()


def _participants(
    part: Part, settings: PartSettings
) -> tuple[Participant, ...]:
    if settings.after is None:
        return (part,)
    from colcon_yamllaunch.engine.readiness import Readiness

    return (part, Readiness(settings.after))


def environment_of(
    settings: PartSettings, environment: Mapping[str, str]
) -> dict[str, str]:
    """
    Return the environment of the processes of a part.

    :param environment: That of a login there
    :raises WorkspaceError: when the workspace cannot be sourced
    """
    variables = {**environment, **settings.variables}
    if settings.workspace is None:
        return variables
    setup = Path(settings.workspace) / 'install' / 'setup.bash'
    return dict(source(setup, variables).variables)


def _log_folder(settings: PartSettings) -> Path | None:
    """Return the folder for the logs there, made, or None for none."""
    if settings.log_name is None:
        return None
    parents = [settings.workspace] if settings.workspace is not None else []
    for parent in (*parents, os.path.expanduser('~/.ros')):
        base = Path(parent) / 'log'
        with suppress(OSError):
            base.mkdir(parents=True, exist_ok=True)
            if base.parent.name != '.ros':
                (base / _COLCON_IGNORE).touch()
            # on a shared file system the launcher or another machine has it
            name = settings.log_name
            for path in (base / name, base / f'{name}_{os.getpid()}'):
                with suppress(FileExistsError):
                    path.mkdir()
                    return path
    return None
