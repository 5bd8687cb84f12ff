# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Machines are connected with, given their parts, and left in order."""

from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import GiveUpError
from colcon_yamllaunch.deployment.deployment import (
    Deployment,
    Machine,
    ProcessRule,
)
from colcon_yamllaunch.plan.plan import Plan, Process, WorkerCall
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.remote import launch_machine
from colcon_yamllaunch.verb.machines import Machines
from colcon_yamllaunch.verb.options import LaunchOptions
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
    monkeypatch.setattr(launch_machine, 'MachineConnection', PlayedContact)
    monkeypatch.setattr(launch_machine, 'MachineLink', lambda part: part)
    return made


def process(name, *words):
    return Process(name, words or ('sleep', '1'), '/here', AT)


class Context(SimpleNamespace):
    """A launch with processes on the machines."""

    def __init__(self, plan, *, is_again=False, is_growing=False):
        locator = SimpleNamespace(
            owner=lambda _: None, package_of=lambda _: None
        )
        super().__init__(
            options=LaunchOptions(positionals=('a.yaml',)),
            environment=VARIABLES,
            cwd=Path('/here'),
            log_folder=None,
            is_again=is_again,
            locator=locator,
            workspace=SimpleNamespace(
                root=None, locator=locator, announce=print
            ),
            reported=[],
        )
        rules = tuple(ProcessRule(AT, name, name=name) for name in MACHINES)
        self.plan = plan
        self.is_growing = is_growing
        self.machines = Machines(self, Deployment(MACHINES, rules))

    def report(self, diagnostics):
        self.reported += diagnostics

    def report_or_fail(self, diagnostics):
        found = list(diagnostics)
        self.report(found)
        if any(diagnostic.severity == 'error' for diagnostic in found):
            raise GiveUpError(1)

    def connect(self):
        evaluation = SimpleNamespace(
            plan=self.plan,
            growing=self.is_growing or None,
            has_run_programs=False,
        )
        self.machines.begin_sync(self.plan, evaluation, ())

    def start(self):
        whole = self.machines.finish_sync(self.plan)
        return self.machines.start(whole, is_growing=self.is_growing)


BOTH = Plan((process('arm'), process('gpu'), process('other')))


def test_parts_are_started_with_the_paths_and_variables_of_machines(contacts):
    context = Context(BOTH)
    context.connect()
    local, parts = context.start()
    assert context.reported == []
    assert [p.label for p in local.processes()] == ['other']
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
    assert not arm.is_closed
    assert not arm.link.is_closed


def test_only_machines_with_parts_are_connected_with(contacts):
    Context(Plan((process('gpu'),))).connect()
    assert [c.machine.name for c in contacts] == ['gpu']


def test_all_machines_that_may_get_more_are_connected_with(contacts):
    plan = Plan((process('gpu'), WorkerCall(1, 'call', AT)))
    context = Context(plan, is_growing=True)
    context.connect()
    context.start()
    assert [c.machine.name for c in contacts] == ['arm', 'gpu']
    assert contacts[0].link.plan.entries == ()


def test_all_unreachable_machines_are_in_one_error(contacts):
    PlayedContact.fails = {'arm': 'connect', 'gpu': 'connect'}
    context = Context(BOTH)
    context.machines.connect_early()
    with pytest.raises(UserError, match=r'^arm: is off\ngpu: is off$'):
        context.connect()
    context.machines.close()
    assert all(c.is_closed for c in contacts)


def test_unreachable_machine_without_processes_is_no_error(contacts):
    PlayedContact.fails = {'arm': 'connect'}
    context = Context(Plan((process('gpu'),)))
    context.machines.connect_early()
    context.connect()
    assert [c.machine.name for c in contacts] == ['arm', 'gpu']
    assert contacts[0].is_closed


def test_a_password_is_asked_for_before_the_launch(contacts):
    PlayedContact.asks = {'gpu'}
    Context(BOTH).connect()
    assert [(c.machine.name, c.may_ask) for c in contacts] == [
        ('arm', False),
        ('gpu', False),
        ('gpu', True),
    ]


def test_nobody_is_asked_while_the_launch_runs(contacts):
    PlayedContact.asks = {'gpu'}
    with pytest.raises(UserError, match='gpu: a password'):
        Context(BOTH, is_again=True).connect()
    assert not any(c.may_ask for c in contacts)


def test_no_part_is_left_when_another_one_does_not_start(contacts):
    PlayedContact.fails = {'gpu': 'start'}
    context = Context(BOTH)
    context.connect()
    with pytest.raises(UserError, match='gpu: does not start'):
        context.start()
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
    context = Context(
        Plan((replace(process('arm', '/missing'), package=package),))
    )
    context.connect()
    with suppress(GiveUpError):
        context.start()
    # the rule for the other machine has no process
    *_, found = context.reported
    assert found.severity == severity
    assert found.message == (
        "arm│arm runs on arm, and there is no program '/missing' there"
    )
    assert found.hint == hint
