# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The interface to a running launch, wherever it runs."""

from collections.abc import Callable
from typing import Protocol

from colcon_yamllaunch.engine.commands import Command
from colcon_yamllaunch.engine.commands import Refused
from colcon_yamllaunch.engine.commands import Response
from colcon_yamllaunch.engine.state import LaunchState


class Launch(Protocol):
    """
    A running launch: its state, and the commands that it executes.

    There are three: the engine of this process; the client of the control
    socket of another process, `control.client.RunningLaunch`; and that of a
    part on a machine, `remote.link.remote_part.RemotePart`. Events change the
    state: those of the engine go to its listeners, as do those of a part, and
    those of another process are read by `RunningLaunch.events`.
    """

    @property
    def state(self) -> LaunchState:
        """Its state, which changes with its events."""

    def ask(
        self,
        command: Command[Response],
        reply: Callable[[Response | Refused], object] = bool,
    ) -> None:
        """
        Execute a command.

        :param reply: Is called with the response, at once or later
        :raises RefusedError: when a part on a machine cannot be reached
        :raises ControlError: when another process cannot be reached
        """
