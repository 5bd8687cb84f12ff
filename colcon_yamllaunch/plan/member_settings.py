# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What a deployment file says about a process or component.

A launch file says what runs, and ROS 2 reads it. What only this program knows
(when a process is ready, what it waits for, when it is started again, what it
may use) comes from the file of `--deploy`, and stands in the plan as these
settings.
"""

from dataclasses import replace
from typing import get_args, Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.position import Position

#: What a readiness condition is about:
#:
#: - `running`: the process has started, or the component is loaded
#: - `topic`: a publisher of the topic `name` exists; with `message`, a message
#:   has arrived
#: - `service`, `action`: a server of `name` exists
#: - `node`: the node `name` is in the graph
#: - `lifecycle`: the lifecycle node of the process is in the state `name`
#: - `parameter`: the parameter `name` of its node equals `value` (JSON)
#: - `transform`: there is a transform from the frame `name` to `value`
#: - `log`: a line of its output matches the regular expression `name`
#: - `port`: something listens on the TCP port `name`, which is a number, or
#:   `HOST:PORT`
#: - `file`: the path `name` exists
#: - `command`: the command line `name` exits with 0; it runs every second
#: - `after`: it has been running for `seconds`
ReadyKind = Literal[
    'running',
    'topic',
    'service',
    'action',
    'node',
    'lifecycle',
    'parameter',
    'transform',
    'log',
    'port',
    'file',
    'command',
    'after',
]
#: Those that only a ROS client can check.
ROS_KINDS: tuple[ReadyKind, ...] = (
    'topic',
    'service',
    'action',
    'node',
    'lifecycle',
    'parameter',
    'transform',
)
#: What happens when a process is not ready in time: its dependents go on
#: waiting, the launch ends, or they are started all the same.
OnTimeout = Literal['warn', 'fail', 'start']
#: After which ends a process is started again.
RestartWhen = Literal['never', 'always', 'failure']
#: What happens beyond the limit of restarts: the launch ends, or the process
#: stays down.
BeyondLimit = Literal['fail', 'leave']
#: Scheduling policies of Linux (`sched(7)`).
Policy = Literal['fifo', 'rr', 'deadline']

#: Seconds from its start until a process is reported as not ready.
READY_TIMEOUT = 60.0
#: Restarts without a limit.
UNLIMITED_RESTARTS = -1
ON_TIMEOUT: tuple[OnTimeout, ...] = get_args(OnTimeout)
RESTART_WHEN: tuple[RestartWhen, ...] = get_args(RestartWhen)
BEYOND_LIMIT: tuple[BeyondLimit, ...] = get_args(BeyondLimit)


@dataclass(frozen=True, slots=True)
class ReadyCondition:
    """
    Something that holds once a process or component is ready.

    :param kind: What it is about; see :data:`ReadyKind`
    :param name: The topic, service, node, state, expression, path, …
    :param value: The value of a parameter as JSON, or the second frame of a
      transform
    :param message: Whether a message must have arrived on the topic
    :param seconds: How long the process must have been running
    """

    kind: ReadyKind
    name: str = ''
    value: str = ''
    message: bool = False
    seconds: float = 0.0

    def __str__(self) -> str:
        match self.kind:
            case 'running':
                return 'its start'
            case 'topic' if self.message:
                return f'a message on {self.name}'
            case 'topic':
                return f'a publisher of {self.name}'
            case 'lifecycle':
                return f'the state {self.name}'
            case 'parameter':
                return f'the parameter {self.name} to be {self.value}'
            case 'transform':
                return f'the transform {self.name} → {self.value}'
            case 'log':
                return f'a line that matches {self.name!r}'
            case 'after':
                return f'{self.seconds:g} s after its start'
            case 'command':
                return f'the command {self.name!r} to succeed'
            case _:
                return f'the {self.kind} {self.name}'


@dataclass(frozen=True, slots=True)
class Restart:
    """
    When a process that ended is started again.

    :param when: After which ends; one that was asked to stop is not started
    :param limit: How often at most within `window`, or
      :data:`UNLIMITED_RESTARTS`
    :param window: Seconds; None for the whole launch
    :param first_delay: Seconds before the first restart; each further restart
      within `window` waits twice as long
    :param longest_delay: The longest wait in seconds
    :param beyond: What happens beyond the limit
    :param together: The labels of the processes that are restarted with it
    :param command: A command line that is run before each restart, and must
      succeed; empty for none
    """

    when: RestartWhen = 'never'
    limit: int = UNLIMITED_RESTARTS
    window: float | None = None
    first_delay: float = 0.0
    longest_delay: float = 0.0
    beyond: BeyondLimit = 'fail'
    together: tuple[str, ...] = ()
    command: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Scheduling:
    """
    A real-time scheduling policy.

    :param policy: See :data:`Policy`
    :param priority: Of `fifo` and `rr`, 1 to 99
    :param runtime: Of `deadline`, in seconds, like `deadline` and `period`
    """

    policy: Policy
    priority: int = 0
    runtime: float = 0.0
    deadline: float = 0.0
    period: float = 0.0


@dataclass(frozen=True, slots=True)
class ResourceLimits:
    """
    What a process may use, with all that it starts; None for no limit.

    :param memory: Bytes; beyond them the system kills it
    :param memory_high: Bytes; beyond them the system slows it down
    :param cpu: Processors; 1.5 for one and a half
    :param cpus: The numbers of the processors that it may run on
    :param io: Its weight against others, 1 to 10000 (100 by default)
    :param tasks: Processes and threads
    :param nice: Its nice value, -20 to 19
    :param scheduling: Its scheduling policy
    :param oom: Its `oom_score_adj`, -1000 to 1000: the higher, the sooner it
      is killed when memory runs out
    """

    memory: int | None = None
    memory_high: int | None = None
    cpu: float | None = None
    cpus: tuple[int, ...] = ()
    io: int | None = None
    tasks: int | None = None
    nice: int | None = None
    scheduling: Scheduling | None = None
    oom: int | None = None


@dataclass(frozen=True, slots=True)
class SettingPlace:
    """Where the deployment file has a key."""

    key: str
    position: Position


@dataclass(frozen=True, slots=True)
class MemberSettings:
    """
    The settings of a process or component.

    :param ready: What holds once it is ready; by default a process is ready
      when it runs, with a node when that is in the graph, a component when it
      is loaded, and an autostarted lifecycle node when it is active
    :param after: The labels of the processes and components that must be ready
      before it starts
    :param ready_timeout: Seconds from its start until it is reported as not
      ready
    :param on_timeout: What happens then
    :param restart: When it is started again; None for what the launch file
      says (`respawn`)
    :param critical: Whether the launch ends, and fails, when it fails
    :param optional: Whether its failure does not count
    :param limits: What it may use
    :param user: The user that it runs as; empty for that of the launch
    :param position: Where the deployment file says so
    :param places: Where it says what the limits and the user are
    """

    position: Position
    ready: tuple[ReadyCondition, ...] = ()
    after: tuple[str, ...] = ()
    ready_timeout: float = READY_TIMEOUT
    on_timeout: OnTimeout = 'warn'
    restart: Restart | None = None
    critical: bool = False
    optional: bool = False
    limits: ResourceLimits | None = None
    user: str = ''
    places: tuple[SettingPlace, ...] = ()

    @property
    def is_restricted(self) -> bool:
        """Whether the process starts with limits, or as another user."""
        return self.limits is not None or bool(self.user)

    def place(self, key: str) -> Position:
        """Return where a limit or the user is set."""
        found = (p.position for p in self.places if p.key == key)
        return next(found, self.position)


def is_same_settings(
    one: MemberSettings | None, other: MemberSettings | None
) -> bool:
    """Return whether settings say the same, wherever they stand."""
    if one is None or other is None:
        return one is other
    return one == replace(other, position=one.position, places=one.places)
