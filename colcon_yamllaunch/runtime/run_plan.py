# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running a plan, from the first process to the exit code."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import ExitStack
import os
from pathlib import Path
import sys
import time
from typing import TextIO

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.runtime.control.control import Control
from colcon_yamllaunch.runtime.control.keyboard import Keyboard
from colcon_yamllaunch.runtime.control.launch_states import About
from colcon_yamllaunch.runtime.control.local_attachment import LocalAttachment
from colcon_yamllaunch.runtime.core import limits
from colcon_yamllaunch.runtime.core.events import Ended
from colcon_yamllaunch.runtime.core.events import Listener
from colcon_yamllaunch.runtime.core.events import Warned
from colcon_yamllaunch.runtime.course.engine import Engine
from colcon_yamllaunch.runtime.course.engine import no_guard
from colcon_yamllaunch.runtime.course.engine import Settings
from colcon_yamllaunch.runtime.course.exit_conditions import Goal
from colcon_yamllaunch.runtime.process.descriptors import keep_to_ourselves
from colcon_yamllaunch.runtime.process.parameter_files import ParameterFiles
from colcon_yamllaunch.runtime.process.spawn import Spawn
from colcon_yamllaunch.runtime.record.failures import Failures
from colcon_yamllaunch.runtime.record.launch_logs import Logs
from colcon_yamllaunch.runtime.screen.display import Display
from colcon_yamllaunch.runtime.screen.line_formats import layout_of
from colcon_yamllaunch.runtime.screen.line_formats import LOG_FORMAT
from colcon_yamllaunch.runtime.screen.presentation import front
from colcon_yamllaunch.runtime.screen.presentation import Look
from colcon_yamllaunch.runtime.screen.presentation import Place
from colcon_yamllaunch.runtime.screen.screen import Screen
from colcon_yamllaunch.runtime.stopping.guard_link import GuardLink
from colcon_yamllaunch.runtime.stopping.launch_scan import new_identity
from colcon_yamllaunch.runtime.streams.channels import size_of
from colcon_yamllaunch.runtime.streams.signals import caught
from colcon_yamllaunch.runtime.streams.terminals import with_terminals


def run(
    plan: Plan,
    *,
    environment: Mapping[str, str],
    log_folder: Path | None,
    stream: TextIO | None = None,
    color: bool | None = None,
    tty: bool = False,
    log_limit: int | None = limits.LOG_LIMIT,
    clock: Callable[[], float] = time.monotonic,
    spawn: Spawn = os.posix_spawn,
    goal: Goal | None = None,
    look: Look | None = None,
    observers: Iterable[Listener] = (),
    about: About | None = None,
    attach: str | None = None,
) -> int:
    """
    Run a plan to its end.

    Must be called in the main thread, and no other thread may run: signals
    are handled here, and processes are started from a working directory that
    changes for a moment.

    :param plan: What to run
    :param environment: The environment for all processes
    :param log_folder: The folder for log files, made when it is missing, or
      None to write none
    :param stream: Where output is shown, by default standard output
    :param color: Whether it is coloured; by default on a terminal, unless
      `NO_COLOR` is set or `TERM` is dumb. False asks the processes, too, and
      removes the colours that they use all the same
    :param tty: Whether each process gets a terminal
    :param log_limit: What all log files may take together, in bytes, or None;
      see :mod:`colcon_yamllaunch.runtime.record.log_files`
    :param clock: Returns seconds that never go back
    :param spawn: Starts a program as :func:`os.posix_spawn` does
    :param goal: What the launch is to achieve, by default nothing
    :param look: How much is shown
    :param observers: Are told what happens, too
    :param about: What other terminals of the user know the launch by; without
      it they do not see it
    :param attach: The label of a process that the keyboard, which is standard
      input, is connected to; it must have a terminal
    :returns: The exit code: 0 when all ended well or was stopped by the user,
      1 when a process failed, could not be started or could not be stopped,
      or when the goal was not reached
    """
    stream = sys.stdout if stream is None else stream
    if tty:
        plan = with_terminals(plan)
    with ExitStack() as stack:
        signals = stack.enter_context(caught())
        keep_to_ourselves()
        display = Display(stream, color, environment)
        stack.callback(display.writer.close)
        environment = display.environment
        settings = Settings(
            new_identity(), environment, display.descriptor, clock, spawn
        )
        troubles: list[str] = []
        screen = display.screen(plan.processes(), troubles.append)
        guard = _guard(settings.identity, screen, stack)
        files = ParameterFiles(guard.folder)
        stack.callback(files.remove)
        records = _records(
            log_folder, log_limit, plan, settings, screen, troubles, stack
        )
        show, keyboard = _front(
            look or Look(), attach, plan, display, screen, stack
        )
        goal = goal or Goal(clock=clock)
        engine = Engine(
            plan,
            settings,
            guard,
            files,
            display.writer,
            (*records.listeners, show, goal.handle, *observers),
            records.publish,
            goal,
        )
        stack.callback(engine.close)
        for text in troubles:
            engine.tell(Warned(text))
        control = Control(engine, keyboard)
        stack.callback(control.close)
        if about is not None:
            control.serve(
                about, environment, guard, log_folder, records.files, clock
            )
        engine.run(signals)
        control.close()
        files.remove()
        guard.dismiss()
        ended = _ended(records.failures, goal)
        engine.tell(ended)
        engine.finish(signals)
        return ended.exit_code


def _ended(failures: Failures, goal: Goal) -> Ended:
    missed = goal.failures()
    return Ended(
        failures.exit_code or int(bool(missed)),
        (*failures.summary(), *(f'failed: {text}' for text in missed)),
        failures.reports(),
        goal.verdicts(),
    )


def _guard(identity: str, screen: Screen, stack: ExitStack) -> GuardLink:
    guard = GuardLink(identity)
    try:
        guard.start()
    except OSError as error:
        screen.handle(Warned(no_guard(error)))
    stack.callback(guard.abandon)
    return guard


@dataclass(frozen=True, slots=True)
class _Records:
    """
    What is kept of a launch.

    :param failures: What went wrong
    :param listeners: Keep it
    :param files: For each label the log with all output
    :param publish: Writes what was collected; see :class:`Engine`
    """

    failures: Failures
    listeners: tuple[Listener, ...]
    files: Mapping[str, Path]
    publish: Callable[[], bool]


def _records(
    folder: Path | None,
    limit: int | None,
    plan: Plan,
    settings: Settings,
    screen: Screen,
    troubles: list[str],
    stack: ExitStack,
) -> _Records:
    layout = layout_of(LOG_FORMAT, settings.environment, troubles.append)
    if folder is None:
        failures = Failures({})
        return _Records(failures, (failures.handle,), {}, _nothing)
    processes = tuple(plan.processes())
    logs = Logs(
        folder,
        processes,
        lambda text: screen.handle(Warned(text)),
        limit=limit,
        layout=layout,
    )
    stack.callback(logs.close)
    files = logs.combined_files(processes)
    failures = Failures(files)
    return _Records(
        failures, (failures.handle, logs.handle), files, logs.flush
    )


def _front(
    look: Look,
    attach: str | None,
    plan: Plan,
    display: Display,
    screen: Screen,
    stack: ExitStack,
) -> tuple[Listener, LocalAttachment | None]:
    """Return who shows what happens, and the keyboard if it is attached."""
    place = Place(
        display.writer, display.terminal, size_of(display.descriptor)
    )
    show = front(look, screen, plan, place, display.environment, stack)
    if attach is None:
        return show, None
    keyboard = Keyboard(sys.stdin.fileno())
    attachment = LocalAttachment(attach, keyboard, screen, show)
    return attachment.handle, attachment


def _nothing() -> bool:
    """Publish nothing, as there are no log files."""
    return False
