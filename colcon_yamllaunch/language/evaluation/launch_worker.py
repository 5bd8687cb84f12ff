# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The worker for Python launch files, as the walk sees it."""

from collections.abc import Mapping
from typing import Any, Protocol

#: A message of the worker or for it; see `python_launch/worker/channel.py`.
WorkerMessage = Mapping[str, Any]


class WorkerError(Exception):
    """The worker cannot answer; the text says what became of it."""


class NoWorkerError(WorkerError):
    """There is no worker, as the environment lacks what it needs."""


class WorkerTimeoutError(WorkerError):
    """The worker does not answer; the text says for how long."""


class LaunchWorker(Protocol):
    """A process that reads launch files with ROS 2's own packages."""

    def send(self, message: WorkerMessage) -> None:
        """
        Send a message.

        :raises WorkerError: when there is none, or it has ended
        """

    def receive(self) -> WorkerMessage:
        """
        Wait for the next message.

        :raises WorkerTimeoutError: when none comes in time
        :raises WorkerError: when the worker has ended
        """

    def doing(self) -> WorkerMessage:
        """Return what the worker is doing, a message `where`, and end it."""
