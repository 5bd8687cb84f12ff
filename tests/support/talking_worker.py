# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The worker of launch files in Python, spoken with as a launcher does."""

from collections.abc import Mapping
import json
from pathlib import Path
import subprocess
from typing import Any

import colcon_yamllaunch

Message = Mapping[str, Any]

PROGRAM = Path(colcon_yamllaunch.__file__).parent / 'python_launch' / 'worker'
#: What the launch files of the tests about events begin with.
HEAD = """\
import signal
from launch import *
from launch.actions import *
from launch.conditions import *
from launch.event import Event
from launch.event_handlers import *
from launch.events import Shutdown as ShuttingDown, matches_action
from launch.events.process import *
from launch.substitutions import *

def run(name, **more):
    return ExecuteProcess(cmd=['true'], name=name, **more)

def say(*text, **more):
    return LogInfo(msg=text, **more)

def when(handler):
    return RegisterEventHandler(handler)

def emit(event):
    return EmitEvent(event=event)

def after(period, *actions, **more):
    return TimerAction(period=period, actions=actions, **more)

"""
#: Seconds; a loaded machine needs some.
_DEADLINE = 60


class TalkingWorker:
    """
    The worker program; processes go by their program instead of their number.

    :param python: The Python that has `launch`
    :param environment: The variables that it gets
    """

    def __init__(self, python: str, environment: Mapping[str, str]) -> None:
        self._process = subprocess.Popen(
            [python, str(PROGRAM)],
            env=dict(environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        #: The files to read for those that are not installed yet.
        self.located: dict[str, str] = {}
        self._requests = 0
        self._names: dict[int, str] = {}
        self.found = self.take()

    def begin(self, packages: Mapping[str, Any] | None = None) -> None:
        """Have it forget all that was before."""
        self._names.clear()
        self.located.clear()
        self.ask('start', log_folder='/tmp', packages=packages or {})

    def visit(self, path: Path, **configurations: str) -> list[Message]:
        """Have it visit a launch file; return what it tells."""
        scope = {'configurations': configurations}
        return self.ask('visit', path=str(path), scope=scope)

    def event(self, kind: str, **fields: Any) -> list[Message]:
        """Tell it what happened; return what it tells."""
        return self.event_to_end(kind, **fields)[:-1]

    def event_to_end(self, kind: str, **fields: Any) -> list[Message]:
        """Tell it what happened; return what it tells, `done` last."""
        name = fields.get('process')
        numbers = {name: number for number, name in self._names.items()}
        event = {'type': kind, **fields}
        if kind == 'exit':
            event = {'respawns': False, 'asked': False, **event}
        if name is not None:
            event['process'] = numbers[name]
        return self.ask_to_end('event', event=event)

    def ended(self, process: str, returncode: int = 0) -> list[str]:
        """Tell that a process ended; return in short what it tells."""
        told = self.event('exit', process=process, returncode=returncode)
        return in_short(told)

    def ask(self, do: str, **fields: Any) -> list[Message]:
        """Send a request; return what it tells, without the last `done`."""
        return self.ask_to_end(do, **fields)[:-1]

    def ask_to_end(self, do: str, **fields: Any) -> list[Message]:
        """Send a request; return all that it tells, `done` last."""
        self._requests += 1
        self.send({'do': do, 'id': self._requests, **fields})
        told: list[Message] = []
        while not told or told[-1]['say'] != 'done':
            told.append(self.take())
            if told[-1]['say'] == 'include':
                scope = told[-1]['scope']
                self.send({'answer': told[-1]['ask'], 'scope': scope})
            elif told[-1]['say'] == 'locate':
                path = self.located.get(told[-1]['path'])
                self.send({'answer': told[-1]['ask'], 'path': path})
        return told

    def close(self) -> None:
        """End it."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.wait(_DEADLINE)
        self._process.stdout.close()

    def send(self, message: Message) -> None:
        """Send a message."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(message) + '\n')
        self._process.stdin.flush()

    def take(self) -> Message:
        """Wait for a message."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, 'the worker has ended'
        message: dict[str, Any] = json.loads(line)
        if message['say'] == 'process':
            self._names[message['id']] = message['program']
        elif message['say'] == 'signal':
            message['process'] = self._names[message['process']]
        elif message['say'] == 'handlers':
            message['output'] = self._named(message['output'])
            described = message['handlers']
            for handler in described if isinstance(described, list) else ():
                if handler['processes'] is not None:
                    handler['processes'] = self._named(handler['processes'])
        return message

    def _named(self, processes: list[object]) -> list[object]:
        """Return processes by their names; what is none stays as it is."""
        return [
            f'[{self._names[one]}]' if isinstance(one, int) else one
            for one in processes
        ]


def lines_of(frames: list[Message]) -> list[str]:
    """Return the lines of source that frames are about."""
    places = [frame['position'] for frame in frames]
    return [
        Path(path).read_text(encoding='utf-8').splitlines()[line - 1].strip()
        for path, line, _ in places
    ]


def in_short(messages: list[Message]) -> list[str]:
    """Return what is told that makes a difference, a line each."""
    return [line for line in map(_in_short, messages) if line]


def _in_short(message: Message) -> str:
    match message['say']:
        case 'message':
            return str(message['text'])
        case 'process':
            return f'start {message["program"]}'
        case 'begin' | 'end':
            return f'{message["say"]} {message.get("kind", "")}'.strip()
        case 'signal':
            return f'signal {message["signal"]} to {message["process"]}'
        case 'shutdown':
            return f'shutdown: {message["reason"]}'
        case 'call':
            return f'call {message["number"]}: {message["title"]}'
        case 'change_state':
            return f'{message["transition"]} {message["node"]}'
        case _:
            return ''
