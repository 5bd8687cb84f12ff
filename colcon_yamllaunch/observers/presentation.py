# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How a launch is shown: the stream, the events, and the window title."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
import os
from typing import TextIO

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.channels import size_of
from colcon_yamllaunch.engine.outcome import signal_name
from colcon_yamllaunch.engine.writer import TextWriter, Writer
from colcon_yamllaunch.observers.screen import layout_of, Screen, SCREEN_FORMAT
from colcon_yamllaunch.plan.plan import Plan, Process

# the values of TERM of terminals that do no more than print
_ONLY_PRINT = frozenset((None, '', 'dumb', 'emacs', 'unknown'))
# the values of TERM of terminals that mostly have no more than ASCII
_ASCII = ('linux', *(f'vt{digit}' for digit in '12345'))
# whether the nodes of ROS 2 use colours; unset, they do on a terminal
_NODES_COLOUR = 'RCUTILS_COLORIZED_OUTPUT'

# XTWINOPS 22 and 23: the terminal keeps former titles on a stack
_SAVE_TITLE = b'\x1b[22;0t'
_RESTORE_TITLE = b'\x1b[23;0t'
# the values of TERM of terminals without a window
_WITHOUT_WINDOW = frozenset((None, '', 'dumb', 'linux', 'vt100', 'unknown'))

# the signs before the title during a change, and after it
_UNDER_WAY, _DONE, _FAILED = '…', '✓', '✗'


class Display:
    """
    Where a launch is shown.

    :param color: Whether it is coloured; by default on a terminal, unless
      `NO_COLOR` is set or `TERM` is dumb
    :param environment: The environment for all processes
    :param open_writer: Returns what writes to the descriptor of the stream
    """

    def __init__(
        self,
        stream: TextIO,
        color: bool | None,
        environment: Mapping[str, str],
        open_writer: Callable[[int], Writer] = Writer,
    ) -> None:
        #: Whether it is a terminal.
        self.terminal = stream.isatty()
        #: The descriptor of the stream, or -1.
        self.descriptor = _descriptor(stream)
        self._is_plain = color is False
        if color is None:
            # https://no-color.org: any value but the empty one
            color = (
                self.terminal
                and not environment.get('NO_COLOR')
                and environment.get('TERM') != 'dumb'
            )
        #: Whether it is coloured.
        self.color = color
        #: The environment, with variables for unbuffered, coloured output.
        self.environment = self.environment_for(environment)
        #: Whether it shows ASCII only.
        encoding = (getattr(stream, 'encoding', None) or '').lower()
        terminal = environment.get('TERM', '')
        self.is_ascii = not encoding.startswith('utf') or terminal.startswith(
            _ASCII
        )
        #: Writes to the stream.
        self.writer: Writer = TextWriter(stream)
        if self.descriptor != -1:
            self.writer = open_writer(self.descriptor)
            try:
                stream.flush()
            except BrokenPipeError:
                self.writer.broken = True
            except OSError as error:
                # an error of earlier output, such as that of the build
                self.writer.error = error

    def environment_for(
        self, environment: Mapping[str, str]
    ) -> dict[str, str]:
        """Return `environment` with variables for unbuffered output."""
        result = {
            'PYTHONUNBUFFERED': '1',
            'RCUTILS_LOGGING_BUFFERED_STREAM': '1',
        }
        if self.color:
            result[_NODES_COLOUR] = '1'
        result.update(environment)
        if self._is_plain:
            result['NO_COLOR'] = '1'
            result.pop(_NODES_COLOUR, None)
        return result

    def screen(
        self, processes: Iterable[Process], warn: Callable[[str], None]
    ) -> Screen:
        """
        Return the screen that shows a launch here.

        :param processes: Its processes, in the order of the plan
        :param warn: Is called with a warning about an invalid format
        """
        nodes_colour = self.environment.get(_NODES_COLOUR) == '1'
        return Screen(
            self.writer,
            processes,
            color=self.color,
            terminal=self.terminal,
            colourless=not self.color and not nodes_colour,
            layout=layout_of(SCREEN_FORMAT, self.environment, warn),
        )


def can_have_status(stream: TextIO, environment: Mapping[str, str]) -> bool:
    """
    Return whether a stream is a terminal that can show a status block.

    A service for continuous integration shows a terminal as a log, which
    keeps everything that was drawn.
    """
    return (
        stream.isatty()
        and _descriptor(stream) != -1
        and not only_prints(environment)
        and not environment.get('CI')
    )


def only_prints(environment: Mapping[str, str]) -> bool:
    """Return whether the terminal can only print."""
    return environment.get('TERM') in _ONLY_PRINT


def is_same_terminal(stream: TextIO | None, descriptor: int) -> bool:
    """Return whether `stream` is the terminal that `descriptor` is."""
    try:
        if stream is None or not stream.isatty():
            return False
        return os.ttyname(stream.fileno()) == os.ttyname(descriptor)
    except (OSError, ValueError):
        return False


def _descriptor(stream: TextIO) -> int:
    try:
        return stream.fileno()
    except (OSError, ValueError):
        return -1


@dataclass(frozen=True, slots=True)
class Presentation:
    """
    How a launch is shown.

    :param verbosity: `quiet` leaves the output of processes, warnings and
      failures; `verbose` adds what each process was started with, and the
      signals that it is sent
    :param title: What the window is called, or None
    :param describe: Returns lines about a process that is started
    :param status: Whether a terminal shows the state of all processes below
      their output
    :param watch: Whether the launch goes on with its files
    :param bell: Whether a terminal rings when something of that fails
    """

    verbosity: events.Verbosity = 'normal'
    title: str | None = None
    describe: Callable[[Process], Iterable[str]] = lambda _: ()
    status: bool = False
    watch: bool = False
    bell: bool = False


def present(
    presentation: Presentation,
    screen: Screen,
    plan: Plan,
    display: Display,
    stack: ExitStack,
) -> events.Listener:
    """Return the listener that shows the launch."""
    show: events.Listener = screen.handle
    if presentation.verbosity == 'quiet':
        show = _quiet(screen.handle)
    elif presentation.verbosity == 'verbose':
        show = _verbose(screen, presentation.describe)
    elif display.terminal:
        from colcon_yamllaunch.observers.start_table import StartTable

        size = size_of(display.descriptor)
        show = StartTable(plan, size, screen).handle
    if presentation.watch and presentation.verbosity != 'verbose':
        show = _without_restarts(show, screen)
    if not display.terminal:
        return show
    has_window = display.environment.get('TERM') not in _WITHOUT_WINDOW
    title = TerminalTitle(
        display.writer,
        presentation.title if has_window else None,
        bell=presentation.bell,
    )
    stack.callback(title.restore)
    if not presentation.watch:
        return show

    def handle(event: events.Event) -> None:
        show(event)
        title.handle(event)

    return handle


def _without_restarts(
    show: events.Listener, screen: Screen
) -> events.Listener:
    """Omit events that the line about a change covers."""
    changed: set[str] = set()
    new: set[str] = set()
    gone: set[str] = set()

    def handle(event: events.Event) -> None:
        match event:
            case events.Replanned():
                new.update(event.started)
                gone.update(event.stopped)
            case events.ChangeReported(is_final=True):
                # processes behind timers are shown when they start
                new.clear()
            case events.Requested():
                label = event.member.label
                if event.action == 'change':
                    changed.add(label)
                elif event.action == 'stop' and label in gone:
                    return
                else:
                    changed.discard(label)
            case events.Exited(asked=True, failed=False):
                if event.process.label in changed | gone:
                    screen.end_output(event.process)
                    return
            case events.Unloaded() if event.component.label in changed | gone:
                return
            case events.Dropped():
                gone.discard(event.member.label)
            case events.Started() if event.process.label in changed | new:
                changed.discard(event.process.label)
                return
            case events.Loaded() if event.component.label in changed | new:
                changed.discard(event.component.label)
                return
            case events.StartFailed():
                changed.discard(event.process.label)
            case events.LoadFailed():
                changed.discard(event.component.label)
            case _:
                pass
        show(event)

    return handle


def _quiet(show: events.Listener) -> events.Listener:
    def handle(event: events.Event) -> None:
        if isinstance(event, events.Output) or event.severity in events.LOUD:
            show(event)

    return handle


def _verbose(
    screen: Screen, describe: Callable[[Process], Iterable[str]]
) -> events.Listener:
    def handle(event: events.Event) -> None:
        screen.handle(event)
        match event:
            case events.Started():
                for line in describe(event.process):
                    screen.say(f'  {line}')
            case events.Signalled(group=True):
                name = signal_name(event.signal)
                screen.say(f'{event.process.label}: {name}, pid {event.pid}')
            case events.Respawned():
                screen.say(f'{event.process.label}: start {event.attempt + 1}')
            case _:
                return

    return handle


class TerminalTitle:
    """
    Shows in the title of a window how the last change went.

    :param writer: Writes to the terminal
    :param title: The title of the launch, None to leave that of the window
    :param bell: Whether to ring when something fails
    """

    def __init__(
        self, writer: Writer, title: str | None, *, bell: bool
    ) -> None:
        self._writer = writer
        self._title = title
        self._bell = bell
        # the labels of processes that have failed since the change
        self._failed: set[str] = set()
        if title:
            writer.steer(_SAVE_TITLE + _steering(title))

    def handle(self, event: events.Event) -> None:
        """Show the sign of an event."""
        match event:
            case events.FilesChanged():
                self._failed.clear()
                self._show(_UNDER_WAY)
            case events.Started():
                self._failed.discard(event.process.label)
            case events.Exited(failed=True, asked=False):
                is_first = not self._failed
                self._failed.add(event.process.label)
                if is_first:
                    self._fail()
            case events.ChangeReported(is_final=True) | events.ChangeChecked():
                if event.severity != 'INFO' and not self._failed:
                    self._fail()
                else:
                    self._show(_FAILED if self._failed else _DONE)

    def restore(self) -> None:
        """Restore the former title of the window."""
        if self._title:
            self._writer.steer(_RESTORE_TITLE)
            self._writer.flush()

    def _fail(self) -> None:
        self._show(_FAILED)
        if self._bell:
            self._writer.steer(b'\a')

    def _show(self, sign: str) -> None:
        if self._title:
            self._writer.steer(_steering(f'{sign} {self._title}'))


def _steering(title: str) -> bytes:
    shown = ''.join(c for c in title if c.isprintable())
    return f'\x1b]2;{shown}\x07'.encode(errors='replace')
