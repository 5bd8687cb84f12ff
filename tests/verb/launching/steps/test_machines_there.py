# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Machines are connected with, given their parts, and left in order."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.plan.plan import HostCall
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.remote.deployment.deployment import Deployment
from colcon_yamllaunch.remote.deployment.deployment import Machine
from colcon_yamllaunch.remote.deployment.deployment import Rule
from colcon_yamllaunch.remote.part_protocol import PartSettings
from colcon_yamllaunch.verb import machines as verb_machines
import pytest

AT = Position('a.yaml', 1, 1)
MACHINES = {n: Machine(n, 'ssh', (n,), env=('MINE',)) for n in ('arm', 'gpu')}
VARIABLES = {'ROS_DOMAIN_ID': '3', 'MINE': 'x', 'SECRET': 'y'}


class PlayedContact:
    """A connection that does what a test says."""

    made: ClassVar[list['PlayedContact']] = []
    fails: ClassVar[dict[str, str]] = {}
    asks: ClassVar[set[str]] = set()

    def __init__(self, machine, places, environment, *, may_ask, say):
        self.machine = machine
        self.places = places
        self.may_ask = may_ask
        self.must_ask = False
        self.is_closed = False
        self.asked = []
        self.made.append(self)

    def connect(self):
        name = self.machine.name
        if name in self.asks and not self.may_ask:
            self.must_ask = True
            raise UserError(f'{name}: a password')
        if 'connect' in self.fails.get(name, ''):
            raise UserError(f'{name}: is off')
        return SimpleNamespace(
            workspace=None, home=f'/home/{name}', ahead=0.0, delay=0.0
        )

    def ask(self, request, arguments, on_line=None):
        self.asked.append((request, arguments))
        return {'missing': ['/missing', '/here']}

    def start_part(self, plan, settings):
        if 'start' in self.fails.get(self.machine.name, ''):
            raise UserError(f'{self.machine.name}: does not start')
        self.link = SimpleNamespace(
            machine=self.machine, plan=plan, settings=settings, is_closed=False
        )
        self.link.close = lambda: setattr(self.link, 'is_closed', True)
        return self.link

    def close(self):
        self.is_closed = True


@pytest.fixture(autouse=True)
def contacts(monkeypatch):
    made = []
    monkeypatch.setattr(PlayedContact, 'made', made)
    monkeypatch.setattr(PlayedContact, 'fails', {})
    monkeypatch.setattr(PlayedContact, 'asks', set())
    monkeypatch.setattr(verb_machines, 'MachineConnection', PlayedContact)
    monkeypatch.setattr(verb_machines, 'MachineLink', lambda part: part)
    return made


def process(name, *words):
    return Process(name, words or ('sleep', '1'), '/here', AT)


def machines(**fields):
    rules = tuple(Rule(name, AT, name) for name in MACHINES)
    locator = SimpleNamespace(owner=lambda _: None, package_of=lambda _: None)
    return verb_machines.MachinesThere(
        Deployment(MACHINES, rules),
        SimpleNamespace(root=None, locator=locator),
        VARIABLES,
        Path('/here'),
        None,
        None,
        'colcon launch',
        **fields,
    )


BOTH = Plan((process('arm'), process('gpu'), process('other')))


def begin(there, plan=BOTH, *, is_growing=False):
    placed = there.place(plan)
    there.begin(there.needed(placed, frozenset(), is_growing=is_growing))
    return placed


def test_parts_are_started_with_the_paths_and_variables_of_machines(contacts):
    there = machines()
    placed = begin(there)
    there.wait()
    assert list(there.check(placed)) == []
    parts = there.start(placed, PartSettings(''), is_growing=False)
    arm, gpu = contacts
    (started,) = arm.link.plan.processes()
    assert started.label == 'arm│arm'
    assert started.cwd == '/home/arm'
    assert arm.link.settings.machine == 'arm'
    assert dict(arm.link.settings.variables) == {
        'ROS_DOMAIN_ID': '3',
        'MINE': 'x',
    }
    assert [p.label for p in gpu.link.plan.processes()] == ['gpu│gpu']
    labels = [p.label for part in parts.parts for p in part.processes()]
    assert labels == ['arm│arm', 'gpu│gpu']
    # they are the launch's from here on
    there.close()
    assert not arm.is_closed
    assert not arm.link.is_closed


def test_only_machines_with_parts_are_connected_with(contacts):
    begin(machines(), Plan((process('gpu'),)))
    assert [c.machine.name for c in contacts] == ['gpu']


def test_all_machines_that_may_get_more_are_connected_with(contacts):
    there = machines()
    plan = Plan((process('gpu'), HostCall(1, 'call', AT)))
    placed = begin(there, plan, is_growing=True)
    there.start(placed, PartSettings(''), is_growing=True)
    assert [c.machine.name for c in contacts] == ['arm', 'gpu']
    assert contacts[0].link.plan.entries == ()


def test_all_that_cannot_be_reached_are_told(contacts):
    PlayedContact.fails = {'arm': 'connect', 'gpu': 'connect'}
    there = machines()
    with pytest.raises(UserError, match=r'^arm: is off\ngpu: is off$'):
        begin(there)
    there.close()
    assert all(c.is_closed for c in contacts)


def test_a_password_is_asked_for_before_the_launch(contacts):
    PlayedContact.asks = {'gpu'}
    begin(machines())
    assert [(c.machine.name, c.may_ask) for c in contacts] == [
        ('arm', False),
        ('gpu', False),
        ('gpu', True),
    ]


def test_nobody_is_asked_while_the_launch_runs(contacts):
    PlayedContact.asks = {'gpu'}
    with pytest.raises(UserError, match='gpu: a password'):
        begin(machines(may_ask=False))
    assert not any(c.may_ask for c in contacts)


def test_no_part_is_left_when_another_one_does_not_start(contacts):
    PlayedContact.fails = {'gpu': 'start'}
    there = machines()
    placed = begin(there)
    with pytest.raises(UserError, match='gpu: does not start'):
        there.start(placed, PartSettings(''), is_growing=False)
    arm, gpu = contacts
    assert arm.link.is_closed
    assert gpu.is_closed


@pytest.mark.parametrize(
    ('package', 'severity', 'hint'),
    [
        ('nav2', 'error', 'install the package nav2 there'),
        (None, 'warning', 'install it there'),
    ],
)
def test_only_a_missing_program_of_a_package_is_an_error(
    contacts, package, severity, hint
):
    there = machines()
    plan = Plan((replace(process('arm', '/missing'), package=package),))
    (found,) = there.check(begin(there, plan))
    assert found.severity == severity
    assert found.message == (
        "arm│arm runs on arm, and there is no program '/missing' there"
    )
    assert found.hint == hint
