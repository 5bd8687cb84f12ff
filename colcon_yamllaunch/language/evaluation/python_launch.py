# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files in Python, which ROS 2's own launcher runs."""

import os
import shutil

from colcon_yamllaunch.language.evaluation.evaluation_state import State
from colcon_yamllaunch.language.evaluation.process_actions import (
    general_timeout,
)
from colcon_yamllaunch.language.plan.plan import DEFAULT_SIGKILL_TIMEOUT
from colcon_yamllaunch.language.plan.plan import DEFAULT_SIGTERM_TIMEOUT
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.position import Position
from colcon_yamllaunch.language.vocabulary.scope import environment_changes

#: The suffix of launch files in Python.
PYTHON_SUFFIX = '.py'
#: The program that runs them.
LAUNCHER = 'ros2'


def add_python_launch_file(
    state: State, path: str, position: Position, length: int = 1
) -> None:
    """
    Run a launch file in Python as a process of its own.

    It sees what it would see in ROS 2: the environment, all launch
    configurations of the scope, and its namespace, which ROS 2 keeps as the
    launch configuration `ros_namespace`.

    :param path: The launch file
    :param position: Where it is included, else its start
    :param length: How many characters that takes
    :raises LaunchError: if ROS 2's launcher is not there
    """
    program = shutil.which(LAUNCHER, path=_search_path(state))
    if program is None:
        raise error(
            f"a launch file in Python is run by '{LAUNCHER} launch', and "
            f"there is no '{LAUNCHER}' on the PATH",
            position,
            hint='source a ROS 2 installation that has it, or write the '
            'launch file in YAML or XML, which need none',
            length=length,
            may_pass_after_build=True,
        )
    _warn_of_lost_settings(state, position, length)
    arguments = _arguments(state, position, length)
    state.entries.append(
        Process(
            label=state.label(os.path.basename(path)),
            argv=(LAUNCHER, 'launch', path, *arguments),
            cwd=state.cwd,
            position=position,
            environment=environment_changes(
                state.environment, state.scope.environment
            ),
            sigterm_timeout=general_timeout(
                state, 'sigterm_timeout', DEFAULT_SIGTERM_TIMEOUT
            ),
            sigkill_timeout=general_timeout(
                state, 'sigkill_timeout', DEFAULT_SIGKILL_TIMEOUT
            ),
            block=state.block,
        )
    )


def _search_path(state: State) -> str:
    return state.scope.environment.get('PATH', os.defpath)


def _arguments(state: State, position: Position, length: int) -> list[str]:
    values = dict(state.scope.configurations)
    if state.scope.namespace is not None:
        values['ros_namespace'] = state.scope.namespace
    for name, value in values.items():
        if not value:
            state.warn(
                f"the launch configuration '{name}' is empty; the launch file "
                'in Python gets none, and uses its own default',
                position,
                hint=f"'{LAUNCHER} launch' takes no empty values",
                length=length,
            )
    return [f'{name}:={value}' for name, value in values.items() if value]


def _warn_of_lost_settings(
    state: State, position: Position, length: int
) -> None:
    for action, settings in (
        ('set_parameter', state.scope.parameters),
        ('set_remap', state.scope.remaps),
    ):
        if settings:
            state.warn(
                f"what '{action}' has set does not reach the nodes of a "
                'launch file in Python',
                position,
                hint='pass it as a launch argument, or write the launch file '
                'in YAML or XML',
                length=length,
            )
