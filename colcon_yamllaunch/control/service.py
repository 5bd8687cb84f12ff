# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a running launch does for its clients; see `protocol`.

The one that holds the launch acknowledges what it has, and the journal keeps
the rest for it, so that it gets everything exactly once, however often it has
to connect again. It may also hold a lease: the launch is stopped when the
lease expires without a message of the holder.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict
import math
import time
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.command_codec import read_request
from colcon_yamllaunch.control.journal import Cursor, Journal
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.engine import commands, events, limits
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.loop import do_nothing
from colcon_yamllaunch.engine.outcome import ending_of
from colcon_yamllaunch.engine.state import to_json
from colcon_yamllaunch.plan.plan import Process

if TYPE_CHECKING:
    from colcon_yamllaunch.control.client_connection import Client

#: Takes the answer to a request.
Reply = Callable[[Mapping[str, Any]], None]
#: Renews the lease of a launch by some seconds; without them, it has none.
Lease = Callable[[float | None], object]
#: How often a lease is renewed, at most, while it lasts.
_RENEWALS = 8
# a day, as no client can be away for longer by mistake
_LONGEST_LEASE = 86_400.0


class Service:
    """
    Answers requests, and shows viewers what processes write.

    :param lease: Stops the launch when it is not renewed
    """

    def __init__(
        self,
        engine: Engine,
        journal: Journal,
        lease: Lease = do_nothing,
    ) -> None:
        self._engine = engine
        self._state = engine.state
        self._supervisor = engine.supervisor
        self._terminals = engine.terminals
        self._viewers: dict[str, list[Client]] = {}
        #: Events and output for clients that subscribe.
        self.journal = journal
        journal.state = engine.state
        self.subscribers = Subscribers(journal, lease)

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        if isinstance(event, events.Started | events.Exited):
            for viewer in tuple(self._viewers.get(event.process.label, ())):
                if isinstance(event, events.Started):
                    viewer.send_message({'started': event.pid})
                else:
                    ending = ending_of(event.outcome, event.asked)
                    again = event.respawn_delay is not None
                    viewer.send_message({'ended': ending, 'again': again})

    def answer(
        self,
        message: Mapping[str, Any],
        reply: Reply,
        client: 'Client',
    ) -> None:
        """
        Answer a request, at once unless `protocol` says otherwise.

        :raises ProtocolError: when it has a wrong form
        """
        if message.get('version') != protocol.VERSION:
            raise ProtocolError(
                f'this launch speaks version {protocol.VERSION} of the '
                'protocol; use the same colcon-yamllaunch as it does'
            )
        try:
            match message.get('request'):
                case 'status':
                    self._engine.measure(
                        lambda: reply(
                            protocol.success(launch=to_json(self._state))
                        )
                    )
                case 'attach':
                    self._attach(message, reply, client)
                case 'subscribe':
                    client.cursor = self.subscribers.subscribe(
                        message, client.cursor
                    )
                    answer = protocol.success(
                        launch=to_json(self._state), now=self.journal.point
                    )
                    if self.subscribers.is_holder(client.cursor):
                        answer |= self.subscribers.hold(client)
                    reply(answer)
                case 'ping':
                    fields = self.subscribers.ping(message, client.cursor)
                    reply(protocol.success(**fields))
                case name:
                    self._execute(str(name), message, reply, client.cursor)
        except RefusedError as error:
            reply(protocol.failure(str(error)))

    def _execute(
        self,
        name: str,
        message: Mapping[str, Any],
        reply: Reply,
        cursor: Cursor | None,
    ) -> None:
        """
        Execute a command.

        :raises ProtocolError: when there is none, or it has a wrong form
        """
        dispatcher = self._engine.dispatcher
        kind = dispatcher.kinds.get(name)
        is_holder = self.subscribers.is_holder(cursor)
        if kind is None or not (kind.is_public or is_holder):
            raise ProtocolError('there is no such request')
        if is_holder and self.subscribers.note_request(message.get('id')):
            # the answer was lost with a connection
            reply(protocol.success())
            return
        dispatcher.ask(
            read_request(kind, message),
            lambda response: reply(_answer(response)),
        )

    def type(self, label: str, keys: bytes) -> None:
        """Type at a process."""
        self._terminals.type(label, keys)

    def detach(self, label: str, viewer: 'Client') -> None:
        """Stop showing a process to a client."""
        self._viewers[label].remove(viewer)
        self._terminals.remove_sink(label, viewer.show)
        self._engine.emit(events.Detached(self._process(label)))

    def _process(self, name: str) -> Process:
        """
        Return a process, wherever it runs.

        :raises RefusedError: when there is none
        """
        member = self._engine.find(name)
        if isinstance(member, Process):
            return member
        return self._supervisor.task(name).process

    def _attach(
        self, message: Mapping[str, Any], reply: Reply, viewer: 'Client'
    ) -> None:
        if viewer.cursor is not None:
            raise RefusedError(
                'who has subscribed attaches by another connection'
            )
        process = self._process(_name(message))
        label = process.label
        # under a debugger, others have one, too
        if not (process.emulate_tty or self._terminals.has_keyboard(label)):
            raise RefusedError(
                f'{label} has no keyboard, as it has no terminal: give it '
                "'emulate_tty: true' in the launch file, or start the "
                f'launch with --attach {label}'
            )
        state = self._state.process(label)
        reply(protocol.success(pid=None if state is None else state.pid))
        if viewer.is_open:
            viewer.label = label
            self._viewers.setdefault(label, []).append(viewer)
            self._terminals.add_sink(label, viewer.show)
            self._engine.emit(events.Attached(process))


def _answer(response: Any) -> Mapping[str, Any]:
    """Return the response to a command as an answer."""
    if isinstance(response, commands.Refused):
        return protocol.failure(response.error)
    answer = protocol.success(**asdict(response))
    if isinstance(response, commands.Described):
        description = answer['description']
        description['environment'] = dict(description['environment'])
    return answer


def _name(message: Mapping[str, Any]) -> str:
    name = message.get('process')
    if not isinstance(name, str):
        raise ProtocolError("the request needs the name of a 'process'")
    return name


@dataclass(frozen=True, slots=True)
class _Subscribe:
    """The request to subscribe; see `protocol`."""

    since: Any = None
    events: bool = True
    output: bool = True
    states: bool = False
    raw: bool = False
    relayed: bool = False
    processes: frozenset[str] | None = None
    behind: int | None = None
    holder: str | None = None
    lease: float | None = None


class Subscribers:
    """
    Opens subscriptions, and keeps what the holder has not acknowledged.

    :param lease: Stops the launch when it is not renewed
    """

    #: Is called when the holder has another connection, and with None when it
    #: has lost that.
    when_held: Callable[['Client | None'], object] = do_nothing

    def __init__(
        self,
        journal: Journal,
        lease: Lease = do_nothing,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._journal = journal
        self._lease = lease
        self._clock = clock
        self._holder: str | None = None
        #: The connection of the holder, None while it has none.
        self.connection: Client | None = None
        #: When something came from the holder last, by the clock.
        self.heard_at = -math.inf
        #: Whether the holder said that it goes on by another connection.
        self.is_reconnecting = False
        # the id of its last request
        self._asked = 0
        # how the holder reads now, and what it has acknowledged
        self._reads: Cursor | None = None
        self._acknowledged: Cursor | None = None
        self._seconds: float | None = None
        self._renewed = -math.inf

    def subscribe(
        self,
        message: Mapping[str, Any],
        before: Cursor | None,
    ) -> Cursor:
        """
        Return the cursor of a client that subscribes.

        :param before: The cursor that it had so far
        :raises ProtocolError: when the request has a wrong form
        :raises RefusedError: when another client is the holder
        """
        request = read_request(_Subscribe, message)
        holder, lease, behind = request.holder, request.lease, request.behind
        if behind is not None and behind < 0:
            raise ProtocolError("'behind' is a number of bytes, or null")
        if lease is not None and not 0 < lease <= _LONGEST_LEASE:
            raise ProtocolError("a 'lease' is a number of seconds, or null")
        if lease is not None and holder is None:
            raise ProtocolError("a 'lease' is for a 'holder' only")
        if holder is not None and self._holder not in (None, holder):
            raise RefusedError('another client holds this launch')
        cursor = Cursor(
            wants_events=request.events,
            wants_output=request.output,
            labels=request.processes,
            behind=limits.JOURNAL_BYTES if behind is None else behind,
            is_raw=request.raw,
            is_relayed=request.relayed,
        )
        if request.states:
            # what the client has not read of the state comes after all
            cursor.version = None if before is None else before.version
            if cursor.version is None:
                state = self._journal.state
                cursor.version = 0 if state is None else state.version
        self._journal.subscribe(cursor, request.since, before)
        if holder is not None:
            self._holder, self._reads = holder, cursor
            self._acknowledge({'events': cursor.events, 'bytes': cursor.bytes})
            self._seconds, self._renewed = lease, -math.inf
            if lease is None:
                self._lease(None)
            self.heard(cursor)
        return cursor

    def hold(self, connection: 'Client') -> dict[str, Any]:
        """
        Note the connection of the holder, which has subscribed.

        :return: Fields of the answer
        """
        self.is_reconnecting = False
        self.connection = connection
        self.when_held(connection)
        return {'asked': self._asked}

    def left(self, connection: 'Client') -> None:
        """Note that a connection has ended."""
        if connection is self.connection:
            self.connection = None
            self.when_held(None)

    def note_request(self, number: object) -> bool:
        """
        Note a request of the holder.

        :param number: The `id` of the request
        :return: Whether the holder has sent it before
        """
        if not isinstance(number, int):
            return False
        if number <= self._asked:
            return True
        self._asked = number
        return False

    @property
    def unacknowledged(self) -> int:
        """How many bytes of output the holder has not acknowledged."""
        if self._acknowledged is None:
            return 0
        return self._journal.bytes_after(self._acknowledged)

    @property
    def has_all(self) -> bool:
        """Whether the holder has acknowledged everything."""
        cursor = self._acknowledged
        return cursor is not None and self._journal.is_at_end(cursor)

    def ping(
        self, message: Mapping[str, Any], cursor: Cursor | None
    ) -> dict[str, float]:
        """
        Return the fields of the answer to a `ping`.

        :param cursor: That of the client
        :raises ProtocolError: when the request has a wrong form
        :raises RefusedError: when the client acknowledges, but is not the
          holder
        """
        acknowledged = message.get('ack')
        if acknowledged is not None:
            if not self.is_holder(cursor):
                raise RefusedError('another client holds this launch')
            self._acknowledge(acknowledged)
        if self.is_holder(cursor):
            self.is_reconnecting = message.get('reconnecting') is True
        return {'clock': time.time()}

    def is_holder(self, cursor: Cursor | None) -> bool:
        """Return whether a cursor is that of the holder."""
        return cursor is not None and cursor is self._reads

    def heard(self, cursor: Cursor) -> None:
        """Renew the lease if something came from the holder."""
        if cursor is not self._reads:
            return
        self.heard_at = now = self._clock()
        if self._seconds is None:
            return
        if now >= self._renewed + self._seconds / _RENEWALS:
            self._renewed = now
            self._lease(self._seconds)

    def _acknowledge(self, point: object) -> None:
        """
        Keep what follows a point for the holder.

        :raises ProtocolError: when that is no point of this launch
        """
        self._acknowledged = self._journal.subscribe(
            Cursor(is_holder=True), point, self._acknowledged
        )
