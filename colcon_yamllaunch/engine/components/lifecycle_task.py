# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What has become of each lifecycle node of a plan."""

from dataclasses import dataclass

from colcon_yamllaunch.plan.plan import Component
from colcon_yamllaunch.plan.plan import Process


@dataclass(slots=True)
class LifecycleTask:
    """
    A lifecycle node in the course of a launch.

    :param owner: The process or component that it is
    :param node: Its full name, None where it is not known yet
    :param state: The label of its state, as `active`, or None while it does
      not run or has not told
    :param goal: The state that it is brought to when it starts: what the
      launch file says, or what it had reached before it was respawned
    :param is_running: Whether its process runs, or it is loaded
    :param is_leaving: Whether its process was asked to end
    :param is_anew: Whether it starts next as the launch file says, whatever
      it had reached
    :param is_driven: Whether it is on the way to its goal
    :param request: The number of the transition that is under way
    :param since: When it was asked for the latest step on its way
    """

    owner: Process | Component
    node: str | None
    goal: str | None = None
    state: str | None = None
    is_running: bool = False
    is_leaving: bool = False
    is_anew: bool = False
    is_driven: bool = False
    request: int | None = None
    since: float = 0.0

    @property
    def label(self) -> str:
        """The label of its process or component."""
        return self.owner.label
