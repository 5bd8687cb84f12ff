# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files in Python, which ROS 2's own launcher runs."""

import os
import shutil

from colcon_yamllaunch.language.actions.process_actions import general_timeout
from colcon_yamllaunch.language.evaluation.scope import environment_changes
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.plan.plan import DEFAULT_SIGKILL_TIMEOUT
from colcon_yamllaunch.language.plan.plan import DEFAULT_SIGTERM_TIMEOUT
from colcon_yamllaunch.language.plan.plan import Process
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.position import Position

#: The program that runs them.
LAUNCHER = 'ros2'


def add_python_launch_file(
    walk: Walk, path: str, position: Position, length: int = 1
) -> None:
    """
    Run a launch file in Python as a process of its own.

    It sees what it would see in ROS 2: the environment, all launch
    configurations of the scope, and its namespace, which ROS 2 keeps as the
    launch configuration `ros_namespace`.

    :param path: The launch file
    :param position: Where it is included, else its start
    :param length: How many characters that takes
    :raises LaunchError: when ROS 2's launcher is not there
    """
    program = shutil.which(LAUNCHER, path=walk.search_path())
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
    _warn_of_lost_changes(walk, position, length)
    arguments = _arguments(walk, position, length)
    walk.draft.entries.append(
        Process(
            label=walk.draft.label(os.path.basename(path)),
            argv=(LAUNCHER, 'launch', path, *arguments),
            cwd=walk.cwd,
            position=position,
            environment=environment_changes(
                walk.environment, walk.scope.environment
            ),
            sigterm_timeout=general_timeout(
                walk, 'sigterm_timeout', DEFAULT_SIGTERM_TIMEOUT
            ),
            sigkill_timeout=general_timeout(
                walk, 'sigkill_timeout', DEFAULT_SIGKILL_TIMEOUT
            ),
            block=walk.draft.block,
        )
    )


def _arguments(walk: Walk, position: Position, length: int) -> list[str]:
    values = walk.scope.configurations.all()
    if walk.scope.namespace is not None:
        values['ros_namespace'] = walk.scope.namespace
    for name, value in values.items():
        if value.text == '':
            walk.warn(
                f"the launch configuration '{name}' is empty; the launch file "
                'in Python gets none, and uses its own default',
                position,
                hint=f"'{LAUNCHER} launch' takes no empty values",
                length=length,
            )
    return [f'{n}:={value.text}' for n, value in values.items() if value.text]


def _warn_of_lost_changes(walk: Walk, position: Position, length: int) -> None:
    for action, changes in (
        ('set_parameter', walk.scope.parameters),
        ('set_remap', walk.scope.remaps),
    ):
        if changes:
            walk.warn(
                f"what '{action}' has set does not reach the nodes of a "
                'launch file in Python',
                position,
                hint='pass it as a launch argument, or write the launch file '
                'in YAML or XML',
                length=length,
            )
