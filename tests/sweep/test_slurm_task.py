# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a task of an array job has for its environment."""

from pathlib import Path
import stat

from colcon_yamllaunch.sweep.run import Goal
from colcon_yamllaunch.sweep.run import read_metric
from colcon_yamllaunch.sweep.slurm_task import Common
from colcon_yamllaunch.sweep.slurm_task import environment_here
from colcon_yamllaunch.sweep.slurm_task import SlurmFiles


def test_what_slurm_sets_is_added() -> None:
    user = {'PATH': '/bin', 'HOME': '/home/me', 'LANG': 'C'}
    sourced = {**user, 'PATH': '/ws/bin:/bin', 'AMENT_PREFIX_PATH': '/ws'}
    here = {
        **user,
        'PATH': '/usr/bin',
        'HOME': '/home/me',
        'LANG': 'de',
        'CUDA_VISIBLE_DEVICES': '1',
        'SLURM_JOB_ID': '7',
    }
    common = Common(Goal(), sourced, user)
    assert environment_here(common, here) == {
        'PATH': '/ws/bin:/bin',
        'HOME': '/home/me',
        'LANG': 'de',
        'AMENT_PREFIX_PATH': '/ws',
        'CUDA_VISIBLE_DEVICES': '1',
        'SLURM_JOB_ID': '7',
    }


def test_the_environment_is_nobody_elses(tmp_path: Path) -> None:
    files = SlurmFiles(tmp_path)
    files.make()
    goal = Goal(timeout=3.0, metrics=(read_metric('--metric', 'a=(b)'),))
    common = Common(goal, {'TOKEN': 'secret'}, {}, share_network=True)
    files.write_common(common)
    (path,) = files.folder.glob('*.json')
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    read = files.read_common()
    assert read.environment == common.environment
    assert read.goal.timeout == 3.0
    assert read.goal.metrics[0].pattern.text == '(b)'
    assert read.share_network
