# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The program that talks ROS for a launch, driven through its pipes."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
import json
import queue
import subprocess
import sys
import threading
from typing import Any

from colcon_yamllaunch.engine import ros_client

#: Seconds; a loaded machine needs some.
DEADLINE = 120
NEEDED = ('rclpy', 'composition_interfaces', 'lifecycle_msgs', 'rosgraph_msgs')

Line = dict[str, Any]
Environment = dict[str, str]


class Talk:
    """
    A running client.

    :param needed: The modules that it is told to need
    """

    def __init__(
        self, environment: Mapping[str, str], needed: tuple[str, ...] = NEEDED
    ) -> None:
        self.process = subprocess.Popen(
            [sys.executable, ros_client.__file__, *needed],
            env=dict(environment),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.lines: list[Line] = []
        self.errors = ''
        self._last = 0
        self._arriving: queue.Queue[Line | None] = queue.Queue()
        self._threads = [
            threading.Thread(target=one)
            for one in (self._read_lines, self._read_errors)
        ]
        for thread in self._threads:
            thread.start()

    def ask(self, do: str, **fields: Any) -> int:
        """Send a request, and return its id."""
        self._last += 1
        self.write(json.dumps({'id': self._last, 'do': do, **fields}) + '\n')
        return self._last

    def write(self, text: str) -> None:
        """Write to its input."""
        assert self.process.stdin is not None
        self.process.stdin.write(text)
        self.process.stdin.flush()

    def load(self, plugin: str, container: str = '/box', **fields: Any) -> int:
        """Ask for a component of `composition`."""
        request = {
            'package': 'composition',
            'plugin': f'composition::{plugin}',
        }
        return self.ask('load', container=container, **(request | fields))

    def answer(self, request: int) -> Line:
        """Wait for the answer of a request, and return it without its id."""
        line = self.wait(lambda one: one.get('id') == request)
        return {k: v for k, v in line.items() if k != 'id'}

    def result(self, do: str, **fields: Any) -> Line:
        """Ask, and wait for the answer."""
        return self.answer(self.ask(do, **fields))

    def event(self, **fields: Any) -> Line:
        """Wait for a line with these fields."""
        return self.wait(
            lambda one: all(one.get(k) == v for k, v in fields.items())
        )

    def wait(self, is_wanted: Callable[[Line], bool]) -> Line:
        """
        Wait for a line, among those that nobody has waited for, too.

        What is not wanted stays, to be waited for later.
        """
        for index, line in enumerate(self.lines):
            if is_wanted(line):
                return self.lines.pop(index)
        while True:
            try:
                line = self._arriving.get(timeout=DEADLINE)
            except queue.Empty:
                line = None
            assert line is not None, f'{self.lines}\n{self.errors}'
            if is_wanted(line):
                return line
            self.lines.append(line)

    def end(self) -> int:
        """Close its input, and return its exit code."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        return self.process.wait(DEADLINE)

    def clean_up(self) -> None:
        """Leave nothing running."""
        self.process.kill()
        with self.process:
            for thread in self._threads:
                thread.join()

    def _read_lines(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self._arriving.put(json.loads(line))
        self._arriving.put(None)

    def _read_errors(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.errors += line


@contextmanager
def talking(
    environment: Mapping[str, str], needed: tuple[str, ...] = NEEDED
) -> Iterator[Talk]:
    """Have a client run."""
    talk = Talk(environment, needed)
    try:
        yield talk
    finally:
        talk.clean_up()
