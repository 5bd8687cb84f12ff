# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What actions leave to those behind them, on its way in and out."""

from __future__ import annotations

import importlib
import os
from typing import Any

from .channel import Json
from .descriptions import as_json

#: What launch_ros keeps among the launch configurations.
NAMESPACE = 'ros_namespace'
PARAMETERS = 'global_params'
REMAPS = 'ros_remaps'
#: The variable with which `launch` counts processes.
_COUNTER = '_executable_process_counter'


class Scopes:
    """
    Puts scopes into the context of `launch`, and reads them from there.

    :param context: The launch context
    """

    def __init__(self, context: Any) -> None:
        self._context = context
        self._environment = dict(os.environ)
        #: Whether SetUseSimTime said so; ROS 2 has one for the whole launch.
        self.uses_sim_time = False

    def enter(self, scope: Json) -> None:
        """Let the context be in a scope."""
        configurations = self._context.launch_configurations
        others = {
            name: value
            for name, value in configurations.items()
            if not isinstance(value, str)
            and name not in (NAMESPACE, PARAMETERS, REMAPS)
        }
        configurations.clear()
        configurations.update(others)
        configurations.update(scope.get('configurations') or {})
        if scope.get('namespace') is not None:
            configurations[NAMESPACE] = scope['namespace']
        if scope.get('parameters'):
            configurations[PARAMETERS] = [
                one['file'] if 'file' in one else (one['name'], one['value'])
                for one in scope['parameters']
            ]
        if scope.get('remaps'):
            configurations[REMAPS] = [(a, b) for a, b in scope['remaps']]
        self.uses_sim_time = bool(scope.get('uses_sim_time'))
        if 'processes' in scope:
            # ROS 2 counts all processes of a launch
            _counter().__dict__[_COUNTER] = scope['processes']
        wanted = dict(self._environment)
        for name, value in (scope.get('environment') or {}).items():
            if value is None:
                wanted.pop(name, None)
            else:
                wanted[name] = value
        set_environment(wanted)

    def restore(self) -> None:
        """Let the environment be that of this program again."""
        set_environment(self._environment)

    def current(self) -> Json:
        """Return the scope that the context is in."""
        configurations = self._context.launch_configurations
        return {
            'configurations': {
                name: value
                for name, value in configurations.items()
                if isinstance(name, str)
                and isinstance(value, str)
                and name != NAMESPACE
            },
            'environment': self.changes(os.environ),
            'namespace': configurations.get(NAMESPACE),
            'parameters': [
                {'name': str(one[0]), 'value': as_json(one[1])}
                if isinstance(one, tuple)
                else {'file': os.path.abspath(one)}
                for one in configurations.get(PARAMETERS) or ()
            ],
            'remaps': [
                [str(old), str(new)]
                for old, new in configurations.get(REMAPS) or ()
            ],
            'uses_sim_time': self.uses_sim_time,
        }

    def changes(self, variables: Any) -> Json:
        """Return the variables that differ from those of this program."""
        changed: Json = {
            name: value
            for name, value in variables.items()
            if self._environment.get(name) != value
        }
        for name in self._environment:
            if name not in variables:
                changed[name] = None
        return changed


def _counter() -> Any:
    return importlib.import_module('launch.descriptions.executable')


def set_environment(wanted: dict[str, str]) -> None:
    """Let the environment variables be others."""
    for name in set(os.environ) - set(wanted):
        del os.environ[name]
    for name, value in wanted.items():
        if os.environ.get(name) != value:
            os.environ[name] = value
