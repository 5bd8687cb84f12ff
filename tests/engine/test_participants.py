# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What takes part in a launch beside its engine, with real processes."""

import io
import os
from pathlib import Path
import subprocess

from colcon_yamllaunch.common import files as common_files
from colcon_yamllaunch.control import socket_folder
from colcon_yamllaunch.engine import commands, events
from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.engine.state import About
from colcon_yamllaunch.plan.plan import Message, Plan
from colcon_yamllaunch.run import run, RunContext


def ran(plan, *participants, **more):
    """Run a plan; return the exit code and what was shown."""
    stream = io.StringIO()
    settings = {
        'environment': {'PATH': os.environ['PATH']},
        'log_folder': None,
        'participants': participants,
        **more,
    }
    return run(plan, RunContext(stream=stream, **settings)), stream.getvalue()


class Helped(Participant):
    """Has a child, and keeps the launch running until that has ended."""

    def __init__(self):
        self.child = subprocess.Popen(['cat'], stdin=subprocess.PIPE)
        self.status = None
        self.closed = 0

    def children(self):
        return {self.child.pid}

    def join(self, engine):
        engine.add_helper(self.child.pid, self.ended)

    def begin(self):
        self.child.stdin.close()

    def ended(self, status):
        self.status = self.child.returncode = status

    def prepare_end(self):
        return self.status is None

    def close(self):
        self.closed += 1


def test_launch_waits_for_a_participant_and_reaps_its_child():
    helped = Helped()
    assert ran(Plan(()), helped) == (0, '')
    assert helped.status == 0
    assert helped.closed


class Listening(Participant):
    """Notes what it receives."""

    def __init__(self):
        self.received = []
        self.read = b''

    def handle(self, event):
        self.received.append(type(event))

    def handle_output(self, event):
        self.received.append(event.data)

    def record(self, process, stream, data):
        self.read += data


def test_events_output_and_raw_output_have_methods_of_their_own(process):
    listening = Listening()
    plan = Plan((process('a', 'printf', 'one\ntwo'),))
    code, _ = ran(plan, listening, Participant())
    assert code == 0
    assert listening.read == b'one\ntwo'
    received = listening.received
    assert received[0] is events.Started
    assert received.index(b'one\n') < received.index(events.Exited)
    assert events.Output not in received


class Translating(Participant):
    """Adds its name to messages, and refuses to stop processes."""

    def __init__(self, name):
        self.name = name

    def execute(self, command, reply, proceed):
        match command:
            case commands.Stop():
                return commands.Refused(f'{self.name} says no')
            case commands.Extend(entries=(message,)):
                text = f'{message.text} {self.name}'
                command = commands.Extend((Message('INFO', text),))
        return proceed(command, reply)


class Asking(Participant):
    """Sends commands when a process has started."""

    def __init__(self):
        self.answers = []

    def join(self, engine):
        self.engine = engine

    def handle(self, event):
        if isinstance(event, events.Started):
            dispatcher = self.engine.dispatcher
            dispatcher.do(commands.Extend((Message('INFO', 'by'),)))
            for name in ('a', 'b'):
                dispatcher.ask(commands.Stop(name), self.answers.append)


def test_participants_execute_commands_in_their_order(process):
    asking = Asking()
    plan = Plan((process('a', 'true'),))
    code, shown = ran(plan, Translating('one'), Translating('two'), asking)
    assert code == 0
    assert 'by one two\n' in shown
    assert asking.answers == [commands.Refused('one says no')] * 2


class Showing(Participant):
    """Shows a hidden launch to other terminals when it begins, twice."""

    def __init__(self, folder):
        self.folder = folder
        self.sockets = []

    def join(self, engine):
        self.engine = engine

    def begin(self):
        for _ in range(3):
            found = filter(Path.is_socket, self.folder.rglob('*'))
            self.sockets.append([path.stat().st_ino for path in found])
            self.engine.show_to_others()


def test_hidden_launch_is_visible_once_a_participant_shows_it(
    process, tmp_path, monkeypatch
):
    monkeypatch.setattr(socket_folder, 'USER_FOLDERS', '/does/not/exist')
    monkeypatch.setattr(common_files, 'SHARED_FOLDERS', ())
    showing = Showing(tmp_path)
    environment = {'PATH': os.environ['PATH'], 'TMPDIR': str(tmp_path)}
    hidden = {'about': About('demo', None, '', '/'), 'is_hidden': True}
    plan = Plan((process('a', 'true'),))
    done = ran(plan, showing, environment=environment, **hidden)
    assert done == (0, '')
    before, once, twice = showing.sockets
    assert before == []
    assert once == twice
    assert len(once) == 1
