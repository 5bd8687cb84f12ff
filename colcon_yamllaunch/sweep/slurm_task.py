# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
One task of an array job: one run of a sweep, on a node.

It needs the standard library only, so any Python that the node has will do.
"""

from collections.abc import Mapping
from contextlib import closing
import json
import os
from pathlib import Path
import sys

from colcon_yamllaunch.plan.plan_json import plan_from_json
from colcon_yamllaunch.sweep.domain_ids import DomainIds
from colcon_yamllaunch.sweep.domain_ids import VARIABLE
from colcon_yamllaunch.sweep.forked_guard import ForkedGuards
from colcon_yamllaunch.sweep.isolation import enter_own_network
from colcon_yamllaunch.sweep.results import one_reason
from colcon_yamllaunch.sweep.results import RunResult
from colcon_yamllaunch.sweep.run import perform
from colcon_yamllaunch.sweep.run import PlannedRun
from colcon_yamllaunch.sweep.slurm_files import Common
from colcon_yamllaunch.sweep.slurm_files import PLAN
from colcon_yamllaunch.sweep.slurm_files import SlurmFiles

_INDEX = 'SLURM_ARRAY_TASK_ID'


def main() -> int:
    """
    Do the run, and return the exit code for Slurm.

    The arguments are the folder of the results and the file with the numbers
    of the runs of this array job.
    """
    results, listed = map(Path, sys.argv[1:])
    numbers = json.loads(listed.read_text(encoding='utf-8'))
    number = numbers[int(os.environ[_INDEX])]
    files = SlurmFiles(results)
    common = files.read_common()
    folder = results / 'runs' / f'{number:04}'
    try:
        result = _result(number, folder, common)
    except Exception as e:  # noqa: BLE001 - whatever it is, it is told
        result = RunResult(number, 'error', one_reason(f'{e}'))
    if result is None:
        # Slurm knows who stopped it
        return 1
    files.write_result(result)
    return 0


def _result(number: int, folder: Path, common: Common) -> RunResult | None:
    text = (folder / PLAN).read_text(encoding='utf-8')
    values = json.loads(text)
    own_network = False
    if not common.share_network:
        try:
            enter_own_network()
            own_network = True
        except OSError:
            # what the node does not allow
            own_network = False
    domains = DomainIds(common.environment, shared=not own_network)
    domain = domains.take()
    if domain is None:
        return RunResult(
            number,
            'error',
            'every ROS_DOMAIN_ID of the node is taken by other runs',
        )
    environment = {
        **environment_here(common, os.environ),
        **values['environment'],
        VARIABLE: str(domain),
    }
    planned = PlannedRun(
        plan_from_json(json.dumps(values['plan'])), environment
    )
    with closing(ForkedGuards()) as guards:
        return perform(number, planned, folder, common.goal, guards)


def environment_here(
    common: Common, environment: Mapping[str, str]
) -> dict[str, str]:
    """
    Return the environment of a run on this node.

    It is that of the workspace, with what Slurm has set for the task, such as
    `CUDA_VISIBLE_DEVICES`; what sourcing has changed stays so.

    :param environment: That of this task
    """
    here = dict(common.environment)
    for name, value in environment.items():
        is_new = common.user.get(name) != value
        is_sourced = common.user.get(name) != common.environment.get(name)
        if is_new and not is_sourced:
            here[name] = value
    return here
