# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A machine that only plays its part, and a launch that listens to it."""

from collections.abc import Callable
import os
from types import SimpleNamespace
from typing import Any

from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.engine import EventTime
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.plan.plan import Block, Plan, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.remote.remote_parts import RemoteParts
from support.launch_states import ABOUT
from support.test_loop import TestLoop

#: The size of the terminals of processes.
SIZE = os.terminal_size((120, 40))
POSITION = Position('/ws/demo.yaml', 3, 5)


def process(label: str, **fields: Any) -> Process:
    """Return a process with a label."""
    return Process(label, ('program',), '/', POSITION, **fields)


class PlayedLink:
    """A link whose other end is the test."""

    def __init__(self, name: str = 'arm', **fields: Any) -> None:
        self.machine = Machine(name, 'ssh', ('robot@arm',), **fields)
        self.pids = frozenset({4711})
        self.sent: list[dict[str, Any]] = []
        self.handler: Any = None
        self.is_paused = False
        self.is_closed = False
        self.reaped: list[int] = []
        self.can_start_again = True
        self.plan_again: Any = None

    def start_again(self, plan: Any, *, at_once: bool) -> None:
        self.plan_again = plan

    def begin(self, loop: Loop, handler: Any) -> None:
        self.handler = handler

    def send(self, request: Any) -> int:
        request = {k: v for k, v in request.items() if k != 'version'}
        self.sent.append(request)
        return len(self.sent)

    def pause(self, is_paused: bool) -> None:
        self.is_paused = is_paused

    def ended(self, pid: int, outcome: Outcome) -> None:
        self.reaped.append(pid)

    def close(self) -> None:
        self.is_closed = True
        self.pids = frozenset()

    # the other end

    def tells(self, event: events.Event) -> None:
        """Tell an event, as the machine does."""
        self.handler.message({'event': event.to_json()})

    def says(self, **message: Any) -> None:
        """Send a message."""
        self.handler.message(message)

    def asked(self, name: str) -> list[dict[str, Any]]:
        """Return the requests of one kind."""
        return [m for m in self.sent if m['request'] == name]

    def answers(self, name: str, **answer: Any) -> None:
        """Answer the last request of a kind."""
        numbers = [
            number
            for number, message in enumerate(self.sent, 1)
            if message['request'] == name
        ]
        ok = 'error' not in answer
        self.handler.message({'ok': ok, 'id': numbers[-1], **answer})


class PlayedLaunch:
    """A launch that notes what it is told."""

    def __init__(
        self,
        parts: RemoteParts | None = None,
    ) -> None:
        self.loop: Any = TestLoop()
        self.terminals: Any = SimpleNamespace()
        #: What the events say of the machines.
        self.state = LaunchState(ABOUT, clock=self.loop.time)
        self.blocks: tuple[Block, ...] = ()
        self.event_time = EventTime(lambda: 1000.0)
        self.is_stopping = False
        self.told: list[events.Event] = []
        self.output: list[tuple[str, str, bytes]] = []
        self.shown: list[tuple[str, str, bytes]] = []
        self.full: set[str] = set()
        self.here: list[Process] = []
        self.times: list[float] = []
        self.helpers: dict[int, Callable[[int], object]] = {}
        if parts is not None:
            parts.join(self)  # type: ignore[arg-type]
            self.state.expect(parts.whole(Plan()).entries)
        self.parts: Any = None

    def emit(self, event: events.Event) -> None:
        self.times.append(self.event_time())
        self.state.apply(event)
        if event.lines() or event.record():
            self.told.append(event)
        if self.parts is not None:
            self.parts.handle(event)

    def feed_output(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        self.times.append(self.event_time())
        self.output.append((process.label, stream, data))

    def check_conditions(self) -> None:
        """Check nothing: there are no conditions."""

    def end_lines(self, label: str) -> None:
        self.output.append((label, 'end', b''))

    def show(self, label: str, stream: events.Stream, data: bytes) -> None:
        self.shown.append((label, stream, data))

    def accepts(self, key: tuple[str, events.Stream]) -> bool:
        return key[0] not in self.full

    def shut_down(self, reason: str) -> None:
        self.is_stopping = True
        self.emit(events.ShuttingDown(reason))

    def terminal_size(self) -> os.terminal_size:
        return SIZE

    def planned_processes(self) -> list[Process]:
        return self.here

    def planned_components(self) -> list[Any]:
        return []

    def add_helper(self, pid: int, ended: Callable[[int], object]) -> None:
        self.helpers[pid] = ended

    def remove_helper(self, pid: int) -> None:
        self.helpers.pop(pid, None)


def plan(*labels: str, **fields: Any) -> Plan:
    """Return a plan of processes."""
    return Plan(tuple(process(label, **fields) for label in labels))
