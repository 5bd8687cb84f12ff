# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The runner on this machine; its run launchers are processes, some at a time.

Each run has a network of its own where that is possible, and ends when this
process ends, for any reason. The next runs are planned while others go on, and
wait for their turn.

Run launchers are forks of a process that has imported all modules and knows
the workspace, as a new program takes longer to import these than a short run
costs. A run launcher launches one run after the other, with one guard for all
of them, as each fork makes both processes copy their memory.
"""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, ExitStack, suppress
import gc
import json
import os
import resource
import signal
import socket
import sys
from typing import Any, Literal

from colcon_yamllaunch.common.adoption import end_with_parent
from colcon_yamllaunch.common.codec import to_json
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.engine.cgroup import expect_moves
from colcon_yamllaunch.engine.guard_link import GuardProcess
from colcon_yamllaunch.engine.loop import caught, Loop, received, STOPPING
from colcon_yamllaunch.engine.outcome import signal_name
from colcon_yamllaunch.sweep.isolation import (
    DOMAIN_VARIABLE,
    DomainIds,
    enter_own_network,
    reason_for_no_network,
)
from colcon_yamllaunch.sweep.results import (
    failed_run,
    MESSAGES,
    result_from_json,
    RunResult,
)
from colcon_yamllaunch.sweep.run import (
    NotBuiltError,
    perform,
    plan_failure,
    PlanError,
    Sweep,
)
from colcon_yamllaunch.sweep.table import Run

#: Bytes of a message of a run launcher; a reason and metrics are shorter.
_MESSAGE = 256 * 1024
#: Runs that are planned ahead at most.
_AHEAD = 8
#: Seconds between two updates of the progress while nothing happens.
_TICK = 0.5
#: SIGINTs to each run when the user wants it killed, and seconds between them.
_ESCALATIONS = 3
_ESCALATION_INTERVAL = 0.3
#: Seconds of a short run on average, and runs after which that is known.
_SHORT = 1.0
_KNOWN_FROM = 4
#: Sent to a run launcher when its run may start processes.
_GO = b'g'
#: Bytes that are kept of the messages of the planning of a run.
_MESSAGES_SIZE = 64 * 1024
#: Files in the message of a run that is planned.
_MOST_USES = 500
#: Runs of a run launcher, so that it does not grow without end.
_RUNS = 100
#: Bytes of the number of a run.
_NUMBER = 32


class _Child:
    """
    A run launcher, as the runner sees it.

    :param messages: The file that its standard output and error go to
    :param domain: Its ROS_DOMAIN_ID
    :ivar state: What its run does; `over` means that no process of it runs any
      more, and only bookkeeping follows
    """

    def __init__(self, messages: int, domain: int, run: Run) -> None:
        self.messages = messages
        self.domain = domain
        self.run = run
        self.has_result = False
        self.state: Literal['planning', 'ready', 'running', 'over', 'idle']
        self.state = 'planning'
        self.link, self.its_link = socket.socketpair(
            socket.AF_UNIX, socket.SOCK_SEQPACKET
        )
        self.pid = 0

    def begin(self, run: Run) -> None:
        """Send it the next run."""
        self.link.send(str(run.number).encode())
        self.run = run
        self.has_result = False
        self.state = 'planning'

    @property
    def is_launched(self) -> bool:
        """Whether there is something to stop."""
        return self.state in ('running', 'over')

    def kill(self, number: int) -> None:
        """Send it a signal."""
        # it is not reaped yet, so the id is still its own
        with suppress(ProcessLookupError):
            os.kill(self.pid, number)

    def close(self) -> None:
        """Close its descriptors."""
        self.link.close()
        os.close(self.messages)


class LocalRunner:
    """
    Launches runs on this machine.

    Its methods must be called in the main thread.
    """

    def __init__(self, sweep: Sweep) -> None:
        self._sweep = sweep
        self._jobs = sweep.jobs or len(os.sched_getaffinity(0))
        self._own_network = False
        self._queue: deque[Run] = deque()
        self._runs: dict[int, Run] = {}
        # runs that need packages that are not built
        self._unbuilt: list[Run] = []
        self._children: list[_Child] = []
        self._loop = Loop()
        self._file_limits = resource.getrlimit(resource.RLIMIT_NOFILE)
        # the seconds of the first runs, and the process for short ones
        self._seconds: list[float] = []
        self._mover = 0
        self._stopped_by: int | None = None
        self._escalates = False

    def run(self, runs: Sequence[Run]) -> int | None:
        """
        Run all, and return the signal that stopped that, if one did.

        :raises UserError: when no run can be started
        """
        self._sweep.build(runs[0])
        self._domains = self._domain_ids()
        self._queue.extend(runs)
        self._runs = {run.number: run for run in runs}
        with (
            closing(self._domains),
            caught(STOPPING) as signals,
            ExitStack() as stack,
        ):
            # each run has two descriptors here
            most = self._file_limits[1]
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
            stack.callback(
                resource.setrlimit, resource.RLIMIT_NOFILE, self._file_limits
            )
            # run launchers share all objects as long as nobody writes to them
            gc.collect()
            gc.freeze()
            stack.callback(gc.unfreeze)
            self._loop.add_reader(signals, self._read_signals, signals)
            self._wake()
            try:
                while self._has_work():
                    self._sweep.progress.tick()
                    self._loop.run_once()
            finally:
                self._end_all()
                if self._mover:
                    os.kill(self._mover, signal.SIGKILL)
                    os.waitpid(self._mover, 0)
                self._loop.close()
        return self._stopped_by

    def _domain_ids(self) -> DomainIds:
        share, reason = self._sweep.share_network, ''
        if not share:
            reason = reason_for_no_network()
            self._own_network = not reason
        shared = not self._own_network
        domains = DomainIds(self._sweep.environment, shared=shared)
        if shared and self._jobs > domains.count:
            why = 'as they share the network of the machine'
            if not share:
                why = (
                    f'as none can have a network of its own here ({reason}), '
                    'and each needs a ROS_DOMAIN_ID of its own'
                )
            text = f'--jobs is limited to {domains.count}, {why}'
            self._sweep.progress.say(text)
            self._jobs = domains.count
        return domains

    def _has_work(self) -> bool:
        """Plan and start runs; return whether to wait for something."""
        if self._stopped_by is None:
            self._plan_next()
            self._start_ready()
        if all(child.state == 'idle' for child in self._children):
            return bool(self._queue) and self._stopped_by is None
        return True

    def _wake(self) -> None:
        """Begin a turn of the loop now and then."""
        self._loop.call_later(_TICK, self._wake)

    def _read_signals(self, signals: int) -> None:
        for number in received(signals):
            self._stop(number)

    def _plan_next(self) -> None:
        """Make idle and new run launchers plan the next runs."""
        if self._unbuilt:
            return
        for child in self._children:
            if self._queue and child.state == 'idle':
                run = self._queue[0]
                self._sweep.folder.clear(run.number)
                # a killed run launcher ends soon, and another one gets the run
                with suppress(OSError):
                    child.begin(run)
                    self._queue.popleft()
                    self._sweep.progress.planned(run)
        most = self._jobs + min(self._jobs, _AHEAD)
        while self._queue and len(self._children) < most:
            domain = self._domains.reserve()
            if domain is None:
                if self._children:
                    return
                raise UserError(
                    'every ROS_DOMAIN_ID is taken by other sweeps',
                    'wait for them',
                )
            run = self._queue.popleft()
            try:
                self._fork_launcher(run, domain)
            except OSError as e:
                self._domains.release(domain)
                self._queue.appendleft(run)
                if self._children:
                    # there may be room when another one has ended
                    return
                raise UserError(
                    f'no run can be started: {e.strerror or e}',
                    'try fewer --jobs',
                ) from e

    def _fork_launcher(self, run: Run, domain: int) -> None:
        self._sweep.folder.clear(run.number)
        self._sweep.progress.planned(run)
        sys.stdout.flush()
        sys.stderr.flush()
        messages = os.memfd_create('messages')
        try:
            child = _Child(messages, domain, run)
        except OSError:
            os.close(messages)
            raise
        parent = os.getpid()

        def work() -> int:
            child.link.close()
            for other in self._children:
                other.close()
            resource.setrlimit(resource.RLIMIT_NOFILE, self._file_limits)
            launcher = _RunLauncher(
                self._sweep, child, own_network=self._own_network
            )
            return launcher.work(parent, self._runs, run)

        with child.its_link:
            try:
                child.pid = _fork(work, messages)
            except OSError:
                child.close()
                raise
        self._children.append(child)
        self._loop.add_reader(child.link.fileno(), self._receive, child)

    def _start_ready(self) -> None:
        """Start planned runs, as far as others leave room."""
        children = self._children
        running = sum(child.state == 'running' for child in children)
        if self._unbuilt:
            if not running:
                self._build()
            return
        for child in children:
            if running < self._jobs and child.state == 'ready':
                child.state = 'running'
                running += 1
                # its programs may have been edited since
                self._sweep.progress.planned(child.run)
                with suppress(OSError):
                    child.link.send(_GO)
        self._sweep.progress.set_running(running)

    def _build(self) -> None:
        """Build the packages that runs need, and plan all runs again."""
        waiting = [
            child.run
            for child in self._children
            if not child.has_result and child.run not in self._unbuilt
        ]
        self._end_all()
        for run in self._unbuilt:
            self._sweep.build(run)
        self._queue.extendleft(reversed([*self._unbuilt, *waiting]))
        self._unbuilt.clear()
        gc.collect()
        gc.freeze()

    def _receive(self, child: _Child) -> None:
        """Receive a message of a run launcher, or notice its end."""
        data = b''
        with suppress(OSError):
            data = child.link.recv(_MESSAGE)
        if not data:
            self._ended(child)
            return
        match json.loads(data):
            case {'planned': uses}:
                child.state = 'ready'
                if uses:
                    self._sweep.progress.planned(child.run, uses)
            case {'over': True}:
                child.state = 'over'
            case {'not built': True}:
                self._unbuilt.append(child.run)
            case {'result': values, 'idle': is_idle}:
                result = result_from_json(values)
                if result is not None:
                    self._done(child, result)
                    if is_idle:
                        child.state = 'idle'
            case _:
                return

    def _ended(self, child: _Child) -> None:
        """Handle the end of a run launcher, in order or not."""
        status = self._reap(child)
        is_expected = child.has_result or child.run in self._unbuilt
        if not is_expected and self._stopped_by is None:
            code = os.waitstatus_to_exitcode(status)
            how = (
                f'was killed by {signal_name(-code)}'
                if code < 0
                else f'ended with exit code {code}'
            )
            reason = f'the process that launched it {how}'
            result = failed_run(child.run.number, reason)
            self._sweep.progress.done(child.run, result)

    def _done(self, child: _Child, result: RunResult) -> None:
        """Record a result, and the messages of the planning of the run."""
        child.has_result = True
        if text := os.pread(child.messages, _MESSAGES_SIZE, 0):
            folder = self._sweep.folder.run_folder(child.run.number)
            with suppress(OSError):
                folder.mkdir(parents=True, exist_ok=True)
                (folder / MESSAGES).write_bytes(text)
            os.ftruncate(child.messages, 0)
            os.lseek(child.messages, 0, os.SEEK_SET)
        self._sweep.progress.done(child.run, result)
        if len(self._seconds) < _KNOWN_FROM:
            self._seconds.append(result.seconds)
            is_known = len(self._seconds) == _KNOWN_FROM
            if is_known and sum(self._seconds) < _SHORT * _KNOWN_FROM:
                parent = os.getpid()
                with suppress(OSError):
                    self._mover = _fork(lambda: _keep_moves_fast(parent))

    def _reap(self, child: _Child) -> int:
        """Wait for a run launcher that ends, and return its status."""
        self._children.remove(child)
        self._loop.remove(child.link.fileno())
        # a run launcher that waits for its next run ends
        child.close()
        _, status = os.waitpid(child.pid, 0)
        self._domains.release(child.domain)
        return status

    def _stop(self, number: int) -> None:
        """Stop all runs, or kill them if they are being stopped already."""
        is_first = self._stopped_by is None
        children = self._children
        count = sum(child.is_launched for child in children)
        self._sweep.progress.interrupted(count, escalates=not is_first)
        if is_first:
            self._stopped_by = number
            for child in children:
                # runs that wait have nothing to stop
                child.kill(
                    signal.SIGINT if child.is_launched else signal.SIGKILL
                )
        elif not self._escalates:
            self._escalate(_ESCALATIONS)

    def _escalate(self, left: int) -> None:
        """Make the launches stop their processes, signal by signal."""
        self._escalates = left > 0
        if left:
            for child in self._children:
                child.kill(signal.SIGINT)
            self._loop.call_later(
                _ESCALATION_INTERVAL, self._escalate, left - 1
            )

    def _end_all(self) -> None:
        """End all run launchers; their runs are stopped in their own way."""
        for child in self._children:
            child.kill(signal.SIGTERM if child.is_launched else signal.SIGKILL)
        for child in self._children.copy():
            self._reap(child)


def _fork(action: Callable[[], int | None], output: int = -1) -> int:
    """
    Call `action` in a child process, and return the child's process id.

    The child has its own session, so keys of the terminal do not reach it, and
    the default signal handlers. The result of `action` is its exit code.

    :param output: The descriptor for standard output and error; -1 for none
    :raises OSError: when there can be no further process
    """
    pid = os.fork()
    if pid:
        return pid
    code = 1
    try:
        signal.set_wakeup_fd(-1)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_DFL)
        os.setsid()
        null = os.open(os.devnull, os.O_RDWR)
        os.dup2(null, 0)
        for target in (1, 2):
            os.dup2(null if output == -1 else output, target)
        os.close(null)
        code = action() or 0
    finally:
        os._exit(code)


def _keep_moves_fast(parent: int) -> None:
    """
    Keep the kernel ready to move processes to control groups.

    Its first move waits for some 10 ms, moves soon after it do not, see
    :func:`.cgroup.expect_moves`. That is a tenth of a run of 0.1 s.
    """
    end_with_parent(signal.SIGTERM, parent)
    os.closerange(3, os.sysconf('SC_OPEN_MAX'))
    while expect_moves():
        pass


class _RunLauncher:
    """
    A process of its own that plans and launches runs.

    :param child: What it has in common with the runner
    """

    def __init__(
        self, sweep: Sweep, child: _Child, *, own_network: bool
    ) -> None:
        self._sweep = sweep
        self._child = child
        self._link = child.its_link
        self._own_network = own_network

    def work(self, parent: int, runs: Mapping[int, Run], run: Run) -> int:
        """
        Launch `run`, then those whose numbers arrive; return the exit code.

        :param parent: The runner; the run launcher ends with it
        """
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            with closing(GuardProcess(is_kept=True)) as guard:
                for left in reversed(range(_RUNS)):
                    if self._own_network:
                        enter_own_network(again=left + 1 < _RUNS)
                    # the new network has undone it
                    end_with_parent(signal.SIGTERM, parent)
                    message = self._launch(run, guard)
                    sys.stdout.flush()
                    sys.stderr.flush()
                    message['idle'] = left > 0 and message.get('idle', True)
                    self._send(message)
                    number = b''
                    if message['idle']:
                        number = self._link.recv(_NUMBER)
                    if not number:
                        break
                    run = runs[int(number)]
        except KeyboardInterrupt:
            return 130
        except Exception as e:  # noqa: BLE001 - the other runs go on
            with suppress(OSError):
                self._send(
                    {**_error(run, f'internal error: {e!r}'), 'idle': False}
                )
            return 1
        finally:
            with suppress(Exception):
                sys.stdout.flush()
                sys.stderr.flush()
        return 0

    def _launch(self, run: Run, guard: GuardProcess) -> dict[str, Any]:
        """Plan a run, wait for its turn, and return its result."""
        sweep = self._sweep
        folder = sweep.folder.run_folder(run.number)
        try:
            variables = {DOMAIN_VARIABLE: str(self._child.domain)}
            planned = sweep.plan(run, folder, variables)
        except NotBuiltError:
            return {'not built': True}
        except (PlanError, UserError) as e:
            sys.stderr.flush()
            text = os.pread(self._child.messages, _MESSAGES_SIZE, 0)
            return _error(run, plan_failure(e, text.decode(errors='replace')))

        def wait() -> None:
            self._send({'planned': planned.uses[:_MOST_USES]})
            if self._link.recv(len(_GO)) != _GO:
                raise KeyboardInterrupt

        def over() -> None:
            # a runner that is gone starts no other run
            with suppress(OSError):
                self._send({'over': True})

        try:
            result = perform(
                run.number, planned, folder, sweep.goal, guard, wait, over
            )
        finally:
            planned.close()
        if result is None:
            raise KeyboardInterrupt
        # the worker of a launch file in Python may leave something behind
        return {'result': to_json(result), 'idle': not planned.participants}

    def _send(self, message: dict[str, Any]) -> None:
        self._link.send(json.dumps(message).encode())


def _error(run: Run, reason: str) -> dict[str, Any]:
    return {'result': to_json(failed_run(run.number, reason))}
