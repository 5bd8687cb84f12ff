# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How much of a launch the user sees, and what a terminal gets beside."""

from collections.abc import Callable
from collections.abc import Iterable
from contextlib import ExitStack

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.runtime.core.events import Event
from colcon_yamllaunch.runtime.core.events import Listener
from colcon_yamllaunch.runtime.core.events import LOUD
from colcon_yamllaunch.runtime.core.events import Output
from colcon_yamllaunch.runtime.core.events import Respawned
from colcon_yamllaunch.runtime.core.events import Signalled
from colcon_yamllaunch.runtime.core.events import Started
from colcon_yamllaunch.runtime.core.events import Verbosity
from colcon_yamllaunch.runtime.core.outcome import signal_name
from colcon_yamllaunch.runtime.screen.display import Display
from colcon_yamllaunch.runtime.screen.screen import Screen
from colcon_yamllaunch.runtime.screen.start_table import StartTable
from colcon_yamllaunch.runtime.streams.channels import size_of
from colcon_yamllaunch.runtime.streams.writer import Writer

# XTWINOPS 22 and 23: the terminal keeps the titles that it had on a stack
_SAVE = b'\x1b[22;0t'
# gives a window the title back that it had before
_RESTORE = b'\x1b[23;0t'
# the values of TERM of terminals that have no window of their own
_WITHOUT_WINDOW = frozenset((None, '', 'dumb', 'linux', 'vt100', 'unknown'))


@dataclass(frozen=True, slots=True)
class Presentation:
    """
    How a launch is shown.

    :param verbosity: `quiet` leaves the output of processes, warnings and
      failures; `verbose` adds what each process was started with, and the
      signals that it is sent
    :param title: What the window is called, or None
    :param describe: Returns lines about a process that is started
    """

    verbosity: Verbosity = 'normal'
    title: str | None = None
    describe: Callable[[Process], Iterable[str]] = lambda _: ()


def present(
    presentation: Presentation,
    screen: Screen,
    plan: Plan,
    display: Display,
    stack: ExitStack,
) -> Listener:
    """
    Return who shows what happens.

    :param presentation: How
    :param screen: Shows what it is told
    :param plan: What is run
    :param display: Where
    :param stack: Takes what is to be undone at the end
    """
    terminal = display.environment.get('TERM') if display.terminal else None
    if presentation.title and terminal not in _WITHOUT_WINDOW:
        display.writer.write(None, _title_sequence(presentation.title))
        stack.callback(_restore_title, display.writer)
    if presentation.verbosity == 'quiet':
        return _quiet(screen.handle)
    if presentation.verbosity == 'verbose':
        return _verbose(screen, presentation.describe)
    if display.terminal:
        return StartTable(plan, size_of(display.descriptor), screen).handle
    return screen.handle


def _title_sequence(title: str) -> bytes:
    """Return what keeps the title of a window and sets another."""
    text = ''.join(c for c in title if c.isprintable())
    return _SAVE + f'\x1b]2;{text}\x07'.encode(errors='replace')


def _restore_title(writer: Writer) -> None:
    writer.write(None, _RESTORE)
    writer.flush()


def _quiet(show: Listener) -> Listener:
    def handle(event: Event) -> None:
        if isinstance(event, Output) or event.severity in LOUD:
            show(event)

    return handle


def _verbose(
    screen: Screen, describe: Callable[[Process], Iterable[str]]
) -> Listener:
    def handle(event: Event) -> None:
        screen.handle(event)
        match event:
            case Started():
                for line in describe(event.process):
                    screen.say(f'  {line}')
            case Signalled(group=True):
                name = signal_name(event.signal)
                screen.say(f'{event.process.label}: {name}, pid {event.pid}')
            case Respawned():
                screen.say(f'{event.process.label}: start {event.attempt + 1}')
            case _:
                return

    return handle
