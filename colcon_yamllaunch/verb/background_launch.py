# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A new launch with a full screen: the launch runs in a child process.

The child builds and reports errors on this terminal, as any launch does. When
its processes are about to start, it detaches into a new session, and the full
screen in this process shows it as a client, like any other launch.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
import math
import os
import signal
import sys
import tempfile
import time
from typing import BinaryIO, TextIO

from colcon_yamllaunch.common.messages import say
from colcon_yamllaunch.control.client import find_launch
from colcon_yamllaunch.engine.loop import readable
from colcon_yamllaunch.terminal.full_screen import session
from colcon_yamllaunch.verb.options_verb import report_errors

#: Seconds between two looks at a launch that begins, or ends.
_INTERVAL = 0.05
#: Seconds that a launch may take to open its socket, or to be gone after it
#: has reported its end.
_TIMEOUT = 10.0
#: What an exit code has more than the signal that it tells, as in shells.
_SIGNALLED = 128
_RUNS_ON = (
    'the launch runs on: colcon launch --ui --of {pid} shows it, '
    'colcon launch --stop --of {pid} ends it'
)


_WAS_KILLED = (
    'the launcher was killed: colcon launch --status shows what is left'
)


class Background:
    """
    Detaches a launch into a new session, for `--ui`.

    :param begun: A descriptor that gets a byte when it is detached
    :param messages: The file that its messages are written to from then on
    """

    def __init__(self, begun: int, messages: BinaryIO) -> None:
        self._begun = begun
        self._messages = messages

    def enter(self) -> TextIO:
        """Detach the launch; return a stream that discards its output."""
        sys.stdout.flush()
        sys.stderr.flush()
        # the keys and signals of the terminal are the screen's
        os.setsid()
        nothing = open(os.devnull, 'r+', encoding='utf-8')  # noqa: SIM115
        os.dup2(nothing.fileno(), 0)
        os.dup2(nothing.fileno(), 1)
        os.dup2(self._messages.fileno(), 2)
        # if it executes its command again, it must not open a screen
        sys.orig_argv = [word for word in sys.orig_argv if word != '--ui']
        with suppress(OSError):
            os.write(self._begun, b'.')
        os.close(self._begun)
        return nothing


def launch_for_screen(
    launch: Callable[[Background], int],
    environment: Mapping[str, str],
    *,
    plain: bool,
) -> int:
    """
    Launch, and show that on the full screen; return the exit code.

    :param launch: Launches, and goes into the background meanwhile
    :param plain: Whether there are to be no colours
    :raises UserError: when there can be no full screen here
    """
    session.need_screen(environment)
    if plain:
        os.environ['NO_COLOR'] = '1'
    with tempfile.TemporaryFile() as messages:
        child = _Child(launch, messages)
        try:
            number = _show(child, environment)
        except SystemExit:
            # a signal, which is meant for the launch as well
            child.signal(signal.SIGTERM)
            child.wait()
            raise
        except Exception:
            say(_RUNS_ON.format(pid=child.pid))
            raise
        if number is not None:
            child.signal(signal.SIGTERM)
        elif not child.has_ended(_TIMEOUT if child.is_over else 0.0):
            say(_RUNS_ON.format(pid=child.pid))
            return 0
        code = child.wait()
        messages.seek(0)
        said = messages.read().decode(errors='replace').rstrip('\n')
        if not said and code < 0:
            said = _WAS_KILLED
        if said:
            say(said)
    if number is not None:
        return _SIGNALLED + number
    return code if code >= 0 else _SIGNALLED - code


class _Child:
    """The process of the launch."""

    def __init__(
        self, launch: Callable[[Background], int], messages: BinaryIO
    ) -> None:
        self._reader, writer = os.pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        self._code: int | None = None
        #: Whether the launch has reported its end.
        self.is_over = False
        self.pid = os.fork()
        if self.pid == 0:
            os.close(self._reader)
            _run(launch, Background(writer, messages))
        os.close(writer)

    def begins(self) -> bool:
        """Wait until the launch runs or ends; return whether it runs."""
        # in a build, Ctrl-C is for the launch
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            while not readable([self._reader], _INTERVAL):
                if self.has_ended():
                    return False
            if os.read(self._reader, 1):
                return True
            self.wait()
            return False
        finally:
            signal.signal(signal.SIGINT, before)
            os.close(self._reader)

    def has_ended(self, timeout: float = 0.0) -> bool:
        """
        Return whether it has ended.

        :param timeout: Seconds that it may take
        """
        deadline = time.monotonic() + timeout
        while self._code is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self._code = os.waitstatus_to_exitcode(status)
            elif time.monotonic() >= deadline:
                return False
            else:
                time.sleep(_INTERVAL)
        return True

    def signal(self, number: int) -> None:
        """Send it a signal, unless it is gone."""
        if not self.has_ended():
            os.kill(self.pid, number)

    def wait(self) -> int:
        """Return the exit code of the launch, or minus its signal."""
        self.has_ended(math.inf)
        assert self._code is not None
        return self._code


def _run(launch: Callable[[Background], int], background: Background) -> None:
    """Run the launch in the child, and end the child."""
    code = 1
    try:
        code = report_errors('launch', partial(launch, background))
    except SystemExit as e:
        code = e.code if isinstance(e.code, int) else 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        # the parent runs the exit handlers of colcon
        os._exit(code)


def _show(child: _Child, environment: Mapping[str, str]) -> int | None:
    """Show the launch once it runs; return the signal that ended that."""
    # meanwhile, as it takes long to import
    from colcon_yamllaunch.terminal.full_screen import launch_screen

    del launch_screen
    if not child.begins():
        return None
    deadline = time.monotonic() + _TIMEOUT
    while (launch := find_launch(child.pid, environment)) is None:
        if child.has_ended():
            return None
        if time.monotonic() > deadline:
            say('the launch has no control socket, so nothing can show it')
            child.signal(signal.SIGINT)
            child.wait()
            return None
        time.sleep(_INTERVAL)
    terminal = session.OuterTerminal(
        child.pid, environment, lambda: child.signal(signal.SIGINT)
    )
    number, child.is_over = session.show(launch, terminal)
    return number
