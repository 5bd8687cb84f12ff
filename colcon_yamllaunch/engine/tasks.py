# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What has become of each process of a plan."""

from dataclasses import dataclass

from colcon_yamllaunch.plan.plan import Process


@dataclass(slots=True)
class Task:
    """
    A process of the plan in the course of a launch.

    :param number: Its number in the plan
    :param respawns: How often it has been respawned since it was last
      started on request
    :param quick_ends: How often in a row it ended at once
    :param started: When it was started last, by the supervisor's clock
    :param group: Its process group, as long as its leader runs
    :param ended: When it ended, or None if it has not been started or runs
    :param ending: How it ended, as a part of a sentence
    :param is_suspended: Whether its leader is stopped as Ctrl-Z does
    :param was_signalled: Whether the plan has sent it a signal that ends it
    :param successor: What it is when it starts next, if something else
    :param is_kept_stopped: Whether it was stopped on request
    :param once: What its next start is of, and only that one, such as the
      process under a debugger
    """

    number: int
    process: Process
    respawns: int = 0
    quick_ends: int = 0
    started: float = 0.0
    group: int | None = None
    ended: float | None = None
    ending: str = ''
    is_suspended: bool = False
    was_signalled: bool = False
    successor: Process | None = None
    is_kept_stopped: bool = False
    once: Process | None = None
