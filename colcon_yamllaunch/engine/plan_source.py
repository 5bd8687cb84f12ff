# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where a plan that grows while it runs gets more from."""

from collections.abc import Iterable
from typing import Protocol

from colcon_yamllaunch.engine import events
from colcon_yamllaunch.plan.plan import Growth


class PlanSource(Protocol):
    """
    Answers what happens with more plan.

    It is told all events of the launch in order. None of its methods waits.
    """

    @property
    def descriptor(self) -> int:
        """What is readable when :meth:`take` may have something, or -1."""

    @property
    def pid(self) -> int:
        """Its process, a child of ours, or 0 when there is none any more."""

    @property
    def number(self) -> int:
        """Its number in the launch, which no process of the plan has."""

    @property
    def is_busy(self) -> bool:
        """Whether an answer is still to come: the launch waits for it."""

    @property
    def wants_output(self) -> frozenset[str]:
        """What ROS 2 calls the processes whose output it is to be told."""

    def handle(self, event: events.Event) -> None:
        """Take note of what happened."""

    def output(self, process: str, stream: events.Stream, data: bytes) -> None:
        """Take note of what a process wrote."""

    def flush(self) -> bool:
        """Send what is not sent yet; return whether all of it is."""

    def call(self, number: int) -> None:
        """Ask for what a `HostCall` stands for."""

    def take(self) -> Iterable[Growth]:
        """Return what has come, in order."""

    def ended(self, status: int) -> Iterable[Growth]:
        """Take into account that its process ended, with a wait status."""

    def close(self) -> None:
        """End it, as nothing is asked of it any more; once or more often."""
