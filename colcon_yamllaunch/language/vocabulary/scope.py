# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What an action sees of the actions before it."""

from collections.abc import Mapping
from dataclasses import dataclass
from dataclasses import field

from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.vocabulary.parameter_value import Parameter


@dataclass(slots=True)
class Scope:
    """
    The state that actions leave to those behind them.

    ROS 2 keeps the last three among the launch configurations too; here each
    has its own place, and lists are never shared between scopes.

    :param configurations: The launch configurations
    :param environment: The environment variables
    :param namespace: The namespace of nodes, absolute, if one was pushed
    :param parameters: What nodes get before their own parameters: a parameter
      or the path of a file with parameters
    :param remaps: The remappings of nodes, as from and to
    :param origins: Where each launch configuration was set, and those that its
      value was made of, nearest first
    :param failed: The launch configurations whose value could not be had
    """

    configurations: dict[str, str]
    environment: dict[str, str]
    namespace: str | None = None
    parameters: tuple[Parameter | str, ...] = ()
    remaps: tuple[tuple[str, str], ...] = ()
    origins: dict[str, tuple[Position, ...]] = field(default_factory=dict)
    failed: set[str] = field(default_factory=set)
    locals: dict[str, str] = field(default_factory=dict)

    def copy(self) -> 'Scope':
        """Return a scope that can be changed without changing this one."""
        return Scope(
            dict(self.configurations),
            dict(self.environment),
            self.namespace,
            self.parameters,
            self.remaps,
            dict(self.origins),
            self.failed,
            dict(self.locals),
        )

    def reset_configurations(self) -> None:
        """Forget what ROS 2 keeps as launch configurations."""
        self.configurations = {}
        self.origins = {}
        self.namespace = None
        self.parameters = ()
        self.remaps = ()


def environment_changes(
    before: Mapping[str, str], after: Mapping[str, str]
) -> tuple[tuple[str, str | None], ...]:
    """
    Return what makes one environment of another.

    :param before: The environment to change
    :param after: The environment that results
    :returns: The variables that differ, sorted by name; None where one is
      unset
    """
    return tuple(
        (name, after.get(name))
        for name in sorted({*before, *after})
        if before.get(name) != after.get(name)
    )
