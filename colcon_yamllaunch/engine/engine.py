# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The loop that ties processes, output, signals and time together."""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterable
from collections.abc import Mapping
from contextlib import suppress
import math
import os
from pathlib import Path
import signal
from types import MappingProxyType
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.escalation import Orphan
from colcon_yamllaunch.common.escalation import send
from colcon_yamllaunch.common.escalation import Target
from colcon_yamllaunch.common.escalation import Timeouts
from colcon_yamllaunch.common.process_scan import is_alive
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.exit_conditions import ExitConditions
from colcon_yamllaunch.engine.launch_settings import Settings
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.loop import TimerHandle
from colcon_yamllaunch.engine.moment import Moment
from colcon_yamllaunch.engine.orphans import Strays
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.output.channels import size_of
from colcon_yamllaunch.engine.output.relay import Recorder
from colcon_yamllaunch.engine.output.relay import Relay
from colcon_yamllaunch.engine.output.signals import received
from colcon_yamllaunch.engine.output.signals import stop_ourselves
from colcon_yamllaunch.engine.output.signals import STOPPING
from colcon_yamllaunch.engine.output.terminals import Terminals
from colcon_yamllaunch.engine.output.terminals import with_terminals
from colcon_yamllaunch.engine.output.writer import Writer
from colcon_yamllaunch.engine.plan_source import PlanSource
from colcon_yamllaunch.engine.process.children import ended_children
from colcon_yamllaunch.engine.process.children import suspended_children
from colcon_yamllaunch.engine.process.line_buffering import SilenceWatch
from colcon_yamllaunch.engine.process.parameter_files import ParameterFiles
from colcon_yamllaunch.engine.process_starter import ProcessStarter
from colcon_yamllaunch.engine.state import LaunchState
from colcon_yamllaunch.engine.stopping.guard_link import GuardLink
from colcon_yamllaunch.engine.supervisor import Supervisor
from colcon_yamllaunch.plan.plan import Block
from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Entry
from colcon_yamllaunch.plan.plan import ParametersOf
from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Process

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.components.composition import Composition
    from colcon_yamllaunch.engine.components.ros_link import RosLink
    from colcon_yamllaunch.engine.dispatcher import Dispatcher
    from colcon_yamllaunch.engine.elsewhere import Companion
    from colcon_yamllaunch.engine.elsewhere import Elsewhere
    from colcon_yamllaunch.engine.plan_changes import PlanChanges
    from colcon_yamllaunch.engine.plan_feed import PlanFeed

# how long the guard lets the process that speaks with ROS end by itself
_CLIENT_TIMEOUTS = Timeouts(0.5, 0.5)


class Engine:
    """
    Runs a plan on the system.

    :param guard: Is told of all processes
    :param writer: The screen, whose pace output keeps to
    :param listeners: Are told what happens
    :param record: Takes all output as it is read
    :param publish: Is called once a turn, to write what has been collected,
      but not before all is started that is due, which is more urgent;
      returns whether it has more to do
    :param state: Is changed by each event before listeners get it
    :param source: Where more plan comes from, if anywhere
    :param elsewhere: The parts that run on other machines, if any do
    :param companion: What is beside a part that runs for another machine
    :param log_files: For each label, the log with all output
    :param parameters_of: Returns the parameters of a process
    """

    def __init__(
        self,
        plan: Plan,
        settings: Settings,
        guard: GuardLink,
        files: ParameterFiles,
        writer: Writer,
        listeners: Iterable[events.Listener],
        record: Recorder,
        publish: Callable[[], bool],
        conditions: ExitConditions,
        state: LaunchState,
        source: PlanSource | None = None,
        elsewhere: 'Elsewhere | None' = None,
        companion: 'Companion | None' = None,
        *,
        log_files: Mapping[str, Path] = MappingProxyType({}),
        parameters_of: ParametersOf = lambda process: process.parameters,
    ) -> None:
        if settings.tty:
            plan = with_terminals(plan)
        self._blocks = plan.blocks
        self._conditions = conditions
        #: The state of the launch.
        self.state = state
        self._settings = settings
        self._guard = guard
        self._writer = writer
        self._publish = publish
        #: What everything waits for.
        self.loop = Loop(settings.clock)
        #: The parts that run on other machines.
        self.elsewhere = elsewhere
        self._companion = companion
        self._size = settings.size
        is_alone = source is None and companion is None
        accepts = writer.accepts if is_alone else self.accepts
        self._relay = Relay(self.loop, accepts, record, self.tell)
        #: The keyboards of processes.
        self.terminals = Terminals(self.loop, self._relay, elsewhere)
        if companion is not None:
            self.terminals.when_echoed = companion.echoed
        self._silence = SilenceWatch(self._holds_back, settings.clock)
        self._listeners = [
            *listeners,
            self.terminals.handle,
            self._silence.handle,
        ]
        if elsewhere is not None:
            self._listeners.append(elsewhere.handle)
        self._ros = self._ros_link(plan) if plan.needs_ros else None
        #: Tell whether the plan may still grow, though nothing runs.
        self.reasons_to_wait: list[Callable[[], bool]] = []
        self._changes: PlanChanges | None = None
        self._adapt: Callable[[Mapping[str, str]], Mapping[str, str]] = dict
        #: The course of the launch.
        self.supervisor = Supervisor(plan, self, self.loop, self.composition)
        self._feed = None if source is None else self._plan_feed(source)
        #: Starts processes.
        self.starter = ProcessStarter(
            settings,
            guard,
            files,
            self._relay,
            self.terminals,
            len(self.supervisor.tasks),
        )
        self._strays = Strays(settings, guard, self.starter)
        self._alarm: TimerHandle | None = None
        # whether the screen may have to be waited for
        self._is_screen_slow = False
        self._last_stop = -limits.SIGNAL_ECHO
        self._stopped_by_signal = False
        #: Are called with True before Ctrl-Z suspends the launch, and
        #: with False when it goes on.
        self.when_suspended: list[Callable[[bool], None]] = []
        #: Who is told when a child that he started ends, with True, or is
        #: suspended, with False; by its process id.
        self.helpers: dict[int, Callable[[bool], None]] = {}
        #: Are called when the screen has another size.
        self.when_resized: list[Callable[[], None]] = []
        self._log_files = log_files
        self._parameters_of = parameters_of
        self._dispatcher: Dispatcher | None = None

    @property
    def dispatcher(self) -> 'Dispatcher':
        """Executes commands."""
        if self._dispatcher is None:
            # few launches are asked for anything
            from colcon_yamllaunch.engine.dispatcher import Dispatcher

            self._dispatcher = Dispatcher(
                self, self._log_files, self._parameters_of
            )
        return self._dispatcher

    @property
    def feed(self) -> 'PlanFeed | None':
        """The source of more plan, if there is one."""
        return self._feed

    @property
    def composition(self) -> 'Composition | None':
        """The course of what happens in ROS, if anything is to."""
        return None if self._ros is None else self._ros.composition

    def extend(self, entries: Iterable[Entry]) -> None:
        """
        Take more into the plan; see `Supervisor.extend`.

        :raises ValueError: when a label is taken
        """
        if self.elsewhere is not None:
            entries = self.elsewhere.extend(entries)
        more = Plan(tuple(entries))
        if self._settings.tty:
            more = with_terminals(more)
        if not self.supervisor.is_stopping:
            self._expect(more)
        self.supervisor.extend(more)

    def replace(self, part: Process | Component) -> None:
        """
        Have a part of the plan be another one, and start or load that anew.

        See `Supervisor.replace` and `Composition.replace`.

        :param part: It has the label of what it takes the place of
        :raises RefusedError: when there is none, or all is being stopped
        """
        if self.elsewhere is not None and self.elsewhere.has(part.label):
            self.elsewhere.replace(part)
            return
        more = Plan((part,))
        if self._settings.tty:
            more = with_terminals(more)
        self._expect(more)
        for process in more.processes():
            self.supervisor.replace(process)
        for component in more.components():
            self._composition_of(component.label).replace(component)

    def drop(self, label: str) -> None:
        """
        Stop or unload a part of the plan, and forget it then.

        :raises RefusedError: when there is none, or all is being stopped
        """
        if self.elsewhere is not None and self.elsewhere.has(label):
            self.elsewhere.drop(label)
        elif any(t.process.label == label for t in self.supervisor.tasks):
            self.supervisor.drop(label)
        else:
            self._composition_of(label).drop(label)

    # what changes the plan while it runs; see `plan_changes.RunningLaunch`

    def change_by(
        self,
        changes: 'PlanChanges',
        adapt: Callable[[Mapping[str, str]], Mapping[str, str]],
    ) -> None:
        """
        Have the plan changed while it runs.

        :param adapt: Adds what is shown how to an environment
        """
        self._changes = changes
        self.state.watch = ''
        self._adapt = adapt
        self.supervisor.outlasts_failures = True
        self.reasons_to_wait.append(lambda: True)
        self.listen(changes.handle)

    @property
    def changes(self) -> 'PlanChanges | None':
        """What changes the plan while it runs, if anything does."""
        return self._changes

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The launch files, groups and timers that parts stand in."""
        return (self._feed and self._feed.blocks) or self._blocks

    @blocks.setter
    def blocks(self, blocks: tuple[Block, ...]) -> None:
        self._blocks = blocks

    @property
    def is_changed(self) -> bool:
        """Whether the plan is changed while it runs."""
        return self._changes is not None

    def groups(self) -> Mapping[str, int]:
        """Return the process groups of the processes that run, by label."""
        return self.state.groups()

    def revise(self, part: Process | Component, *, at_once: bool) -> None:
        """Have a part of the plan be another one from its next start on."""
        if self.elsewhere is not None and self.elsewhere.has(part.label):
            self.elsewhere.revise(part, at_once=at_once)
            return
        more = Plan((part,))
        if self._settings.tty:
            more = with_terminals(more)
        for process in more.processes():
            self.supervisor.revise(process, at_once=at_once)
        for component in more.components():
            self._composition_of(component.label).revise(component)

    def restart(self, labels: Collection[str]) -> tuple[str, ...]:
        """Start processes and load components anew after a change."""
        if self.composition is not None:
            # a container that has crashed is needed, too
            ended = self.composition.ended_containers(labels)
            labels = {*labels, *ended}
        restarted = self.supervisor.restart_changed(labels)
        if self.composition is not None:
            reloaded = self.composition.reload_changed(labels, restarted)
            restarted = (*restarted, *reloaded)
        if self.elsewhere is not None:
            restarted = (*restarted, *self.elsewhere.restart(labels))
        return restarted

    def forget(self, entries: Iterable[Entry]) -> None:
        """Do not do what has not been done yet, such as messages."""
        if self.elsewhere is not None:
            entries = self.elsewhere.forget(entries)
        self.supervisor.forget(entries)

    def renew_environment(self, variables: Mapping[str, str]) -> None:
        """Give processes that start from now on other variables."""
        self.starter.variables = self._adapt(variables)
        if self.elsewhere is not None:
            self.elsewhere.renew_environment(variables)

    # what parts that run elsewhere need; see `elsewhere.LaunchHere`

    @property
    def is_stopping(self) -> bool:
        """Whether everything is being stopped."""
        return self.supervisor.is_stopping

    def shut_down(self, reason: str) -> None:
        """Begin to end the launch, as an entry of its plan would."""
        self.supervisor.stop(reason)

    @property
    def moment(self) -> Moment:
        """When what is told happened."""
        return self._settings.moment

    def take_output(
        self, process: Process, stream: events.Stream, data: bytes
    ) -> None:
        """Take what a process wrote, as if it had been read here."""
        self._relay.feed(process, stream, data)

    def end_lines(self, label: str) -> None:
        """Take the last line of a process as whole, as the process ended."""
        self._relay.end_lines(label)
        # the last line of a process counts before its exit code
        self.check_conditions()

    def check_conditions(self) -> None:
        """Stop the launch if a condition is met or something failed."""
        reason = self._conditions.reason_to_stop()
        if reason is not None:
            self.supervisor.stop(reason)
        silent = self._silence.overdue()
        if silent is not None:
            self.tell(silent)

    def echo(self, label: str, data: bytes) -> None:
        """Show who is attached to a process what its terminal echoed."""
        self._relay.show(label, 'stdout', data)

    def accepts(self, key: tuple[str, events.Stream]) -> bool:
        """Tell whether a process may write more to a stream."""
        return (
            self._writer.accepts(key)
            and (self._feed is None or self._feed.accepts(key[0]))
            and (self._companion is None or self._companion.accepts(key[0]))
        )

    @property
    def is_ended_by_others(self) -> bool:
        """Whether not only what changes the plan has asked for the end."""
        return self._stopped_by_signal or len(self.supervisor.stop_reasons) > 1

    def guard_group(self, group: int) -> None:
        """Have a process group ended with the launch, however that ends."""
        number = self.supervisor.client_number
        self._guard.started(number, group, _CLIENT_TIMEOUTS)

    def release_group(self, group: int) -> None:
        """Take into account that nothing of a process group runs."""
        self._guard.ended(group)

    def start_client(self) -> None:
        """Start the ROS client if one is needed; it comes up meanwhile."""
        if self._ros is not None:
            self._ros.start()

    def run(self, signals: int) -> None:
        """
        Run to the end.

        :param signals: Where signals arrive, see `signals.caught`
        :raises UserError: before anything is started, when the environment
          lacks what the plan needs
        """
        self.loop.add_reader(
            signals, lambda: self._take_signals(received(signals))
        )
        screen = self._writer.descriptor
        if screen != -1:
            # an ordinary file is always ready
            with suppress(PermissionError):
                self.loop.add_hangup_handler(screen, self._writer.give_up)
                self._is_screen_slow = True
        if self._ros is not None:
            self._await_ros(self._ros)
        if self._changes is not None:
            self._changes.begin(self)
        self._conditions.begin()
        if self._feed is not None:
            self._feed.begin()
        if self.elsewhere is not None:
            self.elsewhere.begin(self, self._terminal_size())
        self._look_for_children()
        while True:
            self._follow_up()
            if self.supervisor.done:
                break
            self._pass_on()
            self.loop.run_once()
        self.loop.remove_reader(signals)
        self._end_ros()
        if self._changes is not None:
            self._changes.close()
        self._end_feed()
        if self.elsewhere is not None:
            self.elsewhere.close()
        self.starter.remove_cgroup()
        self._relay.close()
        self._conditions.end()

    def finish(self, signals: int) -> None:
        """Wait until the screen has taken everything, or nobody wants it."""
        numbers: list[int] = []
        self.loop.add_reader(
            signals, lambda: numbers.extend(received(signals))
        )
        ends_by = math.inf
        if self._stopped_by_signal:
            ends_by = self.loop.time() + limits.SCREEN_PATIENCE
            self.loop.call_at(ends_by, self.loop.wake)
        self._pass_on()
        while self._writer.waits() and not self._writer.broken:
            self.loop.run_once()
            if set(STOPPING) & set(numbers) or self.loop.time() >= ends_by:
                return
            self._pass_on()

    def close(self) -> None:
        """Free what the engine holds."""
        self._end_ros()
        self._end_feed()
        if self.elsewhere is not None:
            self.elsewhere.close()
        self.terminals.close()
        self.loop.close()
        self.starter.close()

    def start(self, number: int, process: Process) -> int:
        """Start a process; see `supervisor.Host`."""
        size = self._terminal_size() if process.emulate_tty else None
        return self.starter.start(number, process, size)

    def release(self, group: int) -> bool:
        """Tell whether a group ended with its leader."""
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
        self.starter.kill(number)

    def orphans(
        self, groups: Mapping[int, int], with_leader: Collection[int]
    ) -> list[Orphan]:
        """Find processes of the launch."""
        numbers = {task.number for task in self.supervisor.tasks}
        return self._strays.orphans(
            groups, with_leader, numbers, self._helpers()
        )

    def is_alive(self, orphan: Orphan) -> bool:
        """Tell whether a process still runs."""
        return is_alive(orphan.pid, orphan.birth)

    def signal(self, group: int, number: int) -> bool:
        """Send a signal as it is, and return whether anybody got it."""
        # whatever number a plan has
        with suppress(OSError, OverflowError):
            os.killpg(group, number)
            return True
        return False

    def call(self, number: int) -> None:
        """Ask for what a `HostCall` stands for."""
        if self._feed is not None:
            self._feed.call(number)

    def is_waiting(self) -> bool:
        """Tell whether the launch is to go on; see `supervisor.Host`."""
        if not self.supervisor.is_stopping and any(
            waits() for waits in self.reasons_to_wait
        ):
            return True
        if self.elsewhere is not None and self.elsewhere.is_waiting():
            return True
        if self._companion is not None and self._companion.is_waiting():
            return True
        # which the source takes for the end if nothing else waits
        return self._feed is not None and self._feed.is_waiting()

    def listen(self, listener: events.Listener) -> None:
        """Have somebody else told, too, after all others."""
        self._listeners.append(listener)

    def tell(self, event: events.Event) -> None:
        """Apply an event to the state, and tell everybody who listens."""
        if not isinstance(event, events.Output):
            self.state.apply(event)
        for listener in self._listeners:
            listener(event)

    def _ros_link(self, plan: Plan) -> 'RosLink':
        # few launches need it
        from colcon_yamllaunch.engine.components.ros_link import RosLink

        def start(argv: list[str], streams: tuple[int, int, int]) -> int:
            environment = dict(self._settings.environment)
            number = self.supervisor.client_number
            group = self.starter.start_helper(
                number, argv, environment, '/', streams
            )
            self._guard.started(number, group, _CLIENT_TIMEOUTS)
            return group

        return RosLink(
            plan,
            self._settings.environment,
            self.loop,
            start,
            self.tell,
            self._settings.client_log,
        )

    def _plan_feed(self, source: PlanSource) -> 'PlanFeed':
        # few launches need it
        from colcon_yamllaunch.engine.plan_feed import PlanFeed

        feed = PlanFeed(
            source,
            self.loop,
            self.extend,
            self.tell,
        )
        self._listeners.append(feed.handle)
        if source.pid:
            self._guard.started(source.number, source.pid, _CLIENT_TIMEOUTS)
        return feed

    def _end_feed(self) -> None:
        if self._feed is not None:
            group = self._feed.pid
            self._feed.close()
            self._guard.ended(group)

    def _expect(self, more: Plan) -> None:
        """Prepare for what comes to the plan."""
        self.starter.expect(sum(1 for _ in more.processes()))
        if self._ros is not None:
            self._ros.expect(more, is_late=True)
        elif more.needs_ros:
            known = Plan(tuple(t.process for t in self.supervisor.tasks))
            self._ros = self._ros_link(known)
            self._ros.expect(more, is_late=True)
            self.supervisor.compose(self._ros.composition)
            self._ros.start()

    def _composition_of(self, label: str) -> 'Composition':
        composition = self.composition
        if composition is None:
            raise RefusedError(f"there is no component '{label}'")
        return composition

    def _await_ros(self, ros: 'RosLink') -> None:
        """
        Wait until it is known what the environment has.

        :raises UserError: when it lacks something
        """
        while not (ros.is_found or self.supervisor.is_stopping):
            if ros.error is not None:
                raise UserError(ros.error)
            self._pass_on()
            self.loop.run_once()

    def _end_ros(self) -> None:
        if self._ros is not None and self._ros.pid:
            group = self._ros.pid
            self._ros.close()
            self._guard.ended(group)

    def _children_of_ours(self) -> set[int]:
        return {*self.supervisor.groups, *self._helpers()} - {0}

    def _helpers(self) -> set[int]:
        """Return our children that are no processes of the plan."""
        client = 0 if self._ros is None else self._ros.pid
        host = 0 if self._feed is None else self._feed.pid
        changes = () if self._changes is None else self._changes.pids
        links = () if self.elsewhere is None else self.elsewhere.pids
        return {self._guard.pid, client, host, *changes, *links, *self.helpers}

    def _adopted(self) -> set[int]:
        """Return the children that we adopted."""
        return self._strays.adopted(self._children_of_ours(), self._helpers())

    def _mind_changes(self, changes: 'PlanChanges') -> None:
        if self.supervisor.is_stopping:
            changes.hang_up()
        else:
            changes.advance()

    def _holds_back(self, process: Process) -> bool:
        """Tell whether a process may hold back what it writes."""
        # who runs it elsewhere tells that
        is_here = self.elsewhere is None or not self.elsewhere.has(
            process.label
        )
        return is_here and self._settings.buffering.is_cpp(process)

    def _follow_up(self) -> None:
        """Do what follows from all that happened in this turn."""
        self.check_conditions()
        if self.elsewhere is not None:
            self.elsewhere.advance()
        if self._changes is not None:
            self._mind_changes(self._changes)
        if self._ros is not None and self.supervisor.is_stopping:
            # it takes as long as a process to come to its end
            self._ros.hang_up()
        looked = self.loop.time() - self._strays.looked
        if looked >= limits.ADOPTION_INTERVAL:
            self._reap()
        self.supervisor.end_turn()
        if self._feed is not None:
            self._feed.flush()
        if self._companion is not None:
            self._companion.advance()

    def _pass_on(self) -> None:
        """Pass on to the guard, the logs and the screen what there is."""
        self._guard.flush()
        if not self.supervisor.is_starting and self._publish():
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
        self._set_alarm()

    def _set_alarm(self) -> None:
        """Have a turn when it is time for the next condition or drawing."""
        dues = [self._conditions.due(), self._silence.due()]
        dues.append(self._writer.due())
        for other in (self.elsewhere, self._companion, self._changes):
            if other is not None and not (
                other is self._changes and self.supervisor.is_stopping
            ):
                seconds = other.seconds_to_wait()
                if seconds is not None:
                    dues.append(self.loop.time() + seconds)
        due = min((due for due in dues if due is not None), default=None)
        if self._alarm is not None:
            if self._alarm.when() == due and not self._alarm.cancelled():
                return
            self._alarm.cancel()
        if due is not None:
            self._alarm = self.loop.call_at(due, self.loop.wake)

    def _look_for_children(self) -> None:
        """Look at all children: SIGCHLD may be lost, or not be sent."""
        self._reap()
        self.loop.call_later(limits.ADOPTION_PAUSE, self._look_for_children)

    def _take_signals(self, numbers: list[int]) -> None:
        for number in numbers:
            if number in STOPPING:
                self._stop_by(number)
            elif number == signal.SIGTSTP:
                self._suspend()
            elif number == signal.SIGCONT:
                self.hold(is_held=False)
                for listener in self.when_suspended:
                    listener(False)
                self.resize()
            elif number == signal.SIGWINCH:
                self.resize()
        if signal.SIGCHLD in numbers:
            self._reap()

    def _stop_by(self, number: int) -> None:
        from colcon_yamllaunch.engine import commands

        now = self.loop.time()
        is_echo = now - self._last_stop < limits.SIGNAL_ECHO
        self._last_stop = now
        self._stopped_by_signal = True
        if not self.supervisor.is_stopping:
            name = signal.Signals(number).name
            by_key = number == signal.SIGINT
            reason = 'interrupted' if by_key else f'{name} received'
            # who is at a keyboard can ask again
            self.dispatcher.do(commands.Shutdown(reason, by_key, not by_key))
            return
        # a terminal that closes sends SIGHUP, and so does its shell
        if not is_echo and number != signal.SIGHUP:
            self.dispatcher.do(commands.Escalate())

    def _suspend(self) -> None:
        for listener in self.when_suspended:
            listener(True)
        self.hold(is_held=True)
        stop_ourselves()
        # where nobody could continue us, the system has not stopped us
        self.hold(is_held=False)

    def hold(self, *, is_held: bool) -> None:
        """Hold all processes as Ctrl-Z does, or let them go on."""
        self._signal_all(signal.SIGSTOP if is_held else signal.SIGCONT)
        if self.elsewhere is not None:
            self.elsewhere.suspend(is_held)

    def _terminal_size(self) -> os.terminal_size:
        return self._size or size_of(self._settings.screen)

    def resize(self, given: os.terminal_size | None = None) -> None:
        """
        Give terminals of processes the size of the screen.

        :param given: The size of a screen that is elsewhere
        """
        self._size = given or self._size
        # the terminals control no session, so the kernel tells nobody
        for listener in self.when_resized:
            listener()
        size = self._terminal_size()
        if self.elsewhere is not None:
            self.elsewhere.resize(size)
        self.terminals.resize(size)
        for group in self._relay.resize(size):
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(group, signal.SIGWINCH)

    def _signal_all(self, number: int) -> None:
        """Hold or continue the processes, and all that they started."""
        groups = dict.fromkeys(self.supervisor.groups, 0)
        for group in groups:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(group, number)
        for orphan in self.orphans(groups, groups):
            with suppress(ProcessLookupError, PermissionError):
                os.kill(orphan.pid, number)

    def _reap(self) -> None:
        adopted = self._adopted()
        ours = self._children_of_ours()
        for pid, number in suspended_children(ours):
            if pid in self.helpers:
                if number is not None:
                    self.helpers[pid](False)
                continue
            self.supervisor.suspended(pid, number)
        for pid, status in ended_children(ours | adopted):
            if pid in adopted:
                self._settings.adoption.reaped(pid)
                self._guard.reaped(pid)
            elif pid == self._guard.pid:
                self._replace_guard()
            elif pid in self.helpers:
                self.helpers.pop(pid)(True)
            elif self._ros is not None and pid == self._ros.pid:
                self._guard.ended(pid)
                self._ros.ended(Outcome.from_status(status))
            elif self._changes is not None and pid in self._changes.pids:
                self._changes.ended(pid, Outcome.from_status(status))
            elif self._feed is not None and pid == self._feed.pid:
                self._guard.ended(pid)
                self._feed.ended(status)
            elif self.elsewhere is not None and pid in self.elsewhere.pids:
                self.elsewhere.ended(pid, Outcome.from_status(status))
            else:
                self._relay.drain(pid)
                # the last line of a process counts before its exit code
                self.check_conditions()
                self.supervisor.exited(pid, Outcome.from_status(status))

    def _replace_guard(self) -> None:
        try:
            if not self._guard.restart():
                text = 'the guard ended too often and is not started again'
                self.tell(events.Warned(_without_guard(text)))
        except OSError as error:
            self.tell(events.Warned(no_guard(error)))


def no_guard(error: OSError) -> str:
    """Say what it means that the guard cannot be started."""
    return _without_guard(f'the guard cannot be started: {error.strerror}')


def _without_guard(reason: str) -> str:
    return f'{reason}; if the launcher is killed, its processes go on'
