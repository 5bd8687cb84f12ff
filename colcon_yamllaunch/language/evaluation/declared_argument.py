# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is known of a launch argument without launching."""

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.plan.position import Position


@dataclass(frozen=True, slots=True)
class DeclaredArgument:
    """
    A launch argument.

    :param name: Its name
    :param position: Where it is declared first
    :param description: What it is for, if the launch file says so
    :param default: The default as it is written, None when it is required
    :param choices: The values that it may have; empty when any
    :param is_conditional: Whether it is used only under some condition
    :param set_at: Where a launch file itself sets the value, so that one from
      the command line does not count; None when none does
    """

    name: str
    position: Position
    description: str | None = None
    default: str | None = None
    choices: tuple[str, ...] = ()
    is_conditional: bool = False
    set_at: Position | None = None
