# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The runner through Slurm: array jobs, with a task for each run.

The jobs belong to Slurm: they go on if the sweep is killed, and the next one
with the same command takes them over. Slurm is used through its commands.
`sacct` works only where a cluster keeps accounts; `squeue` and `scontrol`
always do, but forget a job some minutes after its end (MinJobAge).
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import redirect_stderr, suppress
from dataclasses import dataclass
import io
import json
from pathlib import Path
import re
import select
import shlex
import shutil
import signal
import subprocess
import sys
import time

import colcon_yamllaunch
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.engine.loop import caught, received, STOPPING
from colcon_yamllaunch.engine.outcome import signal_name
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.plan.position import shown_position
from colcon_yamllaunch.sweep.results import failed_run, RunResult
from colcon_yamllaunch.sweep.run import (
    NotBuiltError,
    plan_failure,
    PlanError,
    Sweep,
)
from colcon_yamllaunch.sweep.slurm_task import Common, SlurmFiles
from colcon_yamllaunch.sweep.table import Run

#: Seconds that a command of Slurm may take.
_ANSWER_TIMEOUT = 60.0
#: The default of slurm.conf(5).
_ARRAY_SIZE = 1001
# the beginning of each line of an error
_NAME = re.compile(r'^s[a-z]+: (?:error: |fatal: )?')
#: Jobs in one query, so that the command line is not too long.
_AT_ONCE = 500
_OPTION = re.compile(r'[a-z][a-z-]*')
#: Options that the sweep itself sets.
_OURS = (
    *('array', 'chdir', 'dependency', 'error', 'export', 'hold', 'input'),
    *('output', 'parsable', 'requeue', 'no-requeue', 'test-only', 'wait'),
    *('wrap', 'job-name'),
)
#: Seconds between two checks for results, and between two queries.
_CHECK_INTERVAL = 0.5
_QUERY_INTERVAL = 2.0
#: Slurm has a rest of this many times the duration of a query.
_SHARE = 10.0
#: Seconds that a result may take from the node to us, over the network.
_DELAY = 10.0
#: Seconds until runs that Slurm refused are submitted again.
_RETRY_DELAY = 20.0
#: Seconds that cancelled tasks have to end.
_END_TIMEOUT = 60.0
#: States of tasks that have ended (squeue(1), "JOB STATE CODES").
_OVER = ('BF', 'CA', 'CD', 'DL', 'F', 'NF', 'OOM', 'PR', 'RV', 'SE', 'TO')
_PENDING = ('PD', 'CF', 'RQ', 'RH', 'RS')
#: Reasons of tasks that wait for their turn.
_ORDINARY = (
    *('', 'None', 'Priority', 'Resources', 'JobArrayTaskLimit', 'BeginTime'),
    *('Prolog', 'Cleaning', 'Dependency', 'NodesBusy'),
)
_PROGRAM = (
    'import sys; sys.path.append(sys.argv.pop(1)); '
    'from colcon_yamllaunch.sweep.slurm_task import main; '
    'sys.exit(main())'
)
#: The meaning of final states for users; `{}` is the node.
_ENDINGS: Mapping[str, str] = {
    'OUT_OF_MEMORY': 'it ran out of the memory that Slurm gave it{}: ask for '
    'more, such as mem=4G',
    'TIMEOUT': 'its time at Slurm was over{}: ask for more, such as time=60, '
    'or give --timeout',
    'NODE_FAIL': 'its node failed{}',
    'BOOT_FAIL': 'its node failed to start{}',
    'PREEMPTED': 'Slurm gave its place to another job{}',
    'DEADLINE': 'it could not be done before the deadline of the job{}',
}
#: Final states whose subject is the node.
_OF_NODE = ('NODE_FAIL', 'BOOT_FAIL')
#: Final states of runs that the user or the sweep cancelled.
_CANCELLED = ('CANCELLED', 'REVOKED')


class SlurmError(UserError):
    """Slurm reports an error; has its text."""


def read_slurm_options(option: str, text: str) -> tuple[str, ...]:
    """
    Return options of `sbatch`, written `slurm:partition=cpu,time=10`.

    A comma in brackets is part of a value, as in `nodelist=n[1,3]`.

    :param option: The option that has them, for errors
    :raises UserError: when they are written otherwise
    """
    kind, _, rest = text.partition(':')
    if kind != 'slurm':
        raise UserError(
            f'{option} is written slurm:OPTION=VALUE,… with options of '
            f"sbatch, such as slurm:partition=cpu,time=10, not '{text}'"
        )
    options = []
    for word in filter(None, re.split(r',(?![^\[]*\])', rest)):
        name, equals, value = word.partition('=')
        name = name.strip().removeprefix('--')
        if not _OPTION.fullmatch(name):
            raise UserError(
                f"{option}: '{word}' is no option of sbatch",
                'they are written name=value, as in partition=cpu; a comma '
                'separates them',
            )
        if name in _OURS:
            raise UserError(
                f"{option}: '{name}' is for the sweep to say, not for its user"
            )
        options.append(f'--{name}{equals}{value}')
    return tuple(options)


@dataclass(frozen=True, slots=True)
class Ending:
    """
    The end of a task.

    :param state: Such as `OUT_OF_MEMORY`
    :param code: The exit code, such as `1:0`
    :param node: Where it ran, '' if it did not
    """

    state: str
    code: str = ''
    node: str = ''


class SlurmClient:
    """
    The Slurm that the user can reach.

    :param environment: The user's environment
    :raises SlurmError: when it is not installed
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = dict(environment)
        path = environment.get('PATH')
        for name in ('sbatch', 'squeue', 'scancel', 'scontrol'):
            if shutil.which(name, path=path) is None:
                raise SlurmError(
                    f"--on slurm needs the command '{name}' of Slurm, and "
                    'there is none here',
                    'go to a machine of the cluster that has it',
                )
        self._has_accounts = shutil.which('sacct', path=path) is not None

    def array_size(self) -> int:
        """Return how many tasks an array job may have."""
        try:
            text = self._run('scontrol', 'show', 'config')
        except SlurmError:
            return _ARRAY_SIZE
        found = re.search(r'^MaxArraySize\s*=\s*(\d+)', text, re.MULTILINE)
        return _ARRAY_SIZE if found is None else max(1, int(found[1]))

    def submit(self, options: Sequence[str], script: str) -> int:
        """
        Submit a batch job, and return its number.

        :raises SlurmError: when Slurm refuses it
        """
        text = self._run('sbatch', '--parsable', *options, input_text=script)
        # behind a semicolon is the cluster
        number = text.strip().splitlines()[-1:] or ['']
        found = re.match(r'\d+', number[0])
        if found is None:
            raise SlurmError(f"sbatch says '{text.strip()}', and no job")
        return int(found[0])

    def queue(
        self, jobs: Iterable[int]
    ) -> dict[tuple[int, int], tuple[str, str]]:
        """
        Return the state of each task, such as `PD`, and why it waits.

        The keys are job and index. Slurm forgets tasks some time after their
        end.

        :raises SlurmError: when Slurm does not answer
        """
        wanted = sorted(set(jobs))
        found: dict[tuple[int, int], tuple[str, str]] = {}
        for start in range(0, len(wanted), _AT_ONCE):
            some = wanted[start : start + _AT_ONCE]
            listed = ','.join(map(str, some))
            try:
                text = self._run(
                    'squeue',
                    *('--noheader', '--array', f'--jobs={listed}'),
                    *('--states=all', '--format=%F|%K|%t|%r'),
                )
            except SlurmError as e:
                # all of them are forgotten
                if 'Invalid job id' in str(e):
                    continue
                raise
            for line in text.splitlines():
                words = line.strip().split('|')
                if len(words) == 4 and words[0].isdigit():
                    index = int(words[1]) if words[1].isdigit() else 0
                    found[int(words[0]), index] = (words[2], words[3])
        return found

    def cancel(self, jobs: Iterable[int], *, kill: bool = False) -> None:
        """
        Cancel jobs; some may have ended already.

        :raises SlurmError: when Slurm does not answer
        """
        numbers = list(map(str, jobs))
        if not numbers:
            return
        if kill:
            self._run('scancel', '--quiet', '--signal=KILL', '-f', *numbers)
        self._run('scancel', '--quiet', *numbers)

    def ending(self, job: int, index: int) -> Ending | None:
        """Return how a task ended, None if that is unknown."""
        task = f'{job}_{index}'
        if self._has_accounts:
            try:
                text = self._run(
                    'sacct',
                    *('--noheader', '--parsable2', '--allocations'),
                    *('--jobs', task, '--format=State,ExitCode,NodeList'),
                )
            except SlurmError:
                # the cluster keeps none
                self._has_accounts = False
            else:
                for line in text.splitlines():
                    state, code, node, *_ = [*line.split('|'), '', '', '']
                    if state:
                        return Ending(state.split(' ')[0], code, node)
        try:
            text = self._run('scontrol', 'show', 'job', task, '--oneliner')
        except SlurmError:
            return None
        values = dict(re.findall(r'(\w+)=(\S*)', text))
        if 'JobState' not in values:
            return None
        node = values.get('NodeList', '')
        return Ending(
            values['JobState'],
            values.get('ExitCode', ''),
            '' if node == '(null)' else node,
        )

    def _run(self, *words: str, input_text: str = '') -> str:
        try:
            done = subprocess.run(
                words,
                input=input_text,
                env=self._environment,
                capture_output=True,
                text=True,
                errors='replace',
                timeout=_ANSWER_TIMEOUT,
                check=False,
                # Ctrl-C is for the sweep
                start_new_session=True,
            )
        except subprocess.TimeoutExpired as e:
            raise SlurmError(
                f'{words[0]} has not answered in {_ANSWER_TIMEOUT:g} s'
            ) from e
        except OSError as e:
            raise SlurmError(f'{words[0]}: {e.strerror or e}') from e
        if done.returncode:
            lines = (done.stderr or done.stdout).splitlines()
            said = [_NAME.sub('', line).strip() for line in lines]
            text = '; '.join(filter(None, said))
            raise SlurmError(text or f'exit code {done.returncode}')
        return done.stdout


@dataclass(slots=True)
class _Task:
    """
    A task of an array job.

    :param index: Its index there
    :param over_since: When it was first seen to be over without a result
    """

    job: int
    index: int
    run: Run
    over_since: float | None = None


class SlurmRunner:
    """
    Plans runs here, and launches them as tasks of Slurm.

    :param options: Options of `sbatch`
    :param name: The name of the jobs
    """

    def __init__(
        self,
        sweep: Sweep,
        client: SlurmClient,
        options: Sequence[str],
        name: str,
    ) -> None:
        self._sweep = sweep
        self._client = client
        self._options = options
        self._name = name
        self._files = SlurmFiles(sweep.folder.path)
        self._files.make()
        self._arrays: dict[int, list[int]] = {}
        self._tasks: dict[int, _Task] = {}
        # the parts that are still to be submitted, and when
        self._chunks: list[list[Run]] = []
        self._next_try = 0.0
        self._next_query = 0.0
        # reasons of waiting, and others, that were shown
        self._shown: set[str] = set()
        self._stopped_by: int | None = None
        self._deadline = 0.0

    def run(self, runs: Sequence[Run]) -> int | None:
        """
        Run all, and return the signal that stopped that, if one did.

        Must be called in the main thread.

        :raises SlurmError: when Slurm refuses them
        """
        runs = self.take_over(runs)
        if runs:
            self._sweep.build(runs[0])
        runs = self._planned(runs)
        size = self._client.array_size()
        self._chunks = [
            runs[start : start + size] for start in range(0, len(runs), size)
        ]
        with caught(STOPPING) as signals:
            try:
                self._submit()
                while self._tasks or self._chunks:
                    select.select([signals], [], [], _CHECK_INTERVAL)
                    for number in received(signals):
                        self._stop(number)
                    for result in self._files.results():
                        if result.run in self._tasks:
                            self._done(self._tasks[result.run], result)
                    self._query()
                    if self._stopped_by is None:
                        self._submit()
                    elif time.monotonic() >= self._deadline:
                        break
                    self._sweep.progress.tick()
            finally:
                if self._tasks and self._stopped_by is None:
                    # after an error, nobody waits for the tasks
                    self._cancel(kill=False)
        return self._stopped_by

    def take_over(self, runs: Iterable[Run]) -> list[Run]:
        """
        Adopt the tasks of an earlier sweep; return the other runs.

        :raises SlurmError: when Slurm does not answer
        """
        missing = {run.number: run for run in runs}
        for result in self._files.results():
            run = missing.pop(result.run, None)
            if run is not None:
                self._sweep.progress.done(run, result)
        arrays = self._files.arrays()
        queue = self._client.queue(arrays) if arrays else {}
        for (job, index), (state, _) in queue.items():
            numbers = arrays.get(job, [])
            if state in _OVER or index >= len(numbers):
                continue
            run = missing.pop(numbers[index], None)
            if run is not None:
                self._arrays[job] = numbers
                self._tasks[run.number] = _Task(job, index, run)
        if self._tasks:
            count = len(self._tasks)
            what = 'run is' if count == 1 else 'runs are'
            self._sweep.progress.say(f'{count:,} {what} with Slurm already')
        return list(missing.values())

    def _planned(self, runs: Sequence[Run]) -> list[Run]:
        """Write the plans of runs; return the runs that have one."""
        sweep = self._sweep
        planned = []
        for number, run in enumerate(runs, 1):
            sweep.progress.waiting(f'planning {number:,} of {len(runs):,}')
            sweep.progress.tick()
            sweep.folder.clear(run.number)
            sweep.progress.planned(run)
            messages = io.StringIO()
            try:
                try:
                    self._write_plan(run, messages)
                except NotBuiltError:
                    sweep.build(run)
                    self._write_plan(run, messages)
                planned.append(run)
            except (PlanError, UserError) as e:
                reason = plan_failure(e, messages.getvalue())
                sweep.progress.done(run, failed_run(run.number, reason))
        sweep.progress.waiting('')
        self._files.write_common(
            Common(sweep.goal, sweep.environment, sweep.share_network)
        )
        return planned

    def _write_plan(self, run: Run, messages: io.StringIO) -> None:
        """
        Plan a run, and write its plan for a node.

        :param messages: Receives what is printed meanwhile
        :raises UserError: when the plan is not complete
        """
        folder = self._sweep.folder.run_folder(run.number)
        with redirect_stderr(messages):
            planned = self._sweep.plan(run, folder, {})
        try:
            position = planned.plan.worker_position
            if planned.participants or position is not None:
                place = ''
                if position is not None:
                    place = f' ({shown_position(position, str(Path.cwd()))})'
                raise UserError(
                    'what happens while it runs is up to Python'
                    f'{place}, so its plan cannot be sent to a node',
                    'leave out --on',
                )
            plan = json.loads(plan_to_json(planned.plan))
            self._files.write_plan(folder, planned.environment, plan)
            self._sweep.progress.planned(run, planned.uses)
        finally:
            planned.close()

    def _submit(self) -> None:
        """Submit as many runs as Slurm accepts."""
        jobs = self._sweep.jobs
        while self._chunks and time.monotonic() >= self._next_try:
            # a limit counts for each array, so one array follows the other
            if jobs is not None and self._tasks:
                return
            chunk = self._chunks[0]
            numbers = [run.number for run in chunk]
            script = batch_script(
                self._sweep.folder.path, self._files.write_list(numbers)
            )
            limit = '' if jobs is None else f'%{jobs}'
            options = (
                f'--job-name={self._name}',
                f'--array=0-{len(chunk) - 1}{limit}',
                f'--output={self._files.output}/%A_%a.log',
                '--no-requeue',
                '--open-mode=append',
                *self._options,
            )
            try:
                job = self._client.submit(options, script)
            except SlurmError as e:
                if not self._tasks:
                    raise SlurmError(
                        f'Slurm does not take the runs: {e}'
                    ) from e
                # there may be room when others have ended
                self._next_try = time.monotonic() + _RETRY_DELAY
                return
            del self._chunks[0]
            self._arrays[job] = numbers
            for index, run in enumerate(chunk):
                self._tasks[run.number] = _Task(job, index, run)
            self._files.write_arrays(self._arrays)

    def _done(self, task: _Task, result: RunResult) -> None:
        del self._tasks[task.run.number]
        self._sweep.progress.done(task.run, result)
        output = self._output_of(task)
        with suppress(OSError):
            if not output.stat().st_size:
                output.unlink()

    def _query(self) -> None:
        """Query the states of the tasks that have no result."""
        now = time.monotonic()
        if now < self._next_query or not self._tasks:
            return
        progress = self._sweep.progress
        try:
            queue = self._client.queue({t.job for t in self._tasks.values()})
        except SlurmError as e:
            progress.waiting(f'Slurm does not answer: {e}')
            self._next_query = time.monotonic() + _QUERY_INTERVAL
            return
        end = time.monotonic()
        self._next_query = end + max(_QUERY_INTERVAL, _SHARE * (end - now))
        reasons: Counter[str] = Counter()
        running = 0
        for task in tuple(self._tasks.values()):
            state, reason = queue.get((task.job, task.index), ('', ''))
            if state in _PENDING:
                reasons[reason] += 1
            elif state and state not in _OVER:
                running += 1
            else:
                self._handle_end(task, now)
        progress.set_running(running)
        waiting = reasons.total()
        progress.waiting(f'{waiting:,} waiting' if waiting else '')
        for reason, count in reasons.items():
            if reason not in _ORDINARY:
                self._say_once(
                    reason, f'Slurm lets {count:,} runs wait: {reason}'
                )

    def _handle_end(self, task: _Task, now: float) -> None:
        """Record the failure of a task that ended without a result."""
        if task.over_since is None:
            task.over_since = now
        ending = self._client.ending(task.job, task.index)
        state = '' if ending is None else ending.state
        # then there is a result, which may be on its way
        in_order = state in ('COMPLETED', 'COMPLETING', 'RUNNING', '')
        may_come = in_order and now - task.over_since < _DELAY
        if may_come and self._stopped_by is None:
            return
        if state.startswith(_CANCELLED) or self._stopped_by is not None:
            del self._tasks[task.run.number]
            if self._stopped_by is None:
                self._say_once(
                    'cancelled',
                    'runs were cancelled at Slurm; the same command does them '
                    'later',
                )
            return
        reason = reason_of(
            ending, _last_line(self._output_of(task)), self._sweep.folder.path
        )
        self._done(task, failed_run(task.run.number, reason))

    def _say_once(self, key: str, text: str) -> None:
        if key not in self._shown:
            self._shown.add(key)
            self._sweep.progress.say(text)

    def _stop(self, number: int) -> None:
        """Cancel all runs, or kill them if they are cancelled already."""
        if number == signal.SIGHUP:
            # nobody sees it any more, and the next sweep takes them over
            self._stopped_by = number
            self._deadline = time.monotonic()
            return
        kill = self._stopped_by is not None
        self._sweep.progress.interrupted(len(self._tasks), escalates=kill)
        if not kill:
            self._stopped_by = number
            self._deadline = time.monotonic() + _END_TIMEOUT
            self._chunks.clear()
        self._cancel(kill=kill)
        self._next_query = 0.0

    def _cancel(self, *, kill: bool) -> None:
        jobs = {task.job for task in self._tasks.values()}
        try:
            self._client.cancel(jobs, kill=kill)
        except SlurmError as e:
            listed = ' '.join(map(str, sorted(jobs)))
            self._sweep.progress.say(
                f'Slurm does not cancel the runs: {e}; later: scancel {listed}'
            )

    def _output_of(self, task: _Task) -> Path:
        return self._files.output / f'{task.job}_{task.index}.log'


def batch_script(results: Path, listed: Path) -> str:
    """
    Return the script of an array job.

    :param results: The folder of the results
    :param listed: The file with the numbers of its runs
    """
    root = Path(colcon_yamllaunch.__path__[0]).parent
    words = shlex.join(
        ['-I', '-S', '-c', _PROGRAM, str(root), str(results), str(listed)]
    )
    return (
        '#!/bin/sh\n'
        f'for python in {shlex.quote(sys.executable)} python3; do\n'
        '  if command -v "$python" > /dev/null; then\n'
        f'    exec "$python" {words}\n'
        '  fi\n'
        'done\n'
        'echo "there is no Python on $(uname -n)" >&2\n'
        'exit 127\n'
    )


def reason_of(ending: Ending | None, output: str, results: Path) -> str:
    """
    Return why a task has no result.

    :param output: The last line of its output
    :param results: The folder of the results
    """
    if ending is None:
        return (
            f'Slurm has forgotten it, and it left no result in {results}: is '
            'that on a file system that the nodes share?'
        )
    node = f' on {ending.node}' if ending.node else ''
    known = _ENDINGS.get(ending.state)
    if known is not None:
        if ending.state in _OF_NODE:
            node = f': {ending.node}' if ending.node else ''
        return f'{known.format(node)} (Slurm: {ending.state})'
    _, _, number = ending.code.partition(':')
    said = f': {output}' if output else ''
    if number.isdigit() and int(number):
        how = f'was killed by {signal_name(int(number))}{node}'
    else:
        how = f'ended{node} without a result'
        said = said or (
            f'; is {results} on a file system that the nodes share?'
        )
    return (
        f'its task {how} (Slurm: {ending.state}, exit code '
        f'{ending.code}){said}'
    )


def _last_line(output: Path) -> str:
    """Return the last line that a task wrote."""
    try:
        lines = output.read_text(errors='replace').splitlines()
    except OSError:
        return ''
    # the message of Slurm about a killed job comes last
    return next((line for line in reversed(lines) if line.strip()), '')
