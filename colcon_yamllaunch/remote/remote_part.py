# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The part of a launch that runs on one machine, as the launcher sees it.

It emits the events and output of the part in the launch here, for the screen,
logs and reports, and sends commands to the machine.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
import os
import signal
import termios
import time
from typing import Any

from colcon_yamllaunch.common.codec import CodecError, from_json
from colcon_yamllaunch.common.errors import RefusedError
from colcon_yamllaunch.common.printable import printable
from colcon_yamllaunch.common.table import decimal_size
from colcon_yamllaunch.control.command_codec import request_of, response_of
from colcon_yamllaunch.deployment.deployment import Machine
from colcon_yamllaunch.engine import commands, events
from colcon_yamllaunch.engine.engine import Engine
from colcon_yamllaunch.engine.event_codec import EventError, EventReader
from colcon_yamllaunch.engine.events import LinkState
from colcon_yamllaunch.engine.loop import do_nothing, TimerHandle
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.engine.process_stop import timeouts_of, UNATTRIBUTED
from colcon_yamllaunch.engine.state import ProcessState
from colcon_yamllaunch.plan.plan import (
    changed_entries,
    Component,
    Entry,
    Member,
    Plan,
    Process,
    Timer,
)
from colcon_yamllaunch.plan.plan_json import plan_to_json
from colcon_yamllaunch.remote import part_protocol
from colcon_yamllaunch.remote.machine_link import MachineLink

#: Seconds after which an event or output is late and gets the time at which it
#: happened.
LATE = 1.0
#: Seconds that a machine gets to end its part, besides the time-outs of its
#: processes.
END_TIMEOUT = 15.0
#: How many requests to a machine may wait for their answers.
MAXIMUM_REQUESTS = 1000


class RemotePart:
    """
    The part of the launch that runs on one machine.

    :param plan: The plan of the part, with the paths of this computer
    :param localised: Returns a plan with the paths of that machine
    """

    def __init__(
        self,
        link: MachineLink,
        plan: Plan,
        localised: Callable[[Plan], Plan] = lambda plan: plan,
    ) -> None:
        #: The connection to the machine.
        self.link = link
        self._localised = localised
        self._reader = EventReader(self._member_of_event)
        self._members: dict[str, Member] = {}
        self._successors: dict[str, Member] = {}
        self._by_name: dict[str, str] = {}
        # whether its end may wait for timers
        self._has_timers = False
        # all entries as first planned
        self._entries: list[Entry] = []
        self._add(plan)
        # of a machine that is gone: whether its part is being started again,
        # whole or only what was asked for, who waits for that, and what the
        # new part does not have
        self._is_restarting = self._restarts_all = False
        self._to_restart: set[str] = set()
        self._waiting_replies: list[Callable[[Any], object]] = []
        self._missing: set[str] = set()
        # why its part stops by itself though the launch goes on
        self._stopped_for = ''
        self._size = os.terminal_size((80, 24))
        # the callbacks of unanswered requests, by number
        self._replies: dict[int, Callable[[Mapping[str, Any]], None]] = {}
        #: The state of the connection to the machine.
        self.link_state: LinkState = 'up'
        #: Why it is lost or gone, for the user; or empty.
        self.reason = ''
        self._is_idle = False
        self._is_finishing = False
        # when it must have ended, as the launch does
        self._deadline: TimerHandle | None = None
        # whether the user knows that a stop waits for the link
        self._is_waited_for = False
        # processes that are suspended because the launch is
        self._suspended: set[str] = set()
        # streams whose output the screen does not accept now
        self._full_streams: set[tuple[str, events.Stream]] = set()
        # the local modes of terminals, by label
        self._modes: dict[str, int] = {}
        # the processes of the link that the guard knows
        self._guarded: frozenset[int] = frozenset()
        # what the part knows of others, and since which version of the state
        self._noted = part_protocol.NoteElsewhere()
        self._noted_version = -1

    @property
    def machine(self) -> Machine:
        """The machine."""
        return self.link.machine

    @property
    def is_over(self) -> bool:
        """Whether the part has ended or is given up."""
        return self.link_state in ('gone', 'done')

    @property
    def is_busy(self) -> bool:
        """Whether something runs there, starts, or is not answered yet."""
        return not self.is_over and bool(self._replies or not self._is_idle)

    def join(self, launch: Engine) -> None:
        """Connect the part with the launch."""
        self._launch = launch
        self._guard_link()

    def begin(self, size: os.terminal_size) -> None:
        """Start the part, with terminals of `size`."""
        self.link.begin(self._launch.loop, self)
        self.resize(size)

    def resize(self, size: os.terminal_size) -> None:
        """Resize all terminals."""
        self._size = size
        self.send(commands.Resize(size.columns, size.lines))

    def end_turn(self) -> None:
        """Resume the link once the screen accepts output again."""
        if self._full_streams:
            # while all is stopped, there is not much that may still come
            is_stopping = self._launch.is_stopping
            accepts = self._launch.accepts
            self._full_streams = {
                key
                for key in self._full_streams
                if not (is_stopping or accepts(key))
            }
            if not self._full_streams:
                self.link.pause(False)
        self._guard_link()

    def note_elsewhere(self) -> None:
        """Let the part know what others do that it has to do with."""
        state = self._launch.state
        if not state.has_readiness or self.link_state != 'up':
            # a part that is started again knows nothing
            self._noted = part_protocol.NoteElsewhere()
            return
        if self._noted_version == state.version:
            return
        self._noted_version = state.version
        here = self._members.keys()
        ready, running = [], []
        for label, others in state.after.items():
            if label in here:
                ready += [n for n in others if n not in here]
            elif not here.isdisjoint(others) and state.runs(label):
                running.append(label)
        missing = state.missing_of(ready)
        command = part_protocol.NoteElsewhere(
            tuple(sorted({*ready}.difference(missing))), tuple(running)
        )
        if command != self._noted:
            self._noted = command
            self.send(command)

    def send(self, command: commands.Command[Any]) -> None:
        """Send a command, and ignore the answer."""
        if not self.is_over:
            self.link.send(request_of(command))

    def ask(
        self,
        command: commands.Command[commands.Response],
        reply: Callable[
            [commands.Response | commands.Refused], object
        ] = do_nothing,
    ) -> None:
        """
        Send a command, and pass on the response.

        :raises RefusedError: when it cannot be sent now
        """
        if self.link_state != 'up':
            raise RefusedError(self._why_not())
        if len(self._replies) >= MAXIMUM_REQUESTS:
            raise RefusedError(f'{self.machine.name} does not answer')
        number = self.link.send(request_of(command))

        def answered(answer: Mapping[str, Any]) -> None:
            reply(self._response(command, answer))

        self._replies[number] = answered

    def stop(self, command: commands.Shutdown) -> None:
        """Begin to stop the whole part."""
        if self._is_restarting:
            self._give_up(self.reason)
        if self.link_state == 'lost' and not self._is_waited_for:
            self._is_waited_for = True
            until = (
                'its processes have stopped there by themselves; Ctrl-C again '
                'does not wait'
            )
            if self.machine.on_lost == 'keep':
                until = (
                    'it can be told to stop; Ctrl-C again leaves its '
                    'processes running there'
                )
            self._warn(f'the link is lost, so it is waited for until {until}')
        if command.drop_timers or not self._has_timers:
            self._limit_end()
        self.send(command)

    def escalate(self) -> None:
        """Send the next signal of the stop sequence at once."""
        if self.link_state == 'lost':
            # who asks twice does not wait until it is back
            what = 'its processes stop there by themselves'
            if self.machine.on_lost == 'keep':
                what = 'its processes run on there (on_lost: keep)'
            self._give_up(f'{self.reason}; {what}')
        if self._deadline is None:
            self._limit_end()
        self.send(commands.Escalate())

    def suspend(self, is_suspended: bool) -> None:
        """Suspend all processes, or resume them."""
        if is_suspended:
            # the machine reports it when the launch goes on
            self._suspended |= {state.label for state in self._running()}
        elif self._deadline is not None:
            self._limit_end()
        self.send(commands.Hold(is_suspended))

    def finish(self) -> None:
        """Tell the part to end, as the launch has ended."""
        if not self._is_finishing:
            self._is_finishing = True
            if self._deadline is None and not self._has_timers:
                self._limit_end()
            self.send(part_protocol.Finish())

    def close(self) -> None:
        """End the link."""
        self.link.close()
        self._guard_link()

    # lookups

    def label_of(self, name: str) -> str | None:
        """Return the label of a process or component by one of its names."""
        if name in self._members:
            return name
        if name in self._by_name:
            return self._by_name[name]
        for label, member in self._members.items():
            state = self._launch.state.by_label.get(label)
            if isinstance(member, Component) and state and state.node == name:
                return label
        return None

    def member(self, label: str) -> Member:
        """Return a process or component as it is planned now."""
        return self._successors.get(label) or self._members[label]

    def processes(self) -> Iterator[Process]:
        """Iterate over the processes as they are planned now."""
        for label in self._members:
            member = self.member(label)
            if isinstance(member, Process):
                yield member

    def components(self) -> Iterator[tuple[Component, Process | None]]:
        """Iterate over the components, with the process of the container."""
        containers = {
            p.node_name: p for p in self.processes() if p.is_container
        }
        for label in self._members:
            member = self.member(label)
            if isinstance(member, Component):
                yield member, containers.get(member.container)

    # keyboards

    def has_keyboard(self, label: str) -> bool:
        """Return whether keys can be typed at a process now."""
        if self.link_state != 'up' or label not in self._members:
            return False
        state = self._launch.state.process(label)
        return state is not None and state.terminal

    def input_modes(self, label: str) -> int | None:
        """Return the local modes of a terminal as it was sent last."""
        return self._modes.get(label) if self.has_keyboard(label) else None

    # changes of the plan

    def extend(self, plan: Plan) -> None:
        """
        Add entries to the part.

        :raises RefusedError: when a label is taken
        """
        self._add(plan)
        self._is_idle = False
        self.send(commands.Extend(self._localised(plan).entries))

    def revise(self, member: Member, *, at_once: bool) -> None:
        """Replace a process or component from its next start on."""
        if at_once:
            self._plan_member(member)
        else:
            self._successors[member.label] = member
        if member.label not in self._missing:
            (there,) = self._localised(Plan((member,))).entries
            assert isinstance(there, Member)
            self.send(commands.Revise(there, at_once))

    def restart(self, labels: Collection[str]) -> tuple[str, ...]:
        """Restart or reload members after a change; return their labels."""
        states = self._launch.state.by_label
        begun = tuple(
            label
            for label in self._members
            if label in labels
            and label in states
            and states[label].is_begun
            and not states[label].is_kept_stopped
        )
        if begun and self.link_state == 'up':
            self._send_missing(self._missing.intersection(begun))
            self.ask(commands.RestartChanged(begun), self._warn_refused)
            return begun
        return ()

    def drop(self, label: str) -> None:
        """Stop or unload a process or component, then remove it."""
        if label in self._missing:
            self._launch.emit(events.Dropped(self._members[label]))
            self._forget(label)
            return
        self.send(commands.Drop(label))

    def forget(self, plan: Plan) -> None:
        """Cancel entries that have not begun."""
        self._entries = [e for e in self._entries if e not in plan.entries]
        self.send(commands.Forget(self._localised(plan).entries))

    # commands

    def execute(
        self,
        command: commands.MemberCommand[Any],
        reply: Callable[[Any], object],
    ) -> None:
        """
        Execute a command about a process or component.

        :param command: Its `member` is a label
        :param reply: Takes the response
        :raises RefusedError: when it cannot be sent now
        """
        label = command.member
        match command:
            case commands.Type():
                self.send(command)
                reply(commands.DONE)
                return
            case commands.Describe() | commands.ChangeState():
                self.ask(command, reply)
                return
        if self._launch.is_stopping:
            raise RefusedError('the whole launch is being stopped')
        is_restart = isinstance(command, commands.Restart)
        if is_restart and (self.link_state == 'gone' or self._is_restarting):
            if not self.link.can_start_again:
                raise RefusedError(self._why_not())
            self._to_restart.add(label)
            self._waiting_replies.append(reply)
            self._start_again(at_once=True)
            return
        if label in self._missing and self.link_state == 'up':
            if not is_restart:
                raise RefusedError(f'{label} does not run')
            self._send_missing({label})
            reply(commands.DONE)
            return
        self.ask(command, reply)

    def _response(
        self, command: commands.Command[Any], answer: Mapping[str, Any]
    ) -> Any:
        """Return the response to `command` that `answer` contains."""
        if not answer.get('ok'):
            return commands.Refused(printable(str(answer.get('error'))))
        if isinstance(command, part_protocol.Measure):
            try:
                return from_json(
                    part_protocol.MeasuredUsage, {'usage': answer.get('usage')}
                )
            except CodecError as error:
                return commands.Refused(str(error))
        if not isinstance(command, commands.Describe):
            return response_of(command, answer)
        # few ask for that
        from colcon_yamllaunch.engine.description import received_description

        described = answer.get('description')
        if not isinstance(described, Mapping):
            return commands.Refused(
                f'{self.machine.name} does not describe it'
            )
        member = self.member(command.member)
        log = self._launch.state.log_files.get(member.label)
        description = received_description(
            member, described, self._launch.blocks, str(log) if log else None
        )
        return commands.Described(description)

    def measure(self, done: Callable[[], None]) -> None:
        """
        Find out what its processes use.

        :param done: Is called when that is known
        :raises RefusedError: when it cannot be asked for now
        """

        def measured(response: object) -> None:
            usage = getattr(response, 'usage', {})
            self._launch.emit(events.UsageMeasured(self.machine.name, usage))
            done()

        self.ask(part_protocol.Measure(), measured)

    # called by the link

    def message(self, message: Mapping[str, Any]) -> None:
        """Handle a message of the control protocol; `time` is by our clock."""
        if self.is_over:
            return
        try:
            with self._at(message.get('time')):
                self._handle_message(message)
        except EventError as error:
            self._give_up(f'what comes from it makes no sense: {error}')

    def output(
        self, label: str, stream: events.Stream, data: bytes, seconds: float
    ) -> None:
        """
        Handle what a process wrote.

        :param seconds: When, by the clock here (:func:`time.time`)
        """
        process = self._members.get(label)
        if self.is_over:
            return
        if not isinstance(process, Process):
            self._give_up('what comes from it makes no sense: whose output?')
            return
        key = (label, stream)
        with self._at(seconds):
            self._launch.feed_output(process, stream, data)
        if not (self._launch.accepts(key) or self._launch.is_stopping):
            if not self._full_streams:
                self.link.pause(True)
            self._full_streams.add(key)

    @contextmanager
    def _at(self, seconds: object) -> Iterator[None]:
        """Set the time of events that are emitted meanwhile."""
        event_time = self._launch.event_time
        # what comes as fast as it can has the time of here, so that times grow
        if isinstance(seconds, int | float):
            is_late = 0 < seconds < time.time() - LATE
            event_time.past = float(seconds) if is_late else None
        try:
            yield
        finally:
            event_time.past = None

    def lost(self, reason: str) -> None:
        """Handle a lost connection; the link tries to connect again."""
        if self.link_state == 'up':
            self.link_state = 'lost'
            self.reason = printable(reason)
            is_kept = self.machine.on_lost == 'keep'
            name = self.machine.name
            self._launch.emit(events.LinkLost(name, self.reason, is_kept))
            self._refuse_all()

    def back(self, seconds: float) -> None:
        """Handle a new connection after `seconds` without one."""
        if self.link_state == 'lost':
            self.link_state = 'up'
            self.reason = ''
            if self._deadline is not None:
                self._limit_end()
            self._launch.emit(events.LinkBack(self.machine.name, seconds))
            if self._is_restarting:
                self._is_restarting = False
                self.resize(self._size)
                self._send_missing(self._missing & self._to_restart)
                self._answer_waiting(commands.DONE)

    def gone(self, reason: str) -> None:
        """Handle the end of the link: the part has ended, or is given up."""
        if self.is_over:
            return
        self._end(self._stopped_for or reason)
        if self._restarts:
            self._restarts_all = True
            self._start_again(at_once=False)

    @property
    def _restarts(self) -> bool:
        """Whether a part that is gone is started again by itself."""
        return (
            self.machine.on_lost == 'restart'
            and self.link.can_start_again
            and not self._launch.is_stopping
        )

    def _start_again(self, *, at_once: bool) -> None:
        self._enter('lost')
        self._is_restarting = True
        self._is_idle = False
        self.link.start_again(self._plan_again, at_once=at_once)

    def _plan_again(self) -> str:
        """Return the plan of the new part, in JSON."""
        if self._restarts_all:
            plan = Plan(self._not_stopped())
        else:
            plan = self._plan_of(self._to_restart)
        self._missing = {*self._members} - self._expect(plan)
        self._stopped_for = ''
        self._modes.clear()
        self._suspended.clear()
        self._full_streams.clear()
        return plan_to_json(self._localised(plan))

    def _send_missing(self, labels: Collection[str]) -> None:
        """Send entries that the new part does not have yet."""
        if not labels:
            return
        plan = self._plan_of(labels)
        self._missing -= self._expect(plan)
        self._is_idle = False
        self.send(commands.Extend(self._localised(plan).entries))

    def _plan_of(self, labels: Collection[str]) -> Plan:
        """Return a plan of members, with the components of containers."""
        inside = {
            component.label
            for component, process in self.components()
            if process is not None and process.label in labels
        }
        wanted = inside.union(labels)
        return Plan(
            tuple(self.member(p) for p in self._members if p in wanted)
        )

    def _not_stopped(self) -> tuple[Entry, ...]:
        """Return all entries as planned now, but for what was stopped."""
        states = self._launch.state.by_label.values()
        stopped = {state.label for state in states if state.is_kept_stopped}
        labels = self._to_restart.union(self._members.keys() - stopped)

        def planned_now(entry: Entry) -> Entry | None:
            if not isinstance(entry, Member):
                return entry
            return self.member(entry.label) if entry.label in labels else None

        return changed_entries(self._entries, planned_now)

    def _expect(self, plan: Plan) -> set[str]:
        """Mark all of a plan as waiting for a start; return its labels."""
        members = tuple(plan.members())
        for member in members:
            self._plan_member(member)
            self._successors.pop(member.label, None)
            self._launch.emit(events.MemberChanged(member, 'waiting'))
        return {member.label for member in members}

    def _answer_waiting(self, response: object) -> None:
        waiting, self._waiting_replies = self._waiting_replies, []
        self._to_restart.clear()
        self._restarts_all = False
        for reply in waiting:
            reply(response)

    def _end(self, reason: str) -> None:
        was_gone, self._is_restarting = self._is_restarting, False
        self.reason = printable(reason)
        self._enter('gone')
        if was_gone:
            self._answer_waiting(commands.Refused(self._why_not()))
            return
        running = self._running()
        labels = tuple(state.label for state in running)
        name, launch = self.machine.name, self._launch
        launch.emit(events.MachineGone(name, self.reason, labels))
        self._refuse_all()
        is_needed = False
        for state in running:
            launch.end_lines(state.label)
            process = self.member(state.label)
            assert isinstance(process, Process)
            is_needed |= process.on_exit_shutdown
            launch.emit(
                events.Exited(
                    process,
                    state.pid or 0,
                    Outcome(lost=name),
                    launch.state.seconds_of(state),
                    launch.is_stopping,
                    True,
                    0.0 if self._restarts else None,
                )
            )
        if is_needed and not self._restarts:
            launch.shut_down(f'{name} is gone')

    def _handle_message(self, message: Mapping[str, Any]) -> None:
        """
        Handle a message.

        :raises EventError: when it makes no sense
        """
        match message:
            case {'event': event}:
                self._handle_event(self._reader.read(event))
            case {'ok': _, 'id': number}:
                done = self._replies.pop(number, None)
                if done is not None:
                    done(message)
            case {
                'shown': {
                    'process': str(label),
                    'stream': 'stdout' | 'stderr' as stream,
                    'data': bytes(data),
                }
            } if label in self._members:
                self._launch.show(label, stream, data)
            case {
                'modes': {
                    'process': str(label),
                    'lines': bool(lines),
                    'echo': bool(echo),
                }
            } if label in self._members:
                flags = termios.ICANON if lines else 0
                self._modes[label] = flags | (termios.ECHO if echo else 0)
            case {'missed': {'bytes': int(size)}} if size >= 0:
                self._warn(
                    f'{decimal_size(size)} of output are missing: they came '
                    'while the link was lost, and did not fit within the '
                    'limit of the logs (--log-limit)'
                )
            case _:
                raise EventError('a message is of no known kind')

    def _handle_event(self, event: events.Event) -> None:
        match event:
            case events.IdleChanged(is_idle=is_idle):
                self._is_idle = is_idle
                return
            case events.CannotRun(reason=reason):
                self._give_up(reason)
                return
            case events.Ended():
                if not self._stopped_for or self._launch.is_stopping:
                    # else the end of the link follows, and is a loss
                    self._enter('done')
                    self._refuse_all()
                return
            case events.ShuttingDown(reason=reason) if reason.startswith(
                part_protocol.LINK_LOST
            ):
                # the rest of the launch goes on
                self._stopped_for = 'it stopped its part as the link was lost'
                return
            case events.ShuttingDown():
                # a shutdown of ours stops what runs there first; else
                # something that ended there is to end everything
                if not self._launch.is_stopping:
                    self._launch.shut_down(event.reason)
                return
            case events.Planned():
                labels = [member.label for member in event.members]
                for label in labels:
                    self._plan_member(self.member(label))
                    self._successors.pop(label, None)
                members = tuple(self._members[label] for label in labels)
                event = events.Planned(members)
            case events.Warned():
                self._warn(event.text)
                return
            case events.RosLost():
                name = self.machine.name
                event = events.RosLost(f'{name}: {event.reason}')
            case events.Suspended(process=process):
                # it is held, or goes on, with the launch
                is_ours = process.label in self._suspended
                if event.signal != signal.SIGSTOP:
                    self._suspended.discard(process.label)
                if is_ours:
                    return
            case events.Started():
                self._modes.pop(event.process.label, None)
            case events.Exited():
                # the last line of a process counts before its exit code
                self._launch.end_lines(event.process.label)
            case _:
                pass
        self._launch.emit(event)
        # a failure ends the launch before the next event undoes it
        self._launch.check_conditions()
        if isinstance(event, events.Dropped):
            self._forget(event.member.label)

    def _member_of_event(self, label: str) -> Member | None:
        """Return the process or component that a label in an event names."""
        member = self._members.get(label)
        if member is None and label == UNATTRIBUTED:
            # what belongs to no process for sure
            name = f'{label} of {self.machine.name}'
            for process in self.processes():
                return replace(process, label=name)
        return member

    def _add(self, plan: Plan) -> None:
        """
        Add the entries of a plan.

        :raises RefusedError: when a label is taken
        """
        more = tuple(plan.members())
        for member in more:
            if member.label in self._members:
                raise RefusedError(
                    f'there is a process {member.label} already'
                )
        for member in more:
            self._plan_member(member)
        self._has_timers |= any(
            isinstance(entry, Timer) and not entry.cancel_on_shutdown
            for entry in plan.walk()
        )
        self._entries += plan.entries

    def _plan_member(self, member: Member) -> None:
        before = self._members.get(member.label)
        if before is not None:
            self._by_name.pop(before.ros_name, None)
        self._members[member.label] = member
        self._by_name[member.ros_name] = member.label

    def _forget(self, label: str) -> None:
        member = self._members.pop(label, None)
        if member is not None:
            self._by_name.pop(member.ros_name, None)
        self._successors.pop(label, None)
        self._missing.discard(label)

    def _running(self) -> list[ProcessState]:
        """Return the processes that run, according to the last events."""
        states = map(self._launch.state.process, self._members)
        return [state for state in states if state and state.pid is not None]

    def _enter(self, state: LinkState) -> None:
        self.link_state = state
        name = self.machine.name
        self._launch.emit(events.LinkChanged(name, state, self.reason))

    def _warn_refused(self, response: object) -> None:
        if isinstance(response, commands.Refused):
            self._warn(response.error)

    def _warn(self, text: str) -> None:
        self._launch.emit(events.Warned(f'{self.machine.name}: {text}'))

    def _why_not(self) -> str:
        name = self.machine.name
        if self.link_state == 'done':
            return f'nothing runs on {name} any more'
        if self.link_state == 'gone':
            return f'{name} is gone: {self.reason}'
        return f'the link to {name} is lost: {self.reason}'

    def _limit_end(self) -> None:
        """Limit the time until its end by the timeouts of its processes."""
        timeouts = map(timeouts_of, self.processes())
        longest = max((t.sigterm + t.sigkill for t in timeouts), default=0.0)
        if self._deadline is not None:
            self._deadline.cancel()

        def end_late() -> None:
            if self.link_state == 'up':
                self._give_up('it does not end, though it was told to')

        self._deadline = self._launch.loop.call_later(
            longest + END_TIMEOUT, end_late
        )

    def _refuse_all(self) -> None:
        """Refuse all requests that are not answered."""
        waiting, self._replies = self._replies, {}
        for done in waiting.values():
            done({'error': self._why_not()})

    def _give_up(self, reason: str) -> None:
        if not self.is_over:
            self._end(reason)
        self.link.close()

    def _guard_link(self) -> None:
        """Register the processes of the link with the guard."""
        pids = self.link.pids
        if pids == self._guarded:
            return
        for pid in self._guarded - pids:
            self._launch.remove_helper(pid)
        for pid in pids - self._guarded:
            self._launch.add_helper(pid, partial(self._reaped, pid))
        self._guarded = pids

    def _reaped(self, pid: int, status: int) -> None:
        self.link.ended(pid, Outcome.from_status(status))
        self._guard_link()
