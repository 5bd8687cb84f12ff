# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What has become of each component of a plan."""

from dataclasses import dataclass
from typing import Literal

from colcon_yamllaunch.engine.components.lifecycle_task import LifecycleTask
from colcon_yamllaunch.plan.plan import Component

#: `waiting` for its turn, its timer or its container; being loaded; loaded;
#: being unloaded on request; `unloaded` on request or with its container; or
#: `failed`, as it could not be loaded.
LoadPhase = Literal[
    'waiting', 'loading', 'loaded', 'unloading', 'unloaded', 'failed'
]


@dataclass(slots=True)
class ComponentTask:
    """
    A component of the plan in the course of a launch.

    :param number: Its number among the components of the plan
    :param since: When its phase began, by the clock of the composition
    :param lifecycle: The course of its states, if it is a lifecycle node
    :param unique_id: The number that its container knows it by while it is
      loaded
    :param full_name: The full name of its node, as its container told
    :param ending: Why it is not loaded, as a part of a sentence
    :param is_due: Whether its turn has come
    :param is_wanted: Whether it is to be loaded again with its container,
      as nobody asked to unload it
    :param is_again: Whether it is to be loaded again once it is unloaded
    :param request: The number of the load or unload that is under way
    :param was_sent: Whether a client that died had been asked to load it
    :param successor: What it is when it is loaded next, if something else
    """

    number: int
    component: Component
    since: float
    lifecycle: LifecycleTask | None = None
    phase: LoadPhase = 'waiting'
    unique_id: int | None = None
    full_name: str | None = None
    ending: str = ''
    is_due: bool = False
    is_wanted: bool = True
    is_again: bool = False
    request: int | None = None
    was_sent: bool = False
    successor: Component | None = None

    @property
    def label(self) -> str:
        """Its name in output and logs."""
        return self.component.label

    @property
    def state(self) -> str | None:
        """Its lifecycle state, as `active`, if it has one."""
        return None if self.lifecycle is None else self.lifecycle.state

    @property
    def is_open(self) -> bool:
        """Whether it is still to be loaded."""
        return (
            self.is_due
            and self.is_wanted
            and self.unique_id is None
            and self.phase in ('waiting', 'loading')
        )
