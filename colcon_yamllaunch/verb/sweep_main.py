# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""`colcon sweep`, from its options to its exit code."""

from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
import shlex
import sys
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import GiveUpError, say, say_line
from colcon_yamllaunch.common.process_scan import need_proc
from colcon_yamllaunch.language.actions.process_actions import OUTPUT_OVERRIDE
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.sweep.local_runner import LocalRunner
from colcon_yamllaunch.sweep.progress import Progress
from colcon_yamllaunch.sweep.reports import refuse_columns_twice, SweepReports
from colcon_yamllaunch.sweep.results import ResultsFolder, SweepDefinition
from colcon_yamllaunch.sweep.run import (
    Goal,
    NotBuiltError,
    PlanError,
    PlannedRun,
    Sweep,
)
from colcon_yamllaunch.sweep.table import read_table, Run, run_table
from colcon_yamllaunch.verb.code_state import CodeState, files_of
from colcon_yamllaunch.verb.context import LaunchContext
from colcon_yamllaunch.verb.log_folders import log_folder_of, ros_log_folder
from colcon_yamllaunch.verb.options import (
    AGAIN_ALL,
    AGAIN_FAILED,
    LaunchOptions,
    SweepOptions,
)
from colcon_yamllaunch.verb.prepare import prepare

#: The folder below that of the logs that has those of sweeps.
_SWEEPS = 'sweeps'
#: Added to the number of a signal in an exit code, as in shells.
_SIGNALLED = 128


def main(
    options: SweepOptions, known: Any, environment: Mapping[str, str]
) -> int:
    """Run a sweep, and return the exit code."""
    need_proc()
    cwd = Path.cwd()
    log_folder = log_folder_of(known, environment)
    definition = _definition(options, cwd)
    # mistakes are found before anything is built or run
    context = LaunchContext(options.as_launch(), cwd, environment, None)
    context.command = 'colcon sweep'
    context.target()
    base = log_folder.parent if log_folder else ros_log_folder(environment)
    path = cwd / (options.results or base / _SWEEPS / definition.default_name)
    with (
        closing(context),
        closing(ResultsFolder(path, definition, say_line)) as folder,
    ):
        logs = log_folder or folder.path / 'log'
        return _run_sweep(options, folder, _Planner(context, options, logs))


def _definition(options: SweepOptions, cwd: Path) -> SweepDefinition:
    """
    Return what the user asks for.

    :raises UserError: when an option or an argument has a mistake
    """
    file = options.table
    table = run_table(
        options.arguments,
        None if file is None else read_table(cwd / file, str(file)),
        options.repeat,
    )
    metrics = {m.name: m.pattern.text for m in options.metric}
    refuse_columns_twice(table.names, metrics)
    goal = {
        **options.fixed,
        'until': tuple(p.text for p in options.until),
        'timeout': options.timeout,
        'for': options.for_,
        'tty': options.tty,
    }
    words = sys.argv[1:]
    if 'sweep' in words:
        # for people
        words = words[words.index('sweep') + 1 :]
    return SweepDefinition(
        shlex.join(['colcon', 'sweep', *words]),
        options.positionals,
        table,
        {
            name: str(value)
            for name, value in goal.items()
            if value not in (None, (), False)
        },
        metrics,
    )


def _run_sweep(
    options: SweepOptions, folder: ResultsFolder, planner: '_Planner'
) -> int:
    """Run the runs that have no result yet, and show a summary."""
    runs = folder.definition.table.runs
    again = [
        number
        for number, result in sorted(folder.results.items())
        if options.again == AGAIN_ALL
        or (options.again == AGAIN_FAILED and not result.succeeded)
    ]
    folder.journal.forget(again)
    for number in again:
        folder.clear(number)
    missing = [run for run in runs if run.number not in folder.results]
    environment = planner.context.environment
    reports = SweepReports(folder)
    progress = Progress(
        sys.stderr,
        folder,
        reports,
        quiet=options.quiet,
        color=not (options.no_color or environment.get('NO_COLOR')),
        code=planner.code.look,
    )
    done = len(runs) - len(missing)
    if not missing:
        say(
            f'all {len(runs):,} runs are done already; to do them '
            'again: --again failed, or --again all'
        )
    elif done:
        say(f'{done:,} of {len(runs):,} runs are done; going on')
    sweep = Sweep(
        Goal(
            options.until,
            options.timeout,
            options.for_,
            options.metric,
            options.log_limit,
            options.tty,
        ),
        folder,
        progress,
        environment,
        planner.plan,
        planner.build,
        options.jobs,
        options.share_network,
    )
    stopped_by = code = None
    try:
        if missing:
            stopped_by = _launch(sweep, options, missing)
    except GiveUpError as e:
        # the error was shown; other runs may have their results
        code = e.returncode
        if not folder.results:
            return code
    finally:
        progress.end()
    reports.write()
    for line in reports.summary(options.require):
        say(line)
    if stopped_by is not None:
        say('the same command goes on from here')
        return _SIGNALLED + stopped_by
    if code is None:
        code = 0 if reports.is_enough(options.require) else 1
    return code


def _launch(
    sweep: Sweep, options: SweepOptions, runs: list[Run]
) -> int | None:
    """Launch runs; return the signal that stopped that, if one did."""
    if options.on is None:
        return LocalRunner(sweep).run(runs)
    # few have a cluster
    from colcon_yamllaunch.sweep.slurm_runner import SlurmClient, SlurmRunner

    name = ' '.join(['colcon sweep', *options.positionals])
    client = SlurmClient(sweep.environment)
    return SlurmRunner(sweep, client, options.on, name).run(runs)


class _Planner:
    """
    Plans runs; the steps that they have in common are done once.

    :param folder: The folder for logs that belong to no run
    """

    def __init__(
        self, context: LaunchContext, options: SweepOptions, folder: Path
    ) -> None:
        self.context = context
        #: The files that the runs use.
        self.code = CodeState(context.environment)
        self._fixed = options.fixed
        self._folder = folder
        # whether to build packages that runs need
        self._may_build = (
            not options.no_build
            and not options.paths
            and context.workspace.root is not None
        )
        self._built: set[str] = set()
        # nobody sees a screen, so all output goes to the logs, unless the user
        # has decided otherwise
        self._variables: Mapping[str, str] = {}
        if not context.workspace.environment.get(OUTPUT_OVERRIDE):
            self._variables = {OUTPUT_OVERRIDE: 'both'}

    def build(self, run: Run) -> None:
        """
        Build the packages that a run needs, and check its plan.

        :raises GiveUpError: when that fails
        :raises UserError: when that fails, too
        """
        context = self.context.variant(self._options(run), self._folder, {})
        context.needs_declarations = True
        with closing(context), context.workspace.lock:
            plan, _ = prepare(context)
        self.code.add(self._uses(context, plan))
        target = context.target()
        if target.package is None:
            # its programs import and read files that are in no package
            self.code.add_tracked(Path(target.path).parent)
        self._built |= context.wanted

    def plan(
        self, run: Run, folder: Path, variables: Mapping[str, str]
    ) -> PlannedRun:
        """
        Plan a run; see :class:`.run.Sweep`.

        :raises NotBuiltError: when packages are to be built first
        :raises PlanError: when it cannot be planned
        """
        options = self._options(run).replaced(
            no_build=True, build_all=False, paths=(), force=False, why=False
        )
        context = self.context.variant(
            options, folder, {**self._variables, **variables}
        )
        try:
            try:
                plan, environment = prepare(context)
            finally:
                if self._may_build and not context.wanted <= self._built:
                    raise NotBuiltError
        except (NotBuiltError, UserError, GiveUpError) as e:
            context.close()
            if isinstance(e, GiveUpError):
                raise PlanError from e
            raise
        identity, feeds = context.plan_feeds()
        uses = self.code.missing(self._uses(context, plan))
        self.code.add(uses)
        return PlannedRun(
            plan,
            environment,
            identity,
            feeds,
            context.locator.undeclared_owner,
            tuple(uses),
            context.close,
        )

    def _options(self, run: Run) -> LaunchOptions:
        arguments = {**run.arguments, **self._fixed}
        return self.context.options.replaced(arguments=arguments)

    def _uses(self, context: LaunchContext, plan: Plan) -> set[str]:
        """Return the files, and the folders of packages, that a run uses."""
        if context.evaluation is None:
            return set()
        files = files_of(plan, context.evaluation)
        if not context.wanted <= self._built:
            needed = context.workspace.needed_by(context.wanted)
            packages = context.workspace.packages
            files |= {str(p.path) for p in packages if p.name in needed}
        return files
