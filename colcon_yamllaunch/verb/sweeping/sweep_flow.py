# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `colcon sweep` does, step by step."""

from collections.abc import Mapping
from contextlib import closing
import os
from pathlib import Path
import shlex
import sys

from colcon_yamllaunch.sweep.domain_ids import DomainIds
from colcon_yamllaunch.sweep.isolation import reason_for_no_network
from colcon_yamllaunch.sweep.local_runner import LocalRunner
from colcon_yamllaunch.sweep.local_runner import Settings
from colcon_yamllaunch.sweep.progress import Progress
from colcon_yamllaunch.sweep.reports import refuse_columns_twice
from colcon_yamllaunch.sweep.reports import SweepReports
from colcon_yamllaunch.sweep.results import JOURNAL
from colcon_yamllaunch.sweep.results import ResultsFolder
from colcon_yamllaunch.sweep.results import SweepDefinition
from colcon_yamllaunch.sweep.results import SweepJournal
from colcon_yamllaunch.sweep.run import Goal
from colcon_yamllaunch.sweep.table import read_table
from colcon_yamllaunch.sweep.table import Run
from colcon_yamllaunch.sweep.table import run_table
from colcon_yamllaunch.sweep.table import RunTable
from colcon_yamllaunch.verb.cli.messages import say
from colcon_yamllaunch.verb.cli.messages import say_line
from colcon_yamllaunch.verb.cli.option_table import AGAIN_ALL
from colcon_yamllaunch.verb.cli.option_table import AGAIN_FAILED
from colcon_yamllaunch.verb.cli.sweep_options import SweepOptions
from colcon_yamllaunch.verb.launching.launch_flow import LaunchFlow
from colcon_yamllaunch.verb.launching.log_folders import log_folder_of
from colcon_yamllaunch.verb.launching.log_folders import ros_log_folder
from colcon_yamllaunch.verb.launching.steps.launch_basis import GiveUpError
from colcon_yamllaunch.verb.sweeping.code_state import CodeState
from colcon_yamllaunch.verb.sweeping.launch_variants import LaunchVariants

#: The folder below that of the logs that has those of sweeps.
_SWEEPS = 'sweeps'
#: What an exit code has more than the signal that it tells, as in shells.
_SIGNALLED = 128


class SweepFlow:
    """
    One sweep.

    :param log_base: What colcon was told about the folder for logs
    """

    def __init__(
        self,
        options: SweepOptions,
        log_base: str | None,
        environment: Mapping[str, str],
    ) -> None:
        self._options = options
        self._environment = environment
        self._cwd = Path.cwd()
        self._code = CodeState(environment)
        self._log_folder = log_folder_of(log_base, environment)

    def run(self) -> int:
        """
        Do it, and return the exit code.

        :raises UserError: when something of what the user wants is a mistake
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
        # what builds nothing and runs nothing finds mistakes first
        flow = LaunchFlow(
            options.as_launch(), self._cwd, self._environment, None
        )
        flow.command = 'colcon sweep'
        flow.target()
        folder = ResultsFolder(self._results_path(definition))
        folder.open(definition, say_line)
        with (
            closing(flow),
            closing(folder),
            closing(SweepJournal(folder.path / JOURNAL)) as journal,
        ):
            return self._go_on(flow, definition, folder, journal)

    def _results_path(self, definition: SweepDefinition) -> Path:
        if self._options.results is not None:
            return self._cwd / self._options.results
        logs = self._log_folder
        base = ros_log_folder(self._environment)
        if logs is not None:
            base = logs.parent
        return base / _SWEEPS / definition.default_name

    def _go_on(
        self,
        flow: LaunchFlow,
        definition: SweepDefinition,
        folder: ResultsFolder,
        journal: SweepJournal,
    ) -> int:
        """Do what is not done yet, and tell how it went."""
        options, table = self._options, definition.table
        again = self._again(table, journal)
        journal.forget(again)
        for number in again:
            folder.clear(number)
        missing = [r for r in table.runs if r.number not in journal.results]
        reports = SweepReports(definition, folder, journal.results)
        progress = Progress(
            sys.stderr,
            table,
            journal,
            folder,
            reports,
            quiet=options.quiet,
            color=not (options.no_color or self._environment.get('NO_COLOR')),
            code=self._code.look,
        )
        done = len(table.runs) - len(missing)
        if not missing:
            say(
                f'all {len(table.runs):,} runs are done already; to do them '
                'again: --again failed, or --again all'
            )
        elif done:
            say(f'{done:,} of {len(table.runs):,} runs are done; going on')
        stopped_by = None
        if missing:
            try:
                stopped_by = self._do(flow, folder, missing, progress)
            except GiveUpError as e:
                progress.end()
                if journal.results:
                    # what is done is done; why it ends was said
                    reports.write()
                    for line in reports.summary(options.require):
                        say(line)
                return e.returncode
            finally:
                progress.end()
        reports.write()
        for line in reports.summary(options.require):
            say(line)
        if stopped_by is not None:
            say('the same command goes on from here')
            return _SIGNALLED + stopped_by
        return 0 if reports.is_enough(options.require) else 1

    def _again(self, table: RunTable, journal: SweepJournal) -> list[int]:
        """Return the runs that are done and to be done again."""
        results = journal.results
        match self._options.again:
            case str(again) if again == AGAIN_ALL:
                return [r.number for r in table.runs if r.number in results]
            case str(again) if again == AGAIN_FAILED:
                return [n for n, r in results.items() if not r.succeeded]
            case _:
                return []

    def _do(
        self,
        flow: LaunchFlow,
        folder: ResultsFolder,
        runs: list[Run],
        progress: Progress,
    ) -> int | None:
        """Do runs; return the signal that ended that, if one did."""
        options = self._options
        may_build = (
            not options.no_build
            and options.paths is None
            and flow.workspace.root is not None
        )
        variants = LaunchVariants(
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
        if options.on is not None:
            # few have a cluster
            from colcon_yamllaunch.verb.sweeping.slurm_flow import SlurmFlow

            slurm = SlurmFlow(
                options, options.on, folder, progress, self._environment
            )
            runs = slurm.take_over(runs)
            if runs:
                variants.prepare(runs[0])
            return slurm.run(runs, goal, variants)
        variants.prepare(runs[0])
        jobs = options.jobs or len(os.sched_getaffinity(0))
        own_network = False
        if not options.share_network:
            reason = reason_for_no_network()
            own_network = not reason
        domains = DomainIds(self._environment, shared=not own_network)
        if not own_network and jobs > domains.count:
            why = 'as they share the network of the machine'
            if not options.share_network:
                why = (
                    f'as none can have a network of its own here ({reason}), '
                    'and each needs a ROS_DOMAIN_ID of its own'
                )
            say(f'--jobs is limited to {domains.count}, {why}')
            jobs = domains.count
        settings = Settings(
            jobs, own_network, goal, folder.run_folder, folder.clear
        )
        with closing(domains):
            runner = LocalRunner(settings, variants, progress, domains)
            runner.run(runs)
        return runner.stopped_by


def _words() -> list[str]:
    """Return the command line behind the verb, for people."""
    words = sys.argv[1:]
    return words[words.index('sweep') + 1 :] if 'sweep' in words else words
