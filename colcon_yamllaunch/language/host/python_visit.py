# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Stands for what asks the host of launch files in Python."""

from colcon_yamllaunch.language.evaluation.launch_host import HostMessage
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.syntax.position import Span


class NotTakenOverError(Exception):
    """
    Something cannot be a part of the plan.

    :param reason: Why, or None when there is no host
    """

    def __init__(self, reason: str | None) -> None:
        super().__init__()
        self.reason = reason


def ask_host(walk: Walk, request: HostMessage, origin: Span) -> str | None:
    """
    Ask the host for something in the scope that there is, and do what it says.

    :raises NotTakenOverError: always
    """
    del walk, request, origin
    raise NotTakenOverError(None)
