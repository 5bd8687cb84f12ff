# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What clients ask of components and lifecycle nodes; nothing runs here."""

from functools import partial
import json
from pathlib import Path
import socket
from types import SimpleNamespace

from colcon_yamllaunch.control import protocol
from colcon_yamllaunch.control.client_connection import Client
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.service import Service
from colcon_yamllaunch.engine.composition import Composition
from colcon_yamllaunch.engine.dispatcher import Dispatcher
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.state import About, from_json, LaunchState
from colcon_yamllaunch.plan.plan import Block, Component, Plan, SetParameter
from colcon_yamllaunch.plan.position import Position
import pytest
from support.history import History

POSITION = Position('/ws/demo.yaml', 14, 5)
LOG = '/log/box-1'
BLOCKS = (
    Block('file', '/ws/more.yaml', POSITION, None),
    Block('group', '/ns', Position('/ws/more.yaml', 2, 3), 0),
)


def component(label, container='/box', **more):
    more.setdefault('name', label)
    more.setdefault('namespace', '/ns')
    return Component(label, 'demo', 'demo::T', container, POSITION, **more)


class Controlled:
    """A launch of some processes and components, and one client of it."""

    def __init__(self, *entries):
        self.history = History(*entries)
        self.loop = self.history.loop
        self.sent = []
        logs = {'box-1': Path(LOG)}
        about = About('demo', None, '/demo.yaml', '/')
        state = LaunchState(about, clock=self.clock, log_files=logs)
        state.expect(entries)
        self.composition = Composition(
            Plan(entries), self.sent.append, state.apply, self.loop, state
        )
        terminals = SimpleNamespace(
            has_keyboard=lambda _: False,
            add_sink=lambda *_: None,
            remove_sink=lambda *_: None,
        )
        engine = SimpleNamespace(
            state=state,
            participants=(),
            measure=lambda done: done(),
            find=lambda _: None,
            blocks=BLOCKS,
            supervisor=self.history.supervisor,
            composition=self.composition,
            terminals=terminals,
            tell=lambda _: None,
        )
        engine.planned_processes = partial(Engine.planned_processes, engine)
        engine.planned_components = partial(Engine.planned_components, engine)
        engine.parameters_of = lambda p: p.parameters
        engine.dispatcher = Dispatcher(engine)
        service = Service(engine, Journal())
        self.near, far = socket.socketpair()
        far.setblocking(False)
        self.near.settimeout(60)
        self.left = []
        Client(far, self.loop, service, self.left.append)
        self.composition.handle({'event': 'ready'})
        for entry in entries:
            if isinstance(entry, Component):
                self.composition.due(entry)
            else:
                self.composition.started(entry)
        self.history.turn()

    def clock(self):
        return self.history.now

    def ask(self, *requests):
        """Send requests at once, and let the launch do what it can."""
        for name, more in requests:
            self.near.sendall(protocol.encode(protocol.request(name, **more)))
        self.turn()

    def turn(self):
        self.loop.turn()

    def answers(self):
        """Return what has been answered."""
        self.near.setblocking(False)
        data = b''
        try:
            while chunk := self.near.recv(1 << 16):
                data += chunk
        except BlockingIOError:
            pass
        return [json.loads(line) for line in data.splitlines()]

    def asked(self, do):
        """Return the requests of a kind to the client program."""
        return [m for m in self.sent if m['do'] == do]

    def answered(self, do, **answer):
        """Let the client program answer what it was asked last."""
        number = self.asked(do)[-1]['id']
        self.composition.handle({'id': number, 'ok': True, **answer})

    def state(self):
        self.ask(('status', {}))
        (answer,) = self.answers()
        return from_json(answer['launch'], self.clock)


@pytest.fixture
def controlled(process):
    made = []

    def start(*entries):
        box = process('box-1', node_name='/box', is_container=True)
        made.append(Controlled(box, *entries))
        return made[-1]

    yield start
    for one in made:
        one.near.close()
        one.turn()
        one.loop.close()
        # nothing is left of the client
        assert len(one.left) == 1


def test_the_status_has_components_and_lifecycles(controlled, process):
    camera = process('cam-2', node_name='/cam', is_lifecycle=True)
    c = controlled(
        component('a', is_lifecycle=True),
        component('b', '/elsewhere', name='', namespace=''),
        camera,
    )
    state = c.state()
    assert [p.lifecycle for p in state.processes] == [None, 'unknown']
    a, b = state.components
    assert (a.phase, a.node, a.plugin) == ('waiting', '/ns/a', 'demo::T')
    assert (a.process, a.log, a.lifecycle) == ('box-1', LOG, 'unknown')
    assert (b.container, b.process, b.log) == ('/elsewhere', None, None)
    assert (b.node, b.lifecycle) == (None, None)
    (load, _) = c.asked('load')
    loaded = {'ok': True, 'full_name': '/ns/a', 'unique_id': 1}
    c.composition.handle({'id': load['id'], **loaded})
    for node in ('/ns/a', '/cam'):
        active = {'event': 'state', 'node': node, 'state': 'active'}
        c.composition.handle(active)
    c.history.now += 7
    state = c.state()
    assert [p.lifecycle for p in state.processes] == [None, 'active']
    a = state.components[0]
    assert (a.phase, a.lifecycle, a.seconds) == ('loaded', 'active', 7.0)


def test_component_is_unloaded_and_loaded_again(controlled):
    c = controlled(component('a'))
    c.answered('load', full_name='/ns/a', unique_id=1)
    c.ask(('stop', {'member': 'a'}))
    assert [a['ok'] for a in c.answers()] == [True]
    assert c.state().components[0].phase == 'unloading'
    c.answered('unload')
    assert c.state().components[0].phase == 'unloaded'
    c.ask(('stop', {'member': 'a'}))
    assert [a['error'] for a in c.answers()] == ['a is not loaded']
    c.ask(('restart', {'member': 'a'}))
    assert [a['ok'] for a in c.answers()] == [True]
    c.answered('load', ok=False, reason='no such class')
    a = c.state().components[0]
    assert (a.phase, a.ending) == ('failed', 'no such class')


CHANGE = {'member': 'a', 'transition': 'configure'}


@pytest.fixture
def loaded(controlled):
    """Return a launch of a lifecycle node that is loaded."""
    c = controlled(component('a', is_lifecycle=True))
    c.answered('load', full_name='/ns/a', unique_id=1)
    return c


def test_transition_is_answered_when_done(loaded):
    # what is asked meanwhile is answered behind it
    loaded.ask(('change_state', CHANGE), ('status', {}), ('shutdown', {}))
    assert loaded.answers() == []
    loaded.answered('change_state')
    loaded.turn()
    done, status, _ = loaded.answers()
    assert done == protocol.success()
    (a,) = from_json(status['launch']).components
    assert a.lifecycle == 'inactive'
    assert not status['launch']['stopping']


def test_failed_transition_has_its_reason(controlled):
    c = controlled(component('b'), component('a', is_lifecycle=True))
    c.ask(('change_state', CHANGE))
    (refused,) = c.answers()
    assert refused['error'] == 'a does not run'
    c.answered('load', full_name='/ns/a', unique_id=1)
    c.ask(('change_state', CHANGE))
    c.answered('change_state', ok=False, reason='no map')
    c.ask(('change_state', {**CHANGE, 'member': 'b'}))
    failed, none = c.answers()
    assert failed == protocol.failure('no map')
    assert none['error'] == "there is no lifecycle node 'b'"
    # a mistake of form ends the connection, as all others do
    c.ask(('change_state', {**CHANGE, 'transition': 'destroy'}))
    (wrong,) = c.answers()
    assert "the 'transition' is not 'configure' or " in wrong['error']
    assert c.left


def test_client_that_leaves_is_forgotten(loaded):
    loaded.ask(('change_state', CHANGE), ('status', {}))
    assert not loaded.left
    loaded.near.close()
    loaded.turn()
    assert loaded.left
    loaded.answered('change_state')


@pytest.mark.parametrize('number', [{}, {'id': 'x'}])
def test_half_closed_client_gets_the_answer(loaded, number):
    loaded.ask(('change_state', CHANGE | number), ('status', {'id': 2}))
    # requests with an id do not wait for one another
    assert len(loaded.answers()) == len(number)
    loaded.near.shutdown(socket.SHUT_WR)
    # it is not asked again and again whether there is more
    loaded.turn()
    assert not loaded.left
    loaded.answered('change_state')
    loaded.turn()
    assert loaded.answers()[0] == protocol.success() | number
    assert loaded.left


def test_component_is_described_with_its_container(controlled):
    value = SetParameter('rate', '2', POSITION, (Position('/ws/a', 1, 1),))
    c = controlled(
        component('talker', parameters=(value,), remaps=('a:=b',), block=1),
        component('far', container='/elsewhere', block=0),
    )
    c.ask(('describe', {'member': '/ns/talker'}), ('tree', {}))
    description, tree = c.answers()
    here, inner = {'position': '/ws/demo.yaml:14:5'}, '/ws/more.yaml:2:3'
    assert description['description'] == {
        'label': 'talker',
        'name': 'talker',
        'node': '/ns/talker',
        'package': 'demo',
        'within': [
            {'kind': 'file', 'title': '/ws/more.yaml', **here},
            {'kind': 'group', 'title': '/ns', 'position': inner},
        ],
        'parameters': [
            {'name': 'rate', 'value': '2', **here, 'origins': ['/ws/a:1:1']}
        ],
        'log': LOG,
        'argv': [],
        'cwd': None,
        'environment': {},
        'plugin': 'demo::T',
        'container': '/box',
        'remaps': ['a:=b'],
        **here,
    }
    box, file = tree['tree']
    assert (box['title'], file['title']) == ('box-1', '/ws/more.yaml')
    assert [b['title'] for b in box['children']] == ['talker']
    assert [b['title'] for b in file['children']] == ['far', '/ns']


def test_component_cannot_be_killed_or_debugged(controlled):
    c = controlled(component('talker'), component('far', container='/else'))
    for do, process, done, container in (
        ('kill', 'talker', 'killed', 'box-1'),
        ('debug', '/ns/talker', 'debugged', 'box-1'),
        ('kill', 'far', 'killed', '/else'),
    ):
        c.ask((do, {'member': process}))
        (answer,) = c.answers()
        assert answer['error'] == (
            f'{process.removeprefix("/ns/")} is a component, which cannot be '
            f'{done} alone; its container is {container}'
        )


def test_number_of_unanswered_requests_is_limited(loaded, monkeypatch):
    monkeypatch.setattr(protocol, 'MAXIMUM_UNANSWERED', 1)
    requests = ('change_state', {**CHANGE, 'id': 1}), ('status', {'id': 2})
    loaded.ask(*requests)
    assert loaded.answers() == []
    loaded.answered('change_state')
    loaded.turn()
    assert [answer['id'] for answer in loaded.answers()] == [1, 2]
    # who leaves while that many wait is not waited for
    loaded.ask(*requests)
    loaded.near.close()
    loaded.turn()
    assert loaded.left
