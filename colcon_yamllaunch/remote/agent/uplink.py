# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The connection of the engine of a part to the launcher, beside its loop."""

from collections.abc import Mapping
from contextlib import suppress
import os
from pathlib import Path
import select
import socket
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.commands import Shutdown
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.remote.agent.part_orders import PartOrders
from colcon_yamllaunch.remote.agent.uplink_socket import UplinkSocket
from colcon_yamllaunch.remote.wire import frames
from colcon_yamllaunch.remote.wire.event_codec import event_to_json
from colcon_yamllaunch.remote.wire.frames import Frame
from colcon_yamllaunch.remote.wire.frames import FrameError
from colcon_yamllaunch.remote.wire.numbered import Inbox
from colcon_yamllaunch.remote.wire.numbered import Outbox
from colcon_yamllaunch.remote.wire.part_settings import heartbeat_of
from colcon_yamllaunch.remote.wire.part_settings import PartSettings

#: Seconds in which the launcher must speak first.
FIRST_PATIENCE = 60.0
#: Seconds for which the loop may stand still, as a machine that sleeps does,
#: without that being silence of the launcher; less where that is short.
_STANDSTILL = 2.0
#: Seconds that the launcher gets to take what it has not, at the end.
LAST_PATIENCE = 5.0
#: Seconds that a part which has ended waits for a launcher that is away, if it
#: is to be kept.
KEPT_FOR = 3600.0
#: Seconds between two looks at the state of all processes.
_LOOK = 0.05
_CALM_LOOK = 1.0
#: Below so many bytes a second a link that is busy for half of that second is
#: slow, so that it pays to compress.
_SLOW = 8 * 1024 * 1024


class Uplink(Participant):
    """
    The connection of a part to the launcher, beside the engine of the part.

    :param server: The socket where whoever speaks for the launcher connects
    :param log_folder: The folder of the logs there, or None for none
    """

    def __init__(
        self,
        server: socket.socket,
        settings: PartSettings,
        log_folder: Path | None,
    ) -> None:
        self._server = server
        self._keeps = settings.on_lost == 'keep'
        self._lost_after = settings.lost_after
        self._heartbeat = heartbeat_of(settings.lost_after)
        self._standstill = min(_STANDSTILL, settings.lost_after / 2)
        self._outbox = Outbox(
            log_folder or Path(os.environ.get('TMPDIR') or '/tmp'),
            settings.log_limit,
        )
        self._inbox = Inbox()
        self._socket: UplinkSocket | None = None
        # who has connected and said nothing yet
        self._newcomers: list[UplinkSocket] = []
        self._heard = time.monotonic()
        self._beaten = 0.0
        # what the launcher's last heartbeat said, and when it came
        self._echo: tuple[float, float] | None = None
        self._early: list[dict[str, Any]] = []
        self._launch: Engine | None = None
        # the same while it runs
        self._engine: Engine | None = None
        self._orders: PartOrders | None = None
        self._idle = self._told_idle = False
        self._finished = self._is_lost = self._is_suspended = False
        # whether the launcher has said that it will connect again
        self._is_coming_back = False
        self._turned = self._heard
        self._changed = True
        self._looked = 0.0
        self._rows: dict[str, dict[str, Mapping[str, Any]]] = {
            'processes': {},
            'components': {},
        }
        self._told_dropped = 0

    # before the engine

    def _wait_for_launcher(self) -> bool:
        """Wait until the launcher speaks; return whether it does."""
        deadline = time.monotonic() + FIRST_PATIENCE
        came = False
        while self._socket is None:
            # it may have gone again
            if time.monotonic() >= deadline or (came and not self._newcomers):
                return False
            poll = select.poll()
            poll.register(self._server, select.POLLIN)
            for newcomer in self._newcomers:
                poll.register(newcomer.descriptor, select.POLLIN)
            poll.poll(100)
            self._accept()
            came = came or bool(self._newcomers)
            for newcomer in tuple(self._newcomers):
                self._take(newcomer)
        return True

    def failed(self, text: str) -> None:
        """Tell why the part could not run at all, and have that arrive."""
        if self._is_lost or not self._wait_for_launcher():
            return
        self._tell({'failed': text})
        self.over(1)

    # see Participant

    def join(self, engine: Engine) -> None:
        """Receive what the terminals of a launch echo."""
        self._launch = engine
        engine.terminals.when_echoed = self.echoed

    def begin(self) -> None:
        """
        Wait until the launcher speaks.

        :raises UserError: when it does not
        """
        # until here all was made ready
        if not self._wait_for_launcher():
            self._is_lost = True
            raise UserError('the launcher is gone')
        self._turned = time.monotonic()
        engine = self._engine = self._launch
        assert engine is not None
        self._orders = PartOrders(engine, self._tell)
        engine.loop.add_reader(self._server.fileno(), self._accept)
        for one in (self._socket, *self._newcomers):
            if one is not None:
                self._watch(one)
        for content in self._early:
            self._order(content)
        self._early.clear()

    def handle(self, event: events.Event) -> None:
        """Take note of what happened."""
        if isinstance(event, events.ShuttingDown) and self._is_lost:
            # the rest of the launch goes on
            return
        self._changed = True
        data = event_to_json(event)
        if data is not None:
            self._tell({'event': data})

    def record(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        """Take output of a process as it was read."""
        body = frames.output_body(process.label, stream, data, time.time())
        self._outbox.add(frames.OUTPUT, body)

    def echoed(self, label: str, data: bytes) -> None:
        """Take what the terminal of a process echoed."""
        body = frames.output_body(label, 'stdout', data, time.time())
        self._outbox.add(frames.ECHO, body)

    def accepts(self, label: str) -> bool:  # noqa: ARG002
        """Tell whether a process may write more for now."""
        # what is written while the link is lost goes to the file
        return self._socket is None or not self._outbox.is_full

    def end_turn(self) -> None:
        """Do what is due."""
        now = time.monotonic()
        if now - self._turned > self._standstill:
            # what was said meanwhile is still to be read
            self._heard += now - self._turned
        self._turned = now
        self._mind_silence()
        self._tell_idle()
        assert self._orders is not None
        self._orders.advance()
        pause = _LOOK if self._changed else _CALM_LOOK
        if now - self._looked >= pause:
            self._look(now)
        if self._outbox.dropped > self._told_dropped:
            self._tell({'dropped': self._outbox.dropped - self._told_dropped})
            self._told_dropped = self._outbox.dropped
        if self._socket is not None:
            is_due = now - self._beaten >= self._heartbeat
            if is_due or self._inbox.is_due():
                self._beat(self._socket)
            self._socket.flush(self._outbox)
            self._mind_socket(self._socket)

    def due(self) -> float | None:
        """Return when :meth:`end_turn` is to be called again."""
        assert self._orders is not None
        waits = [self._heartbeat, self._orders.seconds_to_wait()]
        if not self._is_lost:
            waits.append(self._lost_after - self._silence())
        if self._changed:
            waits.append(_LOOK)
        return time.monotonic() + min(waits)

    def is_waiting(self) -> bool:
        """Tell whether the part is to go on; it is idle if it is asked."""
        assert self._engine is not None
        self._idle = True
        if not self._told_idle:
            self._engine.loop.wake()
        if self._socket is None and self._engine.is_stopping:
            # somebody has stopped it on its machine
            return False
        return not (self._finished or self._is_lost)

    def over(self, exit_code: int) -> None:
        """Have the launcher take what it has not, as the part has ended."""
        self._changed = True
        if self._orders is not None:
            self._look(time.monotonic())
        self._tell({'ended': exit_code, 'lost': self._is_lost})
        self._engine = None
        # who keeps it for a launcher that is away waits for that
        is_kept = self._keeps and not self._finished
        patience = KEPT_FOR if is_kept else LAST_PATIENCE
        deadline = time.monotonic() + patience
        while not self._outbox.is_empty and time.monotonic() < deadline:
            if self._socket is None and not self._keeps:
                # a lost part leaves nothing behind
                break
            self._exchange()
        if self._socket is not None:
            self._socket.close()
        for newcomer in self._newcomers:
            newcomer.close()
        self._outbox.close()

    # the connection

    def _exchange(self) -> None:
        """Send and take for a moment, without the loop of the engine."""
        poll = select.poll()
        poll.register(self._server, select.POLLIN)
        one = self._socket
        if one is not None:
            one.flush(self._outbox)
            if time.monotonic() - self._beaten >= self._heartbeat:
                self._beat(one)
            if not self._mind_socket(one):
                return
            poll.register(one.descriptor, one.mask)
        for newcomer in self._newcomers:
            poll.register(newcomer.descriptor, select.POLLIN)
        poll.poll(100)
        self._accept()
        for each in (self._socket, *self._newcomers):
            if each is not None:
                self._take(each)

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                accepted, _ = self._server.accept()
                newcomer = UplinkSocket(accepted)
                self._newcomers.append(newcomer)
                self._watch(newcomer)

    def _watch(self, one: UplinkSocket) -> None:
        if self._engine is not None:
            self._engine.loop.add_reader(one.descriptor, self._take, one)
            self._mind_socket(one)

    def _writable(self, one: UplinkSocket) -> None:
        if one is self._socket:
            one.flush(self._outbox)
            self._mind_socket(one)

    def _take(self, one: UplinkSocket) -> None:
        """Take what has come by a connection."""
        try:
            for frame in one.read():
                self._frame(one, frame)
        except FrameError:
            one.is_broken = True
        self._mind_socket(one)

    def _mind_socket(self, one: UplinkSocket) -> bool:
        """Return whether a connection still stands, and wait for it."""
        if not one.is_broken:
            if self._engine is not None:
                loop = self._engine.loop
                if one.mask & select.EPOLLOUT:
                    loop.add_writer(one.descriptor, self._writable, one)
                else:
                    loop.remove_writer(one.descriptor)
            return True
        is_end = one is self._socket and not self._is_coming_back
        self._drop(one)
        if is_end:
            self._lose('the connection to the launcher has ended')
        return False

    def _drop(self, one: UplinkSocket) -> None:
        if self._engine is not None:
            self._engine.loop.remove(one.descriptor)
        one.close()
        if one is self._socket:
            self._socket = None
        elif one in self._newcomers:
            self._newcomers.remove(one)

    def _frame(self, one: UplinkSocket, frame: Frame) -> None:
        if frame.kind == frames.CONTROL:
            self._control(one, frame.content())
        elif one is self._socket and frame.kind == frames.MESSAGE:
            self._heard = time.monotonic()
            if self._inbox.is_new(frame):
                self._order(frame.content())

    def _control(self, one: UplinkSocket, content: Mapping[str, Any]) -> None:
        self._heard = time.monotonic()
        match content:
            case {'resume': int(number)}:
                if one in self._newcomers:
                    self._newcomers.remove(one)
                if self._socket is not None and one is not self._socket:
                    # the launcher has given it up
                    self._drop(self._socket)
                self._socket = one
                self._is_coming_back = False
                self._outbox.resume(number)
                one.send(frames.message({'resumed': self._inbox.last}))
        match content:
            case {'beat': int() | float() as sent}:
                self._echo = float(sent), time.time()
        match content:
            case {'coming_back': True}:
                self._is_coming_back = True
            case {'ack': int(number)}:
                if one is self._socket:
                    self._outbox.acknowledged(number)

    def _beat(self, one: UplinkSocket) -> None:
        self._beaten = now = time.monotonic()
        beat: dict[str, Any] = {'clock': time.time(), 'ack': self._inbox.last}
        if self._echo is not None:
            sent, came = self._echo
            beat |= {'echo': sent, 'age': time.time() - came}
            self._echo = None
        one.send(frames.message(beat))
        self._outbox.packs = one.is_slow(now, _SLOW)

    def _silence(self) -> float:
        if self._is_suspended and self._socket is not None:
            # nor does the launcher do anything
            return 0.0
        return time.monotonic() - self._heard

    def _mind_silence(self) -> None:
        if self._silence() < self._lost_after:
            return
        if self._socket is not None:
            self._drop(self._socket)
        self._lose('nothing is heard of the launcher')
        if self._told_idle and self._silence() >= KEPT_FOR:
            self._is_lost = True

    def _lose(self, reason: str) -> None:
        """Stop the part, unless it is to be kept or has been stopped."""
        if self._engine is None or self._is_lost or self._finished:
            return
        # nobody else can tell of it now
        self._engine.serve()
        if not self._keeps:
            self._is_lost = True
            why = f'the link to the launcher is lost: {reason}'
            self._engine.dispatcher.do(Shutdown(why))

    # what is told and done

    def _tell(self, content: Mapping[str, Any]) -> None:
        self._outbox.add(
            frames.MESSAGE,
            frames.json_body({'time': time.time(), **content}),
        )
        if self._engine is not None:
            # it is sent at the end of a turn
            self._engine.loop.wake()

    def _tell_idle(self) -> None:
        idle, self._idle = self._idle, False
        if idle != self._told_idle:
            self._told_idle = idle
            self._tell({'idle': idle})

    def _order(self, content: dict[str, Any]) -> None:
        if content.get('do') in ('suspend', 'continue'):
            self._is_suspended = content['do'] == 'suspend'
        if self._orders is None:
            self._early.append(content)
        elif content.get('do') == 'finish':
            self._finished = True
        else:
            self._orders.carry_out(content)
            self._changed = True

    def _look(self, now: float) -> None:
        """Tell the states that have changed."""
        self._looked = now
        self._changed = False
        assert self._orders is not None
        changed: dict[str, list[Mapping[str, Any]]] = {}
        for kind, rows in self._orders.rows().items():
            known = self._rows[kind]
            for label, row in rows.items():
                fixed = {k: v for k, v in row.items() if k != 'seconds'}
                if known.get(label) != fixed:
                    known[label] = fixed
                    changed.setdefault(kind, []).append(row)
            for label in known.keys() - rows.keys():
                del known[label]
        if changed:
            self._tell({'states': changed})
