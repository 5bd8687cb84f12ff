# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Stands for what asks the host of launch files in Python."""

from colcon_yamllaunch.language.evaluation.launch_host import HostMessage
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.position import Span


def ask_host(walk: Walk, request: HostMessage, origin: Span) -> str | None:
    """
    Ask the host for something in the scope that there is, and do what it says.

    :raises LaunchError: always
    """
    raise error(f'{walk.cwd}: nothing can do {request["do"]} yet', origin)
