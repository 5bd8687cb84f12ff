# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running a plan, from the first process to the exit code."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
import os
from pathlib import Path
import sys
import time
from typing import TextIO
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.adoption import Adoption
from colcon_yamllaunch.common.errors import OutputError
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.launch_record import LaunchRecord
from colcon_yamllaunch.control.server import serve
from colcon_yamllaunch.control.service import Service
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.engine import no_guard
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.launch_settings import Settings
from colcon_yamllaunch.engine.output.relay import Recorder
from colcon_yamllaunch.engine.output.signals import caught
from colcon_yamllaunch.engine.output.writer import Writer
from colcon_yamllaunch.engine.plan_source import PlanSource
from colcon_yamllaunch.engine.process.descriptors import keep_to_ourselves
from colcon_yamllaunch.engine.process.line_buffering import LineBuffering
from colcon_yamllaunch.engine.process.own_files import Place
from colcon_yamllaunch.engine.process.parameter_files import ParameterFiles
from colcon_yamllaunch.engine.process.spawn import Spawn
from colcon_yamllaunch.engine.state import About
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.stopping.guard_link import GuardLink
from colcon_yamllaunch.engine.stopping.guard_link import Guards
from colcon_yamllaunch.engine.stopping.launch_scan import new_identity
from colcon_yamllaunch.observers.display import can_have_status
from colcon_yamllaunch.observers.display import Display
from colcon_yamllaunch.observers.failures import Failures
from colcon_yamllaunch.observers.failures import OwnerOf
from colcon_yamllaunch.observers.line_formats import layout_of
from colcon_yamllaunch.observers.line_formats import LOG_FORMAT
from colcon_yamllaunch.observers.log_files import CLIENT_LOG
from colcon_yamllaunch.observers.log_files import COMMON_LOG
from colcon_yamllaunch.observers.log_files import Logs
from colcon_yamllaunch.observers.presentation import present
from colcon_yamllaunch.observers.presentation import Presentation
from colcon_yamllaunch.observers.screen import Screen
from colcon_yamllaunch.plan.plan import ParametersOf
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.terminal.own_terminal import OwnTerminal
from colcon_yamllaunch.terminal.own_terminal import status_writer

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.elsewhere import Companion
    from colcon_yamllaunch.engine.elsewhere import Elsewhere
    from colcon_yamllaunch.engine.plan_changes import PlanChanges
    from colcon_yamllaunch.launch_companion import LaunchCompanion
    from colcon_yamllaunch.observers.log_store import LogStore

# what a launch is known by that nobody sees
_UNKNOWN = About('', None, '', '')


def run_plan(
    plan: Plan,
    *,
    environment: Mapping[str, str],
    log_folder: Path | None,
    stream: TextIO | None = None,
    color: bool | None = None,
    tty: bool = False,
    log_limit: int | None = limits.LOG_LIMIT,
    log_store: 'LogStore | None' = None,
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
    elsewhere: 'Elsewhere | None' = None,
    companion: 'LaunchCompanion | None' = None,
    terminal_size: os.terminal_size | None = None,
    guards: Guards | None = None,
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
      see :mod:`colcon_yamllaunch.observers.log_files`
    :param log_store: The log folders of other launches, if they are to be
      tidied up
    :param clock: Returns seconds that never go back
    :param spawn: Starts a program as :func:`os.posix_spawn` does
    :param conditions: When it ends by itself, by default never
    :param observers: Are told what happens, too
    :param about: What other terminals of the user know the launch by; without
      it they do not see it; with a companion they do once that says so
    :param attach: The label of a process that the keyboard, which is standard
      input, is connected to; it must have a terminal
    :param owner_of: Tells which package has a Python module that is missing
    :param parameters_of: Tells which parameters a process is given, and where
    :param identity: The identity of the launch, see `launch_scan`; by default
      a new one
    :param changes: Changes the plan while it runs, and keeps the launch from
      ending when nothing runs; it is closed at the end
    :param source: Where more plan comes from while it runs, if anywhere
    :param elsewhere: The parts of the launch that run on other machines; the
      plan is what runs here then. It is closed at the end
    :param companion: What is beside this launch if it is such a part; nothing
      is shown then
    :param terminal_size: The size of terminals of processes at first, by
      default that of the stream
    :param guards: Starts the guard, by default as a new program
    :raises UserError: before anything is started, when the environment lacks
      what the plan needs
    :raises OutputError: at the end, when output could not be shown; not when
      nobody reads it any more
    """
    stream = sys.stdout if stream is None else stream
    presentation = presentation or Presentation()
    conditions = conditions or ExitConditions(clock=clock)
    troubles: list[str] = []
    with ExitStack() as stack:
        signals = stack.enter_context(caught())
        keep_to_ourselves()

        # what the user sees
        has_status = presentation.status and can_have_status(
            stream, environment
        )
        display = Display(
            stream, color, environment, status_writer if has_status else Writer
        )
        stack.callback(display.writer.close)
        environment = display.environment
        whole = plan if elsewhere is None else elsewhere.whole(plan)
        processes = tuple(whole.processes())
        screen = display.screen(processes, troubles.append)
        layout = layout_of(LOG_FORMAT, environment, troubles.append)

        # what ends it all, come what may; helpers are told from orphans before
        # the guard is there, which is a child, too
        adoption = _adopt(changes, source, elsewhere, guards, stack)
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
            terminal_size,
        )
        guard = _guard(settings.identity, guards, screen, stack)
        launch_record = LaunchRecord(settings.identity)
        files = _parameter_files(guard, launch_record, stack)

        # who listens
        logs = None
        if log_folder is not None:
            logs = Logs(
                log_folder,
                processes,
                lambda text: screen.handle(events.Warned(text)),
                settings.moment,
                limit=log_limit,
                layout=layout,
                store=log_store,
            )
            stack.callback(logs.close)
            guard.logs(log_folder / COMMON_LOG, logs.combined_files)
        log_files = {} if logs is None else logs.combined_files
        state = LaunchState(
            about or _UNKNOWN,
            started=clock(),
            clock=clock,
            log_folder=None if log_folder is None else str(log_folder),
            log_files=log_files,
            tty=tty,
        )
        if elsewhere is not None:
            state.machine_of = elsewhere.machine_of
            state.add_machines(elsewhere.machines)
        state.expect(whole.entries)
        is_elsewhere = _nowhere if elsewhere is None else elsewhere.has
        failures = Failures(
            state,
            _adviser(
                environment, owner_of, buffering, parameters_of, is_elsewhere
            ),
        )
        terminal = OwnTerminal(
            present(presentation, screen, whole, display, stack),
            state,
            display,
            screen,
            guard,
            conditions,
            clock,
            attach,
            has_status=has_status,
        )

        # who does it
        engine = Engine(
            plan,
            settings,
            guard,
            files,
            display.writer,
            (
                failures.handle,
                *(() if logs is None else (logs.handle,)),
                *(() if companion is not None else (terminal.show,)),
                conditions.handle,
                *observers,
            ),
            _recorder(logs, companion),
            bool if logs is None else logs.flush,
            conditions,
            state,
            source,
            elsewhere,
            companion,
            log_files=log_files,
            parameters_of=parameters_of,
        )
        stack.callback(engine.close)
        if changes is not None:
            engine.change_by(changes, display.environment_for)
        conditions.tell = engine.tell
        engine.start_client()
        for text in troubles:
            engine.tell(events.Warned(text))

        # who may ask for more meanwhile
        with ExitStack() as control:
            terminal.connect(engine, control)
            service = Service(
                engine, Journal(log_folder, log_limit), guard.lease
            )
            show = partial(
                serve,
                engine,
                service,
                environment,
                guard,
                launch_record,
                control,
            )
            if companion is not None:
                companion.begin(engine, service, show)
                engine.listen(companion.handle)
            elif about is not None:
                show()
            engine.run(signals)

        files.remove()
        guard.dismiss()
        code = _finish(engine, signals, display.writer, failures, conditions)
        if companion is not None:
            companion.over(code)
        return code


def _adopt(
    changes: 'PlanChanges | None',
    source: PlanSource | None,
    elsewhere: 'Elsewhere | None',
    guards: Guards | None,
    stack: ExitStack,
) -> Adoption:
    """Have orphans of the launch become our children, but no helpers."""
    helpers: set[int] = set()
    if changes is not None:
        stack.callback(changes.close)
        helpers.update(changes.pids)
    if source is not None:
        helpers.add(source.pid)
    if elsewhere is not None:
        helpers.update(elsewhere.pids)
    adoption = Adoption(helpers, 0 if guards is None else guards.pid)
    stack.callback(adoption.end)
    return adoption


def _guard(
    identity: str,
    guards: Guards | None,
    screen: Screen,
    stack: ExitStack,
) -> GuardLink:
    guard = GuardLink(identity, guards)
    try:
        guard.start()
    except OSError as error:
        screen.handle(events.Warned(no_guard(error)))
    stack.callback(guard.abandon)
    return guard


def _parameter_files(
    guard: GuardLink, launch_record: LaunchRecord, stack: ExitStack
) -> ParameterFiles:
    """Have those that are made for processes removed, come what may."""

    def note(place: Place) -> None:
        guard.folder(place)
        launch_record.note_parameters(place)

    files = ParameterFiles(note)
    stack.callback(files.remove)
    return files


def _adviser(
    environment: Mapping[str, str],
    owner_of: OwnerOf,
    buffering: LineBuffering,
    parameters_of: ParametersOf,
    is_elsewhere: Callable[[str], bool],
) -> Callable[[events.Exited, Sequence[str]], str | None]:
    """Return what tells why a process failed, and what to do about that."""

    def advise(event: events.Exited, tail: Sequence[str]) -> str | None:
        # few launches fail
        from colcon_yamllaunch.observers import failure_advice

        advisor = failure_advice.Advisor(
            environment,
            owner_of,
            buffering.holds_back,
            parameters_of,
            is_elsewhere,
        )
        return advisor.advise(event, tail)

    return advise


def _nowhere(label: str) -> bool:  # noqa: ARG001
    """Nothing runs on another machine."""
    return False


def _recorder(logs: Logs | None, companion: 'Companion | None') -> Recorder:
    """Return what takes output before anybody else."""
    takers = []
    if logs is not None:
        takers.append(logs.record)
    if companion is not None:
        takers.append(companion.record)
    if len(takers) == 1:
        return takers[0]

    def record(process: Process, stream: events.Stream, data: bytes) -> None:
        for take in takers:
            take(process, stream, data)

    return record


def _finish(
    engine: Engine,
    signals: int,
    writer: Writer,
    failures: Failures,
    conditions: ExitConditions,
) -> int:
    """
    Tell how the launch ended, and return the exit code.

    :raises OutputError: when output could not be shown
    """
    writer.flush()
    missed = conditions.failures()
    ended = events.Ended(
        int(bool(engine.state.has_failed or missed or writer.error)),
        (*failures.summary(), *(f'failed: {text}' for text in missed)),
        failures.reports(),
        conditions.verdicts(),
        engine.state,
    )
    engine.tell(ended)
    engine.finish(signals)
    if writer.error is not None:
        raise OutputError(writer.error)
    return ended.exit_code
