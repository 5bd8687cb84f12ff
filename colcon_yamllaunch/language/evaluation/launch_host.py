# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the walk needs of the host of launch files in Python."""

from collections.abc import Mapping
from typing import Any
from typing import Protocol

#: A message of the host or for it; see the program of the host.
HostMessage = Mapping[str, Any]


class HostError(Exception):
    """The host cannot be asked; the text says why, in one line."""


class LaunchHost(Protocol):
    """A process that reads launch files with ROS 2's own packages."""

    def send(self, message: HostMessage) -> None:
        """
        Send a message.

        :raises HostError: when there is no host, as `launch` is not there or
          it ended
        """

    def receive(self) -> HostMessage:
        """
        Wait for the next message.

        :raises HostError: when none comes in time, or the host ended
        """
