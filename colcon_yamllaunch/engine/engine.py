# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The engine: connects the loop, processes, output and signals of a launch."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import field
from functools import partial
import math
import os
from pathlib import Path
import signal
import time
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.adoption import Adoption
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.escalation import Orphan, send, Target, Timeouts
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.process_scan import is_alive
from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.channels import size_of
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.guard_link import GuardLink
from colcon_yamllaunch.engine.launch_scan import OrphanFinder
from colcon_yamllaunch.engine.line_buffering import LineBuffering, SilenceWatch
from colcon_yamllaunch.engine.loop import (
    do_nothing,
    ended_children,
    Loop,
    received,
    STOPPING,
    suspend_ourselves,
    suspended_children,
)
from colcon_yamllaunch.engine.own_files import ParameterFiles
from colcon_yamllaunch.engine.participants import overridden, Participant
from colcon_yamllaunch.engine.process_starter import ProcessStarter
from colcon_yamllaunch.engine.relay import Recorder, Relay
from colcon_yamllaunch.engine.spawn import Spawn
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.supervisor import Supervisor
from colcon_yamllaunch.engine.terminals import Terminals, with_terminals
from colcon_yamllaunch.engine.writer import Writer
from colcon_yamllaunch.plan.plan import (
    Component,
    Entry,
    Member,
    ParametersOf,
    Plan,
    Process,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.commands import Command, Refused, Response
    from colcon_yamllaunch.engine.composition import Composition
    from colcon_yamllaunch.engine.dispatcher import Dispatcher
    from colcon_yamllaunch.engine.ros_link import RosLink

# how long the guard waits for the ROS client to end by itself
_CLIENT_TIMEOUTS = Timeouts(0.5, 0.5)


class EventTime:
    """
    The time of the current event.

    An event that another machine kept while the connection was lost arrives
    late, and has the time at which it happened.

    :param now: Returns the time of day, in seconds
    """

    def __init__(self, now: Callable[[], float] = time.time) -> None:
        self._now = now
        #: When it was; None for now.
        self.past: float | None = None

    def __call__(self) -> float:
        """Return the time in seconds since 1970."""
        return self._now() if self.past is None else self.past


@dataclass(frozen=True, slots=True)
class EngineSettings:
    """
    What holds for a whole launch.

    :param identity: Its identity, see `launch_scan`
    :param environment: The environment that processes change for themselves
    :param screen: The descriptor of the screen, or -1; the terminals of
      processes have its size
    :param clock: Returns seconds that never go back
    :param spawn: Starts a program as :func:`os.posix_spawn` does
    :param adoption: The children that others started
    :param buffering: What lets programs show a line when it ends
    :param client_log: The file for what the process that speaks with ROS
      writes to standard error, if the launch needs one, or None
    :param tty: Whether each process gets a terminal
    :param size: The size of such terminals at first, if the screen has none
    :param adapt: Adds to an environment what makes output show as the user
      likes
    :param event_time: When the current event happened
    """

    identity: str
    environment: Mapping[str, str]
    screen: int
    clock: Callable[[], float]
    spawn: Spawn
    adoption: Adoption
    buffering: LineBuffering
    client_log: Path | None = None
    tty: bool = False
    size: os.terminal_size | None = None
    adapt: Callable[[Mapping[str, str]], Mapping[str, str]] = dict
    event_time: EventTime = field(default_factory=EventTime)


class Engine:
    """
    Runs a plan on the system.

    A launch has a state, executes commands (:meth:`ask`) and emits events. So
    have a launch of another process, `control.client.RunningLaunch`, and a
    part of a launch on a machine, `remote.remote_part.RemotePart`.

    :param guard: Receives all processes
    :param writer: The screen; processes wait if it is slow
    :param listeners: Receive all events
    :param recorders: Receive all output as it is read
    :param publish: Is called once a turn, to write what has been collected,
      but not before all is started that is due, which is more urgent;
      returns whether it has more to do; None if nothing is collected
    :param state: Is changed by each event before listeners get it
    :param participants: What else takes part in the launch, in the order in
      which they execute commands and receive events
    :param parameters_of: Returns the parameters of a process
    :param open_control: Opens the control socket, see :meth:`show_to_others`
    """

    def __init__(
        self,
        plan: Plan,
        settings: EngineSettings,
        *,
        guard: GuardLink,
        files: ParameterFiles,
        writer: Writer,
        listeners: Iterable[events.Listener],
        recorders: Iterable[Recorder],
        publish: Callable[[], bool] | None,
        conditions: ExitConditions,
        state: LaunchState,
        participants: Sequence[Participant] = (),
        parameters_of: ParametersOf = lambda process: process.parameters,
        open_control: Callable[[], object] = do_nothing,
    ) -> None:
        if settings.tty:
            plan = with_terminals(plan)
        #: The launch files, groups and timers that the members of the plan
        #: stand in.
        self.blocks = plan.blocks
        #: What takes part in the launch beside the engine.
        self.participants = participants
        self._conditions = conditions
        #: The state of the launch.
        self.state = state
        self._settings = settings
        self._guard = guard
        self._writer = writer
        self._publish = publish
        #: What everything waits for.
        self.loop = Loop(settings.clock)
        self._size = settings.size
        # most participants do not limit output, which is read often
        self._limits = overridden(participants, 'accepts')
        self._relay = Relay(
            self.loop,
            self.accepts if self._limits else writer.accepts,
            [*recorders, *overridden(participants, 'record')],
            self.emit,
        )
        #: The keyboards of processes.
        self.terminals = Terminals(self.loop, self._relay)
        silence = SilenceWatch(settings.buffering.is_cpp, self.loop, self.emit)
        shared = [*listeners, silence.handle]
        self._listeners: list[events.Listener] = [
            *shared,
            self.terminals.handle,
            *overridden(participants, 'handle'),
        ]
        self._output_listeners: list[events.Listener] = [
            *shared,
            *overridden(participants, 'handle_output'),
        ]
        self._ros = self._ros_link(plan) if plan.needs_ros else None
        #: Decides what is started, restarted and stopped.
        self.supervisor = Supervisor(plan, self, self.loop, self.composition)
        #: Starts processes.
        self.starter = ProcessStarter(
            settings,
            guard,
            files,
            self._relay,
            self.terminals,
            len(self.supervisor.tasks),
        )
        self._orphan_finder = OrphanFinder(
            settings, guard, self.loop.children.keys()
        )
        self._end_turns = overridden(participants, 'end_turn')
        # whether the screen may have to be waited for
        self._is_screen_slow = False
        self._last_stop = -limits.SIGNAL_ECHO_INTERVAL
        #: Are called with True before Ctrl-Z suspends the launch, and
        #: with False when it goes on.
        self.when_suspended: list[Callable[[bool], None]] = []
        #: Are called when the screen has another size.
        self.when_resized: list[Callable[[], None]] = []
        self._open_control = open_control
        self._is_visible = False
        #: Returns the parameters of a process.
        self.parameters_of = parameters_of
        self._dispatcher: Dispatcher | None = None
        self._may_start_client = False
        self._expect_guard()
        for participant in participants:
            participant.join(self)

    @property
    def dispatcher(self) -> 'Dispatcher':
        """Executes commands."""
        if self._dispatcher is None:
            # few launches are asked for anything
            from colcon_yamllaunch.engine.dispatcher import Dispatcher

            self._dispatcher = Dispatcher(self)
        return self._dispatcher

    @property
    def composition(self) -> 'Composition | None':
        """The components and lifecycle nodes; None if ROS is not needed."""
        return None if self._ros is None else self._ros.composition

    def show_to_others(self) -> None:
        """Let other terminals of the user see the launch from now on."""
        if not self._is_visible:
            self._is_visible = True
            self._open_control()

    def groups(self) -> Mapping[str, int]:
        """Return the process groups of the processes that run, by label."""
        return self.state.groups()

    def renew_environment(self, variables: Mapping[str, str]) -> None:
        """Change the variables of processes that start from now on."""
        self.starter.variables = self._settings.adapt(variables)

    def find(self, name: str) -> Member | None:
        """Return a member of the plan that does not run here."""
        found = (p.find(name) for p in self.participants)
        return next((member for member in found if member is not None), None)

    def measure(self, done: Callable[[], None]) -> None:
        """Measure the resource usage on other machines, and call `done`."""
        for participant in self.participants:
            done = partial(participant.measure, done)
        done()

    def cpu_shares(self) -> Mapping[str, float]:
        """Return the shares of a processor of what does not run here."""
        return {
            label: share
            for participant in self.participants
            for label, share in participant.cpu_shares().items()
        }

    @property
    def is_stopping(self) -> bool:
        """Whether everything is being stopped."""
        return self.supervisor.is_stopping

    def shut_down(self, reason: str) -> None:
        """Begin to end the launch, as an entry of its plan would."""
        self.supervisor.stop(reason)

    @property
    def event_time(self) -> EventTime:
        """When the current event happened."""
        return self._settings.event_time

    def feed_output(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        """Handle what a process wrote, as if it had been read here."""
        self._relay.feed(process, stream, data)

    def end_lines(self, label: str) -> None:
        """Emit the last line of a process as a whole, as it has ended."""
        self._relay.end_lines(label)
        # the last line of a process counts before its exit code
        self.check_conditions()

    def check_conditions(self) -> None:
        """Stop the launch if a condition is met or something failed."""
        reason = self._conditions.reason_to_stop()
        if reason is not None:
            self.supervisor.stop(reason)

    def show(self, label: str, stream: events.Stream, data: bytes) -> None:
        """Send output or echo of a process to the clients attached to it."""
        self._relay.show(label, stream, data)

    def accepts(self, key: tuple[str, events.Stream]) -> bool:
        """Return whether a process may write more to a stream."""
        return self._writer.accepts(key) and all(
            accepts(key[0]) for accepts in self._limits
        )

    @property
    def is_ended_by_others(self) -> bool:
        """Whether the end was requested by more than a change of the plan."""
        supervisor = self.supervisor
        return supervisor.stopped_by_signal or len(supervisor.stop_reasons) > 1

    def add_helper(
        self,
        pid: int,
        ended: Callable[[int], object],
        number: int | None = None,
    ) -> None:
        """
        Reap a child process that serves the launch, and have it guarded.

        :param ended: Is called with its wait status
        :param number: See :meth:`guard_group`
        """
        self.loop.add_child(pid, ended)
        self.guard_group(pid, number)

    def remove_helper(self, pid: int) -> None:
        """Forget a child process that was reaped by its owner."""
        self.loop.remove_child(pid)
        self._guard.ended(pid)

    def lease(self, seconds: float | None) -> None:
        """
        Make the guard stop the launch if the lease is not renewed in time.

        :param seconds: How long it lasts; None for ever
        """
        self._guard.lease(seconds)

    def guard_group(self, group: int, number: int | None = None) -> None:
        """
        Make the guard end a process group if the launcher is killed.

        :param number: Its number in the launch, which no process of the plan
          has; by default that of the ROS client
        """
        if number is None:
            number = self.supervisor.client_number
        self._guard.started(number, group, _CLIENT_TIMEOUTS)

    def release_group(self, group: int) -> None:
        """Handle the end of the last process of a group."""
        self._guard.ended(group)

    def prepare(self) -> None:
        """
        Prepare for the limits of processes, before anything starts.

        :raises UserError: when one cannot be set
        """
        tasks = self.supervisor.tasks
        for text in self.starter.prepare((t.number, t.process) for t in tasks):
            self.emit(events.Warned(text))

    def start_client(self) -> None:
        """Start the ROS client if one is needed; it comes up meanwhile."""
        self._may_start_client = True
        if self._ros is not None:
            self._ros.start()

    def use_ros(self) -> None:
        """Have a ROS client from now on, if the environment has ROS."""
        if self._ros is not None:
            return
        known = Plan(tuple(t.process for t in self.supervisor.tasks))
        ros = self._ros_link(known)
        if ros.is_found:
            self._use_ros(ros)

    def run(self, signals: int) -> None:
        """
        Run to the end.

        :param signals: Where signals arrive, see `loop.caught`
        :raises UserError: before anything is started, when the environment
          lacks what the plan needs
        """
        self.loop.add_reader(
            signals, lambda: self._handle_signals(received(signals))
        )
        screen = self._writer.descriptor
        if screen != -1:
            # an ordinary file is always ready
            with suppress(PermissionError):
                self.loop.add_hangup_handler(screen, self._writer.give_up)
                self._is_screen_slow = True
        if self._ros is not None:
            self._await_ros(self._ros)
        self._conditions.begin()
        for participant in self.participants:
            participant.begin()
        self._look_for_children()
        while True:
            self._end_turn()
            if self.supervisor.done:
                break
            self._flush()
            self.loop.run_once(self._due())
        self.loop.remove_reader(signals)
        self._close_helpers()
        # nothing runs in it
        self.starter.cgroup.remove()
        self._relay.close()
        self._conditions.end()

    def finish(self, signals: int) -> None:
        """Wait until the screen has taken everything, or was closed."""
        numbers: list[int] = []
        self.loop.add_reader(
            signals, lambda: numbers.extend(received(signals))
        )
        ends_by = math.inf
        if self.supervisor.stopped_by_signal:
            ends_by = self.loop.time() + limits.SCREEN_TIMEOUT
        self._flush()
        while self._writer.waits() and not self._writer.broken:
            self.loop.run_once(min(ends_by, self._due()))
            if set(STOPPING) & set(numbers) or self.loop.time() >= ends_by:
                return
            self._flush()

    def close(self) -> None:
        """Free what the engine holds."""
        self._close_helpers()
        self.terminals.close()
        self.loop.close()
        self.starter.descriptors.restore()

    def start(self, number: int, process: Process) -> int:
        """Start a process; see `ProcessStarter.start`."""
        size = self.terminal_size() if process.emulate_tty else None
        return self.starter.start(number, process, size)

    def starting(self) -> AbstractContextManager[None]:
        """Return a context in which several processes start faster."""
        return self.starter.cgroup.moves_at_once()

    def release(self, group: int) -> bool:
        """Return whether a group ended with its leader."""
        try:
            os.killpg(group, 0)
        except PermissionError:
            return False
        except ProcessLookupError:
            self._guard.ended(group)
            return True
        return False

    def send(self, target: Target, step: signal.Signals) -> bool:
        """Send a signal."""
        return send(target, step)

    def kill(self, number: int) -> None:
        """Kill all that belongs to a process of the plan, if possible."""
        self.starter.cgroup.kill(number)

    def orphans(
        self, groups: Mapping[int, int], with_leader: Collection[int]
    ) -> list[Orphan]:
        """Find processes of the launch."""
        self.starter.cgroup.leave()
        numbers = {task.number for task in self.supervisor.tasks}
        return self._orphan_finder.orphans(groups, with_leader, numbers)

    def is_alive(self, orphan: Orphan) -> bool:
        """Return whether a process still runs."""
        return is_alive(orphan.pid, orphan.birth)

    def signal(self, group: int, number: int) -> bool:
        """Send a signal as it is, and return whether anybody got it."""
        # whatever number a plan has
        with suppress(OSError, OverflowError):
            os.killpg(group, number)
            return True
        return False

    def call(self, number: int) -> None:
        """Call a function of a launch file; see `WorkerCall`."""
        for participant in self.participants:
            participant.call(number)

    def prepare_end(self) -> bool:
        """Prepare for the end; return whether the launch must go on."""
        return any(p.prepare_end() for p in self.participants)

    def ask(
        self,
        command: 'Command[Response]',
        reply: 'Callable[[Response | Refused], object]' = do_nothing,
    ) -> None:
        """Execute a command; see `Dispatcher.ask`."""
        self.dispatcher.ask(command, reply)

    def listen(self, listener: events.Listener) -> None:
        """Pass all events to `listener`, after all other listeners."""
        self._listeners.append(listener)
        self._output_listeners.append(listener)

    def emit(self, event: events.Event) -> None:
        """Apply an event to the state, and pass it to all listeners."""
        listeners = self._output_listeners
        if not isinstance(event, events.Output):
            self.state.apply(event)
            listeners = self._listeners
        for listener in listeners:
            listener(event)

    def planned(self, entries: Iterable[Entry]) -> Plan:
        """Return entries as they are to run here."""
        plan = Plan(tuple(entries))
        return with_terminals(plan) if self._settings.tty else plan

    def planned_processes(self) -> list[Process]:
        """Return the processes that run here as they are planned now."""
        return [t.successor or t.process for t in self.supervisor.tasks]

    def planned_components(self) -> list[tuple[Component, Process | None]]:
        """Return the components here, with their containers' processes."""
        composition = self.composition
        if composition is None:
            return []
        return [
            (t.successor or t.component, composition.container_process(t))
            for t in composition.tasks
        ]

    def expect(self, more: Plan) -> None:
        """Prepare for more entries of the plan."""
        self.starter.descriptors.expect(sum(1 for _ in more.processes()))
        if self._ros is not None:
            self._ros.expect(more)
        elif more.needs_ros:
            known = Plan(tuple(t.process for t in self.supervisor.tasks))
            ros = self._ros_link(known)
            ros.expect(more)
            self._use_ros(ros)

    def _use_ros(self, ros: 'RosLink') -> None:
        self._ros = ros
        self.supervisor.compose(ros.composition)
        if self._may_start_client:
            ros.start()

    def _ros_link(self, plan: Plan) -> 'RosLink':
        # few launches need it
        from colcon_yamllaunch.engine.ros_link import RosLink

        return RosLink(plan, self, self._settings)

    def start_client_program(
        self, argv: list[str], streams: tuple[int, int, int]
    ) -> int:
        """
        Start the ROS client as a process of the launch.

        :returns: its process group
        """
        number = self.supervisor.client_number
        environment = dict(self._settings.environment)
        group = self.starter.start_helper(
            number, argv, environment, '/', streams
        )
        self.guard_group(group, number)
        return group

    def run_command(
        self,
        argv: Sequence[str],
        process: Process,
        ended: Callable[[int], object],
    ) -> int:
        """
        Run a command beside a process, in its environment and folder.

        Nobody sees its output.

        :param ended: Is called with its exit code, or minus the number of the
          signal that ended it
        :returns: its process group
        :raises StartError: when it cannot be started
        """
        number = self.supervisor.client_number
        null = os.open(os.devnull, os.O_RDWR | os.O_CLOEXEC)
        try:
            group = self.starter.start_helper(
                number,
                list(argv),
                self.starter.environment_of(process),
                process.cwd,
                (null, null, null),
            )
        finally:
            os.close(null)
        self.guard_group(group, number)
        self.loop.add_child(
            group, lambda status: ended(os.waitstatus_to_exitcode(status))
        )
        return group

    def _await_ros(self, ros: 'RosLink') -> None:
        """
        Wait until it is known what the environment has.

        :raises UserError: when it lacks something
        """
        while not (ros.is_found or self.supervisor.is_stopping):
            if ros.error is not None:
                raise UserError(ros.error)
            self._flush()
            self.loop.run_once(self._due())

    def _close_helpers(self) -> None:
        if self._ros is not None:
            self._ros.close()
        for participant in self.participants:
            participant.close()

    def _end_turn(self) -> None:
        """Handle the consequences of all events of this turn."""
        self.check_conditions()
        for end_turn in self._end_turns:
            end_turn()
        if self._ros is not None and self.supervisor.is_stopping:
            # it takes as long as a process to come to its end
            self._ros.hang_up()
        looked = self.loop.time() - self._orphan_finder.looked
        if looked >= limits.ADOPTION_INTERVAL:
            self._reap()
        self.supervisor.end_turn()

    def _flush(self) -> None:
        """Send what has been collected to guard, logs and screen."""
        self._guard.flush()
        publish = None if self.supervisor.is_starting else self._publish
        if publish is not None and publish():
            self.loop.wake()
        self._writer.flush()
        self._relay.resume()
        screen = self._writer.descriptor
        if self._writer.broken:
            self.supervisor.stop('nobody reads the output any more')
            self.loop.remove(screen)
        elif self._is_screen_slow:
            if self._writer.waits():
                self.loop.add_writer(screen, self._writer.flush)
            else:
                self.loop.remove_writer(screen)

    def _due(self) -> float:
        """Return when the next condition or drawing is due."""
        dues = self._conditions.due(), self._writer.due()
        return min((due for due in dues if due is not None), default=math.inf)

    def _look_for_children(self) -> None:
        """Check all children, as SIGCHLD may be lost or not sent."""
        self._reap()
        self.loop.call_later(
            limits.IDLE_ADOPTION_INTERVAL, self._look_for_children
        )

    def _handle_signals(self, numbers: list[int]) -> None:
        for number in numbers:
            if number in STOPPING:
                self._stop_by(number)
            elif number == signal.SIGTSTP:
                self._suspend()
            elif number == signal.SIGCONT:
                self._do_hold(is_held=False)
                for listener in self.when_suspended:
                    listener(False)
                self._follow_screen()
            elif number == signal.SIGWINCH:
                self._follow_screen()
        if signal.SIGCHLD in numbers:
            self._reap()

    def _stop_by(self, number: int) -> None:
        from colcon_yamllaunch.engine import commands

        now = self.loop.time()
        is_echo = now - self._last_stop < limits.SIGNAL_ECHO_INTERVAL
        self._last_stop = now
        self.supervisor.stopped_by_signal = True
        if not self.supervisor.is_stopping:
            name = signal.Signals(number).name
            by_key = number == signal.SIGINT
            reason = 'interrupted' if by_key else f'{name} received'
            # a user at a keyboard can ask again
            self.dispatcher.do(commands.Shutdown(reason, by_key, not by_key))
            return
        # a terminal that closes sends SIGHUP, and so does its shell
        if not is_echo and number != signal.SIGHUP:
            self.dispatcher.do(commands.Escalate())

    def _suspend(self) -> None:
        for listener in self.when_suspended:
            listener(True)
        self._do_hold(is_held=True)
        suspend_ourselves()
        # an orphaned process group is not suspended, see suspend_ourselves
        self._do_hold(is_held=False)

    def _do_hold(self, *, is_held: bool) -> None:
        from colcon_yamllaunch.engine.commands import Hold

        self.dispatcher.do(Hold(is_held))

    def _follow_screen(self) -> None:
        """Resize the terminals of processes to that of the screen."""
        from colcon_yamllaunch.engine.commands import Resize

        for listener in self.when_resized:
            listener()
        self.dispatcher.do(Resize(*self.terminal_size()))

    def terminal_size(self) -> os.terminal_size:
        """Return the size of the terminals of processes."""
        return self._size or size_of(self._settings.screen)

    def hold(self, *, is_held: bool) -> None:
        """Suspend all processes as Ctrl-Z does, or let them go on."""
        number = signal.SIGSTOP if is_held else signal.SIGCONT
        groups = dict.fromkeys(self.supervisor.groups, 0)
        for group in groups:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(group, number)
        for orphan in self.orphans(groups, groups):
            with suppress(ProcessLookupError, PermissionError):
                os.kill(orphan.pid, number)

    def resize(self, size: os.terminal_size) -> None:
        """Set the size of the terminals of processes."""
        if self._size is not None:
            # that of a screen elsewhere
            self._size = size
        # the terminals control no session, so the kernel sends no SIGWINCH
        self.terminals.resize(size)
        for group in self._relay.resize(size):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(group, signal.SIGWINCH)

    def _reap(self) -> None:
        ours = {*self.supervisor.groups, *self.loop.children}
        adopted = self._orphan_finder.adopted(ours)
        for pid, number in suspended_children(ours):
            if pid not in self.loop.children:
                self.supervisor.suspended(pid, number)
            elif number is not None:
                self.loop.children[pid][1]()
        for pid, status in ended_children(ours | adopted):
            if pid in adopted:
                self._settings.adoption.reaped(pid)
                self._guard.reaped(pid)
            elif pid in self.loop.children:
                self._guard.ended(pid)
                self.loop.children.pop(pid)[0](status)
            else:
                self._relay.drain(pid)
                # the last line of a process counts before its exit code
                self.check_conditions()
                self.supervisor.exited(pid, self.starter.ended(pid, status))

    def _expect_guard(self) -> None:
        if self._guard.pid:
            self.loop.add_child(self._guard.pid, self._replace_guard)

    def _replace_guard(self, _status: int) -> None:
        try:
            if not self._guard.restart():
                text = 'the guard ended too often and is not started again'
                self.emit(events.Warned(_without_guard(text)))
        except OSError as error:
            self.emit(events.Warned(no_guard(error)))
        self._expect_guard()


def no_guard(error: OSError) -> str:
    """Return a warning about the consequences of a missing guard."""
    return _without_guard(f'the guard cannot be started: {error.strerror}')


def _without_guard(reason: str) -> str:
    return f'{reason}; if the launcher is killed, its processes go on'
