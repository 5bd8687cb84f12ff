# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A source of more plan that answers as the test has written.

Its rules are objects: with the first event, output or call that is `when`, as
`exited a`, it answers with `entries` and `problems`; with `late`, only once a
file of that name exists, and with `never`, never. What it is told is in the
file `told`.
"""

from collections.abc import Callable
from collections.abc import Iterable
import os
from pathlib import Path
import subprocess
from typing import Any

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.plan.plan import Entry
from colcon_yamllaunch.plan.plan import Growth


class PlayedSource:
    """A source with a process of its own, which does nothing."""

    number = 1_000_000_000

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

    @property
    def pid(self) -> int:
        return self._host.pid if self._host.returncode is None else 0

    @property
    def is_busy(self) -> bool:
        return bool(self._coming) or self._is_stuck

    def handle(self, event: events.Event) -> None:
        record = event.record()
        if record and record['event'] not in ('warning', 'ended'):
            words = [
                record[n]
                for n in ('event', 'label', 'reason', 'text')
                if n in record
            ]
            self._tell(' '.join(map(str, words)))

    def output(self, process: str, stream: events.Stream, data: bytes) -> None:
        self._tell(f'{stream} {process} {data.decode().strip()}')

    def flush(self) -> bool:
        return True

    def call(self, number: int) -> None:
        self._tell(f'call {number}')

    def take(self) -> Iterable[Growth]:
        try:
            count = len(os.read(self.descriptor, 100))
        except BlockingIOError:
            return []
        if not count:
            self.descriptor = -1
        coming, self._coming = self._coming[:count], self._coming[count:]
        return coming

    def ended(self, status: int) -> Iterable[Growth]:
        self._host.returncode = status
        self._coming.clear()
        self.descriptor = -1
        return []

    def close(self) -> None:
        if self.pid:
            os.killpg(self.pid, 9)
            self._host.wait()

    def _tell(self, what: str) -> None:
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
