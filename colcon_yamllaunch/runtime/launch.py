# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running a plan, from the first process to the exit code."""

from collections.abc import Callable
from collections.abc import Mapping
from contextlib import ExitStack
import os
from pathlib import Path
import sys
import time
from typing import TextIO

from colcon_yamllaunch.language.plan import Plan
from colcon_yamllaunch.language.plan import Process
from colcon_yamllaunch.runtime.channels import size_of
from colcon_yamllaunch.runtime.descriptors import keep_to_ourselves
from colcon_yamllaunch.runtime.engine import Engine
from colcon_yamllaunch.runtime.engine import no_guard
from colcon_yamllaunch.runtime.engine import Settings
from colcon_yamllaunch.runtime.events import Ended
from colcon_yamllaunch.runtime.events import Listener
from colcon_yamllaunch.runtime.events import Warned
from colcon_yamllaunch.runtime.failures import Failures
from colcon_yamllaunch.runtime.guard_link import GuardLink
from colcon_yamllaunch.runtime.logs import Logs
from colcon_yamllaunch.runtime.members import new_identity
from colcon_yamllaunch.runtime.parameter_files import ParameterFiles
from colcon_yamllaunch.runtime.screen import Screen
from colcon_yamllaunch.runtime.signals import caught
from colcon_yamllaunch.runtime.spawn import Spawn
from colcon_yamllaunch.runtime.writer import DescriptorWriter
from colcon_yamllaunch.runtime.writer import TextWriter
from colcon_yamllaunch.runtime.writer import Writer


def run(
    plan: Plan,
    *,
    environment: Mapping[str, str],
    log_folder: Path | None,
    stream: TextIO | None = None,
    color: bool | None = None,
    clock: Callable[[], float] = time.monotonic,
    spawn: Spawn = os.posix_spawn,
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
      `NO_COLOR` is set or `TERM` is dumb
    :param clock: Returns seconds that never go back
    :param spawn: Starts a program as :func:`os.posix_spawn` does
    :returns: The exit code: 0 when all ended well or was stopped by the user,
      1 when a process failed, could not be started or could not be stopped
    """
    stream = sys.stdout if stream is None else stream
    terminal = stream.isatty()
    if color is None:
        color = terminal and _wants_color(environment)
    settings = Settings(
        new_identity(),
        _with_defaults(environment, color),
        size_of(_descriptor(stream)),
        clock,
        spawn,
    )
    processes = tuple(plan.processes())
    with ExitStack() as stack:
        signals = stack.enter_context(caught())
        keep_to_ourselves()
        writer = _writer(stream)
        stack.callback(writer.close)
        screen = Screen(writer, processes, color=color, terminal=terminal)
        guard = _guard(settings.identity, screen)
        stack.callback(guard.abandon)
        files = ParameterFiles(guard.folder)
        stack.callback(files.remove)
        logs = _logs(log_folder, processes, screen)
        failures = Failures({})
        listeners: list[Listener] = [screen.handle]
        if logs is not None:
            stack.callback(logs.close)
            failures = Failures(logs.combined_files(processes))
            listeners.insert(0, logs.handle)
        listeners.insert(0, failures.handle)
        publish = _nothing if logs is None else logs.flush
        engine = Engine(
            plan, settings, guard, files, writer, listeners, publish
        )
        stack.callback(engine.close)
        engine.run(signals)
        files.remove()
        guard.dismiss()
        engine.tell(Ended(failures.exit_code, failures.summary()))
        engine.finish(signals)
        return failures.exit_code


def _guard(identity: str, screen: Screen) -> GuardLink:
    guard = GuardLink(identity)
    try:
        guard.start()
    except OSError as error:
        screen.handle(Warned(no_guard(error)))
    return guard


def _logs(
    folder: Path | None, processes: tuple[Process, ...], screen: Screen
) -> Logs | None:
    if folder is None:
        return None
    return Logs(folder, processes, lambda text: screen.handle(Warned(text)))


def _wants_color(environment: Mapping[str, str]) -> bool:
    # https://no-color.org: any value but the empty one
    return (
        not environment.get('NO_COLOR') and environment.get('TERM') != 'dumb'
    )


def _with_defaults(
    environment: Mapping[str, str], color: bool
) -> dict[str, str]:
    """Add what makes output show at once, and in colour."""
    result = {'PYTHONUNBUFFERED': '1'}
    if color:
        result['RCUTILS_COLORIZED_OUTPUT'] = '1'
    result.update(environment)
    return result


def _writer(stream: TextIO) -> Writer:
    descriptor = _descriptor(stream)
    if descriptor == -1:
        return TextWriter(stream)
    writer = DescriptorWriter(descriptor)
    try:
        stream.flush()
    except BrokenPipeError:
        writer.broken = True
    return writer


def _descriptor(stream: TextIO) -> int:
    try:
        return stream.fileno()
    except (OSError, ValueError):
        return -1


def _nothing() -> None:
    """Publish nothing, as there are no log files."""
