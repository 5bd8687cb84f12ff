# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How much of a launch the user sees, and what a terminal gets beside."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import ExitStack
import os

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.runtime.core.events import Event
from colcon_yamllaunch.runtime.core.events import Listener
from colcon_yamllaunch.runtime.core.events import Output
from colcon_yamllaunch.runtime.core.events import Respawned
from colcon_yamllaunch.runtime.core.events import Said
from colcon_yamllaunch.runtime.core.events import Signalled
from colcon_yamllaunch.runtime.core.events import Started
from colcon_yamllaunch.runtime.core.outcome import signal_name
from colcon_yamllaunch.runtime.screen.reporting import is_alarming
from colcon_yamllaunch.runtime.screen.reporting import Verbosity
from colcon_yamllaunch.runtime.screen.screen import Screen
from colcon_yamllaunch.runtime.screen.start_table import StartTable
from colcon_yamllaunch.runtime.screen.title import has_title
from colcon_yamllaunch.runtime.screen.title import RESTORE_TITLE
from colcon_yamllaunch.runtime.screen.title import title_sequence
from colcon_yamllaunch.runtime.streams.writer import Writer

_LOUD_LEVELS = frozenset(('WARNING', 'ERROR', 'CRITICAL'))


@dataclass(frozen=True, slots=True)
class Look:
    """
    How a launch looks.

    :param verbosity: `quiet` leaves the output of processes, warnings and
      failures; `verbose` adds what each process was started with, and the
      signals that it is sent
    :param title: What the window is called, or None
    :param describe: Returns lines about a process that is started
    """

    verbosity: Verbosity = 'normal'
    title: str | None = None
    describe: Callable[[Process], Iterable[str]] = lambda _: ()


@dataclass(frozen=True, slots=True)
class Place:
    """
    Where a launch is shown.

    :param writer: Writes there
    :param terminal: Whether it is a terminal
    :param size: The size of the terminal
    """

    writer: Writer
    terminal: bool
    size: os.terminal_size


def front(
    look: Look,
    screen: Screen,
    plan: Plan,
    place: Place,
    environment: Mapping[str, str],
    stack: ExitStack,
) -> Listener:
    """
    Return who shows what happens.

    :param look: How
    :param screen: Shows what it is told
    :param plan: What is run
    :param place: Where
    :param environment: Says what kind of terminal it is
    :param stack: Takes what is to be undone at the end
    """
    if place.terminal and look.title and has_title(environment.get('TERM')):
        place.writer.write(None, title_sequence(look.title))
        stack.callback(_restore_title, place.writer)
    if look.verbosity == 'quiet':
        return _quiet(screen.handle)
    show: Listener = screen.handle
    if look.verbosity == 'verbose':
        show = _verbose(screen, look.describe)
    elif place.terminal:
        show = StartTable(plan, place.size, screen).handle
    return show


def _restore_title(writer: Writer) -> None:
    writer.write(None, RESTORE_TITLE)
    writer.flush()


def _quiet(show: Listener) -> Listener:
    def handle(event: Event) -> None:
        if isinstance(event, Said):
            wanted = event.level in _LOUD_LEVELS
        else:
            wanted = isinstance(event, Output) or is_alarming(event)
        if wanted:
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
