# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the walk needs of the host of launch files in Python."""

from collections.abc import Mapping
from typing import Any
from typing import Protocol

from colcon_yamllaunch.plan.plan import Growth

#: A message of the host or for it; see the program of the host.
WorkerMessage = Mapping[str, Any]


class WorkerError(Exception):
    """The host cannot be asked; the text says what became of it."""


class NoWorkerError(WorkerError):
    """There is no host, as the environment does not have what it needs."""


class WorkerTimeoutError(WorkerError):
    """The host does not answer; the text says for how long."""


class LaunchWorker(Protocol):
    """A process that reads launch files with ROS 2's own packages."""

    def send(self, message: WorkerMessage) -> None:
        """
        Send a message.

        :raises WorkerError: when there is none, or it ended
        """

    def receive(self) -> WorkerMessage:
        """
        Wait for the next message.

        :raises WorkerTimeoutError: when none comes in time
        :raises WorkerError: when the host ended
        """

    def doing(self) -> WorkerMessage:
        """Return what the host is doing, a message `where`, and end it."""


class Growing(Protocol):
    """
    Goes on turning what the host says into plan while the plan runs.

    It says nothing by itself: whoever has the link to the host passes events
    on by :meth:`ask`, and what comes by :meth:`take`, one by one and in order.
    """

    @property
    def has_handlers(self) -> bool:
        """Whether there are event handlers now."""

    @property
    def wants_output(self) -> frozenset[str]:
        """What ROS 2 calls the processes whose output the host wants."""

    @property
    def is_busy(self) -> bool:
        """Whether the end of an answer is still to come."""

    def id_of(self, name: str) -> int | None:
        """
        Return the number by which the host knows a process.

        :param name: Its `ros_name`; None is returned for one that the host
          has nothing to do with, as of a YAML file
        """

    def ask(self, request: WorkerMessage) -> None:
        """
        Send a request, `event` or `call`, without its number.

        :raises WorkerError: when there is no host any more
        """

    def take(self, message: WorkerMessage) -> Growth | None:
        """
        Take what the host said, and return what comes of a whole answer.

        It waits for the host only where a YAML or XML file that is included
        now includes one in Python: then it receives by itself.

        :return: With `done`, what comes to the plan, which may be nothing;
          else None
        :raises WorkerError: when there is no host any more
        """

    def lost(self, reason: str) -> Growth:
        """
        Take into account that the host ended.

        What it had said of an answer that has no end counts. There are no
        handlers any more, and nothing is awaited.

        :param reason: What became of it, as a line; empty if it was to end
        """
