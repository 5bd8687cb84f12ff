# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Launch files in Python.

The host reads them, and what is in them becomes a part of the plan. What it
cannot take over, and all where there is no host, ROS 2's own launcher runs.
"""

import os
import shutil

from colcon_yamllaunch.language.actions.process_actions import general_timeout
from colcon_yamllaunch.language.evaluation.scope import environment_changes
from colcon_yamllaunch.language.evaluation.walk import Walk
from colcon_yamllaunch.language.python_files.python_visit import ask_worker
from colcon_yamllaunch.language.python_files.python_visit import (
    NotTakenOverError,
)
from colcon_yamllaunch.language.python_files.python_visit import (
    visit_in_python,
)
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.plan.plan import DEFAULT_SIGKILL_TIMEOUT
from colcon_yamllaunch.plan.plan import DEFAULT_SIGTERM_TIMEOUT
from colcon_yamllaunch.plan.plan import Process
from colcon_yamllaunch.plan.position import Span

__all__ = ['add_python_launch', 'ask_worker', 'launch_in_python']

#: The program that runs them.
LAUNCHER = 'ros2'
#: The package that has it, which a workspace with all of ROS 2 builds.
LAUNCHER_PACKAGE = 'ros2cli'


def launch_in_python(walk: Walk, path: str, origin: Span) -> bool:
    """
    Do what a launch file in Python says, or else have ROS 2's launcher run it.

    Return whether it is a part of the plan.

    :param path: The launch file
    :param origin: Where it is included, else its start
    :raises LaunchError: when the launch cannot go on
    """
    draft, findings = walk.draft.snapshot(), walk.snapshot()
    try:
        visit_in_python(walk, 'visit', path, origin)
    except NotTakenOverError as e:
        walk.draft.restore(draft)
        walk.restore(findings)
        if e.reason is not None:
            name = os.path.basename(path)
            walk.warn(
                f"'{name}' is run by '{LAUNCHER} launch', as one process: "
                f'{e.reason}',
                origin,
            )
        walk.may_have_others = True
        add_python_launch(walk, path, origin)
        return False
    return True


def add_python_launch(walk: Walk, path: str, origin: Span) -> None:
    """
    Run a launch file in Python as a process of its own.

    It sees what it would see in ROS 2: the environment, all launch
    configurations of the scope, and its namespace, which ROS 2 keeps as the
    launch configuration `ros_namespace`.

    :param path: The launch file
    :param origin: Where it is included, else its start
    :raises LaunchError: when ROS 2's launcher is not there
    """
    program = shutil.which(LAUNCHER, path=walk.search_path())
    if program is None:
        raise error(
            f"a launch file in Python is run by '{LAUNCHER} launch', and "
            f"there is no '{LAUNCHER}' on the PATH",
            origin,
            hint='source a ROS 2 installation that has it, or write the '
            'launch file in YAML or XML, which need none',
            may_pass_after_build=LAUNCHER_PACKAGE in walk.packages.names(),
        )
    _warn_of_lost_changes(walk, origin)
    arguments = _arguments(walk, origin)
    name = walk.draft.process_name(os.path.basename(path))
    walk.draft.entries.append(
        Process(
            label=name,
            argv=(LAUNCHER, 'launch', path, *arguments),
            cwd=walk.cwd,
            position=origin.position,
            name=name,
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


def _arguments(walk: Walk, origin: Span) -> list[str]:
    values = walk.scope.configurations.all()
    if walk.scope.namespace is not None:
        values['ros_namespace'] = walk.scope.namespace
    for name, value in values.items():
        if value.text == '':
            walk.warn(
                f"the launch configuration '{name}' is empty; the launch file "
                'in Python gets none, and uses its own default',
                origin,
                f"'{LAUNCHER} launch' takes no empty values",
            )
    return [f'{n}:={value.text}' for n, value in values.items() if value.text]


def _warn_of_lost_changes(walk: Walk, origin: Span) -> None:
    for action, changes in (
        ('set_parameter', walk.scope.parameters),
        ('set_remap', walk.scope.remaps),
    ):
        if changes:
            walk.warn(
                f"what '{action}' has set does not reach the nodes of a "
                f"launch file in Python that '{LAUNCHER} launch' runs",
                origin,
                'pass it as a launch argument, or write the launch file '
                'in YAML or XML',
            )
