# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The runs of a sweep as array jobs of Slurm, a task each.

The jobs belong to Slurm: a sweep that is killed leaves them there, and the
next one with the same command takes them over.
"""

from collections import Counter
from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
import os
from pathlib import Path
import select
import shlex
import signal
import sys
import time
from typing import Protocol

import colcon_yamllaunch
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.outcome import signal_name
from colcon_yamllaunch.sweep.results import one_reason
from colcon_yamllaunch.sweep.results import RunResult
from colcon_yamllaunch.sweep.slurm_client import Ending
from colcon_yamllaunch.sweep.slurm_client import SlurmClient
from colcon_yamllaunch.sweep.slurm_client import SlurmError
from colcon_yamllaunch.sweep.slurm_files import SlurmFiles
from colcon_yamllaunch.sweep.slurm_place import SlurmPlace
from colcon_yamllaunch.sweep.table import Run

#: Seconds between two looks for results, and between two questions to Slurm.
_LOOK = 0.5
_ASK = 2.0
#: How many times longer than an answer takes Slurm is left alone.
_SHARE = 10.0
#: Seconds that a result may take from the node to us, over the network.
_DELAY = 10.0
#: Seconds between two tries to submit what Slurm did not take.
_AGAIN = 20.0
#: Seconds that cancelled tasks have to end.
_END = 60.0
#: States of tasks that have ended (squeue(1), "JOB STATE CODES").
_OVER = frozenset(
    ('BF', 'CA', 'CD', 'DL', 'F', 'NF', 'OOM', 'PR', 'RV', 'SE', 'TO')
)
_PENDING = frozenset(('PD', 'CF', 'RQ', 'RH', 'RS'))
#: Why a task waits that will run in its turn, or nearly so.
_ORDINARY = frozenset(
    (
        *('None', 'Priority', 'Resources', 'JobArrayTaskLimit', 'BeginTime'),
        *('Prolog', 'Cleaning', 'Dependency', 'NodesBusy', ''),
    )
)
_PROGRAM = (
    'import sys; sys.path.append(sys.argv.pop(1)); '
    'from colcon_yamllaunch.sweep.slurm_task import main; '
    'sys.exit(main())'
)
#: What a state comes to for the user; `{}` is where it was.
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
#: Those that are about the node.
_OF_NODE = ('NODE_FAIL', 'BOOT_FAIL')
#: What the user, or the sweep itself, did: it is to be run once more.
_CANCELLED = ('CANCELLED', 'REVOKED')


class SlurmWatcher(Protocol):
    """Who is told what happens."""

    def began(self, running: int) -> None:
        """Take note of how many runs go on."""

    def waiting(self, text: str) -> None:
        """Take note of what runs wait for."""

    def done(self, run: Run, result: RunResult) -> None:
        """Take note of what came of a run."""

    def interrupted(self, running: int, *, hurry: bool) -> None:
        """Tell that those that run are being stopped."""

    def say(self, text: str) -> None:
        """Show a line."""

    def tick(self) -> None:
        """Show the time."""


@dataclass(frozen=True, slots=True)
class _Task:
    """
    A task of an array job.

    :param index: Its index there
    """

    job: int
    index: int
    run: Run


class SlurmRunner:
    """
    Has runs done.

    :param jobs: How many at a time, None for as many as Slurm lets
    :param name: What the jobs are called
    """

    def __init__(
        self,
        client: SlurmClient,
        place: SlurmPlace,
        files: SlurmFiles,
        watcher: SlurmWatcher,
        name: str,
        jobs: int | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._client = client
        self._place = place
        self._files = files
        self._watcher = watcher
        self._name = name
        self._jobs = jobs
        self._clock = clock
        self._arrays: dict[int, list[int]] = {}
        self._tasks: dict[int, _Task] = {}
        # parts of what is to be submitted, and when it is tried again
        self._chunks: list[list[Run]] = []
        self._next_try = 0.0
        # when a task was first seen to be over, without a result
        self._over: dict[int, float] = {}
        self._next_ask = 0.0
        self._told: set[str] = set()
        #: The signal that the user stopped it with, if any.
        self.stopped_by: int | None = None
        self._deadline = 0.0

    def take_over(self, runs: Iterable[Run]) -> list[Run]:
        """
        Take over what an earlier sweep left; return what else is to be done.

        :raises SlurmError: when Slurm does not answer
        """
        missing = {run.number: run for run in runs}
        for result in self._files.results():
            run = missing.pop(result.run, None)
            if run is not None:
                self._watcher.done(run, result)
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
            self._watcher.say(f'{count:,} {what} with Slurm already')
        return list(missing.values())

    def run(self, runs: Iterable[Run]) -> None:
        """
        Do runs until all are done, or somebody stops that.

        Must be called in the main thread.

        :raises SlurmError: when Slurm does not take them
        """
        todo = list(runs)
        size = self._client.array_size()
        self._chunks = [
            todo[start : start + size] for start in range(0, len(todo), size)
        ]
        reader, writer = os.pipe()
        os.set_blocking(reader, False)
        os.set_blocking(writer, False)
        before = {
            number: signal.signal(number, _ignored)
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
            # who has it ignored, by nohup, means that
            if number != signal.SIGHUP
            or signal.getsignal(number) != signal.SIG_IGN
        }
        wakeup = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
        try:
            self._submit()
            while self._tasks or self._chunks:
                select.select([reader], [], [], _LOOK)
                self._take_signals(reader)
                self._collect()
                self._ask()
                if self.stopped_by is None:
                    self._submit()
                elif self._clock() >= self._deadline:
                    break
                self._watcher.tick()
        finally:
            if self._tasks and self.stopped_by is None:
                # whatever it is, nothing is to go on that nobody waits for
                self._cancel(hurry=False)
            signal.set_wakeup_fd(wakeup)
            for number, handler in before.items():
                signal.signal(
                    number, signal.SIG_DFL if handler is None else handler
                )
            os.close(reader)
            os.close(writer)

    def _submit(self) -> None:
        """Submit what there is, as far as Slurm takes it."""
        while self._chunks and self._clock() >= self._next_try:
            # where it is said how many at a time, an array after the other
            if self._jobs is not None and self._tasks:
                return
            chunk = self._chunks[0]
            numbers = [run.number for run in chunk]
            script = batch_script(
                self._files.folder.parent, self._files.write_list(numbers)
            )
            limit = '' if self._jobs is None else f'%{self._jobs}'
            options = (
                f'--job-name={self._name}',
                f'--array=0-{len(chunk) - 1}{limit}',
                f'--output={self._files.output}/%A_%a.log',
                '--no-requeue',
                '--open-mode=append',
                *self._place.options,
            )
            try:
                job = self._client.submit(options, script)
            except SlurmError as e:
                if not self._tasks:
                    raise SlurmError(
                        f'Slurm does not take the runs: {e}'
                    ) from e
                # there may be place when others have ended
                self._next_try = self._clock() + _AGAIN
                return
            del self._chunks[0]
            self._arrays[job] = numbers
            for index, run in enumerate(chunk):
                self._tasks[run.number] = _Task(job, index, run)
            self._files.write_arrays(self._arrays)

    def _collect(self) -> None:
        """Take the results that there are."""
        for result in self._files.results():
            task = self._tasks.get(result.run)
            if task is not None:
                self._done(task, result)

    def _done(self, task: _Task, result: RunResult) -> None:
        del self._tasks[task.run.number]
        self._over.pop(task.run.number, None)
        self._watcher.done(task.run, result)
        output = self._output_of(task)
        try:
            if not output.stat().st_size:
                output.unlink()
        except OSError:
            return

    def _ask(self) -> None:
        """Ask Slurm what became of those that have no result."""
        now = self._clock()
        if now < self._next_ask or not self._tasks:
            return
        jobs = {task.job for task in self._tasks.values()}
        try:
            queue = self._client.queue(jobs)
        except SlurmError as e:
            self._watcher.waiting(f'Slurm does not answer: {e}')
            self._next_ask = self._clock() + _ASK
            return
        took = self._clock() - now
        self._next_ask = self._clock() + max(_ASK, _SHARE * took)
        reasons: Counter[str] = Counter()
        running = 0
        for task in tuple(self._tasks.values()):
            state, reason = queue.get((task.job, task.index), ('', ''))
            if state in _PENDING:
                reasons[reason] += 1
            elif state and state not in _OVER:
                running += 1
            else:
                self._mind_end(task, now)
        self._watcher.began(running)
        waiting = reasons.total()
        self._watcher.waiting(f'{waiting:,} waiting' if waiting else '')
        for reason in reasons:
            if reason not in _ORDINARY and reason not in self._told:
                self._told.add(reason)
                self._watcher.say(
                    f'Slurm lets {reasons[reason]:,} runs wait: {reason}'
                )

    def _mind_end(self, task: _Task, now: float) -> None:
        """Give a task up that is over, and has left no result."""
        number = task.run.number
        since = self._over.setdefault(number, now)
        ending = self._client.ending(task.job, task.index)
        state = '' if ending is None else ending.state
        # who has ended in order has written a result, which is on its way
        in_order = state in ('COMPLETED', 'COMPLETING', 'RUNNING', '')
        if in_order and now - since < _DELAY and self.stopped_by is None:
            return
        if state.startswith(_CANCELLED) or self.stopped_by is not None:
            del self._tasks[number]
            self._over.pop(number, None)
            if self.stopped_by is None and 'cancelled' not in self._told:
                self._told.add('cancelled')
                self._watcher.say(
                    'runs were cancelled at Slurm; the same command does them '
                    'later'
                )
            return
        text = _last_words(self._output_of(task))
        reason = reason_of(ending, text, str(self._files.folder.parent))
        self._done(task, RunResult(number, 'error', one_reason(reason)))

    def _take_signals(self, reader: int) -> None:
        try:
            numbers = os.read(reader, 4096)
        except BlockingIOError:
            return
        for number in numbers:
            if number not in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                continue
            if number == signal.SIGHUP:
                # nobody sees it any more, and the next one takes it over
                self.stopped_by = number
                self._deadline = self._clock()
                return
            hurry = self.stopped_by is not None
            self._watcher.interrupted(len(self._tasks), hurry=hurry)
            if not hurry:
                self.stopped_by = number
                self._deadline = self._clock() + _END
                self._chunks.clear()
            self._cancel(hurry=hurry)
            self._next_ask = 0.0

    def _cancel(self, *, hurry: bool) -> None:
        jobs = {task.job for task in self._tasks.values()}
        try:
            self._client.cancel(jobs, kill=hurry)
        except SlurmError as e:
            listed = ' '.join(map(str, sorted(jobs)))
            self._watcher.say(
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


def reason_of(ending: Ending | None, output: str, results: str) -> str:
    """
    Return why a task came to nothing.

    :param output: The last line that it wrote
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
    if number.isdigit() and int(number):
        how = f'was killed by {signal_name(int(number))}{node}'
        said = f': {output}' if output else ''
    else:
        how = f'ended{node} without a result'
        said = f': {output}'
        if not output:
            said = f'; is {results} on a file system that the nodes share?'
    return (
        f'its task {how} (Slurm: {ending.state}, exit code '
        f'{ending.code}){said}'
    )


def _last_words(output: Path) -> str:
    """Return the last line that a task wrote."""
    try:
        lines = output.read_text(errors='replace').splitlines()
    except OSError:
        return ''
    # what Slurm says of a job it kills comes last, and tells most
    return next((line for line in reversed(lines) if line.strip()), '')


def _ignored(number: int, frame: object) -> None:
    """Let the wake-up descriptor do the work."""
