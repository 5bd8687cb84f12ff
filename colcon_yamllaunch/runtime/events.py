# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What happens in a launch, told to everything that shows or records it.

Events carry no time of day: they are told at the moment when they happen.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from colcon_yamllaunch.language.plan import Process
from colcon_yamllaunch.runtime.outcome import Outcome

Stream = Literal['stdout', 'stderr']


@dataclass(frozen=True, slots=True)
class Started:
    """A process runs."""

    process: Process
    pid: int


@dataclass(frozen=True, slots=True)
class StartFailed:
    """
    A process could not be started.

    :param reason: Why, and the way out, in one line
    """

    process: Process
    reason: str


@dataclass(frozen=True, slots=True)
class Output:
    """
    A process wrote something.

    :param data: Whole lines as they were written; it ends inside a line only
      where the process did, or where the line is longer than the limit
    """

    process: Process
    stream: Stream
    data: bytes


@dataclass(frozen=True, slots=True)
class Exited:
    """
    A process ended, and all that it wrote before has been told.

    :param seconds: How long it ran
    :param asked: Whether it had been asked to stop
    :param failed: Whether this is a failure, see
      :func:`colcon_yamllaunch.runtime.outcome.is_failure`
    :param respawn_delay: Seconds until it is started again, or None
    """

    process: Process
    pid: int
    outcome: Outcome
    seconds: float
    asked: bool
    failed: bool
    respawn_delay: float | None = None


@dataclass(frozen=True, slots=True)
class Respawned:
    """
    A process that ended is started once more; `Started` follows.

    :param attempt: The number of the restart, counted from 1
    """

    process: Process
    attempt: int


@dataclass(frozen=True, slots=True)
class Signalled:
    """
    A process was sent a signal on the way to its end.

    :param pid: The process group, or the one process that left it
    :param signal: The number of the signal
    :param group: Whether the whole group was meant
    """

    process: Process
    pid: int
    signal: int
    group: bool


@dataclass(frozen=True, slots=True)
class ShuttingDown:
    """
    Everything is being stopped.

    :param reason: Why, as a part of a sentence
    :param interactive: Whether someone at a keyboard asked for it
    """

    reason: str
    interactive: bool = False


@dataclass(frozen=True, slots=True)
class StillRunning:
    """
    Stopping takes a while.

    :param labels: The processes that are waited for
    :param timers: How many timers are waited for
    :param signal: The latest signal that one of them was sent
    """

    labels: tuple[str, ...]
    timers: int
    signal: int


@dataclass(frozen=True, slots=True)
class LeftBehind:
    """A process cannot be ended, not even by SIGKILL."""

    label: str
    pid: int


@dataclass(frozen=True, slots=True)
class Said:
    """The launch file has something to say; see `plan.Message`."""

    level: str
    text: str


@dataclass(frozen=True, slots=True)
class Warned:
    """The launcher itself is in some trouble, yet goes on."""

    text: str


@dataclass(frozen=True, slots=True)
class Ended:
    """
    The launch is over.

    :param exit_code: What the launcher exits with
    :param summary: Lines that say what failed, if anything did
    """

    exit_code: int
    summary: tuple[str, ...] = ()


Event = (
    Started
    | StartFailed
    | Output
    | Exited
    | Respawned
    | Signalled
    | ShuttingDown
    | StillRunning
    | LeftBehind
    | Said
    | Warned
    | Ended
)
Listener = Callable[[Event], None]
