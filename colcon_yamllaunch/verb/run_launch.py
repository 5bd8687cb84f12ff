# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""From a launch context to a running launch, and to its exit code."""

from collections.abc import Iterable, Iterator, Mapping
import gc
from pathlib import Path
import signal
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import say
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.cgroup import is_wanted, make_ready
from colcon_yamllaunch.engine.events import Ended, Event, Started, StartFailed
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.observers.presentation import Presentation
from colcon_yamllaunch.plan.plan import Plan, Process, SetParameter
from colcon_yamllaunch.verb.context import LaunchContext
from colcon_yamllaunch.verb.log_folders import locked, log_store_of
from colcon_yamllaunch.verb.options import WATCH_WITH_BELL
from colcon_yamllaunch.verb.prepare import (
    check_limits,
    prepare,
    warn_of_doubled_nodes,
    warn_of_missing_programs,
)
from colcon_yamllaunch.workspace.building.build_lock import WorkspaceLock

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.participants import Participant
    from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic
    from colcon_yamllaunch.observers.log_store import LogStore
    from colcon_yamllaunch.watch.change_loop import ChangeLoop

# what few launches need is imported where it is needed


def launch(context: LaunchContext) -> 'tuple[int, ChangeLoop | None]':
    """
    Prepare a launch and run it; return the exit code, and what watched files.

    :raises UserError: when there can be no launch
    """
    with locked(context.log_folder), context.workspace.lock:
        if context.options.from_plan is None:
            return _run(context, *prepare(context))
        plan = saved_plan(context.options.from_plan, context.cwd)
        if context.machines is not None:
            context.machines.begin_sync(plan)
            plan = context.machines.finish_sync(plan)
        environment = context.process_environment()
        warn_of_missing_programs(context, plan, environment)
        return _run(context, plan, environment)


def saved_plan(path: Path, cwd: Path) -> Plan:
    """
    Return the plan that a file has.

    :param path: The file as the user names it, in `cwd`
    :raises UserError: when it has none, or one that cannot be run
    """
    # few plans are saved
    from colcon_yamllaunch.common.files import content_of
    from colcon_yamllaunch.plan.plan_json import (
        plan_from_json,
        PlanFormatError,
    )
    from colcon_yamllaunch.plan.position import shown_position

    try:
        plan = plan_from_json(content_of(cwd / path).decode('utf-8'))
    except (OSError, UnicodeDecodeError, PlanFormatError) as e:
        reason = e.strerror if isinstance(e, OSError) else e
        raise UserError(f"'{path}' has no plan: {reason}") from e
    if plan.left_open:
        raise UserError(
            f"'{path}' cannot be run, as {plan.left_open[0]} was left "
            'open in it: save it with --run-commands'
        )
    position = plan.worker_position
    if position is not None:
        place = shown_position(position, str(cwd))
        raise UserError(
            f"'{path}' cannot be run, as what happens while it runs is up "
            f'to Python ({place}): launch that file'
        )
    return plan


def _run(
    context: LaunchContext, plan: Plan, environment: Mapping[str, str]
) -> 'tuple[int, ChangeLoop | None]':
    """Run a plan that is prepared."""
    check_limits(context, plan)
    # an error of the launch file needs nothing of this
    if is_wanted(environment):
        make_ready()
    from colcon_yamllaunch.run import run, RunContext

    options = context.options
    # one that this waited for may have started them meanwhile
    warn_of_doubled_nodes(context, plan, environment)
    attached = None
    if options.attach is not None:
        from colcon_yamllaunch.terminal.attachment import with_terminal

        plan, attached = with_terminal(plan, options.attach)
    whole = plan
    participants: list[Participant] = []
    if context.machines is not None:
        growing = context.evaluation and context.evaluation.growing
        plan, parts = context.machines.start(plan, is_growing=bool(growing))
        participants.append(parts)
    participants += _readiness(context, whole)
    service = None
    if environment.get('NOTIFY_SOCKET'):
        from colcon_yamllaunch.service.running import RunningService

        service = RunningService(whole, environment)
        participants += service.participants
        environment = service.environment_of(environment)
    # from here on the launch itself counts its time
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    # who types Ctrl-C once more just when the launch has ended gets its exit
    # code all the same: from here on only the launch takes SIGINT
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    identity, feeds = context.plan_feeds()
    changes = None
    if options.watch is not None:
        from colcon_yamllaunch.verb.watch_launch import change_loop

        changes = change_loop(context, whole, environment)
        participants.insert(0, changes)
    observer = _Observer(plan, context.workspace.lock)
    observers = [observer.handle]
    if context.junit is not None:
        observers.insert(0, context.junit.handle)
    stream, color = None, False if options.no_color else None
    if service is not None:
        stream = service.stream
    if context.background is not None:
        stream = context.background.enter()
        # what it is shown on is a terminal all the same
        color = color if environment.get('NO_COLOR') else color is None
    run_context = RunContext(
        environment=environment,
        log_folder=context.log_folder,
        stream=stream,
        color=color,
        tty=options.tty,
        log_limit=options.log_limit,
        log_store=_log_store(context),
        conditions=_conditions(context, whole),
        presentation=_presentation(context),
        about=context.about(),
        attach=attached,
        owner_of=context.locator.undeclared_owner,
        parameters_of=_parameters_of,
        identity=identity,
        participants=(*participants, *feeds),
    )
    # all that is there now stays, see `launch_main.main`
    gc.freeze()
    gc.enable()
    code = run(plan, run_context, observers)
    ended = observer.ended
    if ended is not None and context.background is not None:
        # it is shown after the user has left
        for line in ended.summary:
            say(line)
    if ended is not None and ended.exit_code:
        context.annotate(_failures_of(ended))
    return code, changes


def _readiness(context: LaunchContext, whole: Plan) -> 'list[Participant]':
    """Return what finds out which members are ready, if that matters."""
    until_ready = context.options.until_ready
    # a saved plan may have settings, too
    has_settings = any(m.settings is not None for m in whole.members())
    # and what a launch file in Python starts later
    deployment = context.deployment if context.evaluation else None
    may_grow = context.evaluation and context.evaluation.growing
    comes_later = bool(may_grow and deployment and deployment.has_settings)
    if not (has_settings or comes_later or until_ready):
        return []
    from colcon_yamllaunch.engine.readiness import needs_readiness, Readiness
    from colcon_yamllaunch.plan.start_order import dependencies_of

    if not (until_ready or comes_later or needs_readiness(whole)):
        return []
    return [Readiness(dependencies_of(whole.members()))]


def _log_store(context: LaunchContext) -> 'LogStore | None':
    """Return the log folders of earlier launches, if this one keeps logs."""
    if context.log_folder is None:
        return None
    return log_store_of(context.log_folder, context.environment, say)


class _Observer:
    """
    Keeps how a launch ended, and lets other launches build in time.

    :param plan: What runs here
    :param lock: The lock of the workspace, which is released when all
      processes were started that wait for nothing
    """

    def __init__(self, plan: Plan, lock: WorkspaceLock) -> None:
        self.ended: Ended | None = None
        self._lock = lock
        entries = plan.entries
        self._to_start = {e.label for e in entries if isinstance(e, Process)}
        if not self._to_start:
            lock.release()

    def handle(self, event: Event) -> None:
        if isinstance(event, Ended):
            self.ended = event
        elif self._to_start and isinstance(event, Started | StartFailed):
            self._to_start.discard(event.process.label)
            if not self._to_start:
                self._lock.release()


def _conditions(context: LaunchContext, plan: Plan) -> ExitConditions:
    """
    Return what ends the launch by itself.

    :param plan: What runs here and on other machines
    """
    options = context.options
    if options.watch is None:
        ready = None
        if options.until_ready:
            ready = [
                member.label
                for member in plan.members()
                if member.settings is None or not member.settings.optional
            ]
        return ExitConditions(
            options.until,
            options.timeout,
            options.for_,
            begun=context.begun,
            ready=ready,
        )
    from colcon_yamllaunch.watch.until_checks import UntilChecks

    return UntilChecks(options.until, options.timeout)


def _presentation(context: LaunchContext) -> Presentation:
    options = context.options

    def describe(process: Process) -> Iterable[str]:
        from colcon_yamllaunch.language.actions import parameter_files
        from colcon_yamllaunch.plan.plan_text import process_as_text

        return process_as_text(
            process, str(context.cwd), parameter_files.parameters_of
        )

    return Presentation(
        'quiet'
        if options.quiet
        else 'verbose'
        if options.verbose
        else 'normal',
        f'{options.title} - colcon launch',
        describe,
        status=not options.no_status,
        watch=options.watch is not None,
        bell=options.watch == WATCH_WITH_BELL,
    )


def _parameters_of(process: Process) -> Iterable[SetParameter]:
    from colcon_yamllaunch.language.actions import parameter_files

    # all else waits meanwhile
    return parameter_files.parameters_of(process, limits.PARAMETER_FILE_BYTES)


def _failures_of(ended: Ended) -> 'Iterator[Diagnostic]':
    """Return what failed in a launch as problems of its launch files."""
    from colcon_yamllaunch.language.syntax.diagnostics import Diagnostic

    for failure in ended.failures:
        text = '\n'.join((failure.text, *failure.tail))
        member = failure.member
        position = None if member is None else member.position
        yield Diagnostic('error', text, position)
    for verdict in ended.verdicts:
        if verdict.failure is not None:
            yield Diagnostic('error', verdict.failure)
