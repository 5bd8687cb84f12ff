# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A new launch on the full screen: it runs in a process of its own.

That begins as any launch, with this terminal, which shows its build and its
errors. When it begins to run, it goes into the background, with a session of
its own, and the full screen here is a client of it like any other.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
import math
import os
import signal
import sys
import tempfile
import time
from typing import BinaryIO, TextIO

from colcon_yamllaunch.engine.loop import readable
from colcon_yamllaunch.verb import full_screen
from colcon_yamllaunch.verb.messages import report_errors, say

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


class Background:
    """
    Detaches a launch into a session of its own, for `--ui`.

    :param begun: A descriptor that gets a byte then
    :param messages: Takes what it has to say from then on
    """

    def __init__(self, begun: int, messages: BinaryIO) -> None:
        self._begun = begun
        self._messages = messages

    def enter(self) -> TextIO:
        """Go there; return the stream that shows what nobody sees."""
        sys.stdout.flush()
        sys.stderr.flush()
        # the keys and signals of the terminal are the screen's
        os.setsid()
        nothing = open(os.devnull, 'r+', encoding='utf-8')  # noqa: SIM115
        os.dup2(nothing.fileno(), 0)
        os.dup2(nothing.fileno(), 1)
        os.dup2(self._messages.fileno(), 2)
        # one that begins anew has no screen of its own
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
    full_screen.need_screen(environment)
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
        if said:
            say(said)
        elif child.was_killed:
            say(
                'the launcher was killed: colcon launch --status shows what '
                'is left'
            )
        return code if number is None else _SIGNALLED + number


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
        #: Whether a signal ended it that it could do nothing about.
        self.was_killed = False
        self.pid = os.fork()
        if self.pid == 0:
            os.close(self._reader)
            _run(launch, Background(writer, messages))
        os.close(writer)

    def begins(self) -> bool:
        """Wait until the launch runs; tell whether it ever does."""
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
                code = os.waitstatus_to_exitcode(status)
                self.was_killed = code < 0
                self._code = _SIGNALLED - code if self.was_killed else code
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
        """Return its exit code."""
        self.has_ended(math.inf)
        assert self._code is not None
        return self._code


def _run(launch: Callable[[Background], int], background: Background) -> None:
    """Be the process of the launch, to its end."""
    code = 1
    try:
        code = report_errors('launch', lambda: launch(background))
    except SystemExit as e:
        code = e.code if isinstance(e.code, int) else 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        # what is to be done at the end of colcon, the parent does
        os._exit(code)


def _show(child: _Child, environment: Mapping[str, str]) -> int | None:
    """Show the launch once it runs; return the signal that ended that."""
    # meanwhile, as it takes long to import
    from colcon_yamllaunch.terminal.full_screen import launch_screen

    del launch_screen
    if not child.begins():
        return None
    deadline = time.monotonic() + _TIMEOUT
    while (launch := full_screen.launch_of(child.pid, environment)) is None:
        if child.has_ended():
            return None
        if time.monotonic() > deadline:
            say('the launch has no control socket, so nothing can show it')
            child.signal(signal.SIGINT)
            child.wait()
            return None
        time.sleep(_INTERVAL)
    terminal = full_screen.OuterTerminal(
        child.pid, environment, lambda: child.signal(signal.SIGINT)
    )
    shown = full_screen.show(launch, terminal)
    child.is_over = terminal.is_over
    return shown
