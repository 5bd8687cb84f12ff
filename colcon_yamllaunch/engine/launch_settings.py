# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What holds for a whole launch while it runs."""

from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import field
import os
from pathlib import Path
import time

from colcon_yamllaunch.common.adoption import Adoption
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.engine.process.line_buffering import LineBuffering
from colcon_yamllaunch.engine.process.spawn import Spawn


class Moment:
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
class Settings:
    """
    What holds for a whole launch.

    :param identity: Its identity, see `launch_scan`
    :param environment: The environment that processes change for themselves
    :param screen: The descriptor of the screen, whose size terminals for
      processes have, or -1
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
    :param moment: When what is told happened, by the time of day
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
    moment: Moment = field(default_factory=Moment)
