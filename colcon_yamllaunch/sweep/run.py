# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One run of a sweep, from its plan to its result."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
import os
from pathlib import Path
import re
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.guard_link import GuardProcess
from colcon_yamllaunch.engine.line_pattern import LinePattern, SearchTimeError
from colcon_yamllaunch.engine.lines import bare
from colcon_yamllaunch.engine.loop import do_nothing
from colcon_yamllaunch.engine.participants import Participant
from colcon_yamllaunch.observers.failures import OwnerOf
from colcon_yamllaunch.observers.presentation import Presentation
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.run import run, RunContext
from colcon_yamllaunch.sweep.progress import Progress
from colcon_yamllaunch.sweep.results import (
    failed_run,
    one_reason,
    ResultsFolder,
    RunResult,
)
from colcon_yamllaunch.sweep.table import Run

#: Characters of the value of a metric that are kept.
_LONGEST_VALUE = 200
_NAME = re.compile(r'[^\W\d][\w ./%()-]*')


@dataclass(frozen=True, slots=True)
class Metric:
    """
    A value to find in the output of processes.

    :param pattern: Its first group is the value
    """

    name: str
    pattern: LinePattern


@dataclass(frozen=True, slots=True)
class Goal:
    """
    The conditions and options that all runs of a sweep share.

    :param until: Expressions that are to be found in output
    :param timeout: Seconds for that, or for the launch to end
    :param for_: Seconds that the launch goes on for after that
    :param log_limit: Bytes of logs of a run, None for any number
    :param tty: Whether each process gets a terminal
    """

    until: tuple[LinePattern, ...] = ()
    timeout: float | None = None
    for_: float | None = None
    metrics: tuple[Metric, ...] = ()
    log_limit: int | None = None
    tty: bool = False


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """
    A run that can begin.

    :param environment: The environment of its processes
    :param identity: The identity of its launch if it has one already
    :param participants: What takes part in its launch beside the engine
    :param owner_of: Returns the package that has a missing Python module
    :param uses: Files that it uses and that other runs did not use yet
    :param close: Ends the helpers of the plan
    """

    plan: Plan
    environment: Mapping[str, str]
    identity: str = ''
    participants: Sequence[Participant] = ()
    owner_of: OwnerOf = lambda _module, _package: None
    uses: tuple[str, ...] = ()
    close: Callable[[], object] = do_nothing


class NotBuiltError(Exception):
    """A run needs packages that are to be built first."""


class PlanError(Exception):
    """A run cannot be planned; the errors were printed."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """
    Everything that runners need.

    :param progress: Receives events and results
    :param environment: The user's environment
    :param plan: Plans a run; gets the folder for its logs, and variables to
      add to its environment. Raises :class:`NotBuiltError`,
      :class:`PlanError` or :class:`UserError`
    :param build: Builds the packages that a run needs, while nothing runs
    :param jobs: How many runs go on at a time, None for the default
    :param share_network: Whether runs stay in the network of the machine
    """

    goal: Goal
    folder: ResultsFolder
    progress: Progress
    environment: Mapping[str, str]
    plan: Callable[[Run, Path, Mapping[str, str]], PlannedRun]
    build: Callable[[Run], object]
    jobs: int | None = None
    share_network: bool = False


def plan_failure(error: Exception, messages: str) -> str:
    """
    Return why a run cannot be planned, in one line.

    :param error: What :attr:`Sweep.plan` has raised
    :param messages: What was printed meanwhile
    """
    lines = [line for line in messages.splitlines() if line.strip()]
    errors = [line for line in lines if 'error: ' in line]
    return next(
        filter(None, [str(error), *errors, *lines]), 'it cannot be planned'
    )


def read_metric(option: str, text: str) -> Metric:
    """
    Parse a metric, which is written `name=regex`.

    :param option: The option that has it, for errors
    :raises UserError: when it is none
    """
    name, is_given, expression = text.partition('=')
    name = name.strip()
    if not is_given or not expression:
        raise UserError(
            f"{option} is written name=REGEX, not '{text}'",
            r"such as 'distance=drove ([\d.]+) m'",
        )
    if not _NAME.fullmatch(name):
        raise UserError(
            f"{option}: '{name}' is no name of a metric",
            'it begins with a letter',
        )
    try:
        pattern = LinePattern(expression)
    except (re.error, OverflowError, RecursionError) as e:
        raise UserError(
            f"{option}: '{expression}' is no regular expression: {e}"
        ) from e
    if not pattern.groups:
        raise UserError(
            f"{option}: '{expression}' has no group, so nothing says which "
            'part of the line is the value',
            r"put that in brackets, as in 'drove ([\d.]+) m'",
        )
    return Metric(name, pattern)


class _Conditions(ExitConditions):
    """
    The exit conditions of a run that waits for its turn.

    :param wait: Blocks until the run may start processes
    :param over: Called when none of its processes run any more
    """

    def __init__(
        self,
        goal: Goal,
        wait: Callable[[], object],
        over: Callable[[], object],
    ) -> None:
        super().__init__(goal.until, goal.timeout, goal.for_)
        self._wait = wait
        self._over = over
        self.begun = time.monotonic()

    def begin(self) -> None:
        """Wait; the time counts from then on."""
        self._wait()
        self.begun = time.monotonic()
        super().begin()

    def end(self) -> None:
        """Allow another run to start; only bookkeeping follows."""
        super().end()
        self._over()


class RunObserver:
    """
    Collects the metrics of a launch and the reason of its failure.

    :param metrics: The last line that matches one counts
    """

    def __init__(self, metrics: Iterable[Metric]) -> None:
        self._metrics = tuple(metrics)
        #: The values that were found, by the names of their metrics.
        self.found: dict[str, str] = {}
        self.reason = 'its launch ended with an error'
        #: Whether a signal stopped it.
        self.interrupted = False

    def handle(self, event: events.Event) -> None:
        """Receive an event."""
        match event:
            case events.Output():
                if self._metrics:
                    self._search(bare(event.data))
            case events.ShuttingDown():
                self.interrupted = event.interactive or event.by_signal
            case events.Ended():
                if event.reason:
                    self.reason = one_reason(event.reason)
            case _:
                return

    def _search(self, lines: str) -> None:
        for metric in self._metrics:
            # a line that takes too long has no value
            with suppress(SearchTimeError):
                value = metric.pattern.last_group(lines)
                if value is not None:
                    self.found[metric.name] = value[:_LONGEST_VALUE]


def perform(
    number: int,
    planned: PlannedRun,
    folder: Path,
    goal: Goal,
    guard: GuardProcess | None = None,
    wait: Callable[[], object] = do_nothing,
    over: Callable[[], object] = do_nothing,
) -> RunResult | None:
    """
    Launch a run, and return its result, None if it was interrupted.

    :param folder: The folder for its logs
    :param guard: Its guard, by default one for this run alone
    :param wait: Blocks until its processes may be started; all else is
      prepared before that
    :param over: Called when none of its processes run any more, before the
      launch is closed
    """
    observer = RunObserver(goal.metrics)
    conditions = _Conditions(goal, wait, over)
    with open(os.devnull, 'w', encoding='utf-8') as nothing:
        try:
            context = RunContext(
                environment=planned.environment,
                log_folder=folder,
                stream=nothing,
                tty=goal.tty,
                log_limit=goal.log_limit,
                conditions=conditions,
                presentation=Presentation('quiet'),
                owner_of=planned.owner_of,
                identity=planned.identity,
                participants=planned.participants,
                guard=guard,
            )
            code = run(planned.plan, context, (observer.handle,))
        except UserError as e:
            # the environment lacks something; nothing was started
            return failed_run(number, str(e))
    if observer.interrupted:
        return None
    return RunResult(
        number,
        'failed' if code else 'succeeded',
        observer.reason if code else '',
        round(time.monotonic() - conditions.begun, 3),
        observer.found,
    )
