# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch file comes to: plain data, ready to be run."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.member_settings import (
    MemberSettings,
    ReadyCondition,
    ROS_KINDS,
)
from colcon_yamllaunch.plan.position import Position

#: Seconds from SIGINT to SIGTERM where a process says nothing else (ROS 2).
DEFAULT_SIGTERM_TIMEOUT = 5.0
#: Seconds from SIGTERM to SIGKILL where a process says nothing else (ROS 2).
DEFAULT_SIGKILL_TIMEOUT = 5.0
#: Retries without end, as ROS 2 counts them.
UNLIMITED_RETRIES = -1
#: The values of the `output` attribute, as in ROS 2.
OUTPUT_MODES = ('both', 'screen', 'log', 'own_log', 'full')

_ALL = frozenset(('stdout', 'stderr'))
_NONE: frozenset[str] = frozenset()

#: The streams of a process that the screen shows, by output mode.
SHOWN = {
    'both': _ALL,
    'screen': _ALL,
    'log': frozenset(('stderr',)),
    'own_log': _NONE,
    'full': _ALL,
}
#: The output modes that write to the log file of the whole launch.
IN_COMMON_LOG = frozenset(('both', 'log', 'full'))
#: The output modes that write to log files of the process itself.
IN_OWN_LOG = frozenset(('both', 'log', 'own_log', 'full'))


@dataclass(frozen=True, slots=True)
class Transition:
    """
    A transition of lifecycle nodes (ROS 2 design, "Managed nodes").

    :param starts: The states that have it
    :param goal: The state that it leads to when it succeeds
    """

    starts: tuple[str, ...]
    goal: str


#: The transitions that may be requested, by name.
TRANSITIONS = {
    'configure': Transition(('unconfigured',), 'inactive'),
    'activate': Transition(('inactive',), 'active'),
    'deactivate': Transition(('active',), 'inactive'),
    'cleanup': Transition(('inactive',), 'unconfigured'),
    'shutdown': Transition(
        ('unconfigured', 'inactive', 'active'), 'finalized'
    ),
}


def transitions_of(state: str | None) -> list[str]:
    """Return the transitions that a state has."""
    return [n for n, known in TRANSITIONS.items() if state in known.starts]


#: Variables by name, sorted; None where one is unset.
Variables = tuple[tuple[str, str | None], ...]


@dataclass(frozen=True, slots=True)
class SetParameter:
    """
    A parameter of a node, and where it comes from.

    :param name: Its full name, parts separated by dots
    :param value: Its value as YAML
    :param position: Where the launch file sets it
    :param origins: Where the launch configuration that its value was made of
      was set, and those that this one was made of, nearest first
    """

    name: str
    value: str
    position: Position
    origins: tuple[Position, ...] = ()


@dataclass(frozen=True, slots=True)
class ParameterFile:
    """
    An argument that is the path of a file with parameters.

    The file exists only while the launch runs; whoever starts the process
    writes `content` and passes the path.

    :param content: What the file says
    :param parameters: The parameters in it; none when it is another file
      with its substitutions made
    """

    content: str
    parameters: tuple[SetParameter, ...] = ()


@dataclass(frozen=True, slots=True)
class Block:
    """
    A launch file or group that others stand in.

    :param kind: `file`, `group` or `timer`
    :param title: What to call it: a path, a namespace, a time
    :param position: Where it is written; a file, where it is included
    :param parent: The index of the block around it, None for the outermost
    """

    kind: str
    title: str
    position: Position
    parent: int | None


@dataclass(frozen=True, slots=True)
class EvaluatedCondition:
    """
    A condition that was evaluated.

    :param text: The condition as it is written
    :param taken: Whether the action was done
    :param position: Where it is written
    """

    text: str
    taken: bool
    position: Position


@dataclass(frozen=True, slots=True)
class Process:
    """
    A process to be started.

    :param label: The name in output and logs, unique in the plan
    :param argv: The command line
    :param cwd: The working directory, an absolute path
    :param environment: The variables that differ from the environment that
      the launch runs in, sorted by name; None where one is unset
    :param output: One of :data:`OUTPUT_MODES`
    :param emulate_tty: Whether stdout and stderr are terminals
    :param respawn: Whether to start it again when it ends, however it ended
    :param respawn_delay: Seconds to wait before that
    :param respawn_max_retries: How often at most, or
      :data:`UNLIMITED_RETRIES`
    :param sigterm_timeout: Seconds from SIGINT to SIGTERM when stopping
    :param sigkill_timeout: Seconds from SIGTERM to SIGKILL when stopping
    :param on_exit_shutdown: Whether the launch ends when the process does
    :param position: Where the launch file says so
    :param name: What ROS 2 calls it, its program and number, as `talker.py-2`;
      None where that is the label
    :param package: The package that the program belongs to, if any
    :param node_name: The full name of the ROS node as far as it is known
    :param parameters: The parameters that the launch files give it, in order;
      the last of several with one name counts
    :param block: The index of the block that it stands in
    :param is_container: Whether it is a component container
    :param is_lifecycle: Whether its node is a lifecycle node
    :param autostart: Whether that node is configured and activated
    :param settings: What a deployment file says about it
    """

    label: str
    argv: tuple[str | ParameterFile, ...]
    cwd: str
    position: Position
    name: str | None = None
    environment: Variables = ()
    output: str = 'both'
    emulate_tty: bool = False
    respawn: bool = False
    respawn_delay: float = 0.0
    respawn_max_retries: int = UNLIMITED_RETRIES
    sigterm_timeout: float = DEFAULT_SIGTERM_TIMEOUT
    sigkill_timeout: float = DEFAULT_SIGKILL_TIMEOUT
    on_exit_shutdown: bool = False
    package: str | None = None
    node_name: str | None = None
    parameters: tuple[SetParameter, ...] = ()
    block: int | None = None
    is_container: bool = False
    is_lifecycle: bool = False
    autostart: bool = False
    settings: MemberSettings | None = None

    @property
    def ros_name(self) -> str:
        """What ROS 2 calls it, or else the label; unique in the plan."""
        return self.name or self.label


@dataclass(frozen=True, slots=True)
class Component:
    """
    A node to be loaded into a component container.

    :param label: The name in output and logs, unique in the plan
    :param package: The package that has the plugin
    :param plugin: The class of the node, such as `demo::Talker`
    :param container: The full name of the container's node
    :param position: Where the launch file says so
    :param name: The name of its node, empty for the one that it has itself
    :param namespace: The namespace of its node, empty for the one that it
      has itself
    :param remaps: Remapping rules as `from:=to`; the first that matches counts
    :param parameters: Its parameters in order, their values as JSON with
      `.inf` and `.nan`; the last of several with one name counts
    :param extra_arguments: What the container takes besides, like parameters
    :param block: The index of the block that it stands in
    :param is_lifecycle: Whether it is a lifecycle node
    :param autostart: Whether it is configured and activated once it is loaded
    :param settings: What a deployment file says about it
    """

    label: str
    package: str
    plugin: str
    container: str
    position: Position
    name: str = ''
    namespace: str = ''
    remaps: tuple[str, ...] = ()
    parameters: tuple[SetParameter, ...] = ()
    extra_arguments: tuple[SetParameter, ...] = ()
    block: int | None = None
    is_lifecycle: bool = False
    autostart: bool = False
    settings: MemberSettings | None = None

    @property
    def node_name(self) -> str | None:
        """The full name of its node, None where it has its own."""
        if not self.name:
            return None
        return f'{self.namespace.rstrip("/")}/{self.name}'

    @property
    def ros_name(self) -> str:
        """The label, as ROS 2 has no other name for it."""
        return self.label


@dataclass(frozen=True, slots=True)
class Message:
    """
    A line for the user.

    :param level: One of DEBUG, INFO, WARNING, ERROR, CRITICAL
    :param text: The line
    """

    level: str
    text: str


@dataclass(frozen=True, slots=True)
class Shutdown:
    """The end of the launch, with a reason that may be empty."""

    reason: str


@dataclass(frozen=True, slots=True)
class Timer:
    """
    Entries that are due later.

    :param period: Seconds from the moment that the timer's turn comes
    :param entries: What is due then, in order
    :param cancel_on_shutdown: Whether a shutdown drops the timer; if not, the
      launch does not end before it fired
    :param on_ros_time: Whether the seconds are those of the topic `/clock`
    """

    period: float
    entries: 'tuple[Entry, ...]'
    cancel_on_shutdown: bool = True
    on_ros_time: bool = False


@dataclass(frozen=True, slots=True)
class AfterReady:
    """
    Entries that are due once processes and components are ready.

    :param labels: The labels of these processes and components
    :param entries: What is due then, in order
    """

    labels: tuple[str, ...]
    entries: 'tuple[Entry, ...]'


@dataclass(frozen=True, slots=True)
class ChangeState:
    """
    A transition of a lifecycle node, asked for when its turn comes.

    :param node: The full name of the node
    :param transition: One of :data:`TRANSITIONS`
    :param position: Where the launch file says so
    """

    node: str
    transition: str
    position: Position


@dataclass(frozen=True, slots=True)
class SignalProcess:
    """
    A signal to a process of the launch.

    :param process: What ROS 2 calls the process
    :param signal: The number of the signal; 0 to stop the process as
      `--stop` does, with all steps of the escalation
    :param position: Where the launch file says so
    """

    process: str
    signal: int
    position: Position


@dataclass(frozen=True, slots=True)
class WorkerCall:
    """
    Something that only the worker of launch files in Python can go on with.

    When its turn comes, the worker is asked, and answers with more plan.

    :param number: What the worker knows it by
    :param title: What it does, such as `call spawn_more (a.launch.py:7)`
    :param position: Where the launch file says so
    """

    number: int
    title: str
    position: Position


#: A member of a launch: it has a label, and is started, stopped and shown by
#: that.
Member = Process | Component

#: What a plan does at its turn.
Entry = (
    Member
    | Message
    | Shutdown
    | Timer
    | AfterReady
    | ChangeState
    | SignalProcess
    | WorkerCall
)


@dataclass(frozen=True, slots=True)
class EventHandler:
    """
    What a launch file in Python does when something happens.

    The worker of launch files in Python is told what happens, and answers with
    more plan; here is only what there is to be seen of it before.

    :param event: `start`, `exit`, `output`, `complete`, `shutdown`, `state`
      or `other`
    :param processes: What ROS 2 calls the processes that it waits for; empty
      for all of them, or when it is not about processes
    :param condition: What else has to hold, such as `inactive`; or empty
    :param actions: What it does, a line each, such as `start rviz2` or
      `call on_exit`
    :param position: Where the launch file says so
    """

    event: str
    processes: tuple[str, ...]
    condition: str
    actions: tuple[str, ...]
    position: Position


@dataclass(frozen=True, slots=True)
class Plan:
    """
    Everything that a launch does, in order.

    :param entries: What to do, in the order of the launch files
    :param blocks: The launch files, groups and timers, outer ones first
    :param conditions: The conditions that were evaluated, in order
    :param left_open: The substitutions that stand in it as they are written;
      with any, it is to be looked at, and not to be run
    :param handlers: What launch files in Python do when something happens
    """

    entries: tuple[Entry, ...] = ()
    blocks: tuple[Block, ...] = ()
    conditions: tuple[EvaluatedCondition, ...] = ()
    left_open: tuple[str, ...] = ()
    handlers: tuple[EventHandler, ...] = ()

    def walk(self) -> Iterator[Entry]:
        """Iterate over all entries in order, including those due later."""
        pending = list(reversed(self.entries))
        while pending:
            entry = pending.pop()
            yield entry
            if isinstance(entry, Timer | AfterReady):
                pending.extend(reversed(entry.entries))

    def processes(self) -> Iterator[Process]:
        """Iterate over all processes, those behind timers too."""
        return (e for e in self.walk() if isinstance(e, Process))

    def components(self) -> Iterator[Component]:
        """Iterate over all components, those behind timers too."""
        return (e for e in self.walk() if isinstance(e, Component))

    def members(self) -> Iterator[Member]:
        """Iterate over all processes, then over all components."""
        yield from self.processes()
        yield from self.components()

    def changes_of_state(self) -> Iterator[ChangeState]:
        """Iterate over all transitions, those behind timers too."""
        return (e for e in self.walk() if isinstance(e, ChangeState))

    @property
    def has_ros_timer(self) -> bool:
        """Whether a timer is on the time of the topic `/clock`."""
        return any(isinstance(e, Timer) and e.on_ros_time for e in self.walk())

    @property
    def needs_ros(self) -> bool:
        """Whether more is to be done in ROS than to start processes."""
        return (
            self.has_ros_timer
            or any(
                isinstance(e, Component | ChangeState)
                or (isinstance(e, Process) and e.is_lifecycle)
                for e in self.walk()
            )
            or any(True for _ in self.ros_conditions())
        )

    def ros_conditions(self) -> Iterator[ReadyCondition]:
        """Iterate over the readiness conditions that a ROS client checks."""
        return (
            condition
            for member in self.members()
            if member.settings is not None
            for condition in member.settings.ready
            if condition.kind in ROS_KINDS
        )

    @property
    def worker_position(self) -> Position | None:
        """Where it first says what only a launch file in Python can do.

        That needs the worker of launch files in Python while the plan runs.
        None if there is nothing of the kind.
        """
        for handler in self.handlers:
            return handler.position
        for entry in self.walk():
            if isinstance(entry, WorkerCall):
                return entry.position
        return None


@dataclass(frozen=True, slots=True)
class Growth:
    """
    What comes to a plan while it runs.

    :param entries: What to do next, as if it had stood at the end; labels of
      processes and components differ from all that are there already
    :param problems: What went wrong, as lines for the user; the launch fails
      with any
    :param blocks: The launch files, groups and timers of the plan as it is
      now, if they are known
    """

    entries: tuple[Entry, ...] = ()
    problems: tuple[str, ...] = ()
    blocks: tuple[Block, ...] = ()


def changed_entries(
    entries: Iterable[Entry], change: Callable[[Entry], Entry | None]
) -> tuple[Entry, ...]:
    """
    Return entries after a change to each, including those due later.

    :param change: Returns what replaces an entry, None to leave it out; it is
      not called for what contains others
    """
    found: list[Entry] = []
    for entry in entries:
        if isinstance(entry, Timer | AfterReady):
            inner = changed_entries(entry.entries, change)
            found.append(replace(entry, entries=inner))
        elif (changed := change(entry)) is not None:
            found.append(changed)
    return tuple(found)


#: Returns all parameters that a process is given, with where they are set; the
#: last of several with one name counts.
ParametersOf = Callable[[Process], Iterable[SetParameter]]
