# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A running launch on the full screen, and a new one beside it."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
import importlib.util
import os
import select
import signal
import subprocess
import sys
import termios
import time
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import flush_or_drop, say
from colcon_yamllaunch.common.process_scan import is_suspended
from colcon_yamllaunch.control.client import (
    ControlError,
    find_launch,
    LaunchEndedError,
    RunningLaunch,
)
from colcon_yamllaunch.control.selection import Candidate
from colcon_yamllaunch.control.subscription import BEGINNING
from colcon_yamllaunch.observers.presentation import only_prints
from colcon_yamllaunch.terminal.client_attachment import attach
from colcon_yamllaunch.terminal.pager import command, LESS

if TYPE_CHECKING:
    from colcon_yamllaunch.terminal.full_screen.launch_screen import LaunchApp


#: What to say without the library that draws.
MISSING = (
    "--ui needs the Python package 'textual': pip install 'textual>=2.1.2'"
)
#: By how much the launch comes before us where both want a processor, as for
#: nice(1).
NICE = 5
#: Seconds in which nobody has read anything, nor left what shows it.
_GLANCE = 0.4
#: Seconds that the screen may take to close after a signal.
_CLOSE_TIMEOUT = 1.0
_ENDING = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: Signals that the library takes, and does not leave to others at its end.
_KEPT = (signal.SIGTSTP, signal.SIGCONT)


def need_screen(environment: Mapping[str, str]) -> None:
    """
    Check that the full screen can be shown.

    :raises UserError: when textual or a terminal is missing
    """
    if importlib.util.find_spec('textual') is None:
        raise UserError(MISSING)
    if not (os.isatty(0) and os.isatty(1)):
        raise UserError(
            '--ui needs a terminal, but standard input or output is none; '
            '--status and --logs do without'
        )
    if only_prints(environment):
        raise UserError(
            '--ui needs a terminal that can be drawn on, and TERM says that '
            'this one cannot; --status and --logs do without'
        )


def show_launch(chosen: Candidate, environment: Mapping[str, str]) -> int:
    """
    Show a launch that others have started; return the exit code.

    :raises UserError: when that is not possible here
    :raises ControlError: when the launch refuses
    """
    need_screen(environment)
    if not isinstance(chosen.launch, RunningLaunch):
        raise ControlError(
            'its launcher was killed, so there is nothing to show; --stop '
            'ends what still runs'
        )
    terminal = OuterTerminal(chosen.state.pid, environment)
    number, _ = show(chosen.launch, terminal)
    return 0 if number is None else 128 + number


def show(
    launch: RunningLaunch, terminal: 'OuterTerminal'
) -> tuple[int | None, bool]:
    """
    Show a launch until the user leaves.

    Return the signal that ended that, if one did, and whether the launch ended
    while it was shown.

    :raises ControlError: when the launch refuses
    """
    # it takes long to import
    from colcon_yamllaunch.terminal.full_screen.launch_model import BEHIND
    from colcon_yamllaunch.terminal.full_screen.launch_screen import LaunchApp

    try:
        launch.subscribe(BEGINNING, states=True, behind=BEHIND)
    except LaunchEndedError:
        raise
    except ControlError as e:
        raise ControlError(
            f'it cannot be shown, as it is of an older colcon-yamllaunch: {e}'
        ) from e
    os.nice(NICE)
    # the library takes it away
    plain = os.environ.get('NO_COLOR')
    if not plain:
        # only one that is not empty counts (https://no-color.org)
        os.environ.pop('NO_COLOR', None)
    with ScreenWatchdog(0) as watchdog:
        app = LaunchApp(launch, terminal, shown=watchdog.note)
        try:
            with _ended_by_signals(app, terminal):
                app.run()
                if app.signal is not None:
                    # the terminal may be gone
                    for stream in (sys.__stdout__, sys.__stderr__):
                        if stream is not None:
                            flush_or_drop(stream)
        finally:
            app.panes.close()
            if plain is not None:
                os.environ['NO_COLOR'] = plain
    if app.error is not None:
        raise app.error
    return app.signal, bool(app.panes.model.ending)


class OuterTerminal:
    """
    The terminal while the full screen is suspended: attach, show logs.

    :param pid: The launcher
    :param interrupt: Does what Ctrl-C does to a launch that was started for
      this screen; None for any other
    """

    def __init__(
        self,
        pid: int,
        environment: Mapping[str, str],
        interrupt: Callable[[], None] | None = None,
    ) -> None:
        self._pid = pid
        self._environment = environment
        self._interrupt = interrupt
        #: Whether the launch was started for this screen.
        self.owns_launch = interrupt is not None

    def interrupt(self) -> None:
        """Do to the launch what Ctrl-C does."""
        if self._interrupt is not None:
            self._interrupt()

    def attach(self, label: str) -> None:
        """Connect the terminal to a process, until that is over."""
        launch = find_launch(self._pid, self._environment)
        if launch is None:
            return
        try:
            state = launch.refresh()
            members = [p for p in state.processes if p.label == label]
            attach(Candidate(launch, state), members)
        except (ControlError, UserError) as e:
            say(f'{label}: {e}')
            self._wait()
        finally:
            launch.close()

    def page(self, path: str) -> None:
        """Show a file, until the user has seen it."""
        begin = time.monotonic()
        try:
            subprocess.run(
                [*command(self._environment), path],
                env={'LESS': LESS, **self._environment},
                check=False,
            )
        except (OSError, ValueError) as e:
            say(f'there is no pager: {e}; the log is {path}')
        # one that does not wait, such as cat, or that does not work
        if time.monotonic() - begin < _GLANCE:
            self._wait()

    def _wait(self) -> None:
        say('Enter goes back')
        sys.stdin.readline()


@contextmanager
def _ended_by_signals(
    app: 'LaunchApp', terminal: OuterTerminal
) -> Iterator[None]:
    """
    End the screen on a signal, whatever it does.

    The library hangs for good in a write when the terminal takes nothing any
    more: the thread that writes has ended by an error, or is blocked, and its
    queue has a bound. So handlers of asyncio would never run; these do.
    """

    def end(number: int, _: object) -> None:
        if app.signal is None:
            signal.setitimer(signal.ITIMER_REAL, _CLOSE_TIMEOUT)
            app.end_by(number)

    def give_up(*_: object) -> None:
        terminal.interrupt()
        # the watchdog gives the terminal back, if it is still there
        os._exit(128 + (app.signal or 0))

    handlers = dict.fromkeys(_ENDING, end) | {signal.SIGALRM: give_up}
    before = {n: signal.signal(n, h) for n, h in handlers.items()}
    before |= {number: signal.getsignal(number) for number in _KEPT}
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        for number, handler in before.items():
            signal.signal(number, handler)


# ends what the library begins: keys of the kitty protocol, the mouse, pastes
# and reported changes of focus and size, one drawing at once, no wraps,
# the other screen, no cursor; see xterm's ctlseqs
_RESTORE = (
    b'\x1b[<u\x1b[?1000;1002;1003;1006;1015;1016l\x1b[?2004l\x1b[?1004l'
    b'\x1b[?2048l\x1b[?2026l\x1b[0m\x1b[?7h\x1b[?1049l\x1b[?25h'
)
_ON, _OFF = b'+', b'-'
#: Seconds between two times that it tells of a terminal that is gone, or looks
#: whether the screen is stopped.
_INTERVAL = 0.5
_SIGNALS = (
    *(signal.SIGINT, signal.SIGQUIT, signal.SIGTERM, signal.SIGHUP),
    *(signal.SIGTSTP, signal.SIGTTOU, signal.SIGTTIN),
)


class ScreenWatchdog:
    """
    Watches over the full screen as long as it is open.

    :param terminal: A descriptor of the terminal
    """

    def __init__(self, terminal: int) -> None:
        before = termios.tcgetattr(terminal)
        screen = os.getpid()
        reader, self._writer = os.pipe()
        self._pid = os.fork()
        if self._pid == 0:
            code = 1
            try:
                os.close(self._writer)
                _watch(reader, terminal, before, screen)
                code = 0
            finally:
                os._exit(code)
        os.close(reader)

    def note(self, is_shown: bool) -> None:
        """Record whether the screen is shown."""
        with suppress(OSError):
            os.write(self._writer, _ON if is_shown else _OFF)

    def __enter__(self) -> 'ScreenWatchdog':
        return self

    def __exit__(self, *_: object) -> None:
        self.note(False)
        os.close(self._writer)
        with suppress(ChildProcessError):
            os.waitpid(self._pid, 0)


def _watch(reader: int, terminal: int, before: list[Any], screen: int) -> None:
    """Wait in the child until the screen has ended."""
    # it is no part of the job, which others suspend, hang up and kill
    os.setpgid(0, 0)
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    last = _OFF
    poll = select.poll()
    poll.register(reader, select.POLLIN)
    # poll reports a hang-up in any case
    poll.register(terminal, 0)
    while True:
        found = dict(poll.poll(1000 * _INTERVAL if last == _ON else None))
        if reader in found:
            if not (read := os.read(reader, 64)):
                break
            last = read[-1:]
        elif found:
            # the kernel tells only the foreground job of the terminal
            os.kill(screen, signal.SIGHUP)
            time.sleep(_INTERVAL)
        elif is_suspended(screen):
            # it sets the terminal again when it continues
            _restore(terminal, before)
            last = _OFF
    if last == _ON:
        _restore(terminal, before)


def _restore(terminal: int, before: list[Any]) -> None:
    """Restore the modes of the terminal."""
    with suppress(OSError, termios.error):
        os.write(terminal, _RESTORE)
        # with it, keys make no signals; if they do, a shell was faster
        if not termios.tcgetattr(terminal)[3] & termios.ISIG:
            termios.tcsetattr(terminal, termios.TCSANOW, before)
