# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Decides which processes and timers of a plan start and stop, and when.

How a process is stopped is decided in :mod:`.process_stop`, whether it starts
again after it has ended in :mod:`.restarts`, and when entries are due that
wait for others in :mod:`.held_entries`.

Nothing here touches the system: the engine does, and its loop is passed in. So
tests replay any launch without a process.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace
from functools import cached_property, partial
from itertools import count
import math
import signal
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.held_entries import HeldEntries
from colcon_yamllaunch.engine.loop import Loop, TimerHandle
from colcon_yamllaunch.engine.outcome import is_failure, Outcome, signal_name
from colcon_yamllaunch.engine.process_stop import ProcessStop, ProcessTask
from colcon_yamllaunch.engine.spawn import StartError
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.plan.member_settings import is_same_settings
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    changed_entries,
    ChangeState,
    Component,
    Entry,
    Member,
    Message,
    Plan,
    Process,
    Shutdown,
    SignalProcess,
    Timer,
    WorkerCall,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.composition import Composition
    from colcon_yamllaunch.engine.engine import Engine
    from colcon_yamllaunch.engine.restarts import Respawn, Restarts


class Supervisor:
    """
    Decides what the processes and timers of a launch do.

    :param engine: Starts processes, sends signals and emits events
    :param composition: Loads components, if the plan needs ROS
    """

    def __init__(
        self,
        plan: Plan,
        engine: 'Engine',
        loop: Loop,
        composition: 'Composition | None' = None,
    ) -> None:
        self._engine = engine
        self._composition = composition
        self._loop = loop
        self._tasks: dict[int, ProcessTask] = {}
        self._by_label: dict[str, ProcessTask] = {}
        self._numbers = count()
        self._expect(plan.processes())
        #: The number of the ROS client, which no process of the plan has.
        self.client_number = next(self._numbers)
        self._agenda: deque[Entry] = deque(plan.entries)
        self._timers: dict[int, tuple[Timer, TimerHandle]] = {}
        self._timer_keys = count()
        self._held = HeldEntries(engine, self._execute_soon)
        # those that wait for their next start
        self._respawns: dict[int, Respawn] = {}
        self._running: dict[int, ProcessTask] = {}
        self._groups: dict[int, int] = {}
        self._stop_of = partial(ProcessStop, engine, loop, self._groups)
        # the end of everything, once it has begun, and what ends after that
        self._stop: ProcessStop | None = None
        self._later_stops: list[list[str]] = []
        # those that run elsewhere and end now, and how long that is waited for
        self._others: list[str] = []
        self._others_until = -math.inf
        # the latest report of what it waits for, and its time
        self._progress: tuple[object, float] = (None, -math.inf)
        self._single_stops: dict[int, ProcessStop] = {}
        # what restarts after a change, in the order of the launch
        self._queue: list[int] = []
        #: Whether the launch goes on after a failure, as a change may fix it.
        self.outlasts_failures = False
        #: The reasons of all requests to stop everything.
        self.stop_reasons: set[str] = set()
        #: Whether the launcher received a signal that stops everything.
        self.stopped_by_signal = False
        #: Whether the launch is over.
        self.done = False

    @property
    def tasks(self) -> list[ProcessTask]:
        """The processes of the plan, in its order."""
        return list(self._tasks.values())

    @property
    def groups(self) -> Collection[int]:
        """The process groups whose leader runs."""
        return tuple(self._running)

    @property
    def is_starting(self) -> bool:
        """Whether more is to be started at once."""
        return bool(self._agenda)

    @property
    def is_stopping(self) -> bool:
        """Whether everything is being stopped."""
        return self._stop is not None

    def end_turn(self) -> None:
        """
        Do what follows from all that happened in a turn of the loop.

        Only some processes are started, so that others get their turn.
        """
        if self._composition is not None:
            self._composition.end_turn()
        self._held.release_ready()
        if self._agenda:
            with self._engine.starting():
                for _ in range(limits.STARTS_PER_TURN):
                    if self._agenda:
                        self._execute(self._agenda.popleft())
        self._end_single_stops()
        if self._respawns:
            self._restarts.end_turn()
        self._advance_stop()
        self._end_if_idle()
        if self._agenda:
            self._loop.wake()

    def next_timer(self) -> float | None:
        """Return when the next timer is due, by the clock, if one is set."""
        return min(
            (
                handle.when()
                for timer, handle in self._timers.values()
                if not timer.on_ros_time
            ),
            default=None,
        )

    def exited(self, group: int, outcome: Outcome) -> None:
        """Handle the end of the leader of a group."""
        task = self._running.pop(group)
        process = task.process
        if self._engine.release(group):
            del self._groups[group]
        single_stop = self._single_stops.get(task.number)
        asked = self.is_stopping or single_stop is not None
        task.group = None
        was_signalled = self._state(task).is_signalled
        failed = is_failure(outcome, asked or was_signalled)
        seconds = self._loop.time() - task.started
        delay = None
        if not asked and _may_start_again(process):
            delay = self._restarts.delay(task, seconds, failed)
        self._ended(
            task,
            events.Exited(
                process, group, outcome, seconds, asked, failed, delay
            ),
            asked=asked,
            failed=failed,
        )
        if single_stop is not None:
            single_stop.advance()

    def task(self, name: str) -> ProcessTask:
        """
        Return a process of the plan.

        :param name: Its label, or what ROS 2 calls it
        :raises RefusedError: when there is none with this name
        """
        if name in self._by_label:
            return self._by_label[name]
        for task in self._tasks.values():
            if task.process.ros_name == name:
                return task
        raise RefusedError(f"there is no process '{name}'")

    def stop_process(self, name: str) -> None:
        """
        Stop one process, with all that it started, and keep it stopped.

        Whatever follows from the end of a process otherwise, such as
        `respawn` and `on_exit: shutdown`, does not follow from this one. A
        second call sends the next signal at once.

        :raises RefusedError: when there is nothing to stop
        """
        task = self._ended_for(name, 'stop')
        if task.number in self._single_stops:
            self._single_stops[task.number].escalate()
        self._stop_single(task)

    def kill_process(self, name: str) -> None:
        """
        End one process, with all that it started, by SIGKILL.

        What else holds for :meth:`stop_process` holds for this.

        :raises RefusedError: when there is nothing to end
        """
        task = self._ended_for(name, 'kill')
        if task.number in self._single_stops:
            self._single_stops[task.number].cancel()
        self._single_stops[task.number] = self._stop_of(
            [task], first=signal.SIGKILL
        )

    def restart_process(self, name: str, once: Process | None = None) -> None:
        """
        Stop one process if it runs, then start it.

        Its respawns are counted from 0 again.

        :param once: What is started this time in its place, under a debugger
        :raises RefusedError: when it cannot be started now
        """
        task = self._asked_for(name, 'restart' if once is None else 'debug')
        task.once = once
        task.is_restarting = True
        self._stop_single(task)

    def extend(self, more: Plan) -> None:
        """
        Add entries to the end of the plan.

        While everything is being stopped, only their messages are shown.

        :raises ValueError: when a label is taken
        """
        if self.is_stopping:
            self._execute_while_stopping(more.entries)
            return
        members = tuple(more.members())
        self._expect(more.processes())
        if self._composition is not None:
            self._composition.extend(more)
        if members:
            self._engine.emit(events.Planned(members))
        self._execute_soon(more.entries)

    def compose(self, composition: 'Composition') -> None:
        """Load components from now on."""
        self._composition = composition
        for task in self.tasks:
            ending = self._state(task).ending
            if task.group is not None:
                composition.started(task.process)
            elif ending and not (
                task.number in self._respawns
                or task.number in self._single_stops
            ):
                composition.ended(
                    task.process,
                    ending,
                    asked=True,
                    failed=False,
                    again=False,
                )

    def revise(self, process: Process, *, at_once: bool) -> None:
        """
        Replace a process from its next start on.

        :param process: It has the label of a process of the plan
        :param at_once: Whether it would be started as the running one was, so
          that its `respawn`, `on_exit` and timeouts apply now
        :raises RefusedError: when there is none
        """
        task = self.task(process.label)
        is_same = process == task.process
        task.successor = None if is_same else process
        before = task.process
        if at_once:
            # the event follows when it starts
            task.process = process
            if not is_same_settings(before.settings, process.settings):
                self._engine.emit(events.Planned((process,)))
        self.hold_again(process)

    def hold_again(self, member: Member) -> None:
        """Let a member that waits for others wait for those that it names."""
        self._held.hold_again(member)
        self._loop.wake()

    def restart_changed(self, labels: Collection[str]) -> tuple[str, ...]:
        """
        Restart processes after a change, and return their labels.

        Unlike after a restart on request, lifecycle nodes get their states
        back. Each starts when those before it in the launch have started. A
        process that has not been started yet, or was stopped on request, is
        left alone.
        """
        restarted = []
        for task in self.tasks if not self.is_stopping else ():
            label = task.process.label
            is_skipped = self._state(task).is_kept_stopped or task.is_dropped
            if label in labels and not is_skipped and self._is_begun(task):
                self._restart_after_change(task)
                if task.number not in self._queue:
                    self._queue.append(task.number)
                restarted.append(label)
        return tuple(restarted)

    def restart_running(self, label: str) -> None:
        """Restart a process with another one, if it runs."""
        task = self._by_label.get(label)
        if task is not None and task.group is not None:
            self._restart_after_change(task)

    def start_again(self, task: ProcessTask) -> None:
        """Start a process once what it waits for is ready again."""
        settings = (task.successor or task.process).settings
        after = () if settings is None else settings.after
        if self._engine.state.missing_of(after):
            self._held.hold(AfterReady(after, (task.process,)))
        else:
            self._start(task)

    def is_required(self, task: ProcessTask, failed: bool) -> bool:
        """
        Return whether the launch ends with a process that was not stopped.

        As in ROS 2, `on_exit: shutdown` wins over `respawn`.
        """
        is_outlasted = failed and self.outlasts_failures
        return task.process.on_exit_shutdown and not is_outlasted

    def drop(self, label: str) -> None:
        """
        Stop a process, and forget it once it has ended.

        :raises RefusedError: when there is none, or all is being stopped
        """
        task = self.task(label)
        self._filter(
            lambda entry: isinstance(entry, Member) and entry.label == label
        )
        if not self._is_begun(task):
            self._forget(task)
            return
        self._cancel_restart(task)
        if task.number not in self._single_stops:
            self.stop_process(label)
        task.is_dropped = True

    def forget(self, entries: Iterable[Entry]) -> None:
        """Remove entries that have not been executed yet, such as messages."""
        unwanted = list(entries)

        def removed(entry: Entry) -> bool:
            if entry not in unwanted:
                return False
            # each is removed once
            unwanted.remove(entry)
            return True

        self._filter(removed)

    def suspended(self, group: int, number: int | None) -> None:
        """
        Handle that the leader of a group is suspended or goes on.

        :param number: The signal that suspends it, None if it goes on
        """
        task = self._running.get(group)
        # while we stop everything, we continue processes ourselves
        if task is None or self.is_stopping:
            return
        if number is not None or self._state(task).is_held:
            self._engine.emit(events.Suspended(task.process, group, number))

    def stop(
        self,
        reason: str,
        *,
        interactive: bool = False,
        drop_timers: bool = False,
    ) -> None:
        """
        Begin to stop everything that was started, and start nothing more.

        :param reason: Why, as a part of a sentence
        :param interactive: Whether someone at a keyboard asked for it
        :param drop_timers: Whether timers that outlast a shutdown are dropped
        """
        self.stop_reasons.add(reason)
        if not self.is_stopping:
            self._engine.emit(
                events.ShuttingDown(
                    reason, interactive, self.stopped_by_signal
                )
            )
            self._begin_stopping()
        if drop_timers:
            self._drop_timers(all_of_them=True)

    def escalate(self) -> None:
        """Send the next signal of the stop sequence at once."""
        if self._stop is None:
            return
        self._drop_timers(all_of_them=True)
        if self._later_stops:
            # nothing waits for others any more
            self._later_stops.clear()
            self._stop_next(first=signal.SIGTERM)
        else:
            self._stop.escalate()
        self._report_progress(self._stop)

    @cached_property
    def _restarts(self) -> 'Restarts':
        # few launches start anything again
        from colcon_yamllaunch.engine.restarts import Restarts

        return Restarts(
            self, self._engine, self._loop, self._groups, self._respawns
        )

    def _state(self, task: ProcessTask) -> ProcessState:
        state = self._engine.state.process(task.process.label)
        assert state is not None
        return state

    def _execute_soon(self, entries: Iterable[Entry]) -> None:
        self._agenda.extend(entries)

    def _execute(self, entry: Entry) -> None:
        match entry:
            case Process():
                if entry.label in self._by_label:
                    self._start(self._by_label[entry.label])
            case Message():
                self._engine.emit(events.MessageShown(entry.level, entry.text))
            case Timer():
                self._set(entry)
            case AfterReady():
                self._held.hold(entry)
            case Component():
                if self._composition is not None:
                    self._composition.due(entry)
            case ChangeState():
                if self._composition is not None:
                    self._composition.change_as_planned(entry)
            case SignalProcess():
                self._signal(entry)
            case WorkerCall():
                self._engine.call(entry.number)
            case Shutdown():
                reason = entry.reason or 'the launch file says so'
                self.stop(reason)

    def _signal(self, entry: SignalProcess) -> None:
        try:
            task = self.task(entry.process)
            if not self._is_begun(task):
                # as in ROS 2, it gets the signal once it runs
                task.early_signals.append(entry)
                return
            if not entry.signal:
                self.stop_process(entry.process)
                return
            group, number = task.group, entry.signal
            if group is None or not self._engine.signal(group, number):
                raise RefusedError(f'{task.process.label} does not run')
        except RefusedError as error:
            place = events.shown(entry.position)
            what = signal_name(entry.signal) if entry.signal else 'stop'
            self._engine.emit(events.Warned(f'{what}: {error} (from {place})'))
            return
        self._engine.emit(events.Signalled(task.process, group, number, True))

    def _expect(self, processes: Iterable[Process]) -> None:
        """
        Add processes to the plan.

        :raises ValueError: when a label is taken
        """
        for process in processes:
            if process.label in self._by_label:
                raise ValueError(f'there is a process {process.label} already')
            task = ProcessTask(next(self._numbers), process)
            self._tasks[task.number] = task
            self._by_label[process.label] = task

    def _forget(self, task: ProcessTask) -> None:
        """Remove a process from the plan."""
        process = task.process
        del self._tasks[task.number]
        del self._by_label[process.label]
        if self._composition is not None:
            self._composition.drop_process(process)
        self._engine.emit(events.Dropped(process))

    def _succeed(self, task: ProcessTask, process: Process) -> None:
        """Replace a process before its start."""
        before, task.process, task.successor = task.process, process, None
        if self._composition is not None:
            self._composition.replace_process(before, process)
        self._engine.emit(events.Planned((process,)))

    def _start(self, task: ProcessTask) -> None:
        if task.successor is not None:
            self._succeed(task, task.successor)
        process = task.process
        once, task.once = task.once, None
        try:
            group = self._engine.start(task.number, once or process)
        except StartError as error:
            # the program may just be written again, or memory be short
            asked = self.is_stopping
            delay = None
            if not asked and _may_start_again(process):
                delay = self._restarts.delay(task, 0.0, True)
            event = events.StartFailed(process, str(error), delay)
            self._ended(task, event, asked=asked, failed=True)
            return
        task.started = self._loop.time()
        task.group = group
        self._running[group] = task
        self._groups[group] = task.number
        self._engine.emit(events.Started(process, group))
        if self._composition is not None:
            self._composition.started(process)
        early_signals, task.early_signals = task.early_signals, []
        for entry in early_signals:
            self._signal(entry)

    def _ended(
        self,
        task: ProcessTask,
        event: events.Exited | events.StartFailed,
        *,
        asked: bool,
        failed: bool,
    ) -> None:
        """Emit the end of a process, or its failed start, and go on."""
        self._engine.emit(event)
        delay = event.respawn_delay
        is_exit = isinstance(event, events.Exited)
        if self._composition is not None:
            self._composition.ended(
                task.process,
                self._state(task).ending,
                asked=asked,
                failed=failed,
                again=delay is not None or task.is_restarting,
            )
        if delay is not None:
            # what did not start has left nothing running
            self._restarts.restart_later(task, delay, is_clean=not is_exit)
            return
        how = 'ended' if is_exit else 'could not be started'
        if asked:
            return
        if _may_start_again(task.process):
            self._restarts.check_limit(task, failed)
        if self.is_required(task, failed):
            self.stop(f'{task.process.label} {how}')
        elif self._is_critical(task, failed):
            self.stop(f'{task.process.label} {how}, and is critical')

    def _is_critical(self, task: ProcessTask, failed: bool) -> bool:
        """Return whether the launch ends with a process that failed."""
        settings = task.process.settings
        is_critical = settings is not None and settings.critical
        return is_critical and failed and not self.outlasts_failures

    def _ended_for(self, name: str, action: events.Action) -> ProcessTask:
        """Return a process that is to be stopped, and kept so."""
        task = self._asked_for(name, action)
        task.once = None
        self._cancel_restart(task)
        if self._composition is not None and task.group is None:
            # one that was to be respawned
            self._composition.ended(
                task.process, 'stopped', asked=True, failed=False, again=False
            )
        return task

    def _asked_for(self, name: str, action: events.Action) -> ProcessTask:
        task = self.task(name)
        if not self._is_begun(task):
            raise RefusedError(f'{name} has not been started yet')
        self._request(task, action)
        return task

    def _restart_after_change(self, task: ProcessTask) -> None:
        self._request(task, 'change')
        task.is_restarting = True
        self._stop_single(task)

    def _cancel_restart(self, task: ProcessTask) -> None:
        task.is_restarting = False
        if task.number in self._queue:
            self._queue.remove(task.number)

    def _request(self, task: ProcessTask, action: events.Action) -> None:
        """Emit a request to stop a process, and cancel its respawn."""
        self._engine.emit(events.Requested(task.process, action))
        if self._composition is not None:
            # after a restart, its node begins with the goal of the launch file
            is_restart = action in ('restart', 'debug')
            self._composition.stop_requested(
                task.process, is_restart=is_restart
            )
        if task.number in self._respawns:
            self._restarts.cancel(task)
        # one that waits to be started again
        self._held.drop(task.process.label)

    def _is_begun(self, task: ProcessTask) -> bool:
        """
        Return whether a process has been started.

        :raises RefusedError: when everything is being stopped
        """
        if self.is_stopping:
            raise RefusedError('the whole launch is being stopped')
        return self._state(task).is_begun

    def _set(self, timer: Timer) -> None:
        key = next(self._timer_keys)
        if timer.on_ros_time and self._composition is not None:
            handle = self._composition.at_ros_time(
                timer.period, lambda: self._fire(key)
            )
        else:
            handle = self._loop.call_later(timer.period, self._fire, key)
        self._timers[key] = (timer, handle)

    def _fire(self, key: int) -> None:
        timer, _ = self._timers.pop(key)
        if not self.is_stopping:
            self._execute_soon(timer.entries)
            return
        # a timer that outlasts a shutdown shows messages, but starts nothing
        self._execute_while_stopping(timer.entries)

    def _execute_while_stopping(self, entries: Iterable[Entry]) -> None:
        for entry in entries:
            if isinstance(entry, Message) or (
                isinstance(entry, Timer) and not entry.cancel_on_shutdown
            ):
                self._execute(entry)

    def _filter(self, is_unwanted: Callable[[Entry], bool]) -> None:
        """Remove entries that have not been executed yet."""

        def left(entry: Entry) -> Entry | None:
            return None if is_unwanted(entry) else entry

        self._agenda = deque(changed_entries(self._agenda, left))
        self._held.change(left)
        for key, (timer, handle) in self._timers.items():
            entries = changed_entries(timer.entries, left)
            self._timers[key] = replace(timer, entries=entries), handle

    def _drop_timers(self, *, all_of_them: bool) -> None:
        for key, (timer, handle) in list(self._timers.items()):
            if all_of_them or timer.cancel_on_shutdown:
                handle.cancel()
                del self._timers[key]

    def _begin_stopping(self) -> None:
        self._agenda.clear()
        self._held.clear()
        self._drop_timers(all_of_them=False)
        if self._respawns:
            self._restarts.cancel_all()
        if self._composition is not None:
            self._composition.stop()
        for single_stop in self._single_stops.values():
            single_stop.cancel()
        self._single_stops.clear()
        self._queue.clear()
        # what waited for others ends before them
        after = self._engine.state.after
        if after:
            # few launches have an order
            from colcon_yamllaunch.plan.start_order import stages_of

            self._later_stops = stages_of(after)[::-1]
        self._stop_next()
        self._progress_later()

    def _stop_next(self, first: signal.Signals = signal.SIGINT) -> None:
        """
        Begin to stop the processes of the next stage.

        :param first: The signal to begin with
        """
        if self._stop is not None:
            self._stop.cancel()
        labels = self._later_stops.pop(0) if self._later_stops else []
        tasks = self.tasks
        if self._later_stops:
            here = self._by_label
            tasks = [here[label] for label in labels if label in here]
        is_whole = not self._later_stops
        self._stop = self._stop_of(tasks, whole=is_whole, first=first)
        self._others = [n for n in labels if n not in self._by_label]
        self._others_until = self._loop.time() + limits.STOP_STAGE_TIMEOUT

    def _stop_single(self, task: ProcessTask) -> None:
        """Begin to stop one process, unless that has begun."""
        if task.number not in self._single_stops:
            self._single_stops[task.number] = self._stop_of([task])

    def _progress_later(self) -> None:
        def report() -> None:
            self._progress_later()
            if self._stop is not None:
                self._report_progress(self._stop)

        self._loop.call_later(limits.PROGRESS_INTERVAL, report)

    def _report_progress(self, stop: ProcessStop) -> None:
        """Report what is waited for, if that has changed."""
        if not stop.escalation.is_over:
            stop.advance()
        labels = tuple(task.process.label for task in stop.alive())
        timers = len(self._timers)
        now = self._loop.time()
        progress = labels, timers, stop.escalation.latest_signal()
        before, last = self._progress
        is_repeated = (
            progress == before and now - last < limits.PROGRESS_REPEAT_INTERVAL
        )
        if is_repeated or not (labels or timers):
            return
        self._progress = progress, now
        following, due = stop.escalation.next_signal() or (None, now)
        self._engine.emit(events.StillRunning(*progress, following, due - now))

    def _end_single_stops(self) -> None:
        stops = self._single_stops
        first = [n for n in self._queue if n in stops]
        others = [n for n in stops if n not in first]
        for number, stop in [(n, stops[n]) for n in (*first, *others)]:
            task = self._tasks[number]
            is_over = stop.escalation.is_over and task.group is None
            # one that cannot be started again may end the launch
            if self.is_stopping or not is_over:
                continue
            if number in self._queue:
                if self._queue[0] != number:
                    # those before it start first
                    continue
                self._queue.remove(number)
            stop.cancel()
            stop.abandon()
            del self._single_stops[number]
            if task.is_restarting:
                task.is_restarting = False
                task.respawns = task.quick_ends = task.doublings = 0
                task.restarts.clear()
                self.start_again(task)
            elif task.is_dropped:
                self._forget(task)
            else:
                self._engine.emit(events.MemberChanged(task.process, 'ended'))

    def _end_if_idle(self) -> None:
        # those on ROS time are cancelled with it
        self._timers = {
            key: timer
            for key, timer in self._timers.items()
            if not timer[1].cancelled()
        }
        if self._agenda or self._timers or self._respawns:
            return
        if self._later_stops:
            return
        if self._stop is None:
            if self._running or self._single_stops:
                return
            composition = self._composition
            if composition is not None and composition.is_busy:
                return
            if self._engine.prepare_end():
                return
            self._held.abandon()
            if composition is not None:
                composition.end()
            # what processes left running ends with the launch
            self._begin_stopping()
        assert self._stop is not None
        escalation = self._stop.escalation
        if not (self._running or escalation.orphans or escalation.is_over):
            self._stop.advance()
        if escalation.is_over and not self._engine.prepare_end():
            self._stop.abandon()
            self.done = True

    def _advance_stop(self) -> None:
        """Stop those that others waited for, as these have ended."""
        while self._later_stops and self._stop is not None:
            if not (self._stop.groups() or self._stop.escalation.is_over):
                self._stop.advance()
            if not self._stop.escalation.is_over:
                return
            is_late = self._loop.time() >= self._others_until
            if not is_late and any(map(self._engine.state.runs, self._others)):
                self._loop.wake_at(self._others_until)
                return
            self._stop_next()


def _may_start_again(process: Process) -> bool:
    """Return whether a process can start again after it has ended."""
    settings = process.settings
    return process.respawn or (settings is not None and bool(settings.restart))
