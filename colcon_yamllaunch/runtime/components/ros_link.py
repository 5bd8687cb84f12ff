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
import select
import signal
import time
from typing import Any

from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.runtime.components.composition import Composition
from colcon_yamllaunch.runtime.components.ros_needs import are_beside
from colcon_yamllaunch.runtime.components.ros_needs import missing_packages
from colcon_yamllaunch.runtime.components.ros_needs import needed_packages
from colcon_yamllaunch.runtime.core import events
from colcon_yamllaunch.runtime.core import limits
from colcon_yamllaunch.runtime.core.outcome import Outcome
from colcon_yamllaunch.runtime.process.descriptors import open_log
from colcon_yamllaunch.runtime.process.pythons import pythons
from colcon_yamllaunch.runtime.process.spawn import StartError
from colcon_yamllaunch.runtime.streams.watches import Watches

#: What the process runs; it imports nothing of this package.
PROGRAM = Path(__file__).with_name('ros_client.py')

#: Starts a program with standard streams; returns its process group.
Start = Callable[[list[str], tuple[int, int, int]], int]


class RosLink:
    """
    The client process of a launch.

    :param environment: The environment that it runs in
    :param watches: What waits for what it says
    :param start: Starts it as a process of the launch
    :param tell: Is told what happens
    :param log: The file for its standard error, or None
    """

    def __init__(
        self,
        plan: Plan,
        environment: Mapping[str, str],
        watches: Watches,
        start: Start,
        tell: events.Listener,
        clock: Callable[[], float],
        log: Path | None,
    ) -> None:
        self._environment = environment
        self._watches = watches
        self._start = start
        self._tell = tell
        self._clock = clock
        self._log = log
        self._packages = needed_packages(plan)
        self._pythons = pythons(environment.get('PATH', os.defpath))
        self._python = self._first_found = 0
        #: The course of what it is asked for.
        self.composition = Composition(plan, self._send, tell, clock)
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
        self._begun = 0.0
        self._ends = 0
        self._due: float | None = None
        self._input = self._output = -1
        self._unsent = b''
        self._read = b''

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
        self._due = None
        self._begun = self._clock()
        self._is_ready = False
        its_input, self._input = os.pipe()
        self._output, its_output = os.pipe()
        error = open_log(self._log)
        try:
            python = self._pythons[self._python]
            argv = [python, str(PROGRAM), *self._packages]
            self.pid = self._start(argv, (its_input, its_output, error))
        except StartError as reason:
            self._close_pipes()
            self._lost(f'could not be started: {reason}')
            return
        finally:
            for descriptor in (its_input, its_output, error):
                os.close(descriptor)
        os.set_blocking(self._input, False)
        os.set_blocking(self._output, False)
        self._watches.add(self._output, self._readable)
        self._watches.add(self._input, lambda _: self._write(), 0)

    def ended(self, outcome: Outcome) -> None:
        """Take into account that the client ended."""
        # what it said last counts
        while self._take():
            continue
        self._close_pipes()
        self.pid = 0
        if self._is_wanted and self.error is None:
            self._lost(str(outcome), was_killed=outcome.signal is not None)

    def advance(self) -> None:
        """Start the client again when that is due."""
        if self._due is not None and self._due <= self._clock():
            self.start()

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until :meth:`advance` is to be called again."""
        if self._due is None:
            return None
        return max(0.0, self._due - self._clock())

    def hang_up(self) -> None:
        """Have the client end, as nothing is asked of it any more."""
        self._due = None
        self._is_wanted = False
        self._close_pipes()

    def close(self) -> None:
        """End the client, at the latest after a moment."""
        self.hang_up()
        if not self.pid:
            return
        deadline = time.monotonic() + limits.CLIENT_PATIENCE
        while not _reaped(self.pid) and time.monotonic() < deadline:
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
            self._due = self._clock()
            return
        if not was_ready and not was_killed:
            self._python = self._first_found
        if not self.is_found:
            self.error = f'the ROS client {ending}{self._last_words()}'
            return
        if self._clock() - self._begun > limits.CLIENT_STEADY:
            self._ends = 0
        self._ends += 1
        if self._ends > limits.CLIENT_RESTARTS:
            self.composition.client_given_up(
                f'the ROS client ended {self._ends} times, at last it '
                f'{ending}{self._last_words()}'
            )
            return
        pause = limits.SHORTEST_PAUSE * 2.0 ** (self._ends - 1)
        self._due = self._clock() + pause
        text = f'the ROS client {ending}, and is started again'
        self._tell(events.Warned(text))

    def _last_words(self) -> str:
        if self._log is None:
            return ''
        with suppress(OSError):
            text = self._log.read_bytes()[-limits.TAIL_BYTES :]
            lines = text.decode(errors='replace').split('\n')
            last = next((s for s in reversed(lines) if s.strip()), '')
            return f': {last.strip()}; see {self._log}' if last else ''
        return ''

    def _close_pipes(self) -> None:
        for descriptor in (self._input, self._output):
            if descriptor != -1:
                self._watches.remove(descriptor)
                os.close(descriptor)
        self._input = self._output = -1
        self._unsent = self._read = b''

    def _send(self, request: Mapping[str, Any]) -> None:
        if self._input != -1:
            # the engine's loop writes before it waits
            self._unsent += json.dumps(request).encode() + b'\n'
            self._write()

    def _write(self) -> None:
        try:
            while self._unsent:
                count = os.write(self._input, self._unsent)
                self._unsent = self._unsent[count:]
        except BlockingIOError:
            pass
        except OSError:
            # its end is noticed soon
            self._unsent = b''
        waits = select.EPOLLOUT if self._unsent else 0
        self._watches.change(self._input, waits)

    def _readable(self, _: int) -> None:
        self._take()

    def _take(self) -> bool:
        """Take what the client said; return whether there was anything."""
        if self._output == -1:
            return False
        try:
            data = os.read(self._output, limits.READ_SIZE)
        except BlockingIOError:
            return False
        if not data:
            # it is reported as a child, or closed its output for good
            self._watches.change(self._output, 0)
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self.pid, signal.SIGKILL)
            return False
        *lines, self._read = (self._read + data).split(b'\n')
        for line in lines:
            self._take_line(line)
        return True

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


def _reaped(pid: int) -> bool:
    try:
        return os.waitpid(pid, os.WNOHANG)[0] == pid
    except ChildProcessError:
        return True
