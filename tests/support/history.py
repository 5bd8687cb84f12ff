# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launches without a process, whose time passes as the test says."""

from contextlib import nullcontext
from itertools import count

from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.engine.composition import Composition
from colcon_yamllaunch.engine.events import MemberChanged, Started
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.readiness import needs_readiness, Readiness
from colcon_yamllaunch.engine.spawn import StartError
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.supervisor import Supervisor
from colcon_yamllaunch.plan.plan import Component, Plan
from colcon_yamllaunch.plan.position import Position
from colcon_yamllaunch.plan.start_order import dependencies_of
from support.launch_states import ABOUT
from support.test_loop import TestLoop

FINE = Outcome(code=0)
POSITION = Position('/ws/demo.yaml', 7, 9)


def component(label='a', container='/box', **more):
    """Return a component of a plan."""
    known = {'name': label, 'position': POSITION, **more}
    return Component(label, 'demo', 'demo::It', container, **known)


class FakeHost:
    """A system that takes note of what is done to it."""

    def __init__(self, state):
        self.state = state
        self.pids = count(1000)
        self.by_label = {}
        self.refused = set()
        self.sent = []
        self.killed = []
        self.left = []
        self.events = []
        self.waits = False
        self.signalled = []
        self.calls = []
        self.commands = []
        self.listeners = []
        self.composition = None

    def use_ros(self):
        """Find no ROS."""

    def planned_processes(self):
        return [task.process for task in self.supervisor.tasks]

    def start(self, number, process):
        if process.label in self.refused:
            raise StartError('refused')
        self.by_label[process.label] = pid = next(self.pids)
        return pid

    def starting(self):
        return nullcontext()

    def release(self, group):
        return True

    def send(self, target, step):
        pid = target.pid if isinstance(target, Orphan) else target
        self.sent.append((pid, step))
        return True

    def orphans(self, groups, led):
        return [o for o in self.left if o.group not in led]

    def kill(self, number):
        self.killed.append(number)

    def is_alive(self, orphan):
        return orphan in self.left

    def signal(self, group, number):
        self.signalled.append((group, number))
        return group in self.by_label.values()

    def call(self, number):
        self.calls.append(number)

    def prepare_end(self):
        return self.waits

    def emit(self, event):
        self.state.apply(event)
        # which is neither shown nor recorded
        if not isinstance(event, MemberChanged):
            self.events.append(event)
        for listener in self.listeners:
            listener(event)

    def run_command(self, argv, process, ended):
        self.commands.append((argv, process.label, ended))
        return next(self.pids)


class History:
    """A supervisor with its own time."""

    def __init__(self, *entries):
        self.loop = TestLoop()
        plan = Plan(entries)
        self.launch = LaunchState(ABOUT, clock=self.loop.time)
        self.launch.expect(entries)
        self.host = FakeHost(self.launch)
        self.asked = []
        self.composition = self.compose(plan)
        self.supervisor = Supervisor(
            plan,
            self.host,
            self.loop,
            self.composition if plan.needs_ros else None,
        )
        self.host.loop, self.host.supervisor = self.loop, self.supervisor
        if plan.needs_ros:
            self.host.composition = self.composition
        self.readiness = Readiness(dependencies_of(plan.members()))
        if needs_readiness(plan):
            self.readiness.join(self.host)
            self.readiness.begin()
            self.host.listeners.append(self.readiness.handle)
        self.loop.is_over = lambda: self.supervisor.done
        self.loop.end_turn = self.end_turn

    @property
    def now(self):
        return self.loop.now

    @now.setter
    def now(self, seconds):
        self.loop.now = seconds

    def compose(self, plan):
        return Composition(
            plan, self.asked.append, self.host.emit, self.loop, self.launch
        )

    def extend(self, *entries):
        self.supervisor.extend(Plan(entries))
        self.turn()

    def end_turn(self):
        self.readiness.end_turn()
        self.supervisor.end_turn()

    def turn(self, turns=20):
        self.loop.turn(turns)

    def after(self, seconds):
        self.loop.pass_time(seconds)

    def exit(self, label, outcome=FINE):
        self.supervisor.exited(self.host.by_label[label], outcome)
        self.turn()

    def says(self, **message):
        """Have the client that speaks with ROS say something."""
        self.composition.handle(message)
        self.turn()

    def ready(self, *containers):
        self.says(event='ready')
        for name in containers:
            self.there(name)

    def there(self, container, there=True):
        self.says(event='container', container=container, there=there)

    def open(self, do):
        """Return the requests of a kind that nobody answered or cancelled."""
        cancelled = [r['request'] for r in self.asked if 'request' in r]
        return [
            r for r in self.asked if r['do'] == do and r['id'] not in cancelled
        ]

    def answer(self, do, reason=None, **fields):
        """Answer the oldest open request of a kind."""
        request = self.open(do)[0]
        self.asked.remove(request)
        fields |= (
            {'ok': True}
            if reason is None
            else {
                'ok': False,
                'reason': reason,
            }
        )
        self.says(id=request['id'], **fields)
        return request

    def loads(self, *ids):
        """Have the oldest loads succeed, and return their names."""
        names = []
        for unique_id in ids:
            name = f'/{self.open("load")[0]["name"]}'
            self.answer('load', full_name=name, unique_id=unique_id)
            names.append(name)
        return names

    def stop(self, label):
        self.supervisor.stop_process(label)
        self.turn()

    def restart(self, label):
        self.supervisor.restart_process(label)
        self.turn()

    def state(self, label):
        state = self.launch.process(label)
        state.seconds = self.launch.seconds_of(state)
        return state

    def phases(self):
        return [state.phase for state in self.launch.processes]

    def happened(self, kind):
        return [e for e in self.host.events if isinstance(e, kind)]

    def started(self):
        return [e.process.label for e in self.happened(Started)]

    def sent(self, label):
        pid = self.host.by_label[label]
        return [number for target, number in self.host.sent if target == pid]
