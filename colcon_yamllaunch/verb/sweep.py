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
from colcon_yamllaunch.common.process_scan import need_proc
from colcon_yamllaunch.language.actions.process_actions import OUTPUT_OVERRIDE
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.sweep.local_runner import LocalRunner
from colcon_yamllaunch.sweep.progress import Progress
from colcon_yamllaunch.sweep.reports import refuse_columns_twice
from colcon_yamllaunch.sweep.reports import SweepReports
from colcon_yamllaunch.sweep.results import ResultsFolder
from colcon_yamllaunch.sweep.results import RunResult
from colcon_yamllaunch.sweep.results import SweepDefinition
from colcon_yamllaunch.sweep.run import Goal
from colcon_yamllaunch.sweep.run import NotBuiltError
from colcon_yamllaunch.sweep.run import PlanError
from colcon_yamllaunch.sweep.run import PlannedRun
from colcon_yamllaunch.sweep.run import Sweep
from colcon_yamllaunch.sweep.table import read_table
from colcon_yamllaunch.sweep.table import Run
from colcon_yamllaunch.sweep.table import run_table
from colcon_yamllaunch.verb.code_state import CodeState
from colcon_yamllaunch.verb.code_state import files_of
from colcon_yamllaunch.verb.command_line import asks_for_help
from colcon_yamllaunch.verb.command_line import parse_sweep_options
from colcon_yamllaunch.verb.command_line import show_help
from colcon_yamllaunch.verb.context import GiveUpError
from colcon_yamllaunch.verb.log_folders import log_folder_of
from colcon_yamllaunch.verb.log_folders import ros_log_folder
from colcon_yamllaunch.verb.messages import say
from colcon_yamllaunch.verb.messages import say_line
from colcon_yamllaunch.verb.messages import show_versions
from colcon_yamllaunch.verb.options import AGAIN_ALL
from colcon_yamllaunch.verb.options import AGAIN_FAILED
from colcon_yamllaunch.verb.options import SweepOptions
from colcon_yamllaunch.verb.run_launch import LaunchFlow

#: The folder below that of the logs that has those of sweeps.
_SWEEPS = 'sweeps'
#: Added to the number of a signal in an exit code, as in shells.
_SIGNALLED = 128


def main(known: Any, environment: Mapping[str, str]) -> int:
    """Run a sweep, and return the exit code."""
    if asks_for_help(known.positionals):
        return show_help(known.verb_parser, 'sweep')
    options = parse_sweep_options(known)
    if options.version:
        return show_versions()
    need_proc()
    return SweepFlow(options, known, environment).run()


class SweepFlow:
    """
    One sweep.

    :param known: What colcon has made of the command line
    """

    def __init__(
        self,
        options: SweepOptions,
        known: Any,
        environment: Mapping[str, str],
    ) -> None:
        self._options = options
        self._environment = environment
        self._cwd = Path.cwd()
        self._code = CodeState(environment)
        self._log_folder = log_folder_of(known, environment)

    def run(self) -> int:
        """
        Run the sweep, and return the exit code.

        :raises UserError: when an option or an argument has a mistake
        """
        options = self._options
        file = options.table
        table = run_table(
            options.arguments,
            None if file is None else read_table(self._cwd / file, str(file)),
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
        definition = SweepDefinition(
            shlex.join(['colcon', 'sweep', *_words()]),
            options.positionals,
            table,
            {
                name: str(value)
                for name, value in goal.items()
                if value not in (None, (), False)
            },
            metrics,
        )
        # mistakes are found before anything is built or run
        flow = LaunchFlow(
            options.as_launch(), self._cwd, self._environment, None
        )
        flow.command = 'colcon sweep'
        flow.target()
        path = self._results_path(definition)
        with (
            closing(flow),
            closing(ResultsFolder(path, definition, say_line)) as folder,
        ):
            return self._go_on(flow, folder)

    def _results_path(self, definition: SweepDefinition) -> Path:
        if self._options.results is not None:
            return self._cwd / self._options.results
        logs = self._log_folder
        base = ros_log_folder(self._environment)
        if logs is not None:
            base = logs.parent
        return base / _SWEEPS / definition.default_name

    def _go_on(self, flow: LaunchFlow, folder: ResultsFolder) -> int:
        """Run the runs that have no result yet, and show a summary."""
        options, runs = self._options, folder.definition.table.runs
        again = self._again(folder.results)
        folder.journal.forget(again)
        for number in again:
            folder.clear(number)
        missing = [run for run in runs if run.number not in folder.results]
        reports = SweepReports(folder)
        progress = Progress(
            sys.stderr,
            folder,
            reports,
            quiet=options.quiet,
            color=not (options.no_color or self._environment.get('NO_COLOR')),
            code=self._code.look,
        )
        done = len(runs) - len(missing)
        if not missing:
            say(
                f'all {len(runs):,} runs are done already; to do them '
                'again: --again failed, or --again all'
            )
        elif done:
            say(f'{done:,} of {len(runs):,} runs are done; going on')
        stopped_by = code = None
        try:
            if missing:
                stopped_by = self._launch(flow, folder, missing, progress)
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

    def _again(self, results: Mapping[int, RunResult]) -> list[int]:
        """Return the runs with a result that are to run again."""
        match self._options.again:
            case str(again) if again == AGAIN_ALL:
                return sorted(results)
            case str(again) if again == AGAIN_FAILED:
                return [n for n, r in results.items() if not r.succeeded]
            case _:
                return []

    def _launch(
        self,
        flow: LaunchFlow,
        folder: ResultsFolder,
        runs: list[Run],
        progress: Progress,
    ) -> int | None:
        """Launch runs; return the signal that stopped that, if one did."""
        options = self._options
        may_build = (
            not options.no_build
            and not options.paths
            and flow.workspace.root is not None
        )
        planner = _Planner(
            flow,
            options.fixed,
            self._log_folder or folder.path / 'log',
            self._code,
            may_build=may_build,
        )
        goal = Goal(
            options.until,
            options.timeout,
            options.for_,
            options.metric,
            options.log_limit,
            options.tty,
        )
        sweep = Sweep(
            goal,
            folder,
            progress,
            self._environment,
            planner.plan,
            planner.build,
            options.jobs,
            options.share_network,
        )
        if options.on is None:
            return LocalRunner(sweep).run(runs)
        # few have a cluster
        from colcon_yamllaunch.sweep.slurm_client import SlurmClient
        from colcon_yamllaunch.sweep.slurm_runner import SlurmRunner

        name = ' '.join(['colcon sweep', *options.positionals])
        client = SlurmClient(self._environment)
        return SlurmRunner(sweep, client, options.on, name).run(runs)


class _Planner:
    """
    Plans runs; the steps that they have in common are done once.

    :param flow: The launch
    :param fixed: Launch arguments of all runs, beside their own
    :param folder: The folder for logs that belong to no run
    :param code: Receives the files that the runs use
    :param may_build: Whether to build packages that runs need
    """

    def __init__(
        self,
        flow: LaunchFlow,
        fixed: Mapping[str, str],
        folder: Path,
        code: CodeState,
        *,
        may_build: bool,
    ) -> None:
        self._flow = flow
        self._fixed = fixed
        self._folder = folder
        self._code = code
        self._may_build = may_build
        self._built: set[str] = set()
        # nobody sees a screen, so all output goes to the logs, unless the user
        # has decided otherwise
        self._variables: Mapping[str, str] = {}
        if not flow.workspace.environment.get(OUTPUT_OVERRIDE):
            self._variables = {OUTPUT_OVERRIDE: 'both'}

    def build(self, run: Run) -> None:
        """
        Build the packages that a run needs, and check its plan.

        :raises GiveUpError: when that fails
        :raises UserError: when that fails, too
        """
        flow = self._flow.variant(
            {**run.arguments, **self._fixed}, self._folder, {}, builds=True
        )
        flow.needs_declarations = True
        try:
            with flow.workspace.lock:
                plan, _ = flow.prepare()
        finally:
            flow.close()
        self._code.add(self._uses(flow, plan))
        target = flow.target()
        if target.package is None:
            # its programs import and read files that are in no package
            self._code.add_tracked(Path(target.path).parent)
        self._built |= flow.wanted

    def _uses(self, flow: LaunchFlow, plan: Plan) -> set[str]:
        """Return the files, and the folders of packages, that a run uses."""
        if flow.evaluation is None:
            return set()
        files = files_of(plan, flow.evaluation)
        if not flow.wanted <= self._built:
            needed = flow.workspace.needed_by(flow.wanted)
            packages = flow.workspace.packages
            files |= {str(p.path) for p in packages if p.name in needed}
        return files

    def plan(
        self, run: Run, folder: Path, variables: Mapping[str, str]
    ) -> PlannedRun:
        """
        Plan a run; see :class:`.run.Sweep`.

        :raises NotBuiltError: when packages are to be built first
        :raises PlanError: when it cannot be planned
        """
        flow = self._flow.variant(
            {**run.arguments, **self._fixed},
            folder,
            {**self._variables, **variables},
        )
        try:
            try:
                plan, environment = flow.prepare()
            finally:
                if self._may_build and not flow.wanted <= self._built:
                    raise NotBuiltError
        except GiveUpError as e:
            flow.close()
            raise PlanError from e
        except UserError:
            flow.close()
            raise
        identity, feeds = flow.plan_feeds()
        uses = self._code.missing(self._uses(flow, plan))
        self._code.add(uses)
        locator = flow.locator
        return PlannedRun(
            plan,
            environment,
            identity,
            feeds,
            lambda module, user: locator.undeclared_owner(module, user),
            tuple(uses),
            flow.close,
        )


def _words() -> list[str]:
    """Return the command line behind the verb, for people."""
    words = sys.argv[1:]
    return words[words.index('sweep') + 1 :] if 'sweep' in words else words
