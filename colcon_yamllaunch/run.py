# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Running a plan, from the first process to the exit code."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
import os
from pathlib import Path
import sys
import time
from typing import TextIO, TYPE_CHECKING

from colcon_yamllaunch.common.adoption import Adoption
from colcon_yamllaunch.common.errors import OutputError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.control.journal import Journal
from colcon_yamllaunch.control.server import LaunchRecord, serve
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.engine import Engine, EngineSettings, no_guard
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.guard_link import GuardLink, GuardProcess
from colcon_yamllaunch.engine.launch_scan import new_identity
from colcon_yamllaunch.engine.line_buffering import LineBuffering
from colcon_yamllaunch.engine.loop import caught
from colcon_yamllaunch.engine.own_files import OwnFile, ParameterFiles
from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.engine.spawn import close_on_exec_all, Spawn
from colcon_yamllaunch.engine.state import About, LaunchState
from colcon_yamllaunch.engine.writer import Writer
from colcon_yamllaunch.observers.failures import Failures, OwnerOf
from colcon_yamllaunch.observers.log_files import CLIENT_LOG, COMMON_LOG, Logs
from colcon_yamllaunch.observers.presentation import (
    can_have_status,
    Display,
    is_same_terminal,
    present,
    Presentation,
)
from colcon_yamllaunch.observers.screen import layout_of, LOG_FORMAT
from colcon_yamllaunch.plan.plan import ParametersOf, Plan

if TYPE_CHECKING:
    from colcon_yamllaunch.observers.log_store import LogStore
    from colcon_yamllaunch.terminal.attachment import LocalAttachment
    from colcon_yamllaunch.terminal.terminal_session import TerminalSession

# of a launch that other terminals do not see
_UNKNOWN = About('', None, '', '')


@dataclass(frozen=True, slots=True)
class RunContext:
    """
    What is fixed when a launch begins to run, apart from its plan.

    :param environment: The environment for all processes
    :param log_folder: The folder for log files, made when it is missing, or
      None to write none
    :param stream: Where output is shown, by default standard output
    :param color: Whether it is coloured; by default on a terminal, unless
      `NO_COLOR` is set or `TERM` is dumb. False asks the processes, too, and
      removes the colours that they use all the same
    :param tty: Whether each process gets a terminal
    :param terminal_size: The size of these terminals at first, by default
      that of the stream
    :param log_limit: Bytes that all log files may take together, or None;
      see :mod:`colcon_yamllaunch.observers.log_files`
    :param log_store: The log folders of other launches, if old ones are to be
      deleted
    :param presentation: What is shown, and how
    :param about: What other terminals of the user know the launch by; without
      it, they do not see it
    :param is_hidden: Whether nothing is shown, and other terminals see it
      only when a participant calls `Engine.show_to_others`
    :param attach: The label of a process that the keyboard, which is standard
      input, is connected to; it must have a terminal
    :param conditions: When it ends by itself, by default never
    :param owner_of: Returns the package that has a missing Python module
    :param parameters_of: Returns the parameters of a process
    :param identity: The identity of the launch, see `launch_scan`; by default
      a new one
    :param participants: What takes part in it beside the engine; they are
      closed at the end
    :param guard: The guard, by default one for this launch alone
    :param clock: Returns seconds that never go back
    :param spawn: Starts a program as :func:`os.posix_spawn` does
    """

    environment: Mapping[str, str]
    log_folder: Path | None
    stream: TextIO | None = None
    color: bool | None = None
    tty: bool = False
    terminal_size: os.terminal_size | None = None
    log_limit: int | None = limits.DEFAULT_LOG_BYTES
    log_store: 'LogStore | None' = None
    presentation: Presentation = Presentation()
    about: About | None = None
    is_hidden: bool = False
    attach: str | None = None
    conditions: ExitConditions | None = None
    owner_of: OwnerOf = lambda _module, _package: None
    parameters_of: ParametersOf = lambda process: process.parameters
    identity: str = ''
    participants: Sequence[Participant] = ()
    guard: GuardProcess | None = None
    clock: Callable[[], float] = time.monotonic
    spawn: Spawn = os.posix_spawn


def run(
    plan: Plan,
    context: RunContext,
    observers: Iterable[events.Listener] = (),
) -> int:
    """
    Run a plan to its end, and return the exit code.

    It is 0 when everything ended well or the user stopped it, 1 when a process
    failed, could not be started or could not be stopped, when a condition was
    not met, or when output could not be shown.

    Must be called in the main thread, and no other thread may run: signals
    are handled here, and processes are started from a working directory that
    changes for a moment.

    :param plan: What runs on this machine
    :param observers: Receive all events
    :raises UserError: before anything is started, when the environment lacks
      what the plan needs
    :raises OutputError: at the end, when output could not be shown; not when
      nobody reads it any more
    """
    with ExitStack() as stack:
        signals = stack.enter_context(caught())
        close_on_exec_all()
        launch = _Launch(plan, context, observers, stack)
        engine = launch.engine
        for text in launch.troubles:
            engine.emit(events.Warned(text))
        with ExitStack() as control:
            launch.connect(control)
            try:
                engine.prepare()
                engine.start_client()
                engine.run(signals)
            except Exception as error:
                for participant in context.participants:
                    participant.failed(error)
                raise
        launch.files.remove()
        launch.guard.dismiss()
        return launch.finish(signals)


class _Launch:
    """
    A launch that is about to run: its engine, and the observers of that.

    :param stack: Closes all of it
    """

    def __init__(
        self,
        plan: Plan,
        context: RunContext,
        observers: Iterable[events.Listener],
        stack: ExitStack,
    ) -> None:
        self._context = context
        self._conditions = context.conditions or ExitConditions(
            clock=context.clock
        )
        #: What was wrong while it was prepared.
        self.troubles: list[str] = []
        self._display = self._open_display(stack)
        whole = plan
        for participant in context.participants:
            whole = participant.whole(whole)
        processes = tuple(whole.processes())
        self._screen = self._display.screen(processes, self.troubles.append)

        # before the guard starts, which is a child, too, and no orphan
        settings = self._settings(_adopt(context, stack))
        self.guard = self._start_guard(settings.identity, stack)
        self._record = LaunchRecord(settings.identity)
        #: The parameter files of processes.
        self.files = ParameterFiles(self._note_folder)
        stack.callback(self.files.remove)

        logs = self._open_logs(whole, settings, stack)
        log_files = {} if logs is None else logs.combined_files
        folder = context.log_folder
        state = LaunchState(
            context.about or _UNKNOWN,
            started=context.clock(),
            clock=context.clock,
            log_folder=None if folder is None else str(folder),
            log_files=log_files,
            tty=context.tty,
        )
        self._failures = Failures(state, self._advise)
        self._keyboards: list[LocalAttachment | TerminalSession] = []
        listeners: list[events.Listener] = [self._failures.handle]
        if logs is not None:
            listeners.append(logs.handle)
        if not context.is_hidden:
            listeners.append(self._open_terminal(whole, state, stack))
        self.engine = Engine(
            plan,
            settings,
            guard=self.guard,
            files=self.files,
            writer=self._display.writer,
            listeners=(*listeners, self._conditions.handle, *observers),
            recorders=() if logs is None else (logs.record,),
            publish=None if logs is None else logs.flush,
            conditions=self._conditions,
            state=state,
            participants=context.participants,
            parameters_of=context.parameters_of,
            open_control=self._open_control,
        )
        stack.callback(self.engine.close)
        # the participants have said by now on which machines it runs
        state.expect(whole.entries)
        self._conditions.emit = self.engine.emit

    def connect(self, stack: ExitStack) -> None:
        """
        Accept keys and the requests of other terminals.

        :param stack: Ends that
        """
        context = self._context
        for keyboard in self._keyboards:
            keyboard.connect(self.engine)
            stack.callback(keyboard.close)
        self._control = stack
        if context.about is not None and not context.is_hidden:
            self.engine.show_to_others()

    def _open_control(self) -> None:
        context = self._context
        serve(
            self.engine,
            Journal(context.log_folder, context.log_limit),
            self._display.environment,
            self.guard,
            self._record,
            self._control,
        )

    def finish(self, signals: int) -> int:
        """
        Report how the launch ended, and return the exit code.

        :raises OutputError: when output could not be shown
        """
        engine, writer = self.engine, self._display.writer
        writer.flush()
        missed = self._conditions.failures()
        ended = events.Ended(
            int(bool(engine.state.has_failed or missed or writer.error)),
            (
                *self._failures.summary(),
                *(f'failed: {text}' for text in missed),
            ),
            self._failures.reports(),
            self._conditions.verdicts(),
            engine.state,
            next(iter((*self._failures.reasons(), *missed)), ''),
        )
        engine.emit(ended)
        engine.finish(signals)
        for participant in self._context.participants:
            participant.finish()
        if writer.error is not None:
            raise OutputError(writer.error)
        return ended.exit_code

    def _open_display(self, stack: ExitStack) -> Display:
        context = self._context
        stream = sys.stdout if context.stream is None else context.stream
        self._has_status = context.presentation.status and can_have_status(
            stream, context.environment
        )
        writer = Writer
        if self._has_status:
            # most launches by programs have no terminal
            from colcon_yamllaunch.terminal.status_writer import StatusWriter

            writer = StatusWriter
        display = Display(stream, context.color, context.environment, writer)
        stack.callback(display.writer.close)
        return display

    def _settings(self, adoption: Adoption) -> EngineSettings:
        context, display = self._context, self._display
        environment = display.environment
        self._buffering = LineBuffering(environment.get('PATH', os.defpath))
        folder = context.log_folder
        return EngineSettings(
            context.identity or new_identity(),
            environment,
            display.descriptor,
            context.clock,
            context.spawn,
            adoption,
            self._buffering,
            None if folder is None else folder / CLIENT_LOG,
            context.tty,
            context.terminal_size,
            display.environment_for,
        )

    def _start_guard(self, identity: str, stack: ExitStack) -> GuardLink:
        guard = GuardLink(identity, self._context.guard)
        try:
            guard.start()
        except OSError as error:
            self._screen.handle(events.Warned(no_guard(error)))
        stack.callback(guard.abandon)
        return guard

    def _note_folder(self, folder: OwnFile) -> None:
        """Register the folder of parameter files with guard and record."""
        self.guard.remove_later('folder', folder)
        self._record.note_parameters(folder)

    def _open_logs(
        self, whole: Plan, settings: EngineSettings, stack: ExitStack
    ) -> Logs | None:
        context, environment = self._context, self._display.environment
        layout = layout_of(LOG_FORMAT, environment, self.troubles.append)
        if context.log_folder is None:
            return None
        logs = Logs(
            context.log_folder,
            tuple(whole.processes()),
            lambda text: self._screen.handle(events.Warned(text)),
            settings.event_time,
            limit=context.log_limit,
            layout=layout,
            store=context.log_store,
        )
        stack.callback(logs.close)
        common = context.log_folder / COMMON_LOG
        self.guard.logs(common, logs.combined_files)
        return logs

    def _open_terminal(
        self, whole: Plan, state: LaunchState, stack: ExitStack
    ) -> events.Listener:
        """Return what shows events, with keyboard and status block if any."""
        context, display, screen = self._context, self._display, self._screen
        show = present(context.presentation, screen, whole, display, stack)
        has_keys = self._has_status and is_same_terminal(
            sys.stdin, display.descriptor
        )
        if context.attach is not None and not has_keys:
            from colcon_yamllaunch.terminal.attachment import LocalAttachment

            descriptor = sys.stdin.fileno()
            keyboard = LocalAttachment(
                context.attach, descriptor, screen, show
            )
            self._keyboards.append(keyboard)
            show = keyboard.handle
        if self._has_status:
            from colcon_yamllaunch.terminal.terminal_session import (
                TerminalSession,
            )

            session = TerminalSession(
                state,
                display,
                screen,
                show,
                self.guard,
                self._conditions,
                context.clock,
                context.attach,
                has_keys=has_keys,
            )
            self._keyboards.insert(0, session)
            show = session.handle
        return show

    def _advise(self, event: events.Exited, tail: Sequence[str]) -> str | None:
        """Return why a process failed, and what to do about that."""
        # few launches fail
        from colcon_yamllaunch.observers import failure_advice

        state = self.engine.state
        advisor = failure_advice.Advisor(
            self._display.environment,
            self._context.owner_of,
            self._buffering.holds_back,
            self._context.parameters_of,
            lambda label: state.machine_of(label) is not None,
        )
        return advisor.advise(event, tail)


def _adopt(context: RunContext, stack: ExitStack) -> Adoption:
    """Adopt orphans of the launch; helper processes are no orphans."""
    helpers: set[int] = set()
    for participant in context.participants:
        stack.callback(participant.close)
        helpers.update(participant.children())
    guard = context.guard
    adoption = Adoption(helpers, 0 if guard is None else guard.pid)
    stack.callback(adoption.end)
    return adoption
