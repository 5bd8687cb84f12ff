# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `colcon launch` does, step by step."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
import gc
import os
from pathlib import Path
import signal
import time
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.events import Ended
from colcon_yamllaunch.engine.events import Event
from colcon_yamllaunch.engine.events import Listener
from colcon_yamllaunch.engine.events import Started
from colcon_yamllaunch.engine.events import StartFailed
from colcon_yamllaunch.engine.events import Verbosity
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.engine.state import About
from colcon_yamllaunch.language.reports import annotation
from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
from colcon_yamllaunch.observers.failures import OwnerOf
from colcon_yamllaunch.observers.presentation import Presentation
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan import SetParameter
from colcon_yamllaunch.plan.plan_json import plan_from_json
from colcon_yamllaunch.plan.plan_json import PlanFormatError
from colcon_yamllaunch.plan.position import shown_position
from colcon_yamllaunch.verb.context import GiveUpError
from colcon_yamllaunch.verb.context import HostKeeper
from colcon_yamllaunch.verb.log_folders import locked
from colcon_yamllaunch.verb.log_folders import log_store_of
from colcon_yamllaunch.verb.messages import say
from colcon_yamllaunch.verb.messages import show
from colcon_yamllaunch.verb.options import LaunchOptions
from colcon_yamllaunch.verb.options import WATCH_WITH_BELL
from colcon_yamllaunch.verb.prepare import LaunchPreparation

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.participants import Participant
    from colcon_yamllaunch.observers.junit import JUnitReport
    from colcon_yamllaunch.observers.log_store import LogStore
    from colcon_yamllaunch.verb.own_launch import Background


class PlanRun:
    """
    The run of a launch, and its reports.

    :param background: Where it goes when it begins to run, if another process
      shows it
    :raises UserError: when the file for a report cannot be written
    """

    _report: 'JUnitReport | None' = None

    def __init__(
        self,
        options: LaunchOptions,
        cwd: Path,
        environment: Mapping[str, str],
        background: 'Background | None' = None,
    ) -> None:
        self._options = options
        self._cwd = cwd
        self._environment = environment
        self._background = background
        positionals = options.positionals or (str(options.from_plan),)
        self._title = ' '.join(positionals)
        self._ended: Ended | None = None
        self._when_started: Callable[[], object] = bool
        self._to_start: set[str] = set()
        self._started = time.monotonic()
        self._is_late = False
        if self._options.junit is not None:
            from colcon_yamllaunch.observers.junit import JUnitReport

            # the package and the launch file
            names = [Path(word).name for word in positionals]
            name = '.'.join(n.partition('.')[0] or n for n in names)
            self._report = JUnitReport(self._title, name, time.time())
            # now rather than after a launch of an hour
            self._write_report(b'')

    def run(
        self,
        plan: Plan,
        environment: Mapping[str, str],
        log_folder: Path | None,
        log_store: 'LogStore | None',
        about: About,
        attach: str | None,
        owner_of: OwnerOf,
        when_started: Callable[[], None],
        identity: str = '',
        participants: Sequence[Participant] = (),
    ) -> int:
        """
        Run a plan, and return the exit code.

        :param environment: The environment of its processes
        :param log_folder: The folder for the logs, or None to keep none
        :param log_store: The folders of other launches, or None to leave them
          alone
        :param about: What other terminals know the launch by
        :param attach: The label of the process that has the keyboard, if any
        :param owner_of: Tells which package has a missing Python module
        :param when_started: Is called when all processes were started that
          wait for nothing
        :param identity: The identity that the launch has already, if any
        :param participants: What takes part in it beside the engine
        """
        # from here on its time is minded by the launch
        signal.setitimer(signal.ITIMER_REAL, 0)
        self._is_late = False
        self._when_started = when_started
        entries = plan.entries
        self._to_start = {e.label for e in entries if isinstance(e, Process)}
        if not self._to_start:
            when_started()
        from colcon_yamllaunch.run import run
        from colcon_yamllaunch.run import RunContext

        observers: list[Listener] = [self._handle]
        if self._report is not None:
            observers.insert(0, self._report.handle)
        options = self._options
        verbosity: Verbosity = 'verbose' if options.verbose else 'normal'
        stream, color = None, False if options.no_color else None
        if self._background is not None:
            stream = self._background.enter()
            # what it is shown on is a terminal all the same
            color = color if environment.get('NO_COLOR') else color is None
        context = RunContext(
            environment=environment,
            log_folder=log_folder,
            stream=stream,
            color=color,
            tty=options.tty,
            log_limit=options.log_limit,
            log_store=log_store,
            conditions=self._conditions(),
            presentation=Presentation(
                'quiet' if options.quiet else verbosity,
                f'{self._title} - colcon launch',
                self._describe,
                status=not options.no_status,
                watch=options.watch is not None,
                bell=options.watch == WATCH_WITH_BELL,
            ),
            about=about,
            attach=attach,
            owner_of=owner_of,
            parameters_of=_parameters_of,
            identity=identity,
            participants=participants,
        )
        # all that is there now stays, see `LaunchVerb.main`
        gc.freeze()
        gc.enable()
        code = run(plan, context, observers)
        if self._background is not None and self._ended is not None:
            self._background.say(self._ended.summary)
        if self._ended is not None and self._ended.exit_code:
            annotate(failures_of(self._ended), self._environment)
        return code

    def _conditions(self) -> ExitConditions:
        options = self._options
        if options.watch is None:
            return ExitConditions(
                options.until,
                options.timeout,
                options.for_,
                begun=self._started,
            )
        from colcon_yamllaunch.watch.until_checks import UntilChecks

        return UntilChecks(options.until, options.timeout)

    @contextmanager
    def timed(self) -> Iterator[None]:
        """
        End what is done before the launch runs when --timeout is over.

        That is interrupted as by Ctrl-C.

        :raises UserError: when it was
        """
        seconds = self._options.timeout
        if seconds is None or self._options.watch is not None:
            yield
            return

        def end(_number: int, _frame: object) -> None:
            self._is_late = True
            signal.raise_signal(signal.SIGINT)

        before = signal.signal(signal.SIGALRM, end)
        left = self._started + seconds - time.monotonic()
        signal.setitimer(signal.ITIMER_REAL, max(left, 0.001))
        try:
            yield
        except (KeyboardInterrupt, SystemExit):
            if not self._is_late:
                raise
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)
        if self._is_late:
            raise UserError(
                f'--timeout: the launch did not begin within {seconds:g} s'
            )

    @contextmanager
    def reported(self) -> Iterator[None]:
        """Write the report after whatever happens inside."""
        try:
            yield
        finally:
            if self._report is not None:
                seconds = time.monotonic() - self._started
                self._write_report(self._report.document(seconds))

    def _describe(self, process: Process) -> Iterable[str]:
        from colcon_yamllaunch.language.vocabulary import parameter_sections
        from colcon_yamllaunch.plan.plan_text import process_as_text

        return process_as_text(
            process, str(self._cwd), parameter_sections.parameters_of
        )

    def _handle(self, event: Event) -> None:
        if isinstance(event, Ended):
            self._ended = event
        elif self._to_start and isinstance(event, Started | StartFailed):
            self._to_start.discard(event.process.label)
            if not self._to_start:
                self._when_started()

    def _write_report(self, data: bytes) -> None:
        assert self._options.junit is not None
        path = self._cwd / self._options.junit.expanduser()
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        except (OSError, ValueError) as e:
            reason = e.strerror if isinstance(e, OSError) else e
            raise UserError(
                f"--junit: '{path}' cannot be written: {reason}"
            ) from e


def _parameters_of(process: Process) -> Iterable[SetParameter]:
    from colcon_yamllaunch.language.vocabulary import parameter_sections

    # all else waits meanwhile
    return parameter_sections.parameters_of(process, limits.PARAMETERS)


def annotate(
    diagnostics: Iterable[Diagnostic], environment: Mapping[str, str]
) -> None:
    """
    Have GitHub show problems; elsewhere do nothing.

    :param environment: The user's; `GITHUB_ACTIONS` says whether this is a
      workflow, and `GITHUB_WORKSPACE` where the repository is
    """
    if environment.get('GITHUB_ACTIONS') != 'true':
        return
    root = environment.get('GITHUB_WORKSPACE') or os.getcwd()
    for diagnostic in diagnostics:
        position = diagnostic.position
        if position is not None:
            # from an installed launch file to that in the repository
            source = replace(position, path=os.path.realpath(position.path))
            diagnostic = replace(diagnostic, position=source)
        show(annotation(diagnostic, os.path.realpath(root)))


def failures_of(ended: Ended) -> Iterator[Diagnostic]:
    """Return what failed in a launch as problems of its launch files."""
    for failure in ended.failures:
        text = '\n'.join((failure.text, *failure.tail))
        process = failure.process
        position = None if process is None else process.position
        yield Diagnostic('error', text, position)
    for verdict in ended.verdicts:
        if verdict.failure is not None:
            yield Diagnostic('error', verdict.failure)


def read_saved_plan(path: Path, cwd: Path) -> Plan:
    """
    Return the plan that a file has.

    :param path: The file as the user names it, in `cwd`
    :raises UserError: when it has none, or one that cannot be run
    """
    try:
        text = content_of(cwd / path).decode('utf-8')
        plan = plan_from_json(text)
    except (OSError, UnicodeDecodeError, PlanFormatError) as e:
        reason = e.strerror if isinstance(e, OSError) else e
        raise UserError(f"'{path}' has no plan: {reason}") from e
    if plan.left_open:
        raise UserError(
            f"'{path}' cannot be run, as {plan.left_open[0]} was left "
            'open in it: save it with --run-commands'
        )
    position = plan.host_position
    if position is not None:
        place = shown_position(position, str(cwd))
        raise UserError(
            f"'{path}' cannot be run, as what happens while it runs is up "
            f'to Python ({place}): launch that file'
        )
    return plan


#: Makes what changes the plan while it runs, of the launch, its plan and the
#: environment of that.
MakeChanges = Callable[['LaunchFlow', Plan, Mapping[str, str]], 'Participant']


class LaunchFlow(LaunchPreparation):
    """One launch, from its evaluation to its end."""

    def run(
        self, plan_run: PlanRun, changes: MakeChanges | None = None
    ) -> int:
        """
        Do it, and return the exit code.

        :param changes: Makes what changes the plan while it runs
        """
        with locked(self._log_folder), self._workspace.lock:
            try:
                plan, environment = self.prepare()
            except GiveUpError as e:
                return e.returncode
            return self._run(plan, environment, plan_run, changes)

    def variant(
        self,
        arguments: Mapping[str, str],
        log_folder: Path,
        variables: Mapping[str, str],
        *,
        builds: bool = False,
    ) -> 'LaunchFlow':
        """
        Return the same launch with other arguments.

        It has the workspace as it is now, with what is known of it.

        :param log_folder: The folder for its logs
        :param variables: What its environment has, too
        :param builds: Whether it may build, as far as this one may
        """
        options = self._options.replaced(arguments=dict(arguments))
        if not builds:
            options = options.replaced(
                no_build=True,
                build_all=False,
                paths=(),
                force=False,
                why=False,
            )
        other = copy(self)
        other._options = options
        other._log_folder = log_folder
        other._log_dir = str(log_folder)
        other._variables = variables
        other._host = HostKeeper(self.cwd, self._environment, log_folder)
        other._growing = None
        # the runs of a sweep are all here
        other._deployed = None
        other._is_again = True
        other.evaluation, other.wanted = None, set()
        return other

    def run_saved(self, path: Path, plan_run: PlanRun) -> int:
        """
        Run a saved plan in the environment of the workspace.

        :raises UserError: when the file has no plan
        """
        # few plans are saved
        plan = read_saved_plan(path, self.cwd)
        with locked(self._log_folder):
            if self._deployed is not None:
                try:
                    self._deployed.bring_code_of(plan)
                    plan = self._deployed.settled(plan)
                except GiveUpError as e:
                    return e.returncode
            environment = self._process_environment()
            self._warn_of_missing_programs(plan, environment)
            return self._run(plan, environment, plan_run)

    def _run(
        self,
        plan: Plan,
        environment: Mapping[str, str],
        plan_run: PlanRun,
        changes: MakeChanges | None = None,
    ) -> int:
        # one that this waited for may have started them meanwhile
        self._tell_of_doubled_nodes(plan, environment)
        label = None
        if self._options.attach is not None:
            from colcon_yamllaunch.verb.attaching import with_terminal

            plan, label = with_terminal(plan, self._options.attach)
        whole = plan
        participants: list[Participant] = []
        if self._deployed is not None:
            plan, parts = self._deployed.start(
                plan, is_growing=self._growing is not None
            )
            participants.append(parts)
        # who types Ctrl-C once more just when the launch has ended gets its
        # exit code all the same: from here on only the launch takes SIGINT
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        identity, feeds = self.plan_feeds()
        if changes is not None:
            participants.insert(0, changes(self, whole, environment))
        store = None
        if self._log_folder is not None:
            store = log_store_of(self._log_folder, self._environment, say)
        return plan_run.run(
            plan,
            environment,
            self._log_folder,
            store,
            self._about(),
            label,
            lambda module, user: self.locator.undeclared_owner(module, user),
            self._workspace.lock.release,
            identity,
            (*participants, *feeds),
        )

    def plan_feeds(self) -> tuple[str, 'Sequence[Participant]']:
        """
        Return the identity that the launch has already, '' for none.

        And the participant that extends its plan while it runs, if there is
        one. To be called once, when the plan is about to run.
        """
        identity = self._host.identity
        return identity, self._host.feeds(self._growing)


# what few launches need is imported where it is needed
