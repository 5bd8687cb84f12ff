# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What happens in a launch.

Each event has the lines that the launcher prints about it, and its record in
`events.jsonl` and in the control protocol; docs/logs.md describes both for
users. Events have no time: observers receive them when they happen.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
import os
from pathlib import Path
from typing import Any, ClassVar, Literal, TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.outcome import ending_of, Outcome, signal_name
from colcon_yamllaunch.plan.member_settings import BeyondLimit, OnTimeout
from colcon_yamllaunch.plan.plan import Component, Member, Process
from colcon_yamllaunch.plan.position import Position

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.state import LaunchState

Stream = Literal['stdout', 'stderr']
#: What a user requests of a member of a launch.
Action = Literal['stop', 'kill', 'restart', 'debug', 'change']
#: The phases of a process: `waiting` for its turn or its timer, `running`,
#: `stopping` on request, waiting for its `respawn`, or `ended`; of a
#: component: `waiting` for its turn or its container, `loading`, `loaded`,
#: `unloading`, `unloaded` or `failed`. `unknown` while the connection to its
#: machine is lost.
Phase = Literal[
    'waiting',
    'running',
    'stopping',
    'respawn',
    'ended',
    'loading',
    'loaded',
    'unloading',
    'unloaded',
    'failed',
    'unknown',
]
#: The state of the connection to a machine; `done` after its part ended.
LinkState = Literal['up', 'lost', 'gone', 'done']
#: How much of what happens a user wants to see.
Verbosity = Literal['quiet', 'normal', 'verbose']

#: The label of the launcher's own lines.
LAUNCHER = 'launch'
#: The label of its lines about what `--watch` does.
WATCHER = 'watch'
#: The name that messages of the launch file have, as in ROS 2.
MESSENGER = 'launch.user'
#: The severities of messages that are shown even with `--quiet`.
LOUD = frozenset(('WARNING', 'ERROR', 'CRITICAL'))
#: The fields of events that can hold the member concerned.
MEMBER_FIELDS = ('process', 'component', 'member')
#: Why a component is unloaded, as a rule.
REQUESTED = 'requested'
CONTAINER_ENDED = 'its container ended'
#: The states that a lifecycle node keeps until it is asked for another.
LASTING_STATES = ('unconfigured', 'inactive', 'active', 'finalized')


class Event:
    """
    Something that happened; each class below is one kind of it.

    :cvar is_internal: Whether only the launcher of a part on a machine gets
      its record
    :cvar unrecorded: The fields that its record does not have
    """

    # no ABCMeta, as it would make each isinstance() slow
    __slots__ = ()

    is_internal: ClassVar[bool] = False
    unrecorded: ClassVar[tuple[str, ...]] = ()

    @property
    def name(self) -> str:
        """The name of its record, empty if it has none."""
        return ''

    @property
    def severity(self) -> str:
        """How severe it is, by the names that ROS 2 has for log messages."""
        return 'INFO'

    @property
    def label(self) -> str:
        """The label of its lines."""
        return LAUNCHER

    def lines(self) -> tuple[str, ...]:
        """Return the lines about it on the screen and in `launch.log`."""
        return ()

    def record(self) -> dict[str, Any]:
        """
        Return its record in `events.jsonl` without the time, or {} for none.

        The field `event` comes first.
        """
        return {} if self.is_internal or not self.name else self.to_json()

    def to_json(self) -> dict[str, Any]:
        """Return its record, also if it is internal; see `event_codec`."""
        record = {'event': self.name}
        for field in fields(self):  # type: ignore[arg-type]
            if field.name not in self.unrecorded:
                record |= _recorded(field.name, getattr(self, field.name))
        return record


@dataclass(frozen=True, slots=True)
class Planned(Event):
    """
    Members were added to a running launch, or replaced.

    It comes before any other event of these members.

    :param members: Processes and components; one with the label of a member
      replaces that member
    """

    members: tuple[Member, ...]

    name = 'planned'


@dataclass(frozen=True, slots=True)
class Dropped(Event):
    """A member that has ended was removed from the launch."""

    member: Member

    name = 'dropped'


@dataclass(frozen=True, slots=True)
class Started(Event):
    """A process runs."""

    process: Process
    pid: int

    name = 'started'

    def lines(self) -> tuple[str, ...]:
        return (f'{self.process.label}: started, pid {self.pid}',)


@dataclass(frozen=True, slots=True)
class StartFailed(Event):
    """
    A process could not be started.

    :param reason: Why, and the way out, in one line
    :param respawn_delay: Seconds until it is tried again, or None
    """

    process: Process
    reason: str
    respawn_delay: float | None = None

    name = 'start_failed'
    severity = 'ERROR'

    def lines(self) -> tuple[str, ...]:
        text = f'{self.process.label}: could not be started: {self.reason}'
        return (text + _starts_again(self.respawn_delay),)


@dataclass(frozen=True, slots=True)
class Output(Event):
    """
    A process wrote something.

    :param data: Whole lines as they were written; it ends inside a line only
      where the process did, or where the line is longer than the limit
    """

    process: Process
    stream: Stream
    data: bytes


@dataclass(frozen=True, slots=True)
class Exited(Event):
    """
    A process ended, and all that it wrote before was emitted.

    :param seconds: How long it ran
    :param asked: Whether it had been asked to stop
    :param failed: Whether this is a failure, see
      :func:`colcon_yamllaunch.engine.outcome.is_failure`
    :param respawn_delay: Seconds until it is started again, or None
    """

    process: Process
    pid: int
    outcome: Outcome
    seconds: float
    asked: bool
    failed: bool
    respawn_delay: float | None = None

    name = 'exited'

    @property
    def severity(self) -> str:
        return 'ERROR' if self.failed else 'INFO'

    def lines(self) -> tuple[str, ...]:
        if self.outcome.lost:
            # there is one line for all of a machine
            return ()
        ending = ending_of(self.outcome, self.asked)
        text = f'{self.process.label}: {ending} after {self.seconds:.1f} s'
        return (text + _starts_again(self.respawn_delay),)


@dataclass(frozen=True, slots=True)
class Suspended(Event):
    """
    A process was stopped as Ctrl-Z does, by whomever, or goes on.

    :param signal: The number of the signal, None when it goes on
    """

    process: Process
    pid: int
    signal: int | None = None

    @property
    def name(self) -> str:
        return 'continued' if self.signal is None else 'held'

    def lines(self) -> tuple[str, ...]:
        label = self.process.label
        if self.signal is None:
            return (f'{label}: goes on',)
        return (
            f'{label}: held by {signal_name(self.signal)}; '
            f'to let it go on: kill -CONT -- -{self.pid}',
        )


@dataclass(frozen=True, slots=True)
class Waiting(Event):
    """
    A member starts once others are ready.

    :param labels: The labels of those
    """

    member: Member
    labels: tuple[str, ...]

    name = 'waiting'


@dataclass(frozen=True, slots=True)
class Ready(Event):
    """
    A member is ready, as its settings define that.

    :param seconds: How long after its start
    """

    member: Member
    seconds: float

    name = 'ready'

    def lines(self) -> tuple[str, ...]:
        settings = self.member.settings
        if settings is None or not settings.ready:
            # that it has started says as much
            return ()
        return (f'{self.member.label}: ready after {self.seconds:.1f} s',)


@dataclass(frozen=True, slots=True)
class NotReady(Event):
    """
    A member is not ready in time, or ended before it was.

    :param conditions: What does not hold, each as a part of a sentence; empty
      if it ended
    :param action: What follows for those that wait for it
    :param seconds: How long after its start
    :param found: What there is instead, as a part of a sentence; or empty
    :param waiting: The labels of those that wait for it
    """

    member: Member
    conditions: tuple[str, ...]
    action: OnTimeout
    seconds: float
    found: str = ''
    waiting: tuple[str, ...] = ()

    name = 'not_ready'

    @property
    def severity(self) -> str:
        return 'ERROR' if self.action == 'fail' else 'WARNING'

    @property
    def text(self) -> str:
        """What is wrong, in one line without the label."""
        return not_ready_text(self.conditions, self.seconds, self.found)

    def lines(self) -> tuple[str, ...]:
        if not self.waiting or self.action == 'fail':
            return (f'{self.member.label}: {self.text}',)
        are = 'is' if len(self.waiting) == 1 else 'are'
        how = 'started all the same' if self.action == 'start' else 'held back'
        after = f'{listed(self.waiting)} {are} {how}'
        return (f'{self.member.label}: {self.text}; {after}',)


@dataclass(frozen=True, slots=True)
class NotStarted(Event):
    """
    A member is never started, as what it waits for does not become ready.

    :param labels: The labels of what is not ready
    """

    member: Member
    labels: tuple[str, ...]

    name = 'not_started'
    severity = 'ERROR'

    @property
    def text(self) -> str:
        """What is wrong, in one line."""
        return (
            f'{self.member.label}: not started, as it waits for '
            f'{listed(self.labels)}'
        )

    def lines(self) -> tuple[str, ...]:
        return (self.text,)


@dataclass(frozen=True, slots=True)
class RestartLimit(Event):
    """
    A process ended more often than its settings allow.

    :param restarts: How often it was started again
    :param window: Within how many seconds; None for the whole launch
    :param beyond: Whether the launch ends because of that
    """

    process: Process
    restarts: int
    window: float | None
    beyond: BeyondLimit

    name = 'restart_limit'
    severity = 'ERROR'

    def lines(self) -> tuple[str, ...]:
        within = '' if self.window is None else f' within {self.window:g} s'
        many = 's' * (self.restarts != 1)
        return (
            f'{self.process.label}: not started again, after '
            f'{self.restarts} restart{many}{within}',
        )


@dataclass(frozen=True, slots=True)
class Silent(Event):
    """
    A process in C++ has written no line so far, and may hold lines back.

    :param seconds: For how long
    """

    process: Process
    seconds: float

    name = 'silent'

    def lines(self) -> tuple[str, ...]:
        return (
            f'{self.process.label}: no output for {self.seconds:g} s; if it '
            'prints something, it holds that back as it writes to no '
            'terminal: --tty, or emulate_tty: true in the launch file',
        )


@dataclass(frozen=True, slots=True)
class Respawned(Event):
    """
    A process that ended is started again; `Started` follows.

    :param attempt: The number of the respawn, from 1; a restart on request
      resets it
    """

    process: Process
    attempt: int

    name = 'respawned'


@dataclass(frozen=True, slots=True)
class Signalled(Event):
    """
    A process was sent a signal on the way to its end.

    :param pid: The process group, or the one process that left it
    :param group: Whether the whole group was meant
    """

    process: Process
    pid: int
    signal: int
    group: bool

    name = 'signalled'

    def lines(self) -> tuple[str, ...]:
        if self.group:
            return ()
        return (
            f'{self.process.label}: {signal_name(self.signal)} to what it '
            f'left running, pid {self.pid}',
        )


@dataclass(frozen=True, slots=True)
class Requested(Event):
    """
    A user asks to stop, kill, restart or debug one process.

    For a component, stopping is unloading it, and restarting is reloading it.
    `change` is a restart after a change of its files.
    """

    member: Member
    action: Action

    name = 'requested'

    def lines(self) -> tuple[str, ...]:
        if self.action == 'change':
            # one line names the change and what follows
            return ()
        return (f'{self.member.label}: {self.action} requested',)


@dataclass(frozen=True, slots=True)
class Attached(Event):
    """
    A keyboard and a screen are connected to a process.

    :param hint: Which keys mean something else there; empty if it is shown
      in another terminal
    """

    process: Process
    hint: str = ''

    name = 'attached'
    unrecorded = ('hint',)

    def lines(self) -> tuple[str, ...]:
        where = self.hint or 'attached to another terminal'
        return (f'{self.process.label}: {where}',)


@dataclass(frozen=True, slots=True)
class Detached(Event):
    """Keyboard and screen were disconnected from a process."""

    process: Process

    name = 'detached'

    def lines(self) -> tuple[str, ...]:
        return (f'{self.process.label}: detached',)


@dataclass(frozen=True, slots=True)
class ShuttingDown(Event):
    """
    Everything is being stopped.

    :param reason: Why, as a part of a sentence
    :param interactive: Whether someone at a keyboard asked for it
    :param by_signal: Whether the launcher received a signal
    """

    reason: str
    interactive: bool = False
    by_signal: bool = False

    name = 'shutdown'
    unrecorded = ('interactive', 'by_signal')

    def lines(self) -> tuple[str, ...]:
        hint = ' (Ctrl-C again to force)' if self.interactive else ''
        return (f'stopping: {self.reason}{hint}',)


@dataclass(frozen=True, slots=True)
class StillRunning(Event):
    """
    Stopping takes a while.

    :param labels: The processes that are waited for
    :param timers: How many timers are waited for
    :param signal: The latest signal that one of them was sent
    :param next_signal: The one that comes next, None if none does
    :param seconds: When it comes
    """

    labels: tuple[str, ...]
    timers: int
    signal: int
    next_signal: int | None = None
    seconds: float = 0.0

    name = 'still_running'
    is_internal = True

    def lines(self) -> tuple[str, ...]:
        parts = [listed(self.labels)] if self.labels else []
        if self.timers:
            parts.append(f'{self.timers} timer' + 's' * (self.timers > 1))
        text = f'waiting for {" and ".join(parts)}'
        if self.labels:
            text += f' after {signal_name(self.signal)}'
        if self.next_signal is not None:
            seconds = max(1, round(self.seconds))
            text += f'; {signal_name(self.next_signal)} in {seconds} s'
        return (text,)


@dataclass(frozen=True, slots=True)
class LeftBehind(Event):
    """A process cannot be ended, not even by SIGKILL."""

    process: Process
    pid: int

    name = 'left_behind'
    severity = 'ERROR'

    def lines(self) -> tuple[str, ...]:
        return (
            f'{self.process.label}: pid {self.pid} cannot be stopped, not '
            'even by SIGKILL; it is left behind',
        )


@dataclass(frozen=True, slots=True)
class MessageShown(Event):
    """A message of the launch file; see `plan.Message`."""

    level: str
    text: str

    name = 'message'

    @property
    def severity(self) -> str:
        return self.level

    def lines(self) -> tuple[str, ...]:
        return (self.text,)


@dataclass(frozen=True, slots=True)
class Warned(Event):
    """The launcher has a problem, but goes on."""

    text: str

    name = 'warning'
    severity = 'WARNING'

    def lines(self) -> tuple[str, ...]:
        return (f'warning: {self.text}',)


@dataclass(frozen=True, slots=True)
class Loaded(Event):
    """
    A component was loaded into its container.

    :param node: The full name of its node
    :param unique_id: The number that the container gave it
    :param seconds: How long that took once the container was there
    """

    component: Component
    node: str
    unique_id: int
    seconds: float

    name = 'loaded'

    def lines(self) -> tuple[str, ...]:
        component = self.component
        return (f'{component.label}: loaded into {component.container}',)


@dataclass(frozen=True, slots=True)
class LoadFailed(Event):
    """
    A component could not be loaded.

    :param reason: Why, as the container said, or what became of that
    :param again: Whether it is loaded again, as its container is respawned
    """

    component: Component
    reason: str
    again: bool = False

    name = 'load_failed'
    severity = 'ERROR'

    def lines(self) -> tuple[str, ...]:
        component = self.component
        again = '; it is loaded again with that' if self.again else ''
        return (
            f'{component.label}: could not be loaded into '
            f'{component.container}: {self.reason}{again} '
            f'(from {shown(component.position)})',
        )


@dataclass(frozen=True, slots=True)
class Unloaded(Event):
    """
    A component is not loaded any more.

    :param reason: Why, as a part of a sentence
    """

    component: Component
    reason: str

    name = 'unloaded'

    def lines(self) -> tuple[str, ...]:
        if self.reason == CONTAINER_ENDED:
            # which has a line of its own
            return ()
        component = self.component
        text = f'{component.label}: unloaded from {component.container}'
        return (
            text + ('' if self.reason == REQUESTED else f': {self.reason}'),
        )


@dataclass(frozen=True, slots=True)
class StateChanged(Event):
    """
    A lifecycle node has another state.

    :param node: Its full name
    :param state: The label of the state
    :param before: That of the state before, None if it is the first one seen
    """

    member: Member
    node: str
    state: str
    before: str | None

    name = 'state_changed'

    def lines(self) -> tuple[str, ...]:
        # states between two others last a moment; the first is no news
        if self.state not in LASTING_STATES or self.before is None:
            return ()
        return (f'{self.member.label}: {self.state}',)


@dataclass(frozen=True, slots=True)
class TransitionFailed(Event):
    """
    A lifecycle node could not be configured or activated at its start.

    :param node: Its full name
    :param transition: The name of the transition
    """

    member: Member
    node: str
    transition: str
    reason: str

    name = 'transition_failed'
    severity = 'ERROR'

    def lines(self) -> tuple[str, ...]:
        position = shown(self.member.position)
        return (f'{self.member.label}: {self.text} (from {position})',)

    @property
    def text(self) -> str:
        """What happened, as a part of a sentence."""
        return (
            f"the transition '{self.transition}' of {self.node} failed: "
            f'{self.reason}'
        )


@dataclass(frozen=True, slots=True)
class MemberChanged(Event):
    """
    The state of a process or component changed as no other event says.

    It is neither shown nor recorded; see `state.LaunchState`.

    :param phase: The phase that it enters, or None; a process that is
      `ended` has left nothing running, and one that is `waiting` is started
      again by a machine that is back
    :param ending: Why a component could not be loaded or unloaded, or how a
      process ended of which no more is known; or empty
    :param lifecycle: The state of its lifecycle node, if that changed
    :param unmet: The readiness conditions that do not hold, if these changed
    """

    member: Member
    phase: Phase | None = None
    ending: str = ''
    lifecycle: str | None = None
    unmet: tuple[str, ...] | None = None

    name = 'member_changed'
    is_internal = True


@dataclass(frozen=True, slots=True)
class RosLost(Event):
    """
    The ROS client has ended and is not started again.

    :param reason: Why, as a sentence without its end
    """

    reason: str

    name = 'ros_lost'
    severity = 'ERROR'

    def lines(self) -> tuple[str, ...]:
        return (
            f'{self.reason}; no component is loaded and no lifecycle state '
            'changed any more',
        )


@dataclass(frozen=True, slots=True)
class LinkLost(Event):
    """
    The connection to a machine of the launch is lost.

    :param reason: Why, as a part of a sentence
    :param is_kept: Whether its part runs on meanwhile; else it is stopped
      there unless the link is back soon
    """

    machine: str
    reason: str
    is_kept: bool

    name = 'link_lost'
    unrecorded = ('is_kept',)
    severity = 'WARNING'

    def lines(self) -> tuple[str, ...]:
        what = (
            'its processes stop there unless it was only silent for a moment'
        )
        if self.is_kept:
            what = 'its processes run on there'
        return (
            f'{self.machine}: the link is lost: {self.reason}; {what}, and '
            'it is tried again',
        )


@dataclass(frozen=True, slots=True)
class LinkBack(Event):
    """
    The connection to a machine is back; missed events follow.

    :param seconds: For how long the link was lost
    """

    machine: str
    seconds: float

    name = 'link_back'

    def lines(self) -> tuple[str, ...]:
        return (
            f'{self.machine}: the link is back after {self.seconds:.1f} s',
        )


@dataclass(frozen=True, slots=True)
class MachineGone(Event):
    """
    A machine is lost for good, and so is its part of the launch.

    `Exited` follows for each process that ran there.

    :param reason: Why, and the way out, as a part of a sentence
    :param labels: The processes that ran there
    """

    machine: str
    reason: str
    labels: tuple[str, ...] = ()

    name = 'machine_gone'
    severity = 'ERROR'

    @property
    def text(self) -> str:
        """What happened, as a sentence without its end."""
        return f'{self.machine} is gone: {self.reason}'

    def lines(self) -> tuple[str, ...]:
        lost = f'lost with it: {listed(self.labels)}'
        return (self.text, *((lost,) if self.labels else ()))


@dataclass(frozen=True, slots=True)
class LinkChanged(Event):
    """
    The connection to a machine changed as no other event says.

    It is neither shown nor recorded.

    :param reason: Why it is lost, as a part of a sentence, or empty
    """

    machine: str
    link: LinkState
    reason: str = ''

    name = 'link_changed'
    is_internal = True


@dataclass(frozen=True, slots=True)
class UsageMeasured(Event):
    """
    The resource usage of the processes of a machine was measured.

    It is neither shown nor recorded.

    :param usage: By label the share of a processor, and bytes of memory
    """

    machine: str
    usage: Mapping[str, tuple[float, int]]

    name = 'measured'
    is_internal = True


@dataclass(frozen=True, slots=True)
class StateReceived(Event):
    """
    Another process, which runs the launch, sent its state.

    It is neither shown nor recorded.

    :param data: The state, or what changed in it, see `state.to_json`
    """

    data: object


@dataclass(frozen=True, slots=True)
class FilesChanged(Event):
    """
    Files were changed, and the launch reacts to it.

    :param files: Their paths
    """

    files: tuple[str, ...]

    name = 'changed'


@dataclass(frozen=True, slots=True)
class Built(Event):
    """
    Packages were built while the launch runs.

    :param packages: Those that were built
    :param seconds: How long that took, from the change on
    :param failed: Whether the build failed
    """

    packages: tuple[str, ...]
    seconds: float
    failed: bool = False

    name = 'built'


@dataclass(frozen=True, slots=True)
class Replanned(Event):
    """
    The launch files were evaluated again, and the plan has changed.

    :param started: The labels of new members
    :param stopped: The labels of removed members
    :param restarted: The labels of changed members
    """

    started: tuple[str, ...]
    stopped: tuple[str, ...]
    restarted: tuple[str, ...]

    name = 'replanned'


@dataclass(frozen=True, slots=True)
class Restarted(Event):
    """
    A process was restarted, or a component reloaded, after a change.

    :param seconds: How long that took, from the change on
    """

    member: Member
    seconds: float

    name = 'restarted'


@dataclass(frozen=True, slots=True)
class ChangeReported(Event):
    """
    The result of a change, or what is done about it.

    :param text: The result, in one line
    :param failed: Whether the build, the evaluation or the check failed
    :param details: Lines that say why, as a build or an evaluation shows them
    :param is_final: Whether nothing more follows from the change
    :param is_paused: Whether changes are ignored from now on; None if the
      event is about a change
    """

    text: str
    failed: bool = False
    details: str = ''
    is_final: bool = True
    is_paused: bool | None = None

    name = 'watched'
    label = WATCHER

    @property
    def severity(self) -> str:
        return 'ERROR' if self.failed else 'INFO'

    @property
    def errors(self) -> tuple[str, ...]:
        """What failed, and below it why; empty if nothing did."""
        if not (self.failed and self.details):
            return ()
        return (
            self.text,
            *self.details[: limits.BUILD_ERROR_CHARACTERS].splitlines(),
        )

    def lines(self) -> tuple[str, ...]:
        return (self.text,)

    def to_json(self) -> dict[str, Any]:
        return {
            'event': 'watched',
            'text': self.text,
            'failed': self.failed,
            'final': self.is_final,
            **({'errors': self.errors} if self.errors else {}),
        }


@dataclass(frozen=True, slots=True)
class ChangeChecked(Event):
    """
    What `--until` waits for was checked after a change.

    :param passed: Whether all was seen, and nothing failed
    :param missing: What was not seen
    :param failures: What failed, a part of a sentence each
    :param seconds: How long that took, from when all ran again
    """

    passed: bool
    missing: tuple[str, ...]
    failures: tuple[str, ...]
    seconds: float

    name = 'checked'
    label = WATCHER
    is_final = True

    @property
    def severity(self) -> str:
        return 'INFO' if self.passed else 'ERROR'

    def lines(self) -> tuple[str, ...]:
        if self.passed:
            return (f'green: all was seen ({self.seconds:.2f} s)',)
        parts = [f"'{text}' was not seen" for text in self.missing]
        what = ', '.join((*self.failures, *parts))
        return (f'red: {what} ({self.seconds:.2f} s)',)


@dataclass(frozen=True, slots=True)
class PlanFailed(Event):
    """
    A launch file in Python failed while the launch ran, which ends for that.

    :param problems: What went wrong, as lines for the user
    """

    problems: tuple[str, ...]

    name = 'plan_failed'
    severity = 'ERROR'

    def lines(self) -> tuple[str, ...]:
        return self.problems

    def to_json(self) -> dict[str, Any]:
        return {'event': 'plan_failed', 'text': '\n'.join(self.problems)}


@dataclass(frozen=True, slots=True)
class WorkerLost(Event):
    """
    The worker that runs Python launch files has ended before the launch.

    :param reason: How, as a part of a sentence
    """

    reason: str

    # the name in `events.jsonl` is older than the word worker
    name = 'host_lost'
    severity = 'ERROR'

    @property
    def text(self) -> str:
        """What happened, as a sentence without its end."""
        return f'the worker for Python launch files {self.reason}'

    def lines(self) -> tuple[str, ...]:
        return (
            f'{self.text}; what they would do when something happens is not '
            'done any more',
        )


@dataclass(frozen=True, slots=True)
class IdleChanged(Event):
    """
    The part of a launch on a machine became idle, or busy again.

    It is not shown.
    """

    is_idle: bool

    name = 'idle'
    is_internal = True


@dataclass(frozen=True, slots=True)
class CannotRun(Event):
    """
    A part of a launch on a machine cannot run at all.

    :param reason: Why, in one line
    """

    reason: str

    name = 'cannot_run'
    is_internal = True
    severity = 'ERROR'

    def lines(self) -> tuple[str, ...]:
        return (self.reason,)


@dataclass(frozen=True, slots=True)
class FailureReport:
    """
    What is known of a failure.

    :param member: What failed; None for the launch itself
    :param text: What happened, in one line
    :param tail: The last lines of its output
    :param log_file: The file that has all of its output, if there is one
    :param advice: How to fix it, if the output shows that
    """

    member: Member | None
    text: str
    tail: tuple[str, ...] = ()
    log_file: Path | None = None
    advice: str | None = None


@dataclass(frozen=True, slots=True)
class Verdict:
    """
    The result of an exit condition.

    :param name: The condition, as the user wrote it
    :param seconds: When the result was clear, from the start of the launch
    :param failure: What is wrong, in one line, or None
    """

    name: str
    seconds: float
    failure: str | None = None


@dataclass(frozen=True, slots=True)
class Ended(Event):
    """
    The launch is over.

    :param exit_code: What the launcher exits with
    :param summary: Lines that say what failed, if anything did
    :param failures: The processes that failed, in order
    :param verdicts: The results of the exit conditions
    :param state: The state of the launch
    :param reason: What failed first, as a part of a sentence, if anything did
    """

    exit_code: int
    summary: tuple[str, ...] = ()
    failures: tuple[FailureReport, ...] = ()
    verdicts: tuple[Verdict, ...] = ()
    state: 'LaunchState | None' = None
    reason: str = ''

    name = 'ended'
    unrecorded = ('summary', 'failures', 'verdicts', 'state', 'reason')

    @property
    def severity(self) -> str:
        return 'ERROR' if self.exit_code else 'INFO'

    def lines(self) -> tuple[str, ...]:
        return self.summary


Listener = Callable[[Event], None]


def member_of(event: Event) -> Member | None:
    """Return the process or component that an event is about, if any."""
    for name in MEMBER_FIELDS:
        member: Member | None = getattr(event, name, None)
        if member is not None:
            return member
    return None


def is_optional(event: Event) -> bool:
    """Return whether an event is about a member whose failure is none."""
    # a client applies events about the states of members, too
    settings = getattr(member_of(event), 'settings', None)
    return settings is not None and settings.optional


def _starts_again(delay: float | None) -> str:
    if delay is None:
        return ''
    return ', starts again' + (f' in {delay:g} s' if delay else '')


def not_ready_text(
    conditions: Sequence[str], seconds: float, found: str
) -> str:
    """Return why a member is not ready, in one line; see `NotReady`."""
    if not conditions:
        return f'ended after {seconds:.1f} s, before it was ready'
    instead = f' ({found})' if found else ''
    return (
        f'not ready after {seconds:.1f} s: waiting for '
        f'{" and ".join(conditions)}{instead}'
    )


def listed(labels: Sequence[str]) -> str:
    """Return labels as a part of a sentence; of many, some are counted."""
    names = ', '.join(labels[: limits.LISTED_NAMES])
    more = len(labels) - limits.LISTED_NAMES
    return f'{names} and {more} more' if more > 0 else names


def shown(position: Position) -> str:
    """Return a position for users, relative to the current folder below it."""
    try:
        relative = os.path.relpath(position.path)
    except (OSError, ValueError):
        return str(position)
    if relative.startswith('..'):
        return str(position)
    return str(Position(relative, position.line, position.column))


def _recorded(name: str, value: Any) -> dict[str, Any]:
    """Return what a record has of a field of an event."""
    match value:
        case Process() | Component():
            who = {'label': value.label, 'name': value.ros_name}
            if name == 'component' and isinstance(value, Component):
                who['container'] = value.container
            return who
        case Outcome():
            return {
                'exit_code': value.code,
                'signal': value.signal and signal_name(value.signal),
                'core_dumped': value.core_dumped,
                **({'limit': value.limit} if value.limit else {}),
            }
        case tuple() if name == 'members':
            return {'labels': [member.label for member in value]}
        case tuple():
            return {name: list(value)}
        case None if name == 'signal':
            return {}
        case int() if name in ('signal', 'next_signal'):
            return {name: signal_name(value)}
        case float() if name == 'seconds':
            return {name: round(value, 6)}
        case _:
            return {name: value}
