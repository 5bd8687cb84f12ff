# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The processes of a plan, as the supervisor has them."""

from dataclasses import field

from colcon_yamllaunch.common.frozen import mutable
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.plan import SignalProcess


@mutable
class Task:
    """
    What the supervisor needs of a process besides its `ProcessState`.

    :param number: Its number in the plan
    :param respawns: How often it has been respawned since it was last
      started on request
    :param quick_ends: How often in a row it ended at once
    :param started: When it was started last, by the clock of the loop
    :param group: Its process group, as long as its leader runs
    :param successor: The process that replaces it at its next start, if any
    :param once: The process that replaces it at its next start only, such as
      itself under a debugger
    :param early_signals: The signals of the plan that it gets once it runs
    :param is_restarting: Whether it starts again once it is stopped
    :param is_dropped: Whether it leaves the plan once it is stopped
    :param is_pause_reported: Whether the user knows that its respawns pause
    """

    number: int
    process: Process
    respawns: int = 0
    quick_ends: int = 0
    started: float = 0.0
    group: int | None = None
    successor: Process | None = None
    once: Process | None = None
    early_signals: list[SignalProcess] = field(default_factory=list)
    is_restarting: bool = False
    is_dropped: bool = False
    is_pause_reported: bool = False
