# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A part of a launch on a machine, spoken with as the launcher does."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
import os
from pathlib import Path
import shutil
import signal
import time
from typing import Any
import uuid

from colcon_yamllaunch.common.process_scan import (
    arguments_of,
    running_processes,
)
from colcon_yamllaunch.control.command_codec import request_of
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.engine.commands import Command, Shutdown
from colcon_yamllaunch.engine.launch_scan import launcher_of
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Plan, Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.remote.connection.machine_connection import (
    MachineConnection,
)
from colcon_yamllaunch.remote.machine_link import MachineLink
from colcon_yamllaunch.remote.part_protocol import Finish, PartSettings
from support.marked_processes import command_of, kill, marked, wait_until_none

#: Seconds; a loaded machine needs some.
DEADLINE = 180
_MARK = 'COLCON_LAUNCH_TEST_LINKED'


def process(label: str, script: str, **more: Any) -> Process:
    """Return a process that runs a script of `sh`."""
    position = Position('demo.yaml', 1, 1)
    return Process(label, ('sh', '-c', script), '/', position, **more)


class PlainMachine:
    """
    A machine that any command leads to: this one, with another home.

    :ivar home: Its home folder
    """

    def __init__(self, folder: Path) -> None:
        self.home = folder / 'home'
        self.home.mkdir(parents=True)
        self._mark = uuid.uuid4().hex
        path = os.environ.get('PATH', os.defpath)
        self.words = (
            shutil.which('env') or 'env',
            '-i',
            f'HOME={self.home}',
            f'PATH={path}',
            f'{_MARK}={self._mark}',
            # so that others do not see a part that has lost its launcher
            f'XDG_RUNTIME_DIR={self.home}',
        )

    def machine(self, **more: Any) -> Machine:
        """Return it as a deployment file describes it."""
        return Machine('arm', 'connect', self.words, **more)

    def pids(self) -> list[int]:
        """Return what runs there."""
        return marked(_MARK, self._mark)

    def wait_until_empty(self, seconds: float = DEADLINE) -> None:
        """Wait until nothing runs there."""
        wait_until_none(
            lambda: [command_of(pid)[-200:] for pid in self.pids()], seconds
        )

    def clear(self) -> None:
        """End whatever runs there."""
        while pids := self.pids():
            kill(pids)


class LinkedPart:
    """
    A part that runs, and what was told of it.

    :ivar messages: The messages
    :ivar written: By label and stream, what was written
    :ivar told: The names of what the handler was told, in order
    :ivar gone_for: Why nothing more comes, if so
    """

    def __init__(
        self,
        machine: Machine,
        processes: Sequence[Process],
        environment: Mapping[str, str] | None = None,
        **settings: Any,
    ) -> None:
        self.messages: list[dict[str, Any]] = []
        self.written: dict[tuple[str, str], bytes] = {}
        self.times: list[float] = []
        self.shown = b''
        self.told: list[str] = []
        self.reason = ''
        self.gone_for: str | None = None
        self.contact = MachineConnection(machine, (), environment)
        self.contact.connect()
        settings.setdefault('on_lost', machine.on_lost)
        if machine.lost_after is not None:
            settings.setdefault('lost_after', machine.lost_after)
        settings = {'log_name': 'launch_test', **settings}
        plan = Plan(tuple(processes))
        try:
            self.link = MachineLink(
                self.contact.start_part(
                    plan, PartSettings(machine.name, **settings)
                )
            )
        except BaseException:
            self.contact.close()
            raise
        self.loop = Loop()

    def __enter__(self) -> 'LinkedPart':
        self.link.begin(self.loop, self)
        return self

    def __exit__(self, *_: object) -> None:
        self.link.close()
        self.loop.close()

    # see LinkHandler

    def message(self, message: dict[str, Any]) -> None:
        """Take a message."""
        self.messages.append(message)
        kind = next(iter(message))
        if kind == 'event':
            kind = message['event']['event']
        elif kind == 'shown':
            self.shown += message['shown']['data']
        self.told.append(kind)

    def output(
        self, label: str, stream: str, data: bytes, seconds: float
    ) -> None:
        """Take output."""
        before = self.written.get((label, stream), b'')
        self.written[label, stream] = before + data
        self.times.append(seconds)
        self.told.append('output')

    def lost(self, reason: str) -> None:
        """Take note of a loss."""
        self.told.append('lost')
        self.reason = reason

    def back(self, seconds: float) -> None:
        """Take note of its end."""
        self.told.append('back')

    def gone(self, reason: str) -> None:
        """Take note that nothing more comes."""
        self.told.append('gone')
        self.gone_for = reason

    # what a test does with it

    def turn(self) -> None:
        """Have one turn of the loop of a launch."""
        alarm = self.loop.call_later(0.05, self.loop.wake)
        self.loop.run_once()
        alarm.cancel()
        for pid in self.link.pids:
            with suppress(ChildProcessError):
                found, status = os.waitpid(pid, os.WNOHANG)
                if found:
                    self.link.ended(pid, Outcome.from_status(status))

    def wait_for(
        self, condition: Callable[[], object], seconds: float = DEADLINE
    ) -> None:
        """Have turns until something is so."""
        deadline = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < deadline, (self.told, self.gone_for)
            self.turn()

    def events(self, name: str) -> list[dict[str, Any]]:
        """Return the events of a kind."""
        found = [m.get('event') or {} for m in self.messages]
        return [event for event in found if event.get('event') == name]

    def event(self, name: str) -> dict[str, Any]:
        """Return the first event of a kind."""
        return self.events(name)[0]

    def wait_for_told(self, name: str, count: int = 1) -> None:
        """Have turns until something was told."""
        self.wait_for(lambda: self.told.count(name) >= count)

    def out(self, label: str = 'arm│a', stream: str = 'stdout') -> str:
        """Return what a process has written."""
        return self.written.get((label, stream), b'').decode()

    def send(self, command: Command[Any]) -> int:
        """Send a command, and return the number of its answer."""
        return self.link.send(request_of(command))

    def answer(self, command: Command[Any]) -> dict[str, Any]:
        """Send a command, and return the answer."""
        number = self.send(command)
        found: list[dict[str, Any]] = []

        def has_come() -> bool:
            found[:] = [m for m in self.messages if m.get('id') == number]
            return bool(found)

        self.wait_for(has_come)
        return found[0]

    def finish(self) -> None:
        """Stop all, and wait for the end."""
        self.send(Shutdown('interrupted'))
        self.send(Finish())
        self.wait_for(lambda: self.gone_for is not None)

    @property
    def engine(self) -> int:
        """The process id of the engine there, in this PID namespace."""
        found = launcher_of(self.identity)
        assert found is not None
        return found[0]

    @property
    def identity(self) -> str:
        """The identity of the part."""
        return self.link.identity

    @property
    def guard(self) -> int:
        """The process id of the guard there."""
        for one in running_processes():
            arguments = arguments_of(one.pid)
            if len(arguments) > 2 and arguments[-2] == self.identity:
                return one.pid
        raise AssertionError('there is no guard')

    def cut(self) -> None:
        """Kill the connection, as it is here."""
        os.kill(self.link.pid, signal.SIGKILL)
