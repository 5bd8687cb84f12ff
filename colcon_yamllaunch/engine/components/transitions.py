# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The transitions of lifecycle nodes (ROS 2 design, "Managed nodes")."""

from collections.abc import Mapping

from colcon_yamllaunch.common.frozen import dataclass


@dataclass(frozen=True, slots=True)
class Transition:
    """
    A transition.

    :param starts: The states that have it
    :param goal: The state that it leads to when it succeeds
    """

    starts: tuple[str, ...]
    goal: str


#: The transitions that may be asked for.
TRANSITIONS: Mapping[str, Transition] = {
    'configure': Transition(('unconfigured',), 'inactive'),
    'activate': Transition(('inactive',), 'active'),
    'deactivate': Transition(('active',), 'inactive'),
    'cleanup': Transition(('inactive',), 'unconfigured'),
    'shutdown': Transition(
        ('unconfigured', 'inactive', 'active'), 'finalized'
    ),
}


def transitions_of(state: str | None) -> list[str]:
    """Return the transitions that a state has."""
    return [n for n, known in TRANSITIONS.items() if state in known.starts]
