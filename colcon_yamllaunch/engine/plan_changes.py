# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What changes the plan of a launch that runs, and what it does that with."""

from collections.abc import Collection
from collections.abc import Mapping
from typing import Protocol
from typing import TYPE_CHECKING

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.engine.loop import Loop
from colcon_yamllaunch.engine.outcome import Outcome
from colcon_yamllaunch.plan.plan import Block

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.dispatcher import Dispatcher


class RunningLaunch(Protocol):
    """A launch that runs, to who changes it."""

    #: What the loop of the launch waits for.
    loop: Loop

    #: The launch files, groups and timers that the parts of the plan stand in.
    blocks: tuple[Block, ...]

    def groups(self) -> Mapping[str, int]:
        """Return the process groups of the processes that run, by label."""

    def renew_environment(self, variables: Mapping[str, str]) -> None:
        """Give processes that start from now on other variables."""

    @property
    def dispatcher(self) -> 'Dispatcher':
        """What executes commands."""

    @property
    def is_ended_by_others(self) -> bool:
        """Whether not only what changes the plan has asked for the end."""

    def tell(self, event: events.Event) -> None:
        """Tell everybody who listens."""

    def guard_group(self, group: int) -> None:
        """Have a process group ended with the launch, however that ends."""

    def release_group(self, group: int) -> None:
        """Take into account that nothing of a process group runs."""


class PlanChanges(Protocol):
    """
    Changes the plan of a launch that runs.

    It is told all events in order. None of its methods waits, but the last.
    """

    @property
    def pids(self) -> Collection[int]:
        """The processes that it has started, children of ours."""

    def begin(self, launch: RunningLaunch) -> None:
        """Change a launch from now on."""

    def handle(self, event: events.Event) -> None:
        """Take note of what happened."""

    @property
    def is_paused(self) -> bool:
        """Whether nothing follows from changes for the time being."""

    def pause(self) -> None:
        """Have nothing follow from changes until :meth:`resume`."""

    def resume(self) -> None:
        """Do what follows from the changes since :meth:`pause`."""

    def advance(self) -> None:
        """Do what is due."""

    def seconds_to_wait(self) -> float | None:
        """Return the seconds until :meth:`advance` is to be called again."""

    def ended(self, pid: int, outcome: Outcome) -> None:
        """Take into account that one of its processes ended."""

    def hang_up(self) -> None:
        """Do nothing more, as the launch is being stopped."""

    def close(self) -> None:
        """End all that it has started, and wait for that."""
