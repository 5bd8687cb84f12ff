# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The process that speaks with ROS for a launch, and the pipes to it.

It runs `ros_client` with the Python of the sourced environment, which may be
another than ours. What passes are JSON objects, one a line.
"""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
import signal
import time

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.components.composition import Composition
from colcon_yamllaunch.engine.components.ros_needs import are_beside
from colcon_yamllaunch.engine.components.ros_needs import missing_packages
from colcon_yamllaunch.engine.components.ros_needs import needed_packages
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.output.json_pipes import JsonPipes
from colcon_yamllaunch.engine.process.children import has_ended
from colcon_yamllaunch.engine.process.pythons import pythons
from colcon_yamllaunch.engine.process.restarts import Restarts
from colcon_yamllaunch.engine.process.spawn import StartError
from colcon_yamllaunch.plan.plan import Plan

#: What the process runs; it imports nothing of this package.
PROGRAM = Path(__file__).with_name('ros_client.py')

#: Starts a program with standard streams; returns its process group.
Start = Callable[[list[str], tuple[int, int, int]], int]


class RosLink:
    """
    The client process of a launch.

    :param environment: The environment that it runs in
    :param start: Starts it as a process of the launch
    :param tell: Is told what happens
    :param log: The file for its standard error, or None
    """

    def __init__(
        self,
        plan: Plan,
        environment: Mapping[str, str],
        loop: Loop,
        start: Start,
        tell: events.Listener,
        log: Path | None,
    ) -> None:
        self._environment = environment
        self._pipes = JsonPipes(loop, self._take, log)
        self._start = start
        self._tell = tell
        self._restarts = Restarts(loop, self.start)
        self._packages = needed_packages(plan)
        self._pythons = pythons(environment.get('PATH', os.defpath))
        self._python = self._first_found = 0
        #: The course of what it is asked for.
        self.composition = Composition(plan, self._pipes.send, tell, loop)
        #: The process group of the client, or 0 while there is none.
        self.pid = 0
        #: Whether the environment has what is needed.
        self.is_found = are_beside(
            self._packages, self._pythons[0], environment
        )
        # whether a client has said so, too
        self._is_sure = False
        # of the first Python
        self._missing: list[str] | None = None
        #: Why no launch is possible in this environment, if so.
        self.error: str | None = None
        self._is_ready = False
        self._is_wanted = True

    def expect(self, more: Plan, *, is_late: bool) -> None:
        """
        Take into account what else is needed from the next start on.

        :param is_late: Whether the launch runs already, and so goes on even
          if the environment lacks it
        """
        needed = dict.fromkeys([*self._packages, *needed_packages(more)])
        self._packages = list(needed)
        self.is_found |= is_late

    def start(self) -> None:
        """Start the client; it comes up while the caller goes on."""
        self._restarts.begin()
        self._is_ready = False
        streams = self._pipes.open()
        try:
            python = self._pythons[self._python]
            argv = [python, str(PROGRAM), *self._packages]
            self.pid = self._start(argv, streams)
        except StartError as reason:
            self._pipes.close()
            self._lost(f'could not be started: {reason}')
        finally:
            for descriptor in streams:
                os.close(descriptor)

    def ended(self, outcome: Outcome) -> None:
        """Take into account that the client ended."""
        # what it said last counts
        self._take()
        self._pipes.close()
        self.pid = 0
        if self._is_wanted and self.error is None:
            self._lost(str(outcome), was_killed=outcome.signal is not None)

    def hang_up(self) -> None:
        """Have the client end, as nothing is asked of it any more."""
        self._restarts.cancel()
        self._is_wanted = False
        self._pipes.close()

    def close(self) -> None:
        """End the client, at the latest after a moment."""
        self.hang_up()
        if not self.pid:
            return
        deadline = time.monotonic() + limits.CLIENT_PATIENCE
        while not has_ended(self.pid) and time.monotonic() < deadline:
            time.sleep(0.002)
        with suppress(ProcessLookupError, PermissionError):
            # what it started, too
            os.killpg(self.pid, signal.SIGKILL)
        with suppress(ChildProcessError):
            os.waitpid(self.pid, 0)
        self.pid = 0

    def _lost(self, ending: str, *, was_killed: bool = False) -> None:
        """
        Take into account that there is no client, and what follows.

        :param was_killed: Whether a signal ended it, so that its Python may
          be right all the same
        """
        was_ready = self._is_ready
        self._is_ready = False
        self.composition.client_died()
        is_last = self._python + 1 == len(self._pythons)
        if not (was_ready or was_killed or is_last):
            # what it cannot import may be there for another one
            self._python += 1
            self._restarts.plan_at_once()
            return
        if not was_ready and not was_killed:
            self._python = self._first_found
        if not self.is_found:
            self.error = f'the ROS client {ending}{self._last_words()}'
            return
        if not self._restarts.plan():
            self.composition.client_given_up(
                f'the ROS client ended {self._restarts.ends} times, at last '
                f'it {ending}{self._last_words()}'
            )
            return
        text = f'the ROS client {ending}, and is started again'
        self._tell(events.Warned(text))

    def _last_words(self) -> str:
        last = self._pipes.last_line()
        return f': {last}' if last else ''

    def _take(self) -> None:
        """Take what the client said."""
        for line in self._pipes.read():
            self._take_line(line)
        if self._pipes.is_at_end:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.pid, signal.SIGKILL)

    def _take_line(self, line: bytes) -> None:
        try:
            message = json.loads(line)
        except (ValueError, RecursionError):
            return
        match message:
            case {'event': 'found', 'missing': [*missing]}:
                self._found([str(name) for name in missing])
            case {'event': 'ready'}:
                self._is_ready = True
                self.composition.take(message)
            case dict():
                self.composition.take(message)

    def _found(self, missing: list[str]) -> None:
        if not missing:
            if not self._is_sure:
                self._first_found = self._python
            self.is_found = self._is_sure = True
            return
        if self._missing is None:
            # what the others lack matters less
            self._missing = missing
        is_last = self._python + 1 == len(self._pythons)
        if is_last and not self._is_sure:
            self.error = missing_packages(
                self._missing, self._pythons[0], self._environment
            )
            if self.is_found:
                # the launch began, as it looked well
                self.composition.client_given_up(self.error)
