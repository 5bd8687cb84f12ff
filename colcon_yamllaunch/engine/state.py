# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The state of a launch: what its processes, components and machines do.

Each event of the launch changes it, through :meth:`LaunchState.apply`, and
nothing else does, except while the launch is set up. Every view of a launch
reads it: the status block, the full screen, `--status`, the exit code and the
JUnit report. The control protocol sends its JSON form, from which a client
makes the same state.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
import os
from pathlib import Path
import time
from typing import Any, Literal

from colcon_yamllaunch.common.frozen import dataclass, mutable
from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.events import LinkState, Phase
from colcon_yamllaunch.engine.outcome import (
    ending_of,
    Outcome,
    signal_name,
    STOP_SIGNALS,
)
from colcon_yamllaunch.plan.plan import (
    AfterReady,
    Component,
    Entry,
    Member,
    Process,
    Timer,
)

#: What views show of a process or component: `waiting` for a timer,
#: `starting` (also while it is loaded, configured or activated, and until its
#: readiness conditions hold), `running`,
#: `stopping`, `held` by a signal such as SIGSTOP, waiting for its `respawn`,
#: `ended` by itself, `stopped` on request, or `failed`.
MemberCondition = Literal[
    'waiting',
    'starting',
    'running',
    'stopping',
    'held',
    'respawn',
    'ended',
    'stopped',
    'failed',
]
#: The state of a lifecycle node that is not known (lifecycle_msgs/State).
UNKNOWN = 'unknown'
#: States in which lifecycle nodes are between two others (likewise).
BETWEEN_STATES = ('configuring', 'activating')

# the phases that a lost connection does not make doubtful
_CERTAIN = ('waiting', 'ended', 'unloaded', 'failed')

Failure = (
    events.Exited
    | events.StartFailed
    | events.LoadFailed
    | events.TransitionFailed
)


class StateError(Exception):
    """Data is no state of a launch; the text says why."""


@dataclass(frozen=True, slots=True)
class About:
    """
    What a launch is called.

    :param title: What was launched, as the user called it
    :param package: The package that was named, if one was
    :param file: The path of the launch file
    :param folder: The folder where it was launched
    """

    title: str
    package: str | None
    file: str
    folder: str


@mutable
class CommonState:
    """
    What the states of a process and of a component have in common.

    :param label: Its name in output and logs
    :param phase: See :data:`.events.Phase`
    :param seconds: For how long a process has been running or ended, or has
      waited for others, or a component has been in its phase, when this was
      read; see `LaunchState.seconds_of`
    :param ending: How a process ended, or why a component could not be
      loaded, as a part of a sentence; empty while it runs
    :param node: The full name of its ROS node as far as it is known
    :param package: The package that the program or plugin belongs to, if any
    :param log: The path of the log with all of its output, if it has one; of
      a component, that of its container
    :param lifecycle: The state of its lifecycle node, such as `active`;
      `unknown` until that is known, None if it is no lifecycle node
    :param machine: The name of the machine that it runs on, None for this one
    :param condition: See :data:`MemberCondition`
    :param failure: How it failed last, in short; empty if it has not since
      somebody started it
    :param restarts: How often it has been started, or loaded, again
    :param run_seconds: For how long it ran before, or was loaded, in all
    :param turn: The version of the launch state in which its condition
      changed last; 0 while it has only started
    :param version: The version of the launch state in which it changed last
    :param is_kept_stopped: Whether it was stopped on request
    :param is_ready: Whether it is ready, if the launch knows that
    :param waits_for: The labels of what must be ready before it starts; empty
      once it may start
    :param unmet: The readiness conditions that do not hold yet while it runs,
      each as a part of a sentence

    The other ones are for :meth:`LaunchState.apply` only.
    """

    label: str
    phase: Phase = 'waiting'
    seconds: float = 0.0
    ending: str = ''
    node: str | None = None
    package: str | None = None
    log: str | None = None
    lifecycle: str | None = None
    machine: str | None = None
    condition: MemberCondition = 'starting'
    failure: str = ''
    restarts: int = 0
    run_seconds: float = 0.0
    turn: int = 0
    version: int = 0
    is_kept_stopped: bool = False
    is_ready: bool = False
    waits_for: tuple[str, ...] = ()
    unmet: tuple[str, ...] = ()
    # when its phase began, by the clock of the state
    since: float = 0.0
    # whether its turn comes without a timer
    is_due: bool = True
    # whether it was started or loaded before
    is_begun: bool = False
    # whether those that wait for it start although it is not ready
    is_given_up: bool = False
    # whether it ended as a failure, or on request
    has_failed: bool = False
    was_asked: bool = False
    is_held: bool = False
    # whether a signal ends it that was not sent on request
    is_signalled: bool = False


@mutable
class ProcessState(CommonState):
    """
    A process of a launch.

    :param pid: Its process id, which is that of its group, while it runs
    :param executable: The name of its program
    :param terminal: Whether keys can be typed at it now
    :param name: What ROS 2 calls it, its program and number, as
      `talker.py-2`; None where that is not known
    :param cpu: The share of one processor that it takes on its machine, 1.0
      for all of it; None where that is not known, and on this machine
    :param memory: Its memory there in bytes, likewise
    :param container: The full name of the node, if it is a container
    """

    pid: int | None = None
    executable: str = ''
    terminal: bool = False
    name: str | None = None
    cpu: float | None = None
    memory: int | None = None
    container: str | None = None
    # whether it is started under a debugger next
    is_debugged: bool = False

    @property
    def local_pid(self) -> int | None:
        """Its process id, if it runs on this machine."""
        return self.pid if self.machine is None else None


@mutable
class ComponentState(CommonState):
    """
    A component of a launch.

    :param plugin: The class of its node
    :param container: The full name of the node of its container
    :param process: The label of the container, None where that is not one of
      the launch's processes
    """

    plugin: str = ''
    container: str = ''
    process: str | None = None


@dataclass(frozen=True, slots=True)
class MachineState:
    """
    A machine that a part of a launch runs on.

    :param link: `up`, `lost` while the connection to it is, `gone` when that
      is for good, `done` when its part has ended
    :param reason: Why it is lost or gone, as a part of a sentence; or empty
    """

    name: str
    link: str
    reason: str = ''


@dataclass(frozen=True, slots=True)
class StopProgress:
    """
    What stopping waits for.

    :param event: The latest event about it
    :param due: When the next signal is sent, by the clock of the state
    """

    event: events.StillRunning
    due: float


#: The state of a member of a launch; see `plan.Member`.
MemberState = ProcessState | ComponentState


@mutable
class LaunchState:
    """
    A launch.

    :param about: What it is called
    :param pid: The process id of the launcher
    :param started: When it began, by the clock
    :param clock: Returns seconds that never go back
    :param log_folder: The folder with its logs, if it writes any
    :param log_files: For each label the log with all output
    :param tty: Whether each process has a terminal
    :param machine_of: Returns the name of the machine on which a process or
      component runs, by its label; None for this one
    :param by_label: Its processes and components, in the order of the plan
    :param machines: The machines that parts of it run on, by name
    :param stop_reason: Why everything is being stopped; empty if it is not
    :param countdown: What stopping waits for
    :param watch: What came of the last change, if it goes on with its files
      (`--watch`); empty before the first one, None without `--watch`
    :param watch_failed: Whether that failed
    :param watch_paused: Whether changes are ignored for the time being
    :param change: The latest event about a change
    :param changed: When files were changed, by the clock, while something is
      still to be done about that; else None
    :param errors: What the last build or evaluation that failed has printed
    :param failures: What failed, by label, in order
    :param problems: What failed that is no process, component or node
    :param gone: By name, why machines are gone
    :param lost: The processes that were lost with them
    :param left_behind: Processes that cannot be ended
    :param has_readiness: Whether it is known which members are ready
    :param after: For each member the labels that it waits for, if so
    :param ready_elsewhere: The labels of members that are ready, of those
      that are not known here, as this is a part of a launch
    :param running_elsewhere: The labels of those that run, likewise
    :param readiness_version: Grows whenever a member becomes ready, or does
      not have to be any more
    :param verdicts: What came of its exit conditions; set by `Ended`
    :param exit_code: What the launcher exits with, None until it ends
    :param version: Grows whenever something that is shown changes
    :param order_version: The version in which the order of its processes and
      components, or what belongs to it, changed last
    """

    about: About
    pid: int = field(default_factory=os.getpid)
    started: float = 0.0
    clock: Callable[[], float] = time.monotonic
    log_folder: str | None = None
    log_files: Mapping[str, Path | str] = field(default_factory=dict)
    tty: bool = False
    machine_of: Callable[[str], str | None] = field(
        default_factory=lambda: lambda _label: None
    )
    by_label: dict[str, MemberState] = field(default_factory=dict)
    machines: dict[str, MachineState] = field(default_factory=dict)
    stop_reason: str = ''
    countdown: StopProgress | None = None
    watch: str | None = None
    watch_failed: bool = False
    watch_paused: bool = False
    change: events.ChangeReported | events.ChangeChecked | None = None
    changed: float | None = None
    errors: tuple[str, ...] = ()
    failures: dict[str, Failure] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    gone: dict[str, str] = field(default_factory=dict)
    lost: list[events.Exited] = field(default_factory=list)
    left_behind: dict[tuple[str, int], events.LeftBehind] = field(
        default_factory=dict
    )
    has_readiness: bool = False
    after: dict[str, tuple[str, ...]] = field(default_factory=dict)
    ready_elsewhere: frozenset[str] = frozenset()
    running_elsewhere: frozenset[str] = frozenset()
    readiness_version: int = 0
    verdicts: tuple[events.Verdict, ...] = ()
    exit_code: int | None = None
    version: int = 0
    order_version: int = 0

    # what it says

    @property
    def title(self) -> str:
        """What was launched, as the user called it."""
        return self.about.title

    @property
    def package(self) -> str | None:
        """The package that was named, if one was."""
        return self.about.package

    @property
    def file(self) -> str:
        """The path of the launch file."""
        return self.about.file

    @property
    def folder(self) -> str:
        """The folder where it was launched."""
        return self.about.folder

    @property
    def seconds(self) -> float:
        """For how long it has been running."""
        return self.clock() - self.started

    @property
    def stopping(self) -> bool:
        """Whether everything is being stopped."""
        return bool(self.stop_reason)

    @property
    def processes(self) -> list[ProcessState]:
        """Its processes, in the order of the plan."""
        members = self.by_label.values()
        return [p for p in members if isinstance(p, ProcessState)]

    @property
    def components(self) -> list[ComponentState]:
        """Its components, in the order of the plan."""
        members = self.by_label.values()
        return [p for p in members if isinstance(p, ComponentState)]

    def members(self) -> Iterator[MemberState]:
        """Iterate over all that has a label, components below containers."""
        for process in self.processes:
            yield process
            yield from self.components_of(process.label)
        yield from self.components_of(None)

    def components_of(self, process: str | None) -> Iterator[ComponentState]:
        """
        Iterate over the components of a container.

        :param process: Its label; None for containers of others
        """
        return (c for c in self.components if c.process == process)

    def process(self, label: str) -> ProcessState | None:
        """Return the process with a label, if there is one."""
        member = self.by_label.get(label)
        return member if isinstance(member, ProcessState) else None

    def missing_of(self, labels: Iterable[str]) -> tuple[str, ...]:
        """Return those of some labels that must still become ready."""
        return tuple(label for label in labels if not self._is_past(label))

    def _is_past(self, label: str) -> bool:
        """Return whether nothing has to wait for a label any more."""
        member = self.by_label.get(label)
        if member is None:
            return label in self.ready_elsewhere
        return member.is_ready or member.is_given_up

    def runs(self, label: str) -> bool:
        """Return whether a process runs, as far as that is known."""
        member = self.by_label.get(label)
        if member is None:
            return label in self.running_elsewhere
        machine = self.machines.get(member.machine or '')
        return (
            isinstance(member, ProcessState)
            and member.pid is not None
            and (machine is None or machine.link == 'up')
        )

    def seconds_of(self, member: MemberState) -> float:
        """Return for how long a process runs, waits or has ended."""
        is_process = isinstance(member, ProcessState)
        if member.phase == 'waiting' and is_process and not member.waits_for:
            return 0.0
        return max(0.0, self.clock() - member.since)

    def log_of(self, member: MemberState) -> str | None:
        """Return the path of a log that has all output of a member."""
        label = (
            member.label
            if isinstance(member, ProcessState)
            else member.process
        )
        log = self.log_files.get(label or '')
        return None if log is None else str(log)

    def groups(self) -> dict[str, int]:
        """Return the process groups that run on this machine, by label."""
        return {
            p.label: pid
            for p in self.processes
            if (pid := p.local_pid) is not None
        }

    @property
    def has_failed(self) -> bool:
        """Whether something failed, so that the exit code is 1."""
        return bool(
            self.failures or self.left_behind or self.problems or self.gone
        )

    # what changes it

    def expect(self, entries: Iterable[Entry], *, is_due: bool = True) -> None:
        """
        Add processes and components of a plan, or replace those it has.

        :param is_due: Whether their turn comes without a timer
        """
        for entry in entries:
            if isinstance(entry, Timer | AfterReady):
                self.expect(entry.entries, is_due=False)
            elif isinstance(entry, Member):
                self._expect_member(entry, is_due=is_due)
        self._find_containers()
        self._touch_all()
        self.version = self.order_version

    def note_elsewhere(
        self, ready: Iterable[str], running: Iterable[str]
    ) -> None:
        """Note which members that are not known here are ready, or run."""
        self.ready_elsewhere = frozenset(ready)
        self.running_elsewhere = frozenset(running)
        self.readiness_version += 1

    def add_machines(self, names: Iterable[str]) -> None:
        """Add machines that parts of the launch run on."""
        for name in names:
            self.machines.setdefault(name, MachineState(name, 'up'))

    def apply(self, event: events.Event) -> None:
        """Change the state as an event says."""
        if isinstance(event, events.Output):
            return
        planned = events.member_of(event)
        label = '' if planned is None else planned.label
        if not events.is_optional(event):
            self._note_failure(label, event)
        member = self.by_label.get(label)
        if member is not None and self._apply_to_member(member, event):
            self._show(member)
        elif member is not None or not self._apply_to_launch(event):
            return
        self.version += 1

    def _touch_all(self) -> None:
        """Note that the next version may have other members everywhere."""
        self.order_version = self.version + 1
        for member in self.by_label.values():
            member.version = self.order_version

    def _expect_member(self, entry: Member, *, is_due: bool) -> None:
        label = entry.label
        kind = ProcessState if isinstance(entry, Process) else ComponentState
        member = self.by_label.get(label)
        if not isinstance(member, kind):
            machine = self.machine_of(label)
            member = kind(label, is_due=is_due, machine=machine)
            member.condition = _condition_of(member)
            member.since = self.clock()
            self.by_label[label] = member
        member.package = entry.package
        if not entry.is_lifecycle:
            member.lifecycle = None
        elif member.lifecycle is None:
            member.lifecycle = UNKNOWN
        if isinstance(member, ProcessState) or member.phase != 'loaded':
            member.node = entry.node_name
        if isinstance(member, ProcessState) and isinstance(entry, Process):
            member.executable = os.path.basename(str(entry.argv[0]))
            member.name = entry.ros_name
            member.container = entry.node_name if entry.is_container else None
        elif isinstance(member, ComponentState) and isinstance(
            entry, Component
        ):
            member.plugin = entry.plugin
            member.container = entry.container

    def _find_containers(self) -> None:
        components = self.components
        if components:
            containers = {p.container: p.label for p in self.processes}
            for component in components:
                component.process = containers.get(component.container)

    def _show(self, member: MemberState) -> None:
        """Find out the condition of a member that changed."""
        member.version = self.version + 1
        before, member.condition = member.condition, _condition_of(member)
        is_first_start = (
            not member.turn
            and not member.restarts
            and member.condition in ('starting', 'running')
        )
        if member.condition != before and not is_first_start:
            member.turn = self.version + 1

    def _apply_to_launch(self, event: events.Event) -> bool:
        """Apply an event about the launch; return whether it changed."""
        match event:
            case events.Planned():
                self.expect(event.members)
                if self.has_readiness:
                    # few launches have an order
                    from colcon_yamllaunch.plan.start_order import (
                        dependencies_of,
                    )

                    self.after |= dependencies_of(event.members)
            case events.ShuttingDown():
                self._shut_down(event.reason)
            case events.StillRunning():
                due = self.clock() + event.seconds
                self.countdown = StopProgress(event, due)
            case events.FilesChanged():
                self.changed = self.clock()
            case events.ChangeReported() | events.ChangeChecked():
                self._note_change(event)
            case events.LinkLost():
                self._link(event.machine, 'lost', event.reason)
            case events.LinkBack():
                self._link(event.machine, 'up')
            case events.MachineGone():
                self._link(event.machine, 'gone', event.reason)
            case events.LinkChanged():
                self._link(event.machine, event.link, event.reason)
            case events.UsageMeasured():
                self._measure(event)
            case events.StateReceived():
                self._receive(event.data)
            case events.Ended():
                self.exit_code = event.exit_code
                self.verdicts = event.verdicts
            case _:
                return False
        return True

    def _shut_down(self, reason: str) -> None:
        self.stop_reason = reason
        for member in self.by_label.values():
            member.is_due = False
            if isinstance(member, ComponentState):
                member.is_signalled = member.phase == 'loaded'
            elif member.pid is not None:
                member.phase = 'stopping'
            elif member.phase in ('respawn', 'stopping'):
                member.phase = 'ended'
            self._show(member)

    def _note_change(
        self, event: events.ChangeReported | events.ChangeChecked
    ) -> None:
        if isinstance(event, events.ChangeReported):
            self.watch, self.watch_failed = event.text, event.failed
            self.errors = event.errors or self.errors
            if event.is_paused is not None:
                # what came of the last change is still that
                self.watch_paused = event.is_paused
                return
        self.change = event
        if event.is_final:
            self.changed = None

    def _link(self, name: str, link: LinkState, reason: str = '') -> None:
        self.machines[name] = MachineState(name, link, reason)
        for member in self.by_label.values():
            if member.machine == name:
                member.version = self.version + 1

    def _receive(self, data: object) -> None:
        """
        Apply what another process sent of its state; see `to_json`.

        :raises StateError: when something is missing
        """
        now = self.clock()
        try:
            self.about = About(**_known(data, _ABOUT, ()))
            launch = _known(data, _LAUNCH, _LATER_OF_LAUNCH)
            for name, value in launch.items():
                setattr(self, name, value)
            assert isinstance(data, Mapping)
            self.started = now - data['seconds']
            self.stop_reason = 'requested' if data['stopping'] else ''
            members = [
                _member_from_json(ProcessState, p) for p in data['processes']
            ]
            members += (
                _member_from_json(ComponentState, row)
                for row in data.get('components', ())
            )
            machines = [
                MachineState(**_known(row, ('name', 'link'), ('reason',)))
                for row in data.get('machines', ())
            ]
        except (AttributeError, KeyError, TypeError) as error:
            raise StateError('the launch is not described in full') from error
        logs = dict(self.log_files)
        for member in members:
            member.since = now - member.seconds
            member.version = self.version + 1
            self.by_label[member.label] = member
            if member.log is not None and isinstance(member, ProcessState):
                logs[member.label] = member.log
        self.log_files = logs
        self.machines = {machine.name: machine for machine in machines}
        labels = data.get('labels')
        if labels is not None:
            found = {label: self.by_label.get(label) for label in labels}
            self.by_label = {n: p for n, p in found.items() if p is not None}
            self._touch_all()

    def _measure(self, event: events.UsageMeasured) -> None:
        for process in self.processes:
            if process.machine == event.machine:
                usage = event.usage.get(process.label, (None, None))
                process.cpu, process.memory = usage
                process.version = self.version + 1

    def _note_failure(self, label: str, event: events.Event) -> None:
        match event:
            case (
                events.Started()
                | events.Loaded()
                | events.Dropped()
                | events.StateChanged(state='active')
            ):
                # a machine may start a process again until it is stopped, too
                if not self.stopping:
                    self.failures.pop(label, None)
            case events.Exited(outcome=outcome) if outcome.lost:
                # that the machine is gone is a failure already
                if not event.asked:
                    self.lost.append(event)
            case (
                events.Exited(failed=True)
                | events.StartFailed()
                | events.LoadFailed()
            ):
                self.failures[label] = event
            case events.TransitionFailed():
                # that its process failed says more
                self.failures.setdefault(label, event)
            case events.LeftBehind():
                self.left_behind[label, event.pid] = event
            case events.RosLost():
                self.problems.append(event.reason)
            case events.NotReady(action='fail'):
                self.problems.append(f'{label}: {event.text}')
            case events.RestartLimit(beyond='fail'):
                # one that ended well failed to stay
                self.problems.append(event.lines()[0])
            case events.NotStarted():
                self.problems.append(event.text)
            case events.WorkerLost():
                self.problems.append(event.text)
            case events.PlanFailed():
                self.problems.append(event.problems[0])
            case events.MachineGone():
                self.gone[event.machine] = event.text
            case events.LinkBack(machine=name) if not self.stopping:
                self.gone.pop(name, None)
                self.lost = [e for e in self.lost if e.outcome.lost != name]
            case _:
                return

    def _apply_to_member(
        self, member: MemberState, event: events.Event
    ) -> bool:
        """Apply an event about a member; return whether that changed."""
        match event:
            case events.Dropped():
                del self.by_label[member.label]
                self._find_containers()
                self._touch_all()
            case events.Requested():
                self._request(member, event.action)
            case events.StateChanged():
                member.lifecycle = event.state
                member.node = member.node or event.node
            case events.TransitionFailed():
                member.failure = event.transition
            case events.MemberChanged():
                self._change_member(member, event)
            case events.Waiting():
                if member.phase == 'waiting' and not member.waits_for:
                    member.since = self.clock()
                member.waits_for = event.labels
            case events.Ready():
                member.is_ready, member.is_given_up = True, False
                member.unmet = ()
                self.readiness_version += 1
            case events.NotReady():
                if event.action == 'start':
                    member.is_given_up = True
                    self.readiness_version += 1
            case _ if isinstance(member, ComponentState):
                return self._apply_to_component(member, event)
            case _:
                return self._apply_to_process(member, event)
        return True

    def _apply_to_process(
        self, process: ProcessState, event: events.Event
    ) -> bool:
        match event:
            case events.Started():
                self._begin(process)
                process.pid = event.pid
                process.terminal = (
                    self.tty
                    or event.process.emulate_tty
                    or process.is_debugged
                )
                process.is_debugged = False
                phase: Phase = 'stopping' if self.stopping else 'running'
                self._enter(process, phase)
            case events.StartFailed():
                self._begin(process)
                process.failure = 'cannot start'
                process.ending = f'could not be started: {event.reason}'
                process.has_failed = True
                again = event.respawn_delay is not None
                self._enter(process, 'respawn' if again else 'ended')
            case events.Exited():
                self._exit(process, event)
            case events.Signalled():
                if process.phase != 'running':
                    return False
                process.is_signalled |= event.signal in STOP_SIGNALS
            case events.Suspended():
                process.is_held = event.signal is not None
            case _:
                return False
        return True

    def _begin(self, member: MemberState) -> None:
        """Apply the start of a process, or the loading of a component."""
        member.restarts += member.is_begun
        member.waits_for = ()
        member.is_ready = member.is_given_up = False
        member.is_begun = True
        member.ending = ''
        member.has_failed = member.was_asked = member.is_kept_stopped = False
        self._reset(member)

    def _reset(self, member: MemberState) -> None:
        """Forget what holds only while a member runs as it did before."""
        member.is_held = member.is_signalled = False
        member.unmet = ()
        if member.lifecycle is not None:
            member.lifecycle = UNKNOWN
        if isinstance(member, ProcessState):
            member.pid = member.cpu = member.memory = None
            member.terminal = False

    def _enter(self, member: MemberState, phase: Phase) -> None:
        member.phase = phase
        member.since = self.clock()

    def _exit(self, process: ProcessState, event: events.Exited) -> None:
        process.run_seconds += event.seconds
        process.has_failed = event.failed
        # one that has done its work stays ready
        process.is_ready &= event.outcome.code == 0
        process.was_asked = event.asked or process.is_signalled
        if event.failed:
            process.failure = _in_short(event.outcome)
        process.ending = (
            'stopped'
            if event.asked and not event.failed
            else ending_of(event.outcome, event.asked)
        )
        self._reset(process)
        # what a process that is stopped has started may still run
        is_stopping = (
            process.phase == 'stopping'
            and not self.stopping
            and not event.outcome.lost
        )
        if event.respawn_delay is not None:
            self._enter(process, 'respawn')
        else:
            self._enter(process, 'stopping' if is_stopping else 'ended')

    def _request(self, member: MemberState, action: events.Action) -> None:
        ends = action in ('stop', 'kill')
        # a failure stays one though what failed is stopped
        is_past = ends and member.condition == 'failed'
        if isinstance(member, ComponentState):
            member.failure = ''
            member.was_asked = ends
        else:
            if not is_past:
                member.failure = ''
                member.has_failed = False
            member.was_asked |= member.phase == 'respawn'
            member.is_debugged = action == 'debug'
            member.phase = 'stopping'
        if action != 'change':
            member.is_kept_stopped = ends

    def _change_member(
        self, member: MemberState, event: events.MemberChanged
    ) -> None:
        if event.lifecycle is not None:
            member.lifecycle = event.lifecycle
        if event.unmet is not None:
            member.unmet = event.unmet
        if event.phase is None:
            return
        if isinstance(member, ComponentState):
            member.ending = event.ending
            if event.phase != member.phase:
                member.since = self.clock()
        elif event.phase == 'waiting':
            # its machine is back, and starts it again
            member.is_kept_stopped = False
        elif event.ending:
            # no more is known
            self._reset(member)
            member.ending, member.was_asked = event.ending, True
        member.phase = event.phase

    def _apply_to_component(
        self, component: ComponentState, event: events.Event
    ) -> bool:
        match event:
            case events.Loaded():
                self._begin(component)
                component.failure = ''
                component.node = event.node
                component.run_seconds += event.seconds
                self._enter(component, 'loaded')
            case events.LoadFailed():
                component.failure = 'cannot load'
                component.ending = event.reason
                component.has_failed = True
                self._enter(component, 'waiting' if event.again else 'failed')
            case events.Unloaded():
                component.ending = ''
                component.is_ready = False
                component.was_asked = event.reason == events.REQUESTED
                self._reset(component)
                self._enter(component, 'unloaded')
            case _:
                return False
        return True


def _condition_of(member: MemberState) -> MemberCondition:
    """Return what views show of a process or component."""
    match member.phase:
        case 'waiting' if not member.is_due:
            return 'waiting'
        case 'waiting' if member.has_failed:
            return 'respawn'
        case 'running' | 'loaded':
            if member.is_signalled:
                return 'stopping'
            if member.is_held:
                return 'held'
            if member.lifecycle in BETWEEN_STATES or member.unmet:
                return 'starting'
            return 'running'
        case 'ended' if member.has_failed:
            return 'failed'
        case 'ended' | 'unloaded':
            return 'stopped' if member.was_asked else 'ended'
        case 'stopping' | 'unloading':
            return 'stopping'
        case 'respawn' | 'failed' as phase:
            return phase
        case _:
            return 'starting'


def _in_short(outcome: Outcome) -> str:
    if outcome.lost:
        return 'lost'
    if outcome.signal is not None:
        return signal_name(outcome.signal)
    return f'exit {outcome.code}'


# its JSON form

_ABOUT = ('title', 'package', 'file', 'folder')
_LAUNCH = ('pid', 'log_folder')
_LATER_OF_LAUNCH = (
    *('watch', 'watch_failed', 'watch_paused', 'exit_code'),
    *('has_readiness', 'after'),
)
# those of a process or component with several texts
_TEXTS = frozenset(('waits_for', 'unmet'))
# the fields that each version sends, and those of later versions
_FIELDS: Mapping[type, tuple[tuple[str, ...], tuple[str, ...]]] = {
    ProcessState: (
        (
            *('label', 'phase', 'pid', 'restarts', 'ending', 'executable'),
            *('node', 'package', 'terminal'),
        ),
        (
            *('name', 'lifecycle', 'machine', 'cpu', 'memory'),
            *('condition', 'failure', 'is_ready', 'waits_for', 'unmet'),
        ),
    ),
    ComponentState: (
        (
            *('label', 'phase', 'ending', 'plugin', 'node', 'package'),
            *('container', 'process', 'lifecycle'),
        ),
        ('machine', 'condition', 'failure', 'is_ready', 'waits_for', 'unmet'),
    ),
}


def to_json(state: LaunchState, since: int | None = None) -> dict[str, Any]:
    """
    Return a state as the control protocol sends it.

    :param since: The version that the client has: only the processes and
      components that changed after it are sent, with the order of all of
      them if that changed; None to send everything
    """

    def rows(members: Sequence[MemberState]) -> list[dict[str, Any]]:
        return [
            member_to_json(state, member)
            for member in members
            if since is None or member.version > since
        ]

    data = {
        **_values(state.about, _ABOUT),
        **_values(state, _LAUNCH),
        'seconds': round(state.seconds, 3),
        'stopping': state.stopping,
        'processes': rows(state.processes),
        'components': rows(state.components),
        **_values(state, _LATER_OF_LAUNCH),
        'machines': [
            _values(machine, ('name', 'link', 'reason'))
            for machine in state.machines.values()
        ],
    }
    if since is not None and state.order_version > since:
        data['labels'] = list(state.by_label)
    return data


def member_to_json(state: LaunchState, member: MemberState) -> dict[str, Any]:
    """Return a process or component as the control protocol sends it."""
    required, later = _FIELDS[type(member)]
    values = _values(member, (*required, *later))
    values['seconds'] = round(state.seconds_of(member), 3)
    values['log'] = state.log_of(member)
    machine = state.machines.get(member.machine or '')
    if machine is not None and machine.link != 'up':
        values['terminal'] = False
        if machine.link == 'lost' and member.phase not in _CERTAIN:
            values |= {'phase': 'unknown', 'ending': ''}
    return values


def from_json(
    data: object, clock: Callable[[], float] = time.monotonic
) -> LaunchState:
    """
    Return the state that an object of the control protocol has.

    What is not known here is left out. What came with a later version may be
    missing.

    :param clock: Returns seconds that never go back
    :raises StateError: when something is missing
    """
    state = LaunchState(About('', None, '', ''), clock=clock, log_files={})
    state.apply(events.StateReceived(data))
    return state


def _member_from_json(
    kind: type[ProcessState | ComponentState], row: Mapping[str, Any]
) -> MemberState:
    required, later = _FIELDS[kind]
    known = _known(row, (*required, 'seconds'), later)
    for name in _TEXTS & known.keys():
        # JSON has lists only
        known[name] = tuple(map(str, known[name]))
    member = kind(**known, is_due=False)
    member.log = row['log']
    if 'condition' not in row:
        member.condition = _condition_of(member)
    return member


def _values(of: object, names: Iterable[str]) -> dict[str, Any]:
    return {name: getattr(of, name) for name in names}


def _known(
    data: object, names: Iterable[str], later: Iterable[str]
) -> dict[str, Any]:
    """Return fields of an object; those that came later may be missing."""
    if not isinstance(data, Mapping):
        raise TypeError
    known = {name: data[name] for name in names}
    return known | {name: data[name] for name in later if name in data}
