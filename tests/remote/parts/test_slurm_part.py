# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The Slurm of the tests runs jobs, and leaves nothing of them."""

from collections.abc import Iterator

import pytest
from support.slurm import Slurm


@pytest.fixture(autouse=True)
def no_jobs(slurm: Slurm) -> Iterator[None]:
    yield
    slurm.cancel_all()


def test_a_step_runs(slurm: Slurm) -> None:
    done = slurm.run('srun', '--export=NONE', '/usr/bin/printenv', 'HOME')
    assert (done.returncode, done.stdout) == (0, f'{slurm.home}\n')


def test_step_without_exports_has_no_path(slurm: Slurm) -> None:
    done = slurm.run('srun', '--export=NONE', '/usr/bin/printenv', 'PATH')
    assert done.stdout == ''


def test_a_step_gets_a_graphics_processor(slurm: Slurm) -> None:
    words = ('srun', '--partition=gpu', '--gres=gpu:1')
    done = slurm.run(*words, 'sh', '-c', 'echo $SLURM_JOB_PARTITION')
    assert (done.returncode, done.stdout) == (0, 'gpu\n')
    done = slurm.run('srun', '--gres=fpga', 'true')
    assert 'Invalid generic resource' in done.stderr


def test_a_step_runs_within_an_allocation(slurm: Slurm) -> None:
    done = slurm.run('salloc', 'srun', 'printenv', 'SLURM_JOB_ID')
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip().isdigit()


def test_jobs_are_ended(slurm: Slurm) -> None:
    submitted = slurm.run('sbatch', '--array=1-3', '--wrap', 'sleep 1000')
    assert submitted.returncode == 0, submitted.stderr
    while 'sleep 1000' not in slurm.left():
        assert slurm.queue()
    slurm.cancel_all()
    assert (slurm.queue(), slurm.left()) == ([], [])
