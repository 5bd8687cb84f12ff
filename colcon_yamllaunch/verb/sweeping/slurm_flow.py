# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `colcon sweep --on slurm:…` does with its runs."""

from collections.abc import Mapping
from contextlib import redirect_stderr
import io
import json
from pathlib import Path

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.plan.position import shown_position
from colcon_yamllaunch.sweep.domain_ids import VARIABLE
from colcon_yamllaunch.sweep.local_runner import first_error
from colcon_yamllaunch.sweep.local_runner import NotBuiltError
from colcon_yamllaunch.sweep.local_runner import PlanError
from colcon_yamllaunch.sweep.progress import Progress
from colcon_yamllaunch.sweep.results import one_reason
from colcon_yamllaunch.sweep.results import ResultsFolder
from colcon_yamllaunch.sweep.results import RunResult
from colcon_yamllaunch.sweep.run import Goal
from colcon_yamllaunch.sweep.run import PlannedRun
from colcon_yamllaunch.sweep.slurm_client import SlurmClient
from colcon_yamllaunch.sweep.slurm_files import Common
from colcon_yamllaunch.sweep.slurm_files import SlurmFiles
from colcon_yamllaunch.sweep.slurm_place import SlurmPlace
from colcon_yamllaunch.sweep.slurm_runner import SlurmRunner
from colcon_yamllaunch.sweep.table import Run
from colcon_yamllaunch.verb.cli.sweep_options import SweepOptions
from colcon_yamllaunch.verb.sweeping.launch_variants import LaunchVariants


class SlurmFlow:
    """
    Plans the runs here, and has Slurm do them.

    :param environment: The user's environment
    :raises UserError: when there is no Slurm
    """

    def __init__(
        self,
        options: SweepOptions,
        place: SlurmPlace,
        folder: ResultsFolder,
        progress: Progress,
        environment: Mapping[str, str],
    ) -> None:
        self._options = options
        self._folder = folder
        self._progress = progress
        self._environment = environment
        self._files = SlurmFiles(folder.path)
        self._files.make()
        name = ' '.join(['colcon sweep', *options.positionals])
        self._runner = SlurmRunner(
            SlurmClient(environment),
            place,
            self._files,
            progress,
            name,
            options.jobs,
        )
        # the environment that the runs have, but for what is their own
        self._common: dict[str, str] | None = None

    def take_over(self, runs: list[Run]) -> list[Run]:
        """Return the runs that are not with Slurm already."""
        return self._runner.take_over(runs)

    def run(
        self, runs: list[Run], goal: Goal, variants: LaunchVariants
    ) -> int | None:
        """Do runs; return the signal that ended that, if one did."""
        planned = []
        for number, run in enumerate(runs, 1):
            self._progress.waiting(f'planning {number:,} of {len(runs):,}')
            self._progress.tick()
            if self._plan(run, variants):
                planned.append(run)
        self._progress.waiting('')
        if self._common is not None:
            self._files.write_common(
                Common(
                    goal,
                    self._common,
                    self._environment,
                    self._options.share_network,
                )
            )
        self._runner.run(planned)
        return self._runner.stopped_by

    def _plan(self, run: Run, variants: LaunchVariants) -> bool:
        """Write the plan of a run; return whether there is one."""
        folder = self._folder.run_folder(run.number)
        self._folder.clear(run.number)
        self._progress.planned(run)
        said = io.StringIO()
        try:
            with redirect_stderr(said):
                try:
                    planned = variants.plan(run, folder, {})
                except NotBuiltError:
                    planned = None
            if planned is None:
                variants.build(run)
                with redirect_stderr(said):
                    planned = variants.plan(run, folder, {})
            self._write(planned, folder)
            self._progress.planned(run, planned.uses)
        except (PlanError, UserError) as e:
            reason = str(e) or first_error(said.getvalue())
            result = RunResult(run.number, 'error', one_reason(reason))
            self._progress.done(run, result)
            return False
        finally:
            variants.leave()
        return True

    def _write(self, planned: PlannedRun, folder: Path) -> None:
        """
        Write a plan for a node.

        :raises UserError: when it is not complete
        """
        position = planned.plan.host_position
        if planned.source is not None or position is not None:
            place = ''
            if position is not None:
                place = f' ({shown_position(position, str(Path.cwd()))})'
            raise UserError(
                'what happens while it runs is up to Python'
                f'{place}, so its plan cannot be sent to a node',
                'leave out --on',
            )
        environment = dict(planned.environment)
        environment.pop(VARIABLE, None)
        if self._common is None:
            self._common = environment
        own = {
            name: value
            for name, value in environment.items()
            if self._common.get(name) != value
        }
        self._files.write_plan(
            folder,
            {
                'environment': own,
                'plan': json.loads(plan_to_json(planned.plan)),
            },
        )
