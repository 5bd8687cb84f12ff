# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A worker of Python launch files that answers as the test has written.

Its rules are objects: with the first event, output or call that is `when`, as
`exited a`, it answers with `entries` and `problems`; with `late`, only once a
file of that name exists, and with `never`, never. What it is told is in the
file `told`.
"""

from collections.abc import Callable, Iterable
import os
from pathlib import Path
import subprocess
from typing import Any

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.plan.plan import Entry, Growth
from colcon_yamllaunch.python_launch.plan_feed import PlanFeed


class PlayedFeed(PlanFeed):
    """A feed whose worker is played, and is told all events."""

    def __init__(self, worker: Any) -> None:
        super().__init__(worker, worker)
        self._worker = worker

    def handle(self, event: events.Event) -> None:
        super().handle(event)
        record = event.record()
        if record and record['event'] not in ('warning', 'ended', 'shutdown'):
            words = (record.get(name) for name in ('event', 'label', 'text'))
            self._worker.emit(' '.join(filter(None, words)))


class PlayedWorker:
    """The link to a worker, a process that does nothing, and its answers."""

    has_handlers = True

    def __init__(
        self,
        rules: list[dict[str, Any]],
        wanted: Iterable[str],
        entry_of: Callable[[dict[str, Any]], Entry],
    ) -> None:
        self._rules = rules
        self._entry_of = entry_of
        self.wants_output = frozenset(wanted)
        self._told = Path('told')
        self._told.touch()
        # keeps what writes to the pipe, and is the child that tests kill
        self._host = subprocess.Popen(
            [
                'sh',
                '-c',
                'while read file; do '
                'until [ -e "$file" ]; do sleep 0.01; done; echo; done',
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        assert self._host.stdout is not None
        self.descriptor = self._host.stdout.fileno()
        os.set_blocking(self.descriptor, False)
        self._coming: list[Growth] = []
        self._is_stuck = False

    # the link

    @property
    def pid(self) -> int:
        return self._host.pid if self._host.returncode is None else 0

    def poll(self) -> dict[str, Any] | None:
        try:
            data = (
                os.read(self.descriptor, 1) if self.descriptor != -1 else b''
            )
        except BlockingIOError:
            return None
        if not data:
            self.descriptor = -1
            return None
        return {'say': 'done'}

    def flush(self) -> bool:
        return True

    def reaped(self) -> None:
        self._host.returncode = 0

    def close(self) -> None:
        if self.pid:
            os.killpg(self.pid, 9)
            self._host.wait()

    # what its messages mean

    @property
    def is_busy(self) -> bool:
        return bool(self._coming) or self._is_stuck

    def id_of(self, name: str) -> str:
        return name

    def ask(self, request: dict[str, Any]) -> None:
        match request:
            case {'do': 'call', 'number': number}:
                self.emit(f'call {number}')
            case {'event': {'type': 'shutdown', 'reason': reason}}:
                self.emit(f'shutdown {reason}')
            case {'event': {'type': 'output', **event}}:
                text = event['text'].strip()
                self.emit(f'{event["stream"]} {event["process"]} {text}')

    def handle(self, message: dict[str, Any]) -> Growth:
        return self._coming.pop(0)

    def lost(self, reason: str) -> Growth:
        self._coming.clear()
        self._is_stuck = False
        return Growth()

    def emit(self, what: str) -> None:
        with self._told.open('a', encoding='utf-8') as file:
            print(what, file=file)
        for rule in self._rules:
            if rule['when'] == what:
                self._rules.remove(rule)
                self._answer(rule)
                return

    def _answer(self, rule: dict[str, Any]) -> None:
        if 'never' in rule:
            self._is_stuck = True
            return
        entries = tuple(map(self._entry_of, rule.get('entries', ())))
        problems = tuple(rule.get('problems', ()))
        self._coming.append(Growth(entries, problems=problems))
        assert self._host.stdin is not None
        self._host.stdin.write(f'{rule.get("late", ".")}\n'.encode())
        self._host.stdin.flush()
