# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Array jobs, with a Slurm that a test plays."""

from collections.abc import Iterable, Sequence
import json
import os
from pathlib import Path
import re
import stat
from unittest.mock import Mock

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.sweep import slurm_runner, slurm_task
from colcon_yamllaunch.sweep.progress import Progress
from colcon_yamllaunch.sweep.results import (
    ResultsFolder,
    RunResult,
    SweepDefinition,
)
from colcon_yamllaunch.sweep.run import Goal, PlannedRun, read_metric, Sweep
from colcon_yamllaunch.sweep.slurm_runner import (
    batch_script,
    Ending,
    read_slurm_options,
    reason_of,
    SlurmClient,
    SlurmError,
    SlurmRunner,
)
from colcon_yamllaunch.sweep.table import run_table
import pytest

Queue = dict[tuple[int, int], tuple[str, str]]


class PlayedSlurm(SlurmClient):
    """
    A Slurm whose tasks end at once.

    :ivar fates: How the tasks of some runs end, which have no result then
    """

    def __init__(self, files: slurm_task.SlurmFiles, size: int = 1001) -> None:
        self.files = files
        self.size = size
        self.submitted: list[list[int]] = []
        self.options: list[Sequence[str]] = []
        self.fates: dict[int, str] = {}
        self.most: int | None = None
        self.cancelled: list[int] = []
        self.kept: Queue = {}
        self.when_asked = lambda: None

    def array_size(self) -> int:
        return self.size

    def submit(self, options: Sequence[str], script: str) -> int:
        if self.most is not None and len(self.submitted) >= self.most:
            raise SlurmError('AssocMaxSubmitJobLimit')
        found = re.search(r'(\S+array-\d+\.json)', script)
        assert found is not None
        runs = json.loads(Path(found[1]).read_text())
        self.submitted.append(runs)
        self.options.append(options)
        for run in runs:
            if run not in self.fates:
                self.files.write_result(RunResult(run, 'succeeded'))
        return len(self.submitted)

    def queue(self, jobs: Iterable[int]) -> Queue:
        self.when_asked()
        return {k: v for k, v in self.kept.items() if k[0] in set(jobs)}

    def cancel(self, jobs: Iterable[int], *, kill: bool = False) -> None:
        self.cancelled += jobs

    def ending(self, job: int, index: int) -> Ending | None:
        state = self.fates.get(self.submitted[job - 1][index])
        return None if not state else Ending(state, '1:0', 'n7')


class Case:
    """A sweep with a Slurm that the test plays."""

    def __init__(self, folder: Path, runs: int, size: int = 1001) -> None:
        table = run_table({'seed': f'1..{runs}'})
        definition = SweepDefinition('', ('a.yaml',), table, {}, {})
        self.folder = ResultsFolder(folder, definition, print)
        self.runs = table.runs
        self.files = slurm_task.SlurmFiles(folder)
        self.files.make()
        self.slurm = PlayedSlurm(self.files, size)
        self.progress = Mock(spec=Progress)

    @property
    def results(self) -> dict[int, RunResult]:
        """The recorded results, each recorded once."""
        calls = self.progress.done.call_args_list
        found = {run.number: result for (run, result), _ in calls}
        assert len(found) == len(calls)
        return found

    @property
    def lines(self) -> list[str]:
        """The lines that were shown."""
        return [c.args[0] for c in self.progress.say.call_args_list]

    def runner(self, jobs: int | None = None) -> SlurmRunner:
        options = read_slurm_options('--on', 'slurm:partition=cpu,time=10')
        planned = PlannedRun(Plan(()), {})
        sweep = Sweep(
            *(Goal(), self.folder, self.progress, {}),
            plan=lambda *_: planned,
            build=bool,
            jobs=jobs,
        )
        return SlurmRunner(sweep, self.slurm, options, 'a sweep')


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (
        *('_CHECK_INTERVAL', '_QUERY_INTERVAL', '_DELAY', '_RETRY_DELAY'),
        '_SHARE',
    ):
        monkeypatch.setattr(slurm_runner, name, 0.01)


def test_options_of_sbatch() -> None:
    assert read_slurm_options('--on', 'slurm') == ()
    text = 'slurm:partition=cpu,exclusive,w=n[1,3],mem=4G'
    assert read_slurm_options('--on', text) == (
        *('--partition=cpu', '--exclusive', '--w=n[1,3]', '--mem=4G'),
    )
    with pytest.raises(UserError, match='is no option of sbatch'):
        read_slurm_options('--on', 'slurm:-p=cpu')


def test_arrays_respect_the_maximum_array_size(tmp_path: Path) -> None:
    case = Case(tmp_path / 'a', 25, size=10)
    case.runner().run(case.runs)
    assert [len(runs) for runs in case.slurm.submitted] == [10, 10, 5]
    assert len(case.results) == 25
    assert '--array=0-4' in case.slurm.options[2]
    assert '--partition=cpu' in case.slurm.options[0]
    assert not list(case.files.done.iterdir())
    other = Case(tmp_path / 'b', 5)
    other.runner(jobs=2).run(other.runs)
    assert '--array=0-4%2' in other.slurm.options[0]


def test_refused_submission_is_retried(tmp_path: Path) -> None:
    case = Case(tmp_path, 4, size=2)
    case.slurm.most = 1
    case.slurm.fates = {1: 'TIMEOUT'}

    def more() -> None:
        case.slurm.most = 2

    case.slurm.when_asked = more
    case.runner().run(case.runs)
    assert len(case.results) == 4


def test_first_refused_submission_is_an_error(tmp_path: Path) -> None:
    case = Case(tmp_path, 4)
    case.slurm.most = 0
    with pytest.raises(SlurmError, match='does not take the runs: AssocMax'):
        case.runner().run(case.runs)


@pytest.mark.parametrize(
    ('state', 'reason'),
    [
        ('OUT_OF_MEMORY', 'out of the memory that Slurm gave it on n7: ask'),
        ('TIMEOUT', 'its time at Slurm was over on n7: ask for more'),
        ('NODE_FAIL', 'its node failed: n7 (Slurm: NODE_FAIL)'),
        ('PREEMPTED', 'gave its place to another job on n7'),
        ('FAILED', 'ended on n7 without a result'),
        ('COMPLETED', 'on a file system that the nodes share?'),
        ('', 'Slurm has forgotten it'),
    ],
)
def test_failed_tasks_have_the_reason_of_slurm(
    tmp_path: Path, state: str, reason: str
) -> None:
    case = Case(tmp_path, 3)
    case.slurm.fates = {2: state}
    case.runner().run(case.runs)
    assert case.results[2].outcome == 'error'
    assert reason in case.results[2].reason
    assert case.results[3].succeeded


def test_reason_has_the_last_line_of_the_task() -> None:
    failed, killed = (Ending('FAILED', n, 'n7') for n in ('127:0', '0:9'))
    reason = reason_of(failed, 'there is no Python on n7', Path('/x'))
    assert 'exit code 127:0): there is no Python' in reason
    reason = reason_of(killed, '', Path('/x'))
    assert 'was killed by SIGKILL on n7' in reason


def test_cancelled_tasks_have_no_result(tmp_path: Path) -> None:
    case = Case(tmp_path, 3)
    case.slurm.fates = {2: 'CANCELLED', 3: 'CANCELLED'}
    case.runner().run(case.runs)
    assert list(case.results) == [1]
    assert len(case.lines) == 1


def test_tasks_of_a_killed_sweep_are_taken_over(tmp_path: Path) -> None:
    case = Case(tmp_path, 4)
    case.files.write_arrays({7: [1, 2, 3]})
    case.files.write_result(RunResult(1, 'failed', 'it fell'))
    case.slurm.kept = {(7, 1): ('R', 'None'), (7, 2): ('CA', 'None')}
    left = case.runner().take_over(case.runs)
    assert [run.number for run in left] == [3, 4]
    assert case.results[1].reason == 'it fell'
    assert case.lines == ['1 run is with Slurm already']


def test_unusual_wait_reason_is_shown_once(tmp_path: Path) -> None:
    case = Case(tmp_path, 2)
    case.slurm.fates = {1: 'TIMEOUT', 2: 'TIMEOUT'}
    waits = ('PD', 'PartitionTimeLimit')
    case.slurm.kept = {(1, 0): waits, (1, 1): waits}
    asked = []

    def end() -> None:
        asked.append(1)
        if len(asked) > 3:
            case.slurm.kept = {}

    case.slurm.when_asked = end
    case.runner().run(case.runs)
    assert case.lines == ['Slurm lets 2 runs wait: PartitionTimeLimit']
    case.progress.waiting.assert_any_call('2 waiting')


def test_a_script_is_plain_sh(tmp_path: Path) -> None:
    folder = tmp_path / "it's $HOME"
    script = batch_script(folder, folder / 'array-1.json')
    assert script.startswith('#!/bin/sh\n')
    assert "'\"'\"'" in script
    assert os.system(f"sh -n <<'END'\n{script}END") == 0


def test_task_environment_has_variables_of_slurm() -> None:
    user = {'PATH': '/bin', 'HOME': '/home/me', 'LANG': 'C'}
    sourced = {**user, 'PATH': '/ws/bin:/bin', 'AMENT_PREFIX_PATH': '/ws'}
    of_slurm = {'CUDA_VISIBLE_DEVICES': '1', 'SLURM_JOB_ID': '7'}
    here = {**user, 'PATH': '/usr/bin', 'LANG': 'de', **of_slurm}
    expected = {**sourced, 'LANG': 'de', **of_slurm}
    assert slurm_task.environment_here(sourced, user, here) == expected


def test_common_file_is_private_and_complete(tmp_path: Path) -> None:
    files = slurm_task.SlurmFiles(tmp_path)
    files.make()
    goal = Goal(timeout=3.0, metrics=(read_metric('--metric', 'a=(b)'),))
    common = slurm_task.Common(goal, {'TOKEN': 'secret'}, share_network=True)
    files.write_common(common)
    (path,) = files.folder.glob('*.json')
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    read = files.read_common()
    assert read.user == common.user
    assert read.goal.timeout == 3.0
    assert read.goal.metrics[0].pattern.text == '(b)'
    assert read.share_network
