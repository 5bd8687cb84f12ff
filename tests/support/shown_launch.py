# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A launch that exists on the full screen only."""

from collections.abc import Callable, Iterator
import os
from typing import Any

from colcon_yamllaunch.control.client import LaunchEndedError
from colcon_yamllaunch.control.subscription import (
    Received,
    ReceivedEvent,
    ReceivedOutput,
)
from colcon_yamllaunch.engine.commands import (
    Command,
    Describe,
    Described,
    DONE,
    PlanTree,
    Refused,
    Tree,
    Watch,
)
from colcon_yamllaunch.engine.description import (
    Branch,
    Description,
    EnclosingBlock,
    Parameter,
)
from colcon_yamllaunch.engine.state import (
    ComponentState,
    LaunchState,
    ProcessState,
)
from support.launch_states import component_state, launch_state, process_state


def process(label: str, **more: Any) -> ProcessState:
    """Return a process that runs."""
    known = {
        'pid': 1000,
        'seconds': 5.0,
        'executable': 'talker',
        'node': f'/{label}',
        'package': 'demo',
        'log': f'/log/{label}.log',
    }
    return process_state(label, **{**known, **more})


def component(
    label: str, container: str | None, **more: Any
) -> ComponentState:
    """Return a component that is loaded."""
    known = {'seconds': 4.0, 'container': f'/{container or "far"}'}
    return component_state(label, container, **{**known, **more})


def state_of(*members: Any, **more: Any) -> LaunchState:
    """Return a launch of processes and components."""
    known = {'pid': 999, 'seconds': 6.0, 'log_folder': '/log'}
    return launch_state(*members, **{**known, **more})


def description(label: str) -> Description:
    """Return all that is to be told of a process."""
    return Description(
        label,
        f'{label}-1',
        None,
        'demo',
        '/ws/demo.yaml:3:5',
        (EnclosingBlock('file', '/ws/demo.yaml', ''),),
        (Parameter('rate', '5', '/ws/demo.yaml:9:7', ('/ws/demo.yaml:2:3',)),),
        None,
        argv=('talker', 'a b'),
        environment=(('ROLE', None),),
    )


def wrote(label: str, *lines: str) -> ReceivedOutput:
    """Return lines of a process."""
    data = ''.join(f'{line}\n' for line in lines).encode()
    return ReceivedOutput(label, 'stdout', data, 1_700_000_000.0)


def happened(
    name: str, label: str | None = None, **fields: Any
) -> ReceivedEvent:
    """Return an event."""
    who = {} if label is None else {'label': label}
    return ReceivedEvent(
        name, {'time': 1_700_000_000.0, 'event': name, **who, **fields}
    )


def exited(label: str, code: int) -> ReceivedEvent:
    """Return the end of a process."""
    return happened(
        'exited',
        label,
        exit_code=code,
        signal=None,
        seconds=1.0,
        asked=False,
        failed=code != 0,
        respawn_delay=None,
    )


class ShownLaunch:
    """
    Stands for a `RunningLaunch`; it responds at once.

    :ivar state: Its state, as if each change of it was received at once
    """

    def __init__(self, *members: Any, **more: Any) -> None:
        self.state = state_of(*members, **more)
        #: The commands and requests that were sent.
        self.asked: list[object] = []
        self.tree: tuple[Branch, ...] = ()
        self.refused = ''
        self._received: list[Received] = []
        self._has_ended = False
        self._reader, self._writer = os.pipe()

    def emit(self, *received: Received) -> None:
        """Send something to the screen."""
        self._received += received
        os.write(self._writer, b'.')

    def end(self) -> None:
        """End it."""
        self._has_ended = True
        self.emit()

    def fileno(self) -> int:
        return self._reader

    def close(self) -> None:
        if self._reader != -1:
            os.close(self._reader)
            os.close(self._writer)
            self._reader = -1

    def ask(
        self, command: Command[Any], reply: Callable[[Any], object] = bool
    ) -> None:
        self.asked.append(command)
        match command:
            case Tree():
                reply(PlanTree(self.tree))
            case Describe():
                reply(Described(description(command.member)))
            case Watch() if self.state.watch is None:
                reply(Refused('no files are watched; that is --watch'))
            case _:
                reply(Refused(self.refused) if self.refused else DONE)

    def send_request(self, name: str, _: object, **more: Any) -> None:
        self.asked.append((name, more))

    def subscribe(self, *_: object, **_more: object) -> None:
        pass

    def read(self) -> None:
        os.read(self._reader, 1 << 16)

    def received(self) -> Iterator[Received]:
        taken, self._received = self._received, []
        yield from taken
        if self._has_ended:
            raise LaunchEndedError

    @property
    def commands(self) -> list[object]:
        """The commands that change something."""
        return [
            c
            for c in self.asked
            if isinstance(c, Command) and not isinstance(c, Tree | Describe)
        ]
