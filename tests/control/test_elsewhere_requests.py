# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Requests of other terminals about processes on other machines."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.service import Service
from colcon_yamllaunch.deployment.placement import PlacedPlan
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.dispatcher import Dispatcher
from colcon_yamllaunch.engine.process_stop import ProcessTask
from colcon_yamllaunch.engine.state import from_json
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.remote.remote_parts import RemoteParts
import pytest
from support.played_machine import PlayedLaunch, PlayedLink, process

HERE = process('here')
FIRST = process('arm│first', emulate_tty=True)
LAST = process('arm│last')
LABELS = ['arm│first', 'here', 'arm│last']


class Supervisor:
    """The course of what runs here."""

    is_stopping = False

    def __init__(self) -> None:
        self.tasks = [ProcessTask(0, HERE)]

    def task(self, name: str) -> ProcessTask:
        if name == 'here':
            return self.tasks[0]
        raise RefusedError(f"there is no process '{name}'")

    def stop_process(self, name: str) -> None:
        self.task(name)

    def phase(self, task: ProcessTask) -> str:
        return 'waiting'

    def seconds(self, task: ProcessTask) -> float:
        return 0.0


class Asked:
    """A launch with one process here and two on a machine."""

    def __init__(self) -> None:
        self.link = PlayedLink()
        whole = Plan((FIRST, HERE, LAST))
        placed = PlacedPlan(whole, Plan((HERE,)), {'arm': Plan((FIRST, LAST))})
        self.parts = RemoteParts([self.link], placed)
        self.launch = PlayedLaunch(self.parts)
        self.launch.state.log_files = {'arm│last': Path('/log/last')}
        engine: Any = SimpleNamespace(
            state=self.launch.state,
            participants=[self.parts],
            find=self.parts.find,
            measure=self.parts.measure,
            supervisor=Supervisor(),
            terminals=SimpleNamespace(
                has_keyboard=self.parts.has_keyboard,
                add_sink=lambda label, _: self.parts.attach(label),
                remove_sink=lambda label, _: self.parts.detach(label),
            ),
            composition=None,
            blocks=(),
            emit=self.launch.emit,
        )
        engine.parameters_of = lambda p: p.parameters
        engine.dispatcher = Dispatcher(engine)
        self.service = Service(engine, Journal())
        self.launch.here = [HERE]
        self.parts.begin()
        self.answers: list[Any] = []
        self.client: Any = SimpleNamespace(
            cursor=None, label=None, is_open=True, show=lambda *_: None
        )

    def asks(self, request: str, **more: Any) -> None:
        message = {'version': protocol.VERSION, 'request': request, **more}
        self.service.answer(message, self.answers.append, self.client)


@pytest.fixture
def asked() -> Asked:
    return Asked()


def test_state_has_processes_of_machines_in_order(asked: Asked) -> None:
    asked.link.tells(events.Started(LAST, 77))
    asked.asks('status')
    # what it uses is asked for first
    assert not asked.answers
    asked.link.answers('measure', usage={'arm│last': [0.5, 4096]})
    (answer,) = asked.answers
    state = from_json(answer['launch'])
    assert [p.label for p in state.processes] == LABELS
    last = state.processes[2]
    assert (last.machine, last.pid, last.log) == ('arm', 77, '/log/last')
    assert (last.cpu, last.memory) == (0.5, 4096)
    assert (last.local_pid, state.processes[1].machine) == (None, None)
    (arm,) = state.machines.values()
    assert (arm.name, arm.link) == ('arm', 'up')


def test_machine_describes_its_process(asked: Asked) -> None:
    asked.asks('describe', member='arm│last')
    same = {'cwd': '/home/robot', 'environment': {'A': 'b', 'C': None}}
    description = {'argv': ['there', 1], 'log': '/there/log', **same}
    asked.link.answers('describe', description=description)
    (answer,) = asked.answers
    told = answer['description']
    assert told['argv'] == ('there', '1')
    assert {name: told[name] for name in same} == same
    assert told['log'] == '/log/last'
    asked.asks('describe', member='arm│last')
    asked.link.answers('describe', description='odd')
    assert not asked.answers[-1]['ok']


def test_attaching_shows_a_process_on_a_machine(asked: Asked) -> None:
    asked.asks('attach', process='arm│last')
    assert asked.client.label is None
    assert 'has no keyboard' in asked.answers[-1]['error']
    asked.link.tells(events.Started(FIRST, 78))
    asked.asks('attach', process='arm│first')
    assert asked.client.label == 'arm│first'
    assert asked.answers[-1]['pid'] == 78
    asked.service.detach('arm│first', asked.client)
    sent = [(m['request'], m['is_shown']) for m in asked.link.sent[-2:]]
    assert sent == [('show', True), ('show', False)]
    told = [events.Attached(FIRST), events.Detached(FIRST)]
    assert asked.launch.told[-2:] == told
