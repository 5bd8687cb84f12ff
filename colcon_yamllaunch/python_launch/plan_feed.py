# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Event handlers of Python launch files, which extend the running plan."""

from collections.abc import Callable, Collection
from itertools import chain
import os
import signal
from typing import Any

from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.commands import Command, Escalate, Extend
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.participants import Execute, Participant, Reply
from colcon_yamllaunch.language.evaluation.request import (
    WorkerError,
    WorkerMessage,
)
from colcon_yamllaunch.language.python_files.growing_launch import (
    GrowingLaunch,
)
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError, render
from colcon_yamllaunch.plan.plan import Entry, Growth, Process, Shutdown
from colcon_yamllaunch.python_launch.worker_process import (
    NUMBER,
    WorkerProcess,
)

#: Why a launch ends in which nothing is left to do, as ROS 2 calls it.
IDLE = 'idle'
_FAILED = 'a launch file in Python failed'


class PlanFeed(Participant):
    """
    The worker of Python launch files while their launch runs.

    It receives the events that their handlers may be waiting for, and its
    answers extend the plan.

    :param growing: Translates the answers of the worker into entries
    :param with_settings: Returns entries with the settings of the deployment;
      raises LaunchError when it does not fit them
    """

    def __init__(
        self,
        link: WorkerProcess,
        growing: GrowingLaunch,
        with_settings: Callable[
            [tuple[Entry, ...]], tuple[Entry, ...]
        ] = lambda entries: entries,
    ) -> None:
        self._link = link
        self._growing = growing
        self._with_settings = with_settings
        self._launch: Engine | None = None
        # a copy, as the link closes its descriptor at any time
        self._watched = -1
        # whether the worker was told that the launch ends
        self._knows_end = False
        self._answers_by: float | None = None
        self._retry: TimerHandle | None = None
        # bytes of output since the worker was last idle, and the processes
        # that wrote them
        self._output = 0
        self._labels: set[str] = set()
        # what is restarted after a change, with its end, which is kept back
        self._changed: dict[str, events.Exited | None] = {}
        # whether the worker has ended, or is to end
        self._is_over = False

    @property
    def launch(self) -> Engine:
        """The launch whose plan it extends."""
        assert self._launch is not None
        return self._launch

    def children(self) -> Collection[int]:
        """Return the worker."""
        return {self._link.pid} - {0}

    def join(self, engine: Engine) -> None:
        """Extend the plan of a launch from now on."""
        self._launch = engine
        if self._link.pid:
            engine.add_helper(self._link.pid, self._ended, NUMBER)

    def begin(self) -> None:
        """Read the answers of the worker."""
        if self._link.descriptor != -1:
            self._watched = os.dup(self._link.descriptor)
            self.launch.loop.add_reader(self._watched, self._read)

    def handle(self, event: events.Event) -> None:
        """Pass an event on to the worker."""
        if self._is_over:
            return
        match event:
            case events.Requested(action='change'):
                self._changed.setdefault(event.member.label, None)
            case (
                events.Requested(member=member)
                | events.StartFailed(process=member)
            ):
                # it is not the change any more that it ends for
                kept = self._changed.pop(member.label, None)
                if kept is not None:
                    self._exited(kept)
            case events.Started() if self._changed.pop(
                event.process.label, None
            ):
                return
            case events.Exited() if event.process.label in self._changed:
                # what waits for its end does not wait for this
                self._changed[event.process.label] = event
            case events.Started():
                self._send_of(event.process, 'start', pid=event.pid)
            case events.Exited():
                self._exited(event)
            case events.StateChanged() if self._growing.has_handlers:
                self._send_event(
                    'state',
                    node=event.node,
                    to=event.state,
                    # a word of Python
                    **{'from': event.before},
                )
            case events.ShuttingDown():
                self._shut_down(event.reason, by_sigint=event.interactive)
            case _:
                return

    def handle_output(self, event: events.Output) -> None:
        """Pass output on to the worker, if a handler is waiting for it."""
        process = event.process
        if self._is_over or process.ros_name not in self._growing.wants_output:
            return
        self._output += len(event.data)
        self._labels.add(process.label)
        text = event.data.decode(errors='replace')
        self._send_of(process, 'output', stream=event.stream, text=text)

    def accepts(self, label: str) -> bool:
        """
        Return whether a process may write more.

        A process that writes faster than a handler of its output works is
        held up by its own pipe, as by a slow screen.
        """
        return (
            self._is_over
            or not self._growing.is_busy
            or self._output < limits.STREAM_BACKLOG_BYTES
            or label not in self._labels
        )

    def execute(
        self, command: Command[Any], reply: Reply, proceed: Execute
    ) -> Any:
        """Do not wait for the worker any longer when stopping escalates."""
        if isinstance(command, Escalate):
            self._knows_end = True
            self._answers_by = self.launch.loop.time()
        return proceed(command, reply)

    def call(self, number: int) -> None:
        """Ask the worker to call a function of a launch file."""
        if not self._is_over:
            self._ask({'do': 'call', 'number': number})

    def end_turn(self) -> None:
        """Send what could not be sent before; soon again if it is slow."""
        if self._is_over or self._link.flush():
            return
        if self._retry is None or self._retry.cancelled():
            loop = self.launch.loop
            self._retry = loop.wake_at(loop.time() + limits.WORKER_RETRY_DELAY)

    def prepare_end(self) -> bool:
        """
        Notify the worker that the launch ends, once it has answered.

        The launch waits for its answer to that, but not for long.

        :return: Whether an answer is still to come
        """
        if self._is_over:
            return False
        loop = self.launch.loop
        if self._growing.is_busy:
            if self._knows_end and self._answers_by is None:
                self._answers_by = loop.time() + limits.WORKER_ANSWER_TIMEOUT
                loop.wake_at(self._answers_by)
            return self._answers_by is None or loop.time() < self._answers_by
        if not self._knows_end:
            self._shut_down(IDLE, by_sigint=False)
        return False

    def close(self) -> None:
        """End the worker."""
        self._is_over = True
        self._unwatch()
        pid = self._link.pid
        self._link.close()
        if self._launch is not None and pid:
            self._launch.remove_helper(pid)

    def _ended(self, status: int) -> None:
        # its last answers count
        self._read()
        self._link.reaped()
        self._is_over = True
        self._unwatch()
        self._grow(self._growing.lost(''))
        outcome = Outcome.from_status(status)
        self.launch.emit(events.WorkerLost(str(outcome)))

    def _read(self) -> None:
        try:
            while (message := self._link.poll()) is not None:
                growth = self._growing.handle(message)
                if growth is not None:
                    self._grow(growth)
        except WorkerError as error:
            self._grow(self._growing.lost(str(error)))
        if not self._growing.is_busy:
            # all output so far is handled
            self._output = 0
        if self._link.descriptor == -1:
            # its end is reported when it is reaped
            self._unwatch()

    def _grow(self, growth: Growth) -> None:
        entries, texts = growth.entries, list(growth.problems)
        try:
            entries = self._with_settings(entries)
        except LaunchError as error:
            entries = ()
            texts.append(render(error.diagnostics, os.getcwd()))
        problems = [text.split('\n') for text in texts]
        if problems:
            failed = events.PlanFailed(tuple(chain(*problems)))
            self.launch.emit(failed)
        self.launch.blocks = growth.blocks or self.launch.blocks
        # unless the entries give a better reason
        end = (Shutdown(_FAILED),) if problems else ()
        if entries or end:
            self.launch.dispatcher.do(Extend((*entries, *end)))

    def _exited(self, event: events.Exited) -> None:
        code = event.outcome.code
        if event.outcome.signal is not None:
            # as Python's subprocess has it, and so ROS 2
            code = -event.outcome.signal
        elif event.outcome.lost:
            # ROS 2 knows of no other end that nobody has seen
            code = -signal.SIGKILL
        self._send_of(
            event.process,
            'exit',
            returncode=code,
            respawns=event.respawn_delay is not None,
            asked=event.asked,
        )

    def _shut_down(self, reason: str, *, by_sigint: bool) -> None:
        self._knows_end = True
        self._send_event('shutdown', reason=reason, by_sigint=by_sigint)

    def _send_of(self, process: Process, kind: str, **fields: Any) -> None:
        number = self._growing.id_of(process.ros_name)
        if number is not None:
            self._send_event(kind, process=number, **fields)

    def _send_event(self, kind: str, **fields: Any) -> None:
        self._ask({'do': 'event', 'event': {'type': kind, **fields}})

    def _ask(self, request: WorkerMessage) -> None:
        try:
            self._growing.ask(request)
        except WorkerError:
            # its end is reported when it is reaped
            return

    def _unwatch(self) -> None:
        if self._watched != -1:
            self.launch.loop.remove_reader(self._watched)
            os.close(self._watched)
            self._watched = -1
