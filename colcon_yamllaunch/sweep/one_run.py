# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""One run of a sweep, from its plan to its result."""

from collections.abc import Callable
from collections.abc import Mapping
import os
from pathlib import Path
import resource
import time

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.output.line_pattern import LinePattern
from colcon_yamllaunch.engine.plan_source import PlanSource
from colcon_yamllaunch.observers.failures import OwnerOf
from colcon_yamllaunch.observers.presentation import Presentation
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.run_plan import run_plan
from colcon_yamllaunch.sweep.forked_guard import ForkedGuards
from colcon_yamllaunch.sweep.run_metrics import Metric
from colcon_yamllaunch.sweep.run_metrics import MetricSearch
from colcon_yamllaunch.sweep.run_result import one_reason
from colcon_yamllaunch.sweep.run_result import RunResult

_FAILED = 'failed: '


@dataclass(frozen=True, slots=True)
class Goal:
    """
    What each run is to achieve, and what is measured; as of `colcon launch`.

    :param log_limit: Bytes that the logs of a run may take, or None
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
    :param identity: The identity that its launch has already, if any
    :param source: Where more plan comes from while it runs, if anywhere
    :param owner_of: Tells which package has a Python module that is missing
    :param uses: Files that it uses and that other runs did not use yet
    """

    plan: Plan
    environment: Mapping[str, str]
    identity: str = ''
    source: PlanSource | None = None
    owner_of: OwnerOf = lambda _module, _package: None
    uses: tuple[str, ...] = ()


class _Turn(ExitConditions):
    """
    What ends a run, whose launch waits until it is its turn.

    :param wait: Returns when that is
    :param over: Is called when nothing of it runs any more
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
        """Wait, and count the time from then on."""
        self._wait()
        self.begun = time.monotonic()
        super().begin()

    def end(self) -> None:
        """Let another one have its turn; what follows is bookkeeping."""
        super().end()
        self._over()


def perform(
    number: int,
    planned: PlannedRun,
    folder: Path,
    goal: Goal,
    guards: ForkedGuards,
    wait: Callable[[], object] = bool,
    over: Callable[[], object] = bool,
) -> RunResult | None:
    """
    Do a run, and return what came of it, None if it was interrupted.

    :param number: Its number
    :param folder: Where its logs go
    :param guards: Has guarded other launches of this process, and guards it
    :param wait: Returns when its processes may be started; all else is done
      before that
    :param over: Is called when nothing of it runs any more, before all else
      is done that is to be done then
    """
    before = _processor_time()
    listener = _Listener()
    search = MetricSearch(goal.metrics)
    turn = _Turn(goal, wait, over)
    with open(os.devnull, 'w', encoding='utf-8') as nothing:
        try:
            code = run_plan(
                planned.plan,
                environment=planned.environment,
                log_folder=folder,
                stream=nothing,
                tty=goal.tty,
                log_limit=goal.log_limit,
                conditions=turn,
                presentation=Presentation('quiet'),
                observers=(listener.handle, search.handle),
                owner_of=planned.owner_of,
                identity=planned.identity,
                source=planned.source,
                guards=guards,
            )
        except UserError as e:
            # what the environment lacks; nothing was started
            return RunResult(number, 'error', one_reason(str(e)))
    seconds = time.monotonic() - turn.begun
    if listener.interrupted:
        return None
    return RunResult(
        number,
        'failed' if code else 'succeeded',
        listener.reason if code else '',
        round(seconds, 3),
        search.found,
        round(_processor_time() - before, 4),
    )


def _processor_time() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


class _Listener:
    """Takes note of how a launch ends."""

    def __init__(self) -> None:
        self.reason = 'its launch ended with an error'
        #: Whether a signal stopped it.
        self.interrupted = False

    def handle(self, event: events.Event) -> None:
        match event:
            case events.ShuttingDown():
                is_signal = event.reason.endswith(' received')
                self.interrupted = event.interactive or is_signal
            case events.Ended():
                for line in event.summary:
                    if line.startswith(_FAILED):
                        self.reason = one_reason(line.removeprefix(_FAILED))
                        break
            case _:
                return
