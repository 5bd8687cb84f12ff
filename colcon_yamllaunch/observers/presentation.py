# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which events of a launch the user sees."""

from collections.abc import Callable
from collections.abc import Iterable
from contextlib import ExitStack

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.channels import size_of
from colcon_yamllaunch.engine.outcome import signal_name
from colcon_yamllaunch.observers.display import Display
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process


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
    show = _shown(presentation, screen, plan, display)
    if presentation.watch and presentation.verbosity != 'verbose':
        show = _without_restarts(show, screen)
    if not display.terminal:
        return show
    from colcon_yamllaunch.observers.title import has_window
    from colcon_yamllaunch.observers.title import TerminalTitle

    title = TerminalTitle(
        display.writer,
        presentation.title if has_window(display.environment) else None,
        bell=presentation.bell,
    )
    stack.callback(title.restore)
    if not presentation.watch:
        return show

    def handle(event: events.Event) -> None:
        show(event)
        title.handle(event)

    return handle


def _shown(
    presentation: Presentation, screen: Screen, plan: Plan, display: Display
) -> events.Listener:
    if presentation.verbosity == 'quiet':
        return _quiet(screen.handle)
    if presentation.verbosity == 'verbose':
        return _verbose(screen, presentation.describe)
    if display.terminal:
        from colcon_yamllaunch.observers.start_table import StartTable

        return StartTable(plan, size_of(display.descriptor), screen).handle
    return screen.handle


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
            case events.Watched(is_final=True):
                # processes behind timers are shown when they start
                new.clear()
            case events.Requested():
                label = event.process.label
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
                gone.discard(event.process.label)
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
