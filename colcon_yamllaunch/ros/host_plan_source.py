# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The host of launch files in Python as a source of more plan."""

import signal
from typing import Any
from typing import Protocol

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.language.evaluation.launch_host import Growing
from colcon_yamllaunch.language.evaluation.launch_host import HostError
from colcon_yamllaunch.language.evaluation.launch_host import HostMessage
from colcon_yamllaunch.plan.plan import Growth
from colcon_yamllaunch.plan.plan import Process


class Link(Protocol):
    """What is needed of the link to the host; none of it waits."""

    @property
    def descriptor(self) -> int:
        """What is readable when the host has said something, or -1."""

    @property
    def pid(self) -> int:
        """The process of the host, or 0 when there is none any more."""

    def poll(self) -> HostMessage | None:
        """
        Return the next message if there is one.

        :raises HostError: when nothing will come any more
        """

    def flush(self) -> bool:
        """Write what is to be sent, and return whether all is written."""

    def reaped(self) -> None:
        """Take note that somebody waited for the host."""

    def close(self) -> None:
        """End the host with all that it has started."""


class HostPlanSource:
    """
    Tells the host what happens, and returns what it makes of that.

    See :class:`.plan_source.PlanSource`, which this is.

    :param link: The link to the host
    :param growing: What turns the answers of the host into plan
    :param number: The number of the host in the launch
    """

    def __init__(self, link: Link, growing: Growing, number: int) -> None:
        self._link = link
        self._growing = growing
        self._number = number
        # what is restarted after a change, with its end, which is kept back
        self._changed: dict[str, events.Exited | None] = {}

    @property
    def descriptor(self) -> int:
        """See `PlanSource`."""
        return self._link.descriptor

    @property
    def pid(self) -> int:
        """See `PlanSource`."""
        return self._link.pid

    @property
    def number(self) -> int:
        """See `PlanSource`."""
        return self._number

    @property
    def is_busy(self) -> bool:
        """See `PlanSource`."""
        return self._growing.is_busy

    @property
    def wants_output(self) -> frozenset[str]:
        """See `PlanSource`."""
        return self._growing.wants_output

    def handle(self, event: events.Event) -> None:
        """See `PlanSource`."""
        match event:
            case events.Requested(action='change'):
                self._changed.setdefault(event.process.label, None)
            case events.Requested() | events.StartFailed():
                # it is not the change any more that it ends for
                kept = self._changed.pop(event.process.label, None)
                if kept is not None:
                    self.handle(kept)
            case events.Started() if self._changed.pop(
                event.process.label, None
            ):
                return
            case events.Exited() if event.process.label in self._changed:
                # what waits for its end does not wait for this
                self._changed[event.process.label] = event
            case events.Started():
                self._tell_of(event.process, 'start', pid=event.pid)
            case events.Exited(outcome=outcome):
                code = outcome.code
                if outcome.signal is not None:
                    # as Python's subprocess has it, and so ROS 2
                    code = -outcome.signal
                elif outcome.lost:
                    # ROS 2 knows of no other end that nobody has seen
                    code = -signal.SIGKILL
                self._tell_of(
                    event.process,
                    'exit',
                    returncode=code,
                    respawns=event.respawn_delay is not None,
                    asked=event.asked,
                )
            case events.StateChanged() if self._growing.has_handlers:
                self._tell(
                    'state',
                    node=event.node,
                    to=event.state,
                    # a word of Python
                    **{'from': event.before},
                )
            case events.ShuttingDown():
                self._tell(
                    'shutdown',
                    reason=event.reason,
                    by_sigint=event.interactive,
                )
            case _:
                return

    def output(self, process: str, stream: events.Stream, data: bytes) -> None:
        """See `PlanSource`."""
        number = self._growing.id_of(process)
        if number is not None:
            text = data.decode(errors='replace')
            self._tell('output', process=number, stream=stream, text=text)

    def flush(self) -> bool:
        """See `PlanSource`."""
        return self._link.flush()

    def call(self, number: int) -> None:
        """See `PlanSource`."""
        self._ask({'do': 'call', 'number': number})

    def take(self) -> list[Growth]:
        """See `PlanSource`."""
        growths = []
        try:
            while (message := self._link.poll()) is not None:
                growth = self._growing.take(message)
                if growth is not None:
                    growths.append(growth)
        except HostError as error:
            growths.append(self._growing.lost(str(error)))
        return growths

    def ended(self, status: int) -> list[Growth]:  # noqa: ARG002
        """See `PlanSource`."""
        # what it said last counts
        growths = self.take()
        self._link.reaped()
        return [*growths, self._growing.lost('')]

    def close(self) -> None:
        """See `PlanSource`."""
        self._link.close()

    def _tell_of(self, process: Process, kind: str, **fields: Any) -> None:
        number = self._growing.id_of(process.ros_name)
        if number is not None:
            self._tell(kind, process=number, **fields)

    def _tell(self, kind: str, **fields: Any) -> None:
        self._ask({'do': 'event', 'event': {'type': kind, **fields}})

    def _ask(self, request: HostMessage) -> None:
        try:
            self._growing.ask(request)
        except HostError:
            # its end is reported as that of any child of ours
            return
