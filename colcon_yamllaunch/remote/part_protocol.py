# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launcher sends to its part: settings first, commands later."""

from collections.abc import Mapping
from dataclasses import field
from typing import ClassVar

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine import limits
from colcon_yamllaunch.engine.commands import Command, Done, MemberCommand

#: Seconds without a word from the launcher after which a part is stopped.
LOST_AFTER = 10.0
#: Seconds between two heartbeats at most, and how many heartbeats at least
#: are due before a link is lost.
HEARTBEAT = 1.0
_BEATS = 5
#: Begins the reason of a part to stop when its launcher is gone, by which the
#: launcher knows such a stop.
LINK_LOST = 'the link to the launcher is lost'


@dataclass(frozen=True, slots=True)
class MeasuredUsage:
    """
    The response to `Measure`.

    :param usage: By label the share of a processor, and bytes of memory
    """

    usage: Mapping[str, tuple[float, int]]


@dataclass(frozen=True, slots=True)
class Measure(Command[MeasuredUsage]):
    """Measure what the processes use."""

    name: ClassVar[str] = 'measure'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Finish(Command[Done]):
    """End the part once nothing of it runs."""

    name: ClassVar[str] = 'finish'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class NoteElsewhere(Command[Done]):
    """
    Note what members of the launch that are not in the part do.

    :param ready: The labels of those that members of the part wait for, and
      that are ready
    :param running: The labels of those that wait for members of the part, and
      still run
    """

    ready: tuple[str, ...] = ()
    running: tuple[str, ...] = ()
    name: ClassVar[str] = 'note_elsewhere'
    is_public: ClassVar[bool] = False


@dataclass(frozen=True, slots=True)
class Show(MemberCommand[Done]):
    """
    Send what a process writes at once, and how its terminal reads keys.

    :param is_shown: Whether to do that, or to stop it
    """

    is_shown: bool = True
    name: ClassVar[str] = 'show'
    is_public: ClassVar[bool] = False


def heartbeat_of(lost_after: float) -> float:
    """Return the seconds between two heartbeats of either side."""
    return min(HEARTBEAT, lost_after / _BEATS)


@dataclass(frozen=True, slots=True)
class PartSettings:
    """
    How a part of a launch is run.

    :param machine: The name of the machine
    :param workspace: The workspace there that is sourced, or None
    :param variables: What goes along of the user's environment
    :param on_lost: `stop`, `restart` or `keep`, see `Machine`
    :param lost_after: Seconds without a word from the launcher after which
      the link is lost
    :param log_name: The name of its log folder, None to keep no logs there
    :param log_limit: What its logs may take together, in bytes, or None; what
      is kept for a lost connection may take as much
    :param kept_logs: How many log folders of earlier launches are kept, or
      None to leave them alone
    :param logs_limit: What these may take together, in bytes, or None
    :param tty: Whether each process gets a terminal
    :param after: For each member of the launch the labels that it waits for;
      None if it does not matter which members are ready
    """

    machine: str
    workspace: str | None = None
    variables: Mapping[str, str] = field(default_factory=dict)
    on_lost: str = 'stop'
    lost_after: float = LOST_AFTER
    log_name: str | None = None
    log_limit: int | None = limits.DEFAULT_LOG_BYTES
    kept_logs: int | None = None
    logs_limit: int | None = None
    tty: bool = False
    after: Mapping[str, tuple[str, ...]] | None = None
