# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
One task of an array job, on a node: one run of a sweep; and its files.

They are in the folder of the results, on a file system that the nodes share:
`slurm/common.json` for all runs, `runs/NUMBER/plan.json` for one,
`slurm/array-N.json` with the run of each task of an array job, and
`slurm/done/NUMBER.json` with the result of a run.

A task needs the standard library only, so any Python of the node will do.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
import sys
from typing import Any

from colcon_yamllaunch.common.codec import Codec, to_json
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.files import read_json, write_file
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.line_pattern import LinePattern
from colcon_yamllaunch.plan.plan_json import plan_from_json
from colcon_yamllaunch.sweep.isolation import (
    DOMAIN_VARIABLE,
    DomainIds,
    enter_own_network,
)
from colcon_yamllaunch.sweep.results import (
    ARRAYS,
    DONE,
    failed_run,
    result_from_json,
    RunResult,
    SLURM,
)
from colcon_yamllaunch.sweep.run import Goal, perform, PlannedRun

_COMMON = 'common.json'
_PLAN = 'plan.json'
_INDEX = 'SLURM_ARRAY_TASK_ID'
_CODEC = Codec(special={LinePattern: (lambda p: p.text, LinePattern)})


@dataclass(frozen=True, slots=True)
class Common:
    """
    The part of the runs that they have in common.

    :param user: The environment of the user; variables that differ on a node
      were set by Slurm
    :param share_network: Whether runs stay in the network of the machine
    """

    goal: Goal
    user: Mapping[str, str]
    share_network: bool = False


class SlurmFiles:
    """
    The files of a sweep with Slurm.

    :param results: The folder of the results
    :raises UserError: when they cannot be written
    """

    def __init__(self, results: Path) -> None:
        self._results = results
        self.folder = results / SLURM
        self.done = self.folder / DONE
        #: The folder for output of tasks that is in no log of their run.
        self.output = self.folder / 'output'

    def make(self) -> None:
        """Make the folders."""
        try:
            for folder in (self.done, self.output):
                folder.mkdir(parents=True, exist_ok=True)
        except OSError as e:
            raise _unwritable(self.folder, e) from e

    def write_common(self, common: Common) -> None:
        """Write the common part; only the user can read it."""
        # there may be secrets in an environment
        _write(self.folder / _COMMON, _CODEC.to_json(common), 0o600)

    def read_common(self) -> Common:
        """
        Return the common part.

        :raises OSError: when it cannot be read
        """
        text = (self.folder / _COMMON).read_text(encoding='utf-8')
        return _CODEC.from_json(Common, json.loads(text), 'common')

    def arrays(self) -> dict[int, list[int]]:
        """Return the runs of each array job, by its number."""
        known = read_json(self.folder / ARRAYS)
        arrays = known if isinstance(known, dict) else {}
        return {int(job): runs for job, runs in arrays.items()}

    def write_arrays(self, arrays: Mapping[int, list[int]]) -> None:
        """Write the runs of each array job."""
        _write(self.folder / ARRAYS, arrays)

    def write_list(self, runs: list[int]) -> Path:
        """Write the runs of an array job, and return the file."""
        number = 1
        while (path := self.folder / f'array-{number}.json').exists():
            number += 1
        _write(path, runs)
        return path

    def write_plan(
        self, folder: Path, environment: Mapping[str, str], plan: Any
    ) -> None:
        """
        Write the plan of a run, and the environment of its processes.

        :param folder: The folder of the run
        """
        values = {'environment': dict(environment), 'plan': plan}
        _write(folder / _PLAN, values, 0o600)

    def write_result(self, result: RunResult) -> None:
        """Write the result of a run, on the node."""
        _write(self.done / f'{result.run}.json', to_json(result))

    def results(self) -> Iterator[RunResult]:
        """Yield the new results, each once."""
        # opening a folder makes a network file system look for new files
        try:
            names = os.listdir(self.done)
        except OSError:
            return
        for name in names:
            path = self.done / name
            if not name[0].isdigit():
                continue
            result = result_from_json(read_json(path))
            if result is not None:
                yield result
                with suppress(OSError):
                    path.unlink()


def _write(path: Path, values: Any, mode: int = 0o666) -> None:
    try:
        write_file(path, json.dumps(values).encode(), mode)
    except OSError as e:
        raise _unwritable(path, e) from e


def _unwritable(path: Path, error: OSError) -> UserError:
    return UserError(
        f"'{path}' cannot be written: {error.strerror or error}",
        'name another folder with --results DIR',
    )


def main() -> int:
    """
    Launch the run of this task, and return the exit code for Slurm.

    The arguments are the folder of the results and the file with the numbers
    of the runs of this array job.
    """
    results, listed = map(Path, sys.argv[1:])
    numbers = json.loads(listed.read_text(encoding='utf-8'))
    number = numbers[int(os.environ[_INDEX])]
    files = SlurmFiles(results)
    common = files.read_common()
    try:
        result = _launch(number, results / 'runs' / f'{number:04}', common)
    except Exception as e:  # noqa: BLE001 - the sweep shows any error
        result = failed_run(number, str(e))
    if result is None:
        # Slurm knows why it was stopped
        return 1
    files.write_result(result)
    return 0


def _launch(number: int, folder: Path, common: Common) -> RunResult | None:
    values = json.loads((folder / _PLAN).read_text(encoding='utf-8'))
    own_network = False
    if not common.share_network:
        # not every node allows it
        with suppress(OSError):
            enter_own_network()
            own_network = True
    sourced = values['environment']
    domains = DomainIds(sourced, shared=not own_network)
    domain = domains.reserve()
    if domain is None:
        reason = 'every ROS_DOMAIN_ID of the node is taken by other runs'
        return failed_run(number, reason)
    environment = environment_here(sourced, common.user, os.environ)
    environment[DOMAIN_VARIABLE] = str(domain)
    plan = plan_from_json(json.dumps(values['plan']))
    planned = PlannedRun(plan, environment)
    return perform(number, planned, folder, common.goal)


def environment_here(
    sourced: Mapping[str, str],
    user: Mapping[str, str],
    environment: Mapping[str, str],
) -> dict[str, str]:
    """
    Return the environment of a run on this node.

    It is that of the workspace, with the variables that Slurm has set for the
    task, such as `CUDA_VISIBLE_DEVICES`; sourced variables remain.

    :param sourced: That of the workspace
    :param user: That of the user, see :class:`Common`
    :param environment: That of this task
    """
    here = dict(sourced)
    for name, value in environment.items():
        before = user.get(name)
        if before == sourced.get(name) and before != value:
            here[name] = value
    return here
