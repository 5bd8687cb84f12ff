# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What happens in a launch, told to everything that shows or records it.

Events carry no time of day: they are told at the moment when they happen.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Literal

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.runtime.core.outcome import Outcome

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
      :func:`colcon_yamllaunch.runtime.core.outcome.is_failure`
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
class Held:
    """
    A process was stopped as Ctrl-Z does, by whomever, or goes on.

    :param signal: The number of the signal, None when it goes on
    """

    process: Process
    pid: int
    signal: int | None


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
class Requested:
    """Somebody asks to stop one process, or to start it anew."""

    process: Process
    action: Literal['stop', 'restart']


@dataclass(frozen=True, slots=True)
class Attached:
    """
    A keyboard and a screen are connected to a process.

    :param hint: Which keys mean something else there; empty if it is shown
      in another terminal
    """

    process: Process
    hint: str = ''


@dataclass(frozen=True, slots=True)
class Detached:
    """The keyboard and the screen of a process are not its own any more."""

    process: Process


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
class FailureReport:
    """
    What is known of a process that failed.

    :param text: What happened, in one line
    :param tail: The last lines of its output
    :param log_file: The file that has all of its output, if there is one
    """

    process: Process
    text: str
    tail: tuple[str, ...] = ()
    log_file: Path | None = None


@dataclass(frozen=True, slots=True)
class Verdict:
    """
    What came of something that the launch was to achieve; see `goal`.

    :param name: What it is, as the user wrote it
    :param seconds: When that was clear, from the start of the launch on
    :param failure: What is wrong, in one line, or None
    """

    name: str
    seconds: float
    failure: str | None = None


@dataclass(frozen=True, slots=True)
class Ended:
    """
    The launch is over.

    :param exit_code: What the launcher exits with
    :param summary: Lines that say what failed, if anything did
    :param failures: The processes that failed, in order
    :param verdicts: What came of what the launch was to achieve
    """

    exit_code: int
    summary: tuple[str, ...] = ()
    failures: tuple[FailureReport, ...] = ()
    verdicts: tuple[Verdict, ...] = ()


Event = (
    Started
    | StartFailed
    | Output
    | Exited
    | Held
    | Respawned
    | Signalled
    | Requested
    | Attached
    | Detached
    | ShuttingDown
    | StillRunning
    | LeftBehind
    | Said
    | Warned
    | Ended
)
Listener = Callable[[Event], None]
