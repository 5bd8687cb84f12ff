# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a running launch does for its clients; see `protocol`."""

from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any
from typing import cast
from typing import Protocol
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.journal import Cursor
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.protocol import ProtocolError
from colcon_yamllaunch.control.subscribers import Holder
from colcon_yamllaunch.control.subscribers import Lease
from colcon_yamllaunch.control.subscribers import Subscribers
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.outcome import ending_of
from colcon_yamllaunch.engine.state import to_json
from colcon_yamllaunch.plan.plan import Process

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.commands import Done

#: Takes the answer to a request.
Reply = Callable[[Mapping[str, Any]], None]


class Viewer(Protocol):
    """Somebody who is attached to a process."""

    def show(self, stream: events.Stream, data: bytes) -> None:
        """Take what the process wrote."""

    def tell(self, message: Mapping[str, Any]) -> None:
        """Take a message."""


class Service:
    """
    Answers requests, and shows viewers what processes write.

    :param lease: Stops the launch when it is not renewed
    """

    def __init__(
        self,
        engine: Engine,
        journal: Journal,
        lease: Lease = bool,
    ) -> None:
        self._engine = engine
        self._state = engine.state
        self._supervisor = engine.supervisor
        self._terminals = engine.terminals
        self._viewers: dict[str, list[Viewer]] = {}
        #: What happened, for those who subscribe.
        self.journal = journal
        journal.state = engine.state
        self.subscribers = Subscribers(journal, lease)

    def handle(self, event: events.Event) -> None:
        """Listen to an event."""
        if isinstance(event, events.Started | events.Exited):
            for viewer in tuple(self._viewers.get(event.process.label, ())):
                if isinstance(event, events.Started):
                    viewer.tell({'started': event.pid})
                else:
                    ending = ending_of(event.outcome, event.asked)
                    again = event.respawn_delay is not None
                    viewer.tell({'ended': ending, 'again': again})

    def answer(
        self,
        message: Mapping[str, Any],
        reply: Reply,
        connection: Holder,
        cursor: Cursor | None = None,
    ) -> str | Cursor | None:
        """
        Answer a request, at once unless `protocol` says otherwise.

        Return the label of the process to :meth:`attach` the client to, the
        cursor of its subscription, or None.

        :param connection: That of the client
        :param cursor: Where the client has come that has subscribed
        :raises ProtocolError: when it has a wrong form
        """
        if message.get('version') != protocol.VERSION:
            raise ProtocolError(
                f'this launch speaks version {protocol.VERSION} of the '
                'protocol; use the same colcon-yamllaunch as it does'
            )
        granted: str | Cursor | None = None
        answer = protocol.success()
        try:
            match message.get('request'):
                case 'status':
                    self._engine.measure(
                        lambda: reply(
                            protocol.success(launch=to_json(self._state))
                        )
                    )
                    return None
                case 'attach':
                    if cursor is not None:
                        raise RefusedError(
                            'who has subscribed attaches by another connection'
                        )
                    granted, pid = self._may_attach(_name(message))
                    answer = protocol.success(pid=pid)
                case 'subscribe':
                    granted = self.subscribers.subscribe(message, cursor)
                    answer = protocol.success(
                        launch=to_json(self._state), now=self.journal.point
                    )
                    if self.subscribers.is_holder(granted):
                        answer |= self.subscribers.hold(connection)
                case 'ping':
                    fields = self.subscribers.ping(message, cursor)
                    answer = protocol.success(**fields)
                case name:
                    self._execute(str(name), message, reply, cursor)
                    return None
        except RefusedError as error:
            answer = protocol.failure(str(error))
        reply(answer)
        return granted

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
        if is_holder and self.subscribers.is_repeated(message.get('id')):
            # the answer was lost with a connection
            reply(protocol.success())
            return
        # few launches are asked for anything
        from colcon_yamllaunch.control.command_codec import command_of

        dispatcher.ask(
            command_of(kind, message),
            lambda response: reply(_answer(response)),
        )

    def type(self, label: str, keys: bytes) -> None:
        """Type at a process."""
        self._terminals.type(label, keys)

    def attach(self, label: str, viewer: Viewer) -> None:
        """Show a process to somebody who got leave to attach."""
        self._viewers.setdefault(label, []).append(viewer)
        self._terminals.add_sink(label, viewer.show)
        self._engine.tell(events.Attached(self._process(label)))

    def detach(self, label: str, viewer: Viewer) -> None:
        """Show a process to somebody no more."""
        self._viewers[label].remove(viewer)
        self._terminals.remove_sink(label, viewer.show)
        self._engine.tell(events.Detached(self._process(label)))

    def _process(self, name: str) -> Process:
        """
        Return a process, wherever it runs.

        :raises RefusedError: when there is none
        """
        part = self._engine.find(name)
        if isinstance(part, Process):
            return part
        return self._supervisor.task(name).process

    def _may_attach(self, name: str) -> tuple[str, int | None]:
        """Return label and pid of a process to be attached to."""
        process = self._process(name)
        label = process.label
        # under a debugger, others have one, too
        if not (process.emulate_tty or self._terminals.has_keyboard(label)):
            raise RefusedError(
                f'{label} has no keyboard, as it has no terminal: give it '
                "'emulate_tty: true' in the launch file, or start the "
                f'launch with --attach {label}'
            )
        state = self._state.process(label)
        return label, None if state is None else state.pid


def _answer(response: object) -> Mapping[str, Any]:
    """Return the response to a command as an answer."""
    from colcon_yamllaunch.engine.commands import Described
    from colcon_yamllaunch.engine.commands import Refused

    if isinstance(response, Refused):
        return protocol.failure(response.error)
    answer = protocol.success(**asdict(cast('Done', response)))
    if isinstance(response, Described):
        description = answer['description']
        description['environment'] = dict(description['environment'])
    return answer


def _name(message: Mapping[str, Any]) -> str:
    name = message.get('process')
    if not isinstance(name, str):
        raise ProtocolError("the request needs the name of a 'process'")
    return name
