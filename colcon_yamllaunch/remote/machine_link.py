# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The link to a machine while its part of the launch runs.

It is a client of the control socket of the part, and holds it: after a lost
connection it subscribes from the point that it has come to, and sends again
the requests that the part has not executed.
"""

from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
import math
import os
import signal
import time
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.codec import to_json
from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.command_codec import request_of
from colcon_yamllaunch.control.protocol import MessageReader, ProtocolError
from colcon_yamllaunch.engine.commands import Shutdown
from colcon_yamllaunch.engine.loop import Loop, TimerHandle
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.remote.connection.bootstrap import (
    Bootstrap,
    program_archive,
)
from colcon_yamllaunch.remote.connection.connect_process import (
    can_connect_again,
    connect,
    ConnectProcess,
)
from colcon_yamllaunch.remote.connection.machine_connection import (
    CONNECTION_SILENCE,
    read_message,
    StartedPart,
)
from colcon_yamllaunch.remote.part_protocol import (
    Finish,
    heartbeat_of,
    LOST_AFTER,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.remote.remote_part import RemotePart

#: Seconds that a new connection may take until the machine answers.
ANSWER_TIMEOUT = 15.0
#: Seconds that the start of a new part may take, which sources a workspace.
START_TIMEOUT = 25.0
#: Seconds between two attempts to connect again, and the longest of these
#: pauses, as each is longer than the one before.
FIRST_PAUSE = 0.5
LONGEST_PAUSE = 5.0
#: Seconds after the loss by which a part with `on_lost: stop` has ended: the
#: longest usual timeouts.
STOPPED_AFTER = 20.0
#: Bytes that may wait for a screen that takes no more; a machine that sends
#: more than it may is broken.
MAXIMUM_HELD = 64 * 1024 * 1024
#: Seconds that a machine gets at the end to see that nothing is left there.
CLOSE_TIMEOUT = 2.0
#: Seconds for which the loop may stand still, as when the launch is suspended,
#: without that being silence of a machine; less where that is short.
_STANDSTILL = 2.0
#: Messages that are delivered before others get their turn.
_PER_TURN = 64
#: Bytes of output after which they are acknowledged.
_ACKNOWLEDGED = 512 * 1024
#: Seconds by which the guard of a part waits longer than its engine, which
#: says why it stops.
_GUARD_MARGIN = 5.0
_READ = 256 * 1024
_SUBSCRIBED = 'subscribed'
#: How many heartbeats the difference of the clocks is estimated from; the
#: fastest of them is the best.
_LOOKED_AT = 30
#: The seconds of a time that still has a date (year 9999).
_LAST = 253_402_300_799.0


class MachineLink:
    """
    The client of a part, on one connection after another.

    :param part: The part, which begins to run with :meth:`begin`
    """

    _loop: Loop
    _handler: 'RemotePart'

    def __init__(self, part: StartedPart) -> None:
        self.machine = part.machine
        self._part = part
        self._process: ConnectProcess | None = part.process
        self._is_begun = False
        self._lost_after = part.machine.lost_after or LOST_AFTER
        self._silence = min(CONNECTION_SILENCE, self._lost_after)
        self._heartbeat = heartbeat_of(self._lost_after)
        self._reader = part.reader
        # whether the part is at the other end of the connection
        self._is_relayed = False
        # when those pings were sent that are not answered
        self._pings: deque[float] = deque()
        self._unsent = bytearray()
        self._clock = ClockDifference(part.facts.ahead)
        # None once the engine there answers
        self._bootstrap: Bootstrap | None = None
        # whether the part has answered that we have subscribed
        self._is_subscribed = False
        # the plan of a new part, while one is to be started
        self._new_plan: Callable[[], str] | None = None
        # the first connection exists already
        self._timeout = CONNECTION_SILENCE
        self._lost_at: float | None = None
        self._pause = FIRST_PAUSE
        self._retry: TimerHandle | None = None
        # the next turn in which messages are delivered
        self._delivery: TimerHandle | None = None
        # connections that were given up, until they are reaped
        self._ending: dict[int, ConnectProcess] = {}
        self._reset()

    def _reset(self) -> None:
        """Reset all counters and queues for a new part."""
        # how many events, and bytes of output, were delivered, and how much
        # of that the part knows
        self._events = self._bytes = self._acknowledged = 0
        # the id of the last request, and requests that are not answered
        self._last_request = 0
        self._unanswered: dict[int, bytes] = {}
        self._holder = os.urandom(8).hex()
        # messages to deliver with the sizes of their output
        self._messages: deque[tuple[dict[str, Any], int]] = deque()
        self._queue_size = 0
        self._is_paused = False
        #: Whether nothing more comes.
        self.is_gone = False
        # whether the part has ended
        self._is_over = False

    @property
    def identity(self) -> str:
        """The launch identity of the part on the machine."""
        return self._part.identity

    @property
    def pid(self) -> int:
        """The process id of the connection, or 0."""
        return 0 if self._process is None else self._process.pid

    @property
    def pids(self) -> frozenset[int]:
        """The process ids of all connections that have not ended."""
        return frozenset({self.pid, *self._ending} - {0})

    def begin(self, loop: Loop, handler: 'RemotePart') -> None:
        """
        Start the part, and communicate with it from now on.

        :param handler: Receives what comes from the machine, in order,
          exactly once, and what becomes of the connection
        """
        self._loop, self._handler = loop, handler
        self._is_begun = True
        process = self._process
        assert process is not None
        process.leave_to_guard()
        now = time.monotonic()
        self._heard_at = self._connecting_since = self._last_beat = now
        loop.call_later(self._heartbeat, self._beat)
        self._watch(process)
        self._put(protocol.encode({'relay': True}))

    @property
    def can_start_again(self) -> bool:
        """Whether a new part may be started after this one."""
        return can_connect_again(self.machine, self._part.environment)

    def start_again(self, plan: Callable[[], str], *, at_once: bool) -> None:
        """
        Start a new part on a machine that is gone.

        With `on_lost: restart` that is tried until it succeeds, else once.

        :param plan: Returns the part in JSON when it is sent
        :param at_once: Whether to connect now, or after a pause
        """
        if self.is_gone:
            self._reset()
            self._lost_at = time.monotonic()
            self._retry_later(self._pause)
            self._pause = min(self._pause * 2, LONGEST_PAUSE)
        self._new_plan = plan
        if at_once:
            self._retry_later(0.0)

    def send(self, request: Mapping[str, Any]) -> int:
        """
        Send a request, which is executed exactly once.

        :return: The `id` that its answer will have
        """
        self._last_request += 1
        data = protocol.encode({**request, 'id': self._last_request})
        self._unanswered[self._last_request] = data
        if self._is_subscribed:
            self._put(data)
        return self._last_request

    def pause(self, is_paused: bool) -> None:
        """Stop delivering messages, or resume."""
        self._is_paused = is_paused
        self._deliver_soon()

    def _beat(self) -> None:
        """Send a heartbeat, or handle that the machine is silent."""
        self._loop.call_later(self._heartbeat, self._beat)
        now = time.monotonic()
        gap = now - self._last_beat
        self._last_beat = now
        if gap > self._heartbeat + min(_STANDSTILL, self._silence / 2):
            # what was sent meanwhile is still to be read
            self._heard_at += gap
            self._connecting_since += gap
        if self._process is None:
            return
        if not self._is_subscribed:
            if now - self._connecting_since > self._timeout:
                self._lose('it does not answer')
        elif now - self._heard_at > self._silence:
            # the end of this connection is not to stop its part
            self._ping(reconnecting=True)
            self._lose(f'nothing was heard of it for {self._silence:g} s')
        else:
            self._ping()

    def ended(self, pid: int, outcome: Outcome) -> None:
        """Handle the end of a connection process."""
        known = self._ending.pop(pid, None)
        if known is not None:
            known.status = 0
            return
        if pid != self.pid or self._process is None:
            return
        self._process.status = 0
        # what it has written before
        self._receive()
        if self._process is not None:
            self._lose(f'the connection ended ({outcome})')

    def detach_fork(self) -> None:
        """Close the pipes of the connection, in a fork of this process."""
        if self._process is not None:
            self._process.close_pipes()

    def close(self) -> None:
        """
        End the link, and wait until nothing of it runs here.

        What still runs there is stopped, unless it is to be kept.
        """
        if self._is_subscribed and self.machine.on_lost != 'keep':
            self.send(request_of(Shutdown('the launch has ended')))
            self.send(request_of(Finish()))
        if self._process is not None:
            self._drop_connection(self._process)
        deadline = time.monotonic() + CLOSE_TIMEOUT
        for process in self._ending.values():
            process.close(max(0.0, deadline - time.monotonic()))
        self._ending.clear()
        self.is_gone = True

    # the connection

    def _watch(self, process: ConnectProcess) -> None:
        for descriptor in (process.stdin, process.stdout):
            os.set_blocking(descriptor, False)
        self._loop.add_reader(process.stdout, self._receive)
        self._loop.add_reader(process.stderr, self._read_messages)

    def _read_messages(self) -> None:
        process = self._process
        if process is not None and not process.read_messages():
            self._loop.remove(process.stderr)

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
            data = self._start_program(self._bootstrap, data)
        self._feed(data)

    def _feed(self, data: bytes) -> None:
        process = self._process
        try:
            for message in self._reader.feed(data):
                self._heard_at = time.monotonic()
                if self._is_relayed:
                    self._handle(message)
                else:
                    self._handle_reply(message)
                if self._process is not process or process is None:
                    return
        except ProtocolError as error:
            self._give_up(f'the connection is damaged: {error}')

    def _handle_reply(self, content: Mapping[str, Any]) -> None:
        """Handle a reply of the agent, before the part sends messages."""
        match content:
            case {'reply': _, 'error': str(error)}:
                if self._new_plan is None:
                    # it is there, without its part
                    self._pause = FIRST_PAUSE
                self._give_up(one_line(error))
            case {
                'reply': _,
                'result': {'identity': str(identity), 'boot': str(boot)},
            }:
                self._new_plan = None
                self._part = replace(self._part, identity=identity, boot=boot)
                self._put(protocol.encode({'relay': True}))
            case {'reply': _}:
                self._give_up('it does not say which part it has started')
            case {'relay': _}:
                self._subscribe()

    def _subscribe(self) -> None:
        """Subscribe to what was not delivered yet."""
        self._is_relayed = True
        self._pings.clear()
        # undelivered messages come once more
        self._messages.clear()
        self._queue_size = 0
        keeps = self.machine.on_lost == 'keep'
        lease = None if keeps else self._lost_after + _GUARD_MARGIN
        request = protocol.request(
            'subscribe',
            id=_SUBSCRIBED,
            since=self._point,
            raw=True,
            relayed=True,
            holder=self._holder,
            lease=lease,
        )
        self._put(protocol.encode(request))

    def _handle(self, message: dict[str, Any]) -> None:
        """
        Handle a message of the part.

        :raises ProtocolError: when it makes no sense
        """
        number = message.get('id')
        if 'ok' in message and not isinstance(number, int):
            if message['ok'] is not True:
                raise ProtocolError(one_line(str(message.get('error'))))
            if number == _SUBSCRIBED:
                self._resume(message.get('asked'))
                return
            clock = message.get('clock')
            if not self._pings or not isinstance(clock, int | float):
                raise ProtocolError('it answers what nobody asked')
            self._clock.note(self._pings.popleft(), float(clock))
        elif 'killed' in message:
            self._give_up(one_line(str(message['killed'])))
        elif not self._is_subscribed:
            raise ProtocolError('a message came too early')
        else:
            self._add_message(message)

    def _add_message(self, message: dict[str, Any]) -> None:
        """
        Queue a message for the handler.

        :raises ProtocolError: when too many wait already
        """
        number = message.get('id')
        if isinstance(number, int):
            self._unanswered.pop(number, None)
        size = 0
        match message:
            case {'output': {'data': bytes(data)}} | {
                'shown': {'data': bytes(data)}
            }:
                size = len(data)
        self._messages.append((message, size))
        self._queue_size += size
        if self._queue_size > MAXIMUM_HELD:
            raise ProtocolError('it sends more than it may')
        self._deliver_soon()

    def _resume(self, asked: object) -> None:
        """
        Go on with the part.

        :param asked: The last request that it has executed
        :raises ProtocolError: when it was not asked for that
        """
        if not isinstance(asked, int) or not 0 <= asked <= self._last_request:
            raise ProtocolError('it has executed more than it was asked for')
        self._is_subscribed = True
        self._unanswered = {
            number: data
            for number, data in self._unanswered.items()
            if number > asked
        }
        self._put(b''.join(self._unanswered.values()))
        if self._lost_at is not None:
            seconds = time.monotonic() - self._lost_at
            self._lost_at = None
            self._pause = FIRST_PAUSE
            self._handler.back(seconds)

    def _ping(self, *, reconnecting: bool = False) -> None:
        """Acknowledge what was delivered, and request a reply."""
        self._acknowledged = self._bytes
        self._pings.append(time.time())
        request = protocol.request(
            'ping', ack=self._point, reconnecting=reconnecting
        )
        self._put(protocol.encode(request))

    @property
    def _point(self) -> dict[str, int]:
        """How far events and output were delivered; see `protocol`."""
        return {'events': self._events, 'bytes': self._bytes}

    def _put(self, data: bytes) -> None:
        self._unsent += data
        self._write()

    def _write(self) -> None:
        process = self._process
        if process is None or process.stdin == -1:
            return
        try:
            while self._unsent:
                del self._unsent[: os.write(process.stdin, self._unsent)]
        except BlockingIOError:
            pass
        except OSError:
            # its end shows when we read
            self._unsent.clear()
        if self._unsent:
            self._loop.add_writer(process.stdin, self._write)
        else:
            self._loop.remove_writer(process.stdin)

    def _deliver_soon(self) -> None:
        """Deliver queued messages in the next turn, unless paused."""
        if self._delivery is None and self._messages and not self._is_paused:
            self._delivery = self._loop.call_soon(self._deliver_in_turn)

    def _deliver_in_turn(self) -> None:
        self._delivery = None
        if self.is_gone:
            return
        self._deliver()
        if (
            self._is_subscribed
            and self._bytes - self._acknowledged >= _ACKNOWLEDGED
        ):
            self._ping()
        self._deliver_soon()

    def _deliver(self) -> None:
        """Deliver as many queued messages as fit into a turn."""
        try:
            for _ in range(_PER_TURN):
                if self._is_paused or not self._messages:
                    return
                message, size = self._messages.popleft()
                self._queue_size -= size
                self._deliver_message(message)
        except ProtocolError as error:
            self._give_up(f'the connection is damaged: {error}')

    def _deliver_message(self, message: dict[str, Any]) -> None:
        """
        Pass on one message.

        :raises ProtocolError: when it makes no sense
        """
        handler = self._handler
        match message:
            case {
                'output': {
                    'process': str(label),
                    'stream': 'stdout' | 'stderr' as stream,
                    'time': int() | float() as seconds,
                    'at': int(before),
                    'data': bytes(data),
                }
            }:
                self._bytes = before + len(data)
                here = self._clock.here(float(seconds))
                handler.output(label, stream, data, here)
                return
            case {'output': _}:
                raise ProtocolError('output has a wrong form')
            case {'event': dict(event)}:
                self._events += 1
                there = event.pop('time', None)
                if isinstance(there, int | float):
                    message['time'] = self._clock.here(float(there))
                if event.get('event') == 'ended':
                    self._is_over = True
            case {'missed': {'events': int(events), 'bytes': int(size)}}:
                self._events += events
                self._bytes += size
        handler.message(message)
        if self._is_over and self._is_subscribed:
            # it waits for that
            self._ping()

    # loss

    def _lose(self, reason: str) -> None:
        """Handle the loss of the connection."""
        process = self._process
        if process is not None:
            self._drop_connection(process)
        while self._messages and not self._is_paused:
            self._deliver()
        if self._is_over:
            self._finish('it has ended')
            return
        pause = self._pause
        self._pause = min(self._pause * 2, LONGEST_PAUSE)
        if self._lost_at is None:
            self._lost_at = time.monotonic()
            pause = 0.0
            self._handler.lost(reason)
        self._retry_later(pause)
        if self._new_plan is not None and self.machine.on_lost != 'restart':
            # the requester gets the reason
            self._give_up(reason)
        elif not self.can_start_again:
            self._give_up(f'{reason}; its allocation has ended')

    def _retry_later(self, pause: float) -> None:
        """Try to connect again after a pause."""
        if self._retry is not None:
            self._retry.cancel()
        self._retry = self._loop.call_later(pause, self._reconnect)

    def _reconnect(self) -> None:
        """Connect again, unless the part has stopped by now."""
        if self._lost_at is None or self._process is not None:
            return
        keeps = self.machine.on_lost == 'keep'
        limit = self._lost_after + STOPPED_AFTER
        is_late = time.monotonic() - self._lost_at > limit
        if is_late and not keeps and self._new_plan is None:
            self._give_up(
                f'no connection for {limit:g} s; its part has stopped itself'
            )
            return
        self._connecting_since = time.monotonic()
        self._timeout = ANSWER_TIMEOUT
        try:
            process = connect(
                self.machine,
                self._part.environment,
                host=self._part.facts.host,
            )
        except OSError as error:
            self._lose(str(error.strerror))
            return
        self._process = process
        self._reader = MessageReader(read_message)
        self._is_relayed = False
        self._unsent.clear()
        self._is_subscribed = False
        self._bootstrap = Bootstrap(program_archive(), self.machine.python)
        self._watch(process)
        self._put(self._bootstrap.script())

    def _start_program(self, bootstrap: Bootstrap, data: bytes) -> bytes:
        """Continue to start our program there; return the data behind that."""
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
            if self._new_plan is not None:
                self._connecting_since = time.monotonic()
                self._timeout = START_TIMEOUT
                content = {
                    'request': 'start',
                    'plan': self._new_plan(),
                    'settings': to_json(self._part.settings),
                }
            content['id'] = 1
            self._put(protocol.encode(content))
        return rest

    def _drop_connection(self, process: ConnectProcess) -> None:
        """Close a connection; its process is reaped later."""
        self._process = None
        self._bootstrap = None
        self._is_subscribed = False
        self._unsent.clear()
        if self._is_begun:
            for descriptor in (process.stdin, process.stdout, process.stderr):
                self._loop.remove(descriptor)
        process.close_pipes()
        if process.status is None:
            self._ending[process.pid] = process
            if self._is_begun:
                self._loop.call_later(CLOSE_TIMEOUT, self._kill, process.pid)

    def _kill(self, pid: int) -> None:
        """Kill a connection process that hangs, as after a network failure."""
        if pid in self._ending:
            with suppress(ProcessLookupError):
                os.killpg(pid, signal.SIGKILL)
            self._loop.call_later(CLOSE_TIMEOUT, self._kill, pid)

    def _give_up(self, reason: str) -> None:
        """End the link for good, for any reason."""
        if self._process is not None:
            self._drop_connection(self._process)
        self._finish(reason)

    def _finish(self, reason: str) -> None:
        if not self.is_gone:
            self.is_gone = True
            self._new_plan = self._lost_at = None
            self._handler.gone(reason)


class ClockDifference:
    """
    Estimated from heartbeats, as the Network Time Protocol does (RFC 5905, 8).

    :param ahead: Seconds, as far as is known before
    """

    def __init__(self, ahead: float) -> None:
        # the seconds that each took, and the difference that follows
        self._seen: deque[tuple[float, float]] = deque(maxlen=_LOOKED_AT)
        #: How many seconds it is ahead of ours.
        self.ahead = ahead

    def note(self, sent: float, theirs: float) -> None:
        """
        Note the answer to a heartbeat.

        :param sent: When that was sent, by our clock
        :param theirs: When it was answered, by the other clock
        """
        now = time.time()
        took = now - sent
        if not math.isfinite(took) or not math.isfinite(theirs):
            return
        if took < 0:
            # one of the clocks was set meanwhile
            self._seen.clear()
            return
        self._seen.append((took, theirs + took / 2 - now))
        self.ahead = min(self._seen)[1]

    def here(self, seconds: float) -> float:
        """Return a time of the other clock by ours."""
        here = seconds - self.ahead
        # a time outside this range is wrong
        return here if 0 <= here < _LAST else time.time()


def _last_line(text: str) -> str:
    lines = [line for line in text.splitlines() if line.strip()]
    return one_line(lines[-1]) if lines else 'the connection ended'
