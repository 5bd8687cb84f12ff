# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The link to a machine while its part of the launch runs."""

from collections import deque
from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
import os
import signal
import time
from typing import Any
from typing import Protocol

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.remote.connection.bootstrap import Bootstrap
from colcon_yamllaunch.remote.connection.connect_command import (
    can_connect_again,
)
from colcon_yamllaunch.remote.connection.connect_command import connect_command
from colcon_yamllaunch.remote.connection.connect_command import (
    connect_variables,
)
from colcon_yamllaunch.remote.connection.connect_process import ConnectProcess
from colcon_yamllaunch.remote.connection.machine_connection import StartedPart
from colcon_yamllaunch.remote.connection.program_archive import program_archive
from colcon_yamllaunch.remote.link.clock_difference import ClockDifference
from colcon_yamllaunch.remote.wire import frames
from colcon_yamllaunch.remote.wire.frames import Frame
from colcon_yamllaunch.remote.wire.frames import FrameError
from colcon_yamllaunch.remote.wire.frames import FrameReader
from colcon_yamllaunch.remote.wire.numbered import Inbox
from colcon_yamllaunch.remote.wire.numbered import Outbox
from colcon_yamllaunch.remote.wire.part_settings import heartbeat_of
from colcon_yamllaunch.remote.wire.part_settings import LOST_AFTER

#: Seconds without a word after which a link is lost, at most.
SILENCE = 4.5
#: Seconds that a new connection may take until the machine answers.
PATIENCE = 15.0
#: Seconds that the start of a new part may take, which sources a workspace.
START_PATIENCE = 25.0
#: Seconds between two attempts to connect again, and the longest of these
#: pauses, as each is longer than the one before.
FIRST_PAUSE = 0.5
LONGEST_PAUSE = 5.0
#: Seconds after which nothing of a part runs any more that is stopped when its
#: link is lost, and that has been noticed there: the longest usual time-outs.
STOPPED_AFTER = 20.0
#: Bytes that may wait for a screen that takes no more; a machine that sends
#: more without being told to is broken.
MAXIMUM_HELD = 64 * 1024 * 1024
#: Seconds that a machine gets at the end to see that nothing is left there.
LAST_PATIENCE = 2.0
#: Seconds for which the loop may stand still, as when the launch is suspended,
#: without that being silence of a machine; less where that is short.
_STANDSTILL = 2.0
#: Frames of output that are passed on before others get their turn.
_PER_TURN = 64
_READ = 256 * 1024
_BATCH = 256 * 1024


class LinkHandler(Protocol):
    """What is told what comes from a machine, in one order, exactly once."""

    def message(self, message: dict[str, Any]) -> None:
        """Take a message; its `time` is by the clock here."""

    def output(
        self, label: str, stream: str, data: bytes, seconds: float
    ) -> None:
        """
        Take what a process wrote.

        :param stream: `stdout` or `stderr`
        :param seconds: When, by the clock here (:func:`time.time`)
        """

    def echo(self, label: str, data: bytes) -> None:
        """Take what the terminal of a process has echoed."""

    def lost(self, reason: str) -> None:
        """Take note that the link is lost; it is tried to get it back."""

    def back(self, seconds: float) -> None:
        """Take note that it is back, after so many seconds."""

    def gone(self, reason: str) -> None:
        """Take note that nothing more comes, as the part has ended or not."""


class MachineLink:
    """
    Speaks with the engine of a part, by one connection after another.

    :param part: The part, which begins to run with :meth:`begin`
    :param environment: The variables of the launcher
    """

    def __init__(
        self, part: StartedPart, environment: Mapping[str, str]
    ) -> None:
        self.machine = part.machine
        self.name = part.machine.name
        self._part = part
        self._environment = environment
        self._process: ConnectProcess | None = part.process
        self._loop: Loop | None = None
        self._handler: LinkHandler | None = None
        self._lost_after = part.machine.lost_after or LOST_AFTER
        self._silence = min(SILENCE, self._lost_after)
        self._heartbeat = heartbeat_of(self._lost_after)
        self._outbox = Outbox()
        self._inbox = Inbox()
        self._reader = FrameReader()
        self._unsent = bytearray()
        self._clock = ClockDifference(part.facts.ahead)
        # what waits for a screen that takes no more
        self._waiting: deque[Frame] = deque()
        self._waiting_size = 0
        self._held = False
        # None once the engine there answers
        self._bootstrap: Bootstrap | None = None
        self._is_resumed = False
        # the plan of a new part, while one is to be started
        self._plan: Callable[[], str] | None = None
        # the first connection exists already
        self._patience = SILENCE
        self._heard = self._beaten = time.monotonic()
        self._since = self._turned = self._heard
        self._lost_at: float | None = None
        self._pause = FIRST_PAUSE
        self._retry_at = 0.0
        self._reason = ''
        # connections that were given up, until they are reaped
        self._ending: dict[int, tuple[ConnectProcess, float]] = {}
        #: Whether nothing more comes.
        self.is_gone = False
        self._is_over = False

    @property
    def identity(self) -> str:
        """The identity of the launch that the part is there."""
        return self._part.identity

    @property
    def pid(self) -> int:
        """The process that connects, a child of ours, or 0."""
        return 0 if self._process is None else self._process.pid

    @property
    def pids(self) -> frozenset[int]:
        """That, and those of earlier connections that have not ended."""
        return frozenset({self.pid, *self._ending} - {0})

    @property
    def is_lost(self) -> bool:
        """Whether the link is lost now."""
        return self._lost_at is not None

    def begin(self, loop: Loop, handler: LinkHandler) -> None:
        """Let the part run, and speak with it from now on."""
        self._loop, self._handler = loop, handler
        process = self._process
        assert process is not None
        process.leave_to_guard()
        self._heard = self._since = time.monotonic()
        self._watch(process)
        self._resume()
        self._feed(self._part.received)

    @property
    def can_start_again(self) -> bool:
        """Whether a new part may be started after this one."""
        return can_connect_again(self.machine, self._environment)

    def start_again(self, plan: Callable[[], str], *, at_once: bool) -> None:
        """
        Start a new part on a machine that is gone.

        With `on_lost: restart` that is tried until it succeeds, else once.

        :param plan: Returns the part in JSON when it is sent
        :param at_once: Whether to connect now, or after a pause
        """
        now = time.monotonic()
        if self.is_gone:
            self.is_gone = self._is_over = self._held = False
            self._outbox.close()
            self._outbox, self._inbox = Outbox(), Inbox()
            self._waiting.clear()
            self._waiting_size = 0
            self._lost_at = now
            self._retry_at = now + self._pause
            self._pause = min(self._pause * 2, LONGEST_PAUSE)
        self._plan = plan
        if at_once:
            self._retry_at = now

    def send(self, message: Mapping[str, Any]) -> None:
        """Have a message arrive there, exactly once."""
        self._outbox.add(frames.MESSAGE, frames.json_body(dict(message)))
        self._flush()

    def hold(self, held: bool) -> None:
        """Pass on no output, and nothing behind it, or go on."""
        self._held = held

    def advance(self) -> None:
        """Do what is due."""
        now = time.monotonic()
        if now - self._turned > min(_STANDSTILL, self._silence / 2):
            # what was said meanwhile is still to be read
            self._heard += now - self._turned
            self._since += now - self._turned
        self._turned = now
        self._end_old(now)
        if self.is_gone:
            return
        self._pass_on()
        if self._process is None:
            self._mind_loss(now)
        elif self._bootstrap is not None or not self._is_resumed:
            if now - self._since > self._patience:
                self._lose('it does not answer')
        elif now - self._heard > self._silence:
            # the end of this connection is not to stop its part
            self._put(frames.message({'coming_back': True}))
            self._lose(f'nothing was heard of it for {self._silence:g} s')
        if self._is_resumed:
            is_due = now - self._beaten >= self._heartbeat
            if is_due or self._inbox.is_due():
                self._beat(now)
            self._flush()

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until :meth:`advance` is to be called again."""
        now = time.monotonic()
        waits = [due - now for _, due in self._ending.values()]
        if not self.is_gone:
            if self._waiting and not self._held:
                return 0.0
            # no heartbeat is sent while the connection is lost
            beaten = self._beaten if self._is_resumed else now
            waits.append(beaten + self._heartbeat - now)
            if self._process is None:
                waits.append(self._retry_at - now)
        return max(0.0, min(waits)) if waits else None

    def ended(self, pid: int, outcome: Outcome) -> None:
        """Take into account that a connection process ended."""
        known = self._ending.pop(pid, None)
        if known is not None:
            known[0].status = 0
            return
        if pid != self.pid or self._process is None:
            return
        self._process.status = 0
        # what it has written before
        self._receive()
        if self._process is not None:
            self._lose(f'the connection ended ({outcome})')

    def disown(self) -> None:
        """Have nothing to do with it, in a fork of this process."""
        if self._process is not None:
            self._process.disown()

    def close(self) -> None:
        """
        End the link, and wait until nothing of it runs here.

        What still runs there is stopped, unless it is to be kept.
        """
        if self._is_resumed and self.machine.on_lost != 'keep':
            stop = {'do': 'stop', 'reason': 'the launch has ended'}
            for message in (stop, {'do': 'finish'}):
                self.send({**message, 'drop_timers': True})
        if self._process is not None:
            self._part_with(self._process)
        deadline = time.monotonic() + LAST_PATIENCE
        for process, _ in self._ending.values():
            process.close(max(0.0, deadline - time.monotonic()))
        self._ending.clear()
        self._outbox.close()
        self.is_gone = True

    # the connection

    def _watch(self, process: ConnectProcess) -> None:
        assert self._loop is not None
        for descriptor in (process.stdin, process.stdout):
            os.set_blocking(descriptor, False)
        self._loop.add_reader(process.stdout, self._receive)
        self._loop.add_reader(process.stderr, self._read_messages)

    def _read_messages(self) -> None:
        process = self._process
        if process is not None and not process.read_messages():
            assert self._loop is not None
            self._loop.remove(process.stderr)

    def _ready(self) -> None:
        self._write()
        self._flush()

    def _receive(self) -> None:
        process = self._process
        if process is None:
            return
        try:
            data = os.read(process.stdout, _READ)
        except BlockingIOError:
            return
        except OSError:
            data = b''
        if not data:
            if self._process is process:
                self._lose(_last_line(process.messages))
            return
        if self._bootstrap is not None:
            data = self._greeted(self._bootstrap, data)
        self._feed(data)

    def _feed(self, data: bytes) -> None:
        process = self._process
        try:
            for frame in self._reader.feed(data):
                self._frame(frame)
                if self._process is not process or process is None:
                    return
        except FrameError as error:
            self._give_up(f'the connection is damaged: {error}')

    def _frame(self, frame: Frame) -> None:
        self._heard = time.monotonic()
        if frame.kind == frames.CONTROL:
            self._control(frame.content())
        elif not self._is_resumed:
            raise FrameError('a frame came too early')
        elif self._inbox.is_new(frame):
            self._waiting.append(frame)
            self._waiting_size += len(frame.body)
            if self._waiting_size > MAXIMUM_HELD:
                raise FrameError('it sends more than it may')

    def _control(self, content: Mapping[str, Any]) -> None:
        match content:
            case {'reply': _, 'error': str(error)}:
                if self._plan is None:
                    # it is there, without its part
                    self._pause = FIRST_PAUSE
                self._give_up(one_line(error))
            case {
                'reply': _,
                'result': {'identity': str(identity), 'boot': str(boot)},
            } if self._plan is not None:
                self._plan = None
                self._part = replace(self._part, identity=identity, boot=boot)
                self._resume()
            case {'reply': _} if self._plan is not None:
                self._give_up('it does not say which part it has started')
            case {'reply': _}:
                # the engine there is at the other end now
                self._resume()
            case {'resumed': int(number)}:
                self._outbox.resume(number)
                self._is_resumed = True
                self._found_again()
            case {'killed': True}:
                self._give_up(
                    'its launcher there was killed, and its processes were '
                    'stopped'
                )
        match content:
            case {'ack': int(number)}:
                self._outbox.acknowledged(number)
        match content:
            case {
                'clock': int() | float() as theirs,
                'echo': int() | float() as sent,
                'age': int() | float() as age,
            }:
                self._clock.note(float(sent), float(age), float(theirs))

    def _found_again(self) -> None:
        if self._lost_at is not None:
            seconds = time.monotonic() - self._lost_at
            self._lost_at = None
            self._pause = FIRST_PAUSE
            assert self._handler is not None
            self._handler.back(seconds)

    def _resume(self) -> None:
        """Have the engine there send what has not come."""
        self._is_resumed = False
        now = time.time()
        content = {'resume': self._inbox.last, 'beat': now}
        self._put(frames.message(content))

    def _beat(self, now: float) -> None:
        self._beaten = now
        # what waits here is not taken yet
        number = self._inbox.last - len(self._waiting)
        self._put(frames.message({'beat': time.time(), 'ack': number}))

    def _put(self, data: bytes) -> None:
        self._unsent += data
        self._write()

    def _flush(self) -> None:
        while self._is_resumed and not self._unsent and self._outbox.has_more:
            self._put(self._outbox.take(_BATCH))

    def _write(self) -> None:
        process = self._process
        if process is None or process.stdin == -1:
            return
        with suppress(BlockingIOError):
            try:
                while self._unsent:
                    del self._unsent[: os.write(process.stdin, self._unsent)]
            except BlockingIOError:
                raise
            except OSError:
                # its end shows when we read
                self._unsent.clear()
        assert self._loop is not None
        if self._unsent:
            self._loop.add_writer(process.stdin, self._ready)
        else:
            self._loop.remove_writer(process.stdin)

    def _pass_on(self) -> None:
        """Tell what has come, for a turn."""
        handler = self._handler
        assert handler is not None
        for _ in range(_PER_TURN):
            if self._held or not self._waiting:
                return
            frame = self._waiting.popleft()
            self._waiting_size -= len(frame.body)
            try:
                if frame.kind == frames.MESSAGE:
                    handler.message(self._with_time(frame.content()))
                    if self._is_over:
                        # it waits for that
                        self._beat(time.monotonic())
                else:
                    label, stream, data, seconds = frames.read_output(
                        frame.body
                    )
                    if frame.kind == frames.ECHO:
                        handler.echo(label, data)
                    else:
                        here = self._clock.here(seconds)
                        handler.output(label, stream, data, here)
            except FrameError as error:
                self._give_up(f'the connection is damaged: {error}')
                return

    def _with_time(self, message: dict[str, Any]) -> dict[str, Any]:
        seconds = message.get('time')
        if isinstance(seconds, int | float):
            message['time'] = self._clock.here(seconds)
        if 'ended' in message:
            self._is_over = True
        return message

    # loss

    def _lose(self, reason: str) -> None:
        """Take into account that the connection is of no use any more."""
        process = self._process
        now = time.monotonic()
        if process is not None:
            self._part_with(process)
        while self._waiting and self._is_over_next():
            self._pass_on()
        if self._is_over:
            self._finish('it has ended')
            return
        self._retry_at = now + self._pause
        self._pause = min(self._pause * 2, LONGEST_PAUSE)
        assert self._handler is not None
        if self._lost_at is None:
            self._lost_at = now
            self._reason = reason
            self._retry_at = now
            self._handler.lost(reason)
        if self._plan is not None and self.machine.on_lost != 'restart':
            # who asked for it is told
            self._give_up(reason)
        elif not self.can_start_again:
            self._give_up(f'{reason}; its allocation has ended')

    def _is_over_next(self) -> bool:
        return not self._held

    def _mind_loss(self, now: float) -> None:
        if self._lost_at is None:
            return
        keeps = self.machine.on_lost == 'keep'
        limit = self._lost_after + STOPPED_AFTER
        is_late = now - self._lost_at > limit
        if is_late and not keeps and self._plan is None:
            self._give_up(
                f'no connection for {limit:g} s; its part has stopped itself'
            )
        elif now >= self._retry_at:
            self._connect_again(now)

    def _connect_again(self, now: float) -> None:
        self._since = now
        self._patience = PATIENCE
        self._retry_at = now + self._pause
        command = connect_command(
            self.machine, self._environment, host=self._part.facts.host
        )
        variables = connect_variables(self._environment, may_ask=False)
        try:
            process = ConnectProcess(command, variables)
        except OSError as error:
            self._lose(str(error.strerror))
            return
        self._process = process
        self._reader = FrameReader()
        self._unsent.clear()
        self._is_resumed = False
        self._bootstrap = Bootstrap(program_archive(), self.machine.python)
        self._watch(process)
        self._put(self._bootstrap.script())

    def _greeted(self, bootstrap: Bootstrap, data: bytes) -> bytes:
        """Go on with the first words; return what has come behind them."""
        answer, rest = bootstrap.feed(data)
        self._put(answer)
        if bootstrap.state == 'failed':
            self._lose('another program answers there')
        elif bootstrap.state == 'answered':
            self._bootstrap = None
            content: dict[str, Any] = {
                'request': 'resume',
                'identity': self._part.identity,
                'boot': self._part.boot,
            }
            if self._plan is not None:
                self._since = time.monotonic()
                self._patience = START_PATIENCE
                content = {
                    'request': 'start',
                    'plan': self._plan(),
                    'settings': self._part.settings.as_json(),
                }
            content['id'] = 1
            self._put(frames.message(content))
        return rest

    def _part_with(self, process: ConnectProcess) -> None:
        """Have a connection end, which is reaped later."""
        self._process = None
        self._bootstrap = None
        self._is_resumed = False
        self._unsent.clear()
        if self._loop is not None:
            for descriptor in (process.stdin, process.stdout, process.stderr):
                self._loop.remove(descriptor)
        process.close_pipes()
        if process.status is None:
            due = time.monotonic() + LAST_PATIENCE
            self._ending[process.pid] = process, due

    def _end_old(self, now: float) -> None:
        for pid, (process, due) in tuple(self._ending.items()):
            if now >= due:
                # it hangs in a network that is gone
                with suppress(ProcessLookupError):
                    os.killpg(pid, signal.SIGKILL)
                self._ending[pid] = process, now + LAST_PATIENCE

    def _give_up(self, reason: str) -> None:
        """Take into account that nothing more comes, for whatever reason."""
        if self._process is not None:
            self._part_with(self._process)
        self._finish(reason)

    def _finish(self, reason: str) -> None:
        if not self.is_gone:
            self.is_gone = True
            self._plan = self._lost_at = None
            assert self._handler is not None
            self._handler.gone(reason)


def _last_line(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()]
    return one_line(lines[-1]) if lines else 'the connection ended'
