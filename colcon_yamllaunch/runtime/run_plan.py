# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running a plan, from the first process to the exit code."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import ExitStack
import os
from pathlib import Path
import sys
import time
from typing import TextIO
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.adoption import Adoption
from colcon_yamllaunch.common.errors import OutputError
from colcon_yamllaunch.language.plan.plan import Plan
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.runtime.acts.acts import Acts
from colcon_yamllaunch.runtime.control.launch_record import LaunchRecord
from colcon_yamllaunch.runtime.control.launch_states import About
from colcon_yamllaunch.runtime.control.server import serve
from colcon_yamllaunch.runtime.control.service import Service
from colcon_yamllaunch.runtime.core import events
from colcon_yamllaunch.runtime.core import limits
from colcon_yamllaunch.runtime.core.plan_source import PlanSource
from colcon_yamllaunch.runtime.course.engine import Engine
from colcon_yamllaunch.runtime.course.engine import no_guard
from colcon_yamllaunch.runtime.course.engine import Settings
from colcon_yamllaunch.runtime.course.exit_conditions import ExitConditions
from colcon_yamllaunch.runtime.keys.keyboard import Keyboard
from colcon_yamllaunch.runtime.process.descriptors import keep_to_ourselves
from colcon_yamllaunch.runtime.process.line_buffering import LineBuffering
from colcon_yamllaunch.runtime.process.own_files import Place
from colcon_yamllaunch.runtime.process.parameter_files import ParameterFiles
from colcon_yamllaunch.runtime.process.spawn import Spawn
from colcon_yamllaunch.runtime.record.failures import Failures
from colcon_yamllaunch.runtime.record.failures import OwnerOf
from colcon_yamllaunch.runtime.record.failures import ParametersOf
from colcon_yamllaunch.runtime.record.launch_logs import CLIENT_LOG
from colcon_yamllaunch.runtime.record.launch_logs import COMMON_LOG
from colcon_yamllaunch.runtime.record.launch_logs import Logs
from colcon_yamllaunch.runtime.record.launch_logs import Store
from colcon_yamllaunch.runtime.screen.display import can_have_status
from colcon_yamllaunch.runtime.screen.display import Display
from colcon_yamllaunch.runtime.screen.display import is_same_terminal
from colcon_yamllaunch.runtime.screen.line_formats import layout_of
from colcon_yamllaunch.runtime.screen.line_formats import LOG_FORMAT
from colcon_yamllaunch.runtime.screen.presentation import present
from colcon_yamllaunch.runtime.screen.presentation import Presentation
from colcon_yamllaunch.runtime.screen.screen import Screen
from colcon_yamllaunch.runtime.stopping.guard_link import GuardLink
from colcon_yamllaunch.runtime.stopping.launch_scan import new_identity
from colcon_yamllaunch.runtime.streams.relay import Recorder
from colcon_yamllaunch.runtime.streams.signals import caught
from colcon_yamllaunch.runtime.streams.writer import Writer
from colcon_yamllaunch.runtime.terminal.local_attachment import LocalAttachment

if TYPE_CHECKING:
    from colcon_yamllaunch.runtime.course.plan_changes import PlanChanges
    from colcon_yamllaunch.runtime.terminal.terminal_session import (
        TerminalSession,
    )


def run_plan(
    plan: Plan,
    *,
    environment: Mapping[str, str],
    log_folder: Path | None,
    stream: TextIO | None = None,
    color: bool | None = None,
    tty: bool = False,
    log_limit: int | None = limits.LOG_LIMIT,
    log_store: Store | None = None,
    clock: Callable[[], float] = time.monotonic,
    spawn: Spawn = os.posix_spawn,
    conditions: ExitConditions | None = None,
    presentation: Presentation | None = None,
    observers: Iterable[events.Listener] = (),
    about: About | None = None,
    attach: str | None = None,
    owner_of: OwnerOf = lambda _module, _package: None,
    parameters_of: ParametersOf = lambda process: process.parameters,
    identity: str = '',
    changes: 'PlanChanges | None' = None,
    source: PlanSource | None = None,
) -> int:
    """
    Run a plan to its end, and return the exit code.

    It is 0 when all ended well or was stopped by the user, 1 when a process
    failed, could not be started or could not be stopped, when a condition was
    not met, or when output could not be shown.

    Must be called in the main thread, and no other thread may run: signals
    are handled here, and processes are started from a working directory that
    changes for a moment.

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
    :param log_store: The log folders of other launches, if they are to be
      tidied up
    :param clock: Returns seconds that never go back
    :param spawn: Starts a program as :func:`os.posix_spawn` does
    :param conditions: When it ends by itself, by default never
    :param observers: Are told what happens, too
    :param about: What other terminals of the user know the launch by; without
      it they do not see it
    :param attach: The label of a process that the keyboard, which is standard
      input, is connected to; it must have a terminal
    :param owner_of: Tells which package has a Python module that is missing
    :param parameters_of: Tells which parameters a process is given, and where
    :param identity: The identity of the launch, see `launch_scan`; by default
      a new one
    :param changes: Changes the plan while it runs, and keeps the launch from
      ending when nothing runs; it is closed at the end
    :param source: Where more plan comes from while it runs, if anywhere
    :raises UserError: before anything is started, when the environment lacks
      what the plan needs
    :raises OutputError: at the end, when output could not be shown; not when
      nobody reads it any more
    """
    stream = sys.stdout if stream is None else stream
    with ExitStack() as stack:
        signals = stack.enter_context(caught())
        keep_to_ourselves()
        has_status = (
            presentation is not None
            and presentation.status
            and can_have_status(stream, environment)
        )
        open_writer = _foot if has_status else Writer
        display = Display(stream, color, environment, open_writer)
        stack.callback(display.writer.close)
        environment = display.environment
        # before the guard, which is a child, too
        if changes is not None:
            stack.callback(changes.close)
        helpers = set() if changes is None else set(changes.pids)
        if source is not None:
            helpers.add(source.pid)
        adoption = Adoption(helpers)
        stack.callback(adoption.end)
        buffering = LineBuffering(environment.get('PATH', os.defpath))
        settings = Settings(
            identity or new_identity(),
            environment,
            display.descriptor,
            clock,
            spawn,
            adoption,
            buffering,
            None if log_folder is None else log_folder / CLIENT_LOG,
            tty,
        )
        troubles: list[str] = []
        processes = tuple(plan.processes())
        screen = display.screen(processes, troubles.append)
        guard = _guard(settings.identity, screen, stack)
        launch_record = LaunchRecord(settings.identity)

        def note_parameters(place: Place) -> None:
            guard.folder(place)
            launch_record.note_parameters(place)

        files = ParameterFiles(note_parameters)
        stack.callback(files.remove)
        layout = layout_of(LOG_FORMAT, environment, troubles.append)
        listeners: list[events.Listener] = []
        log_files: Mapping[str, Path] = {}
        record: Recorder = _record_nothing
        publish: Callable[[], bool] = bool
        if log_folder is not None:
            logs = Logs(
                log_folder,
                processes,
                lambda text: screen.handle(events.Warned(text)),
                limit=log_limit,
                layout=layout,
                store=log_store,
            )
            stack.callback(logs.close)
            listeners.append(logs.handle)
            log_files = logs.combined_files
            record, publish = logs.record, logs.flush
            guard.logs(log_folder / COMMON_LOG, log_files)

        def advise(event: events.Exited, tail: Sequence[str]) -> str | None:
            # few launches fail
            from colcon_yamllaunch.runtime.record import failure_advice

            advisor = failure_advice.Advisor(
                environment, owner_of, buffering.holds_back, parameters_of
            )
            return advisor.advise(event, tail)

        failures = Failures(log_files, advise)
        show = present(
            presentation or Presentation(), screen, plan, display, stack
        )
        attachment = None
        has_keys = has_status and is_same_terminal(
            sys.stdin, display.descriptor
        )
        if attach is not None and not has_keys:
            keyboard = Keyboard(sys.stdin.fileno())
            attachment = LocalAttachment(attach, keyboard, screen, show)
            show = attachment.handle
        conditions = conditions or ExitConditions(clock=clock)
        session = None
        if has_status:
            session = _session(
                plan,
                display,
                screen,
                guard,
                conditions,
                clock,
                attach,
                has_keys=has_keys,
            )
            show = session.showing(show)
        engine = Engine(
            plan,
            settings,
            guard,
            files,
            display.writer,
            (failures.handle, *listeners, show, conditions.handle, *observers),
            record,
            publish,
            conditions,
            source,
        )
        stack.callback(engine.close)
        if changes is not None:
            engine.change_by(changes, display.environment_for)
        conditions.tell = engine.tell
        acts = Acts(engine, log_files, parameters_of)
        engine.start_client()
        for text in troubles:
            engine.tell(events.Warned(text))
        with ExitStack() as control:
            if session is not None:
                session.connect(engine, acts)
                control.callback(session.close)
            if attachment is not None:
                attachment.connect(engine)
                control.callback(attachment.close)
            if about is not None:
                service = Service(
                    about, engine, acts, log_folder, log_files, clock
                )
                serve(
                    engine,
                    service,
                    environment,
                    guard,
                    launch_record,
                    control,
                )
            engine.run(signals)
        files.remove()
        guard.dismiss()
        display.writer.flush()
        ended = _ended(failures, conditions, display.writer.error)
        engine.tell(ended)
        engine.finish(signals)
        if display.writer.error is not None:
            raise OutputError(display.writer.error)
        return ended.exit_code


def _foot(descriptor: int) -> Writer:
    # few launches that nobody looks at need it
    from colcon_yamllaunch.runtime.status.foot import Foot

    return Foot(descriptor)


def _session(
    plan: Plan,
    display: Display,
    screen: Screen,
    guard: GuardLink,
    conditions: ExitConditions,
    clock: Callable[[], float],
    attach: str | None,
    *,
    has_keys: bool,
) -> 'TerminalSession':
    from colcon_yamllaunch.runtime.status.foot import Foot
    from colcon_yamllaunch.runtime.terminal.terminal_session import (
        TerminalSession,
    )

    assert isinstance(display.writer, Foot)
    keyboard = None
    if has_keys:
        keyboard = Keyboard(sys.stdin.fileno())
    elif attach is None:
        # what would be shown of keys would be in the block
        keyboard = Keyboard(display.descriptor, takes_keys=False)
    return TerminalSession(
        plan.entries,
        display.writer,
        screen,
        guard,
        keyboard,
        color=display.color,
        is_plain=display.is_ascii,
        environment=display.environment,
        conditions=conditions,
        clock=clock,
        attach=attach if has_keys else None,
    )


def _record_nothing(
    process: Process, stream: events.Stream, data: bytes
) -> None:
    """Keep no logs."""


def _ended(
    failures: Failures, conditions: ExitConditions, unshown: OSError | None
) -> events.Ended:
    missed = conditions.failures()
    return events.Ended(
        failures.exit_code or int(bool(missed or unshown)),
        (*failures.summary(), *(f'failed: {text}' for text in missed)),
        failures.reports(),
        conditions.verdicts(),
    )


def _guard(identity: str, screen: Screen, stack: ExitStack) -> GuardLink:
    guard = GuardLink(identity)
    try:
        guard.start()
    except OSError as error:
        screen.handle(events.Warned(no_guard(error)))
    stack.callback(guard.abandon)
    return guard
