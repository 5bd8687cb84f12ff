# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The runs of a sweep on this machine, some at a time.

Workers do them: forks of this process, which has imported all and knows the
workspace. A worker does one run after the other, as most of what a short run
costs is the memory that a fork copies. Each run has a network of its own where
that is possible, and ends when this process does, whatever ends that. The next
runs are planned while others go on, and wait until it is their turn.
"""

from collections import deque
from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import suppress
import gc
import json
import os
from pathlib import Path
import resource
import select
import signal
import socket
import sys
import time
from typing import Any
from typing import NoReturn
from typing import Protocol

from colcon_yamllaunch.common.codec import to_json
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.outcome import signal_name
from colcon_yamllaunch.sweep.domain_ids import DomainIds
from colcon_yamllaunch.sweep.domain_ids import VARIABLE
from colcon_yamllaunch.sweep.forked_guard import ForkedGuards
from colcon_yamllaunch.sweep.isolation import end_with
from colcon_yamllaunch.sweep.isolation import enter_own_network
from colcon_yamllaunch.sweep.move_keeper import MoveKeeper
from colcon_yamllaunch.sweep.results import MESSAGES
from colcon_yamllaunch.sweep.results import one_reason
from colcon_yamllaunch.sweep.results import result_from_json
from colcon_yamllaunch.sweep.results import RunResult
from colcon_yamllaunch.sweep.run import Goal
from colcon_yamllaunch.sweep.run import perform
from colcon_yamllaunch.sweep.run import PlannedRun
from colcon_yamllaunch.sweep.table import Run

#: Bytes of a message of a run; a reason and metrics are shorter.
_MESSAGE = 256 * 1024
#: Files that a run names in such a message.
_MOST_USES = 500
#: Bytes that are kept of what the planning of a run says.
_SAID = 64 * 1024
#: How many runs are planned ahead at most.
_AHEAD = 8
#: How often a run is asked to hurry when the user does not want to wait, and
#: how many seconds lie between.
_HURRIES = 3
_HURRY_INTERVAL = 0.3
_GO = b'g'
#: Runs that a worker does, so that it does not grow without end, and bytes of
#: the number of one.
_RUNS_OF_WORKER = 100
_NUMBER = 32


class NotBuiltError(Exception):
    """A run needs packages that are to be built first."""


class PlanError(Exception):
    """A run cannot be planned; what is wrong was said."""


class Work(Protocol):
    """What a launch is made of; see `verb/sweeping`."""

    def plan(
        self, run: Run, folder: Path, variables: dict[str, str]
    ) -> PlannedRun:
        """
        Plan a run, in another process.

        :param folder: Where its logs go
        :param variables: Variables that its environment has, too
        :raises NotBuiltError: when it needs what is not built
        :raises PlanError: when it cannot be planned
        """

    def leave(self) -> None:
        """Close what was planned last, in the process that planned it."""

    def build(self, run: Run) -> None:
        """
        Build what a run needs, in this process, while nothing runs.

        :raises SweepEndError: when that fails
        """


class Watcher(Protocol):
    """Who is told what happens."""

    def began(self, running: int) -> None:
        """Take note of how many runs go on."""

    def planned(self, run: Run, uses: Collection[str] = ()) -> None:
        """Take note that a run is planned, with more files that it uses."""

    def done(self, run: Run, result: RunResult) -> None:
        """Take note of what came of a run."""

    def interrupted(self, running: int, *, hurry: bool) -> None:
        """Tell that those that run are being stopped."""

    def tick(self) -> None:
        """Show the time."""


@dataclass(frozen=True, slots=True)
class Settings:
    """
    How runs are done.

    :param jobs: How many at a time
    :param own_network: Whether each has a network of its own
    """

    jobs: int
    own_network: bool
    goal: Goal
    folder_of: Callable[[int], Path]
    clear: Callable[[int], None]


class _Child:
    """A worker, whose run is planned, waits or goes on, or that is idle."""

    def __init__(
        self, run: Run, pid: int, link: socket.socket, said: int, domain: int
    ) -> None:
        self.pid = pid
        self.link = link
        self.said = said
        self.domain = domain
        self.begin(run)

    def begin(self, run: Run) -> None:
        """Have another run."""
        self.run = run
        self.is_idle = False
        self.is_planned = False
        self.goes_on = False
        self.is_over = False
        self.result: RunResult | None = None

    def rest(self) -> None:
        """Have none."""
        self.begin(self.run)
        self.is_idle = True


class LocalRunner:
    """
    Does runs.

    :param domains: Gives each its domain
    """

    def __init__(
        self,
        settings: Settings,
        work: Work,
        watcher: Watcher,
        domains: DomainIds,
    ) -> None:
        self._settings = settings
        self._work = work
        self._watcher = watcher
        self._domains = domains
        self._queue: deque[Run] = deque()
        self._runs: dict[int, Run] = {}
        # those that need what is not built
        self._unbuilt: list[Run] = []
        self._children: dict[int, _Child] = {}
        self._poll = select.poll()
        self._moves = MoveKeeper()
        #: The signal that the user stopped it with, if any.
        self.stopped_by: int | None = None
        self._files = resource.getrlimit(resource.RLIMIT_NOFILE)
        self._hurries = 0
        self._next_hurry = 0.0

    def run(self, runs: Iterable[Run]) -> None:
        """
        Do runs until all are done, or somebody stops that.

        Must be called in the main thread.
        """
        self._queue.extend(runs)
        self._runs = {run.number: run for run in self._queue}
        # what both have is shared as long as nobody writes to it
        gc.collect()
        gc.freeze()
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
        self._poll.register(reader, select.POLLIN)
        # each run has two descriptors here
        files = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (files[1], files[1]))
        self._files = files
        try:
            while self._turn(reader):
                pass
        finally:
            self._end_all()
            self._moves.end()
            resource.setrlimit(resource.RLIMIT_NOFILE, files)
            self._poll.unregister(reader)
            signal.set_wakeup_fd(wakeup)
            for number, handler in before.items():
                signal.signal(
                    number, signal.SIG_DFL if handler is None else handler
                )
            os.close(reader)
            os.close(writer)
            gc.unfreeze()

    def _turn(self, reader: int) -> bool:
        """Wait for something and do it; return whether to go on."""
        if self.stopped_by is None:
            self._fill()
            self._begin()
        if all(child.is_idle for child in self._children.values()):
            return bool(self._queue) and self.stopped_by is None
        self._watcher.tick()
        for descriptor, _ in self._poll.poll(self._wait()):
            if descriptor == reader:
                self._take_signals(reader)
            elif descriptor in self._children:
                self._hear(self._children[descriptor])
        self._hurry()
        return True

    def _wait(self) -> int:
        """Return how long there is nothing to do (milliseconds)."""
        return 100 if self._hurries else 500

    def _fill(self) -> None:
        """Have the next runs planned."""
        if self._unbuilt:
            return
        for child in self._children.values():
            if self._queue and child.is_idle:
                self._employ(child)
        most = self._settings.jobs + min(self._settings.jobs, _AHEAD)
        while self._queue and len(self._children) < most:
            domain = self._domains.take()
            if domain is None:
                if self._children:
                    return
                raise UserError(
                    'every ROS_DOMAIN_ID is taken by other sweeps',
                    'wait for them',
                )
            run = self._queue.popleft()
            try:
                self._fork(run, domain)
            except OSError as e:
                self._domains.give_back(domain)
                self._queue.appendleft(run)
                if self._children:
                    # when another one has ended, there may be room
                    return
                raise UserError(
                    f'no run can be started: {e.strerror or e}',
                    'try fewer --jobs',
                ) from e

    def _employ(self, child: _Child) -> None:
        """Give the next run to a worker that is idle."""
        run = self._queue[0]
        self._settings.clear(run.number)
        # one that was killed ends in a moment, and another one has the run
        with suppress(OSError):
            child.link.send(str(run.number).encode())
            self._queue.popleft()
            child.begin(run)
            self._watcher.planned(run)

    def _begin(self) -> None:
        """Let those begin that are planned."""
        running = sum(
            c.goes_on and not c.is_over for c in self._children.values()
        )
        if self._unbuilt:
            if not running:
                self._build()
            return
        for child in self._children.values():
            if running >= self._settings.jobs:
                break
            if child.is_planned and not child.goes_on:
                child.goes_on = True
                running += 1
                # its programs may have been edited since
                self._watcher.planned(child.run)
                with suppress(OSError):
                    child.link.send(_GO)
        self._watcher.began(running)

    def _build(self) -> None:
        """Build what runs need; all that is planned is planned anew."""
        waiting = [
            child.run
            for child in self._children.values()
            if not child.is_idle and child.run not in self._unbuilt
        ]
        self._end_all()
        for run in self._unbuilt:
            self._work.build(run)
        waiting = [*self._unbuilt, *waiting]
        self._queue.extendleft(reversed(waiting))
        self._unbuilt.clear()
        gc.collect()
        gc.freeze()

    def _fork(self, run: Run, domain: int) -> None:
        settings = self._settings
        settings.clear(run.number)
        self._watcher.planned(run)
        said = os.memfd_create('said')
        sys.stdout.flush()
        sys.stderr.flush()
        ours = its = None
        try:
            ours, its = socket.socketpair(
                socket.AF_UNIX, socket.SOCK_SEQPACKET
            )
            pid = os.fork()
        except OSError:
            for one in (ours, its):
                if one is not None:
                    one.close()
            os.close(said)
            raise
        if not pid:
            ours.close()
            for child in self._children.values():
                child.link.close()
                os.close(child.said)
            resource.setrlimit(resource.RLIMIT_NOFILE, self._files)
            _be(run, its, said, domain, settings, self._work, self._runs)
        its.close()
        child = _Child(run, pid, ours, said, domain)
        self._children[ours.fileno()] = child
        self._poll.register(ours, select.POLLIN)

    def _hear(self, child: _Child) -> None:
        """Take what a run tells, or its end."""
        data = b''
        with suppress(OSError):
            data = child.link.recv(_MESSAGE)
        if not data:
            self._ended(child)
            return
        match json.loads(data):
            case {'planned': uses}:
                child.is_planned = True
                if uses:
                    self._watcher.planned(child.run, uses)
            case {'over': True}:
                child.is_over = True
            case {'not built': True}:
                self._unbuilt.append(child.run)
            case {'result': values, 'idle': is_idle}:
                child.result = result_from_json(values)
                if is_idle and child.result is not None:
                    self._finish(child, child.result)
                    child.rest()
            case _:
                return

    def _ended(self, child: _Child) -> None:
        """Take note that a worker ended, in order or not."""
        if child.result is not None:
            self._finish(child, child.result)
        status = self._forget(child)
        is_unbuilt = child.run in self._unbuilt
        is_done = child.is_idle or child.result is not None
        if is_done or is_unbuilt or self.stopped_by is not None:
            return
        code = os.waitstatus_to_exitcode(status)
        how = (
            f'was killed by {signal_name(-code)}'
            if code < 0
            else f'ended with exit code {code}'
        )
        reason = f'what launches it {how}'
        result = RunResult(child.run.number, 'error', reason)
        self._watcher.done(child.run, result)

    def _finish(self, child: _Child, result: RunResult) -> None:
        """Keep what came of a run, and what was said as it was planned."""
        if os.lseek(child.said, 0, os.SEEK_END):
            _keep(child, self._settings.folder_of(child.run.number))
            os.ftruncate(child.said, 0)
            os.lseek(child.said, 0, os.SEEK_SET)
        self._moves.note(result.seconds)
        self._watcher.done(child.run, result)

    def _forget(self, child: _Child) -> int:
        """Reap a worker that ends, and return its status."""
        del self._children[child.link.fileno()]
        self._poll.unregister(child.link)
        child.link.close()
        _, status = os.waitpid(child.pid, 0)
        self._domains.give_back(child.domain)
        os.close(child.said)
        return status

    def _take_signals(self, reader: int) -> None:
        for number in os.read(reader, 4096):
            if number not in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                continue
            is_first = self.stopped_by is None
            running = [c for c in self._children.values() if c.goes_on]
            self._watcher.interrupted(len(running), hurry=not is_first)
            if is_first:
                self.stopped_by = number
                for child in self._children.values():
                    # those that wait have nothing to stop
                    _signal(
                        child,
                        signal.SIGINT if child.goes_on else signal.SIGKILL,
                    )
            elif not self._hurries:
                self._hurries = _HURRIES

    def _hurry(self) -> None:
        """Have what is being stopped be killed, step by step."""
        if not self._hurries or time.monotonic() < self._next_hurry:
            return
        self._next_hurry = time.monotonic() + _HURRY_INTERVAL
        self._hurries -= 1
        for child in self._children.values():
            _signal(child, signal.SIGINT)

    def _end_all(self) -> None:
        """End whatever there is; what runs is stopped in its own way."""
        for child in self._children.values():
            _signal(child, signal.SIGTERM if child.goes_on else signal.SIGKILL)
        for child in tuple(self._children.values()):
            self._forget(child)


def _signal(child: _Child, number: int) -> None:
    # it is not reaped yet, so the id is still its own
    with suppress(ProcessLookupError):
        os.kill(child.pid, number)


def _keep(child: _Child, folder: Path) -> None:
    """Keep what was said in the planning of a run, for its reader."""
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / MESSAGES).write_bytes(os.pread(child.said, _SAID, 0))


def _ignored(number: int, frame: object) -> None:
    """Let the wake-up descriptor do the work."""


def _be(
    run: Run,
    link: socket.socket,
    said: int,
    domain: int,
    settings: Settings,
    work: Work,
    runs: Mapping[int, Run],
) -> NoReturn:
    """Be a worker, to its end."""
    parent = os.getppid()
    guards = ForkedGuards()
    code = 1
    try:
        signal.set_wakeup_fd(-1)
        for number in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        # the keys of the terminal are for the sweep
        os.setsid()
        null = os.open(os.devnull, os.O_RDWR)
        for descriptor, target in ((null, 0), (said, 1), (said, 2)):
            os.dup2(descriptor, target)
        os.close(null)
        for left in reversed(range(_RUNS_OF_WORKER)):
            if settings.own_network:
                enter_own_network(again=left + 1 < _RUNS_OF_WORKER)
            end_with(parent)
            message = _do(run, link, said, domain, settings, work, guards)
            sys.stdout.flush()
            sys.stderr.flush()
            message['idle'] = left > 0 and message.get('idle', True)
            _tell(link, message)
            following = link.recv(_NUMBER) if message['idle'] else b''
            if not following:
                break
            run = runs[int(following)]
        code = 0
    except KeyboardInterrupt:
        code = 130
    except Exception as e:  # noqa: BLE001 - the others are to be run
        with suppress(OSError):
            _tell(link, _error(run, f'internal error: {e!r}'))
    finally:
        with suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)
    raise AssertionError


def _do(
    run: Run,
    link: socket.socket,
    said: int,
    domain: int,
    settings: Settings,
    work: Work,
    guards: ForkedGuards,
) -> dict[str, Any]:
    """Plan a run, wait until it is its turn, and return what came of it."""
    folder = settings.folder_of(run.number)
    try:
        planned = work.plan(run, folder, {VARIABLE: str(domain)})
    except NotBuiltError:
        return {'not built': True}
    except UserError as e:
        return _error(run, str(e))
    except PlanError:
        sys.stderr.flush()
        text = os.pread(said, _SAID, 0).decode(errors='replace')
        return _error(run, first_error(text))

    def wait() -> None:
        _tell(link, {'planned': planned.uses[:_MOST_USES]})
        if link.recv(len(_GO)) != _GO:
            raise KeyboardInterrupt

    def over() -> None:
        # who is gone has no other one begin
        with suppress(OSError):
            _tell(link, {'over': True})

    try:
        result = perform(
            run.number, planned, folder, settings.goal, guards, wait, over
        )
    finally:
        work.leave()
    if result is None:
        raise KeyboardInterrupt
    # what the host of a launch file in Python leaves goes with its worker
    return {'result': to_json(result), 'idle': planned.source is None}


def first_error(text: str) -> str:
    """Return the line that says why a run cannot be planned."""
    lines = [line for line in text.splitlines() if line.strip()]
    errors = [line for line in lines if 'error: ' in line]
    return next(iter([*errors, *lines]), 'it cannot be planned')


def _error(run: Run, reason: str) -> dict[str, Any]:
    result = RunResult(run.number, 'error', one_reason(reason))
    return {'result': to_json(result)}


def _tell(link: socket.socket, message: dict[str, Any]) -> None:
    link.send(json.dumps(message).encode())
