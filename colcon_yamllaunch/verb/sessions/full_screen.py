# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A running launch on the full screen, and a new one beside it."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import contextmanager
import importlib.util
import os
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.control.client import ControlError
from colcon_yamllaunch.control.client import LaunchEndedError
from colcon_yamllaunch.control.client import running_launches
from colcon_yamllaunch.control.client import RunningLaunch
from colcon_yamllaunch.control.subscription import BEGINNING
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.observers.display import only_prints
from colcon_yamllaunch.terminal.pager import command
from colcon_yamllaunch.terminal.pager import LESS
from colcon_yamllaunch.verb.cli.messages import say
from colcon_yamllaunch.verb.sessions.attaching import attach
from colcon_yamllaunch.verb.sessions.screen_keeper import ScreenKeeper
from colcon_yamllaunch.verb.sessions.selecting import Candidate

if TYPE_CHECKING:
    from colcon_yamllaunch.terminal.full_screen.launch_app import LaunchApp

#: What to say without the library that draws.
MISSING = (
    "--ui needs the Python package 'textual': "
    "pip install 'colcon-yamllaunch[ui]'"
)
#: By how much the launch comes before us where both want a processor, as for
#: nice(1).
NICE = 5
#: Seconds in which nobody has read anything, nor left what shows it.
_GLANCE = 0.4
#: Seconds that the screen may take to close after a signal.
_PATIENCE = 1.0
_ENDING = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: Signals that the library takes, and does not leave to others at its end.
_KEPT = (signal.SIGTSTP, signal.SIGCONT)


def need_screen(environment: Mapping[str, str]) -> None:
    """
    See whether there is all that the full screen needs.

    :raises UserError: when there is not
    """
    if importlib.util.find_spec('textual') is None:
        raise UserError(MISSING)
    if not (_is_terminal(0) and _is_terminal(1)):
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
    number = show(chosen.launch, OuterTerminal(chosen.state.pid, environment))
    return 0 if number is None else 128 + number


def show(launch: RunningLaunch, terminal: 'OuterTerminal') -> int | None:
    """
    Show a launch until the user leaves.

    Return the signal that ended it, if one did.

    :raises ControlError: when the launch refuses
    """
    # it takes long to import
    from colcon_yamllaunch.terminal.full_screen.launch_app import LaunchApp
    from colcon_yamllaunch.terminal.full_screen.launch_model import BEHIND

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
    with ScreenKeeper(0) as keeper:
        app = LaunchApp(
            launch,
            terminal,
            shown=lambda is_shown: keeper.take(is_shown=is_shown),
        )
        try:
            with _ended_by_signals(app, terminal):
                app.run()
                if app.signal is not None:
                    _drop_unwritten()
        finally:
            app.panes.close()
            terminal.is_over = bool(app.panes.model.ending)
            if plain is not None:
                os.environ['NO_COLOR'] = plain
    if app.error is not None:
        raise app.error
    return app.signal


class OuterTerminal:
    """
    What the full screen can have done outside of itself.

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
        #: Whether the launch ended while it was shown.
        self.is_over = False

    @property
    def owns_launch(self) -> bool:
        """Whether the launch was started for this screen."""
        return self._interrupt is not None

    def interrupt(self) -> None:
        """Do to the launch what Ctrl-C does."""
        if self._interrupt is not None:
            self._interrupt()

    def attach(self, label: str) -> None:
        """Connect the terminal to a process, until that is over."""
        launch = launch_of(self._pid, self._environment)
        if launch is None:
            return
        try:
            state = launch.status()
            parts = [
                p
                for p in state.processes
                if p.label == label and isinstance(p, ProcessState)
            ]
            attach(Candidate(launch, state), parts)
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


def launch_of(
    pid: int, environment: Mapping[str, str]
) -> RunningLaunch | None:
    """Return the launch of a launcher, None while there is none."""
    found = None
    for launch in running_launches(environment, lambda _: None):
        if found is None and launch.pid == pid:
            found = launch
        else:
            launch.close()
    return found


@contextmanager
def _ended_by_signals(
    app: 'LaunchApp', terminal: OuterTerminal
) -> Iterator[None]:
    """
    Have signals end the screen, whatever it does.

    The library hangs for good in a write when the terminal takes nothing any
    more: the thread that writes has ended by an error, or is blocked, and its
    queue has a bound. So handlers of asyncio would never run; these do.
    """

    def end(number: int, _: object) -> None:
        if app.signal is None:
            signal.setitimer(signal.ITIMER_REAL, _PATIENCE)
            app.end_by(number)

    def give_up(*_: object) -> None:
        terminal.interrupt()
        # the keeper gives the terminal back, if it is still there
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


def _drop_unwritten() -> None:
    """
    Forget what a terminal that is gone was to show.

    Python would try to write it at its end, and exit with 120 then.
    """
    for stream in (sys.__stdout__, sys.__stderr__):
        if stream is None:
            continue
        try:
            stream.flush()
        except OSError:
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, stream.fileno())
            os.close(null)


def _is_terminal(descriptor: int) -> bool:
    try:
        return os.isatty(descriptor)
    except OSError:
        return False
