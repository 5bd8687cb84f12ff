# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What a launch needs of the ROS environment, and what to do without it."""

from collections.abc import Mapping
from collections.abc import Sequence
import glob
import os

from colcon_yamllaunch.plan.plan import Plan
from colcon_yamllaunch.plan.plan import Timer

#: What the Python packages are needed for; rclpy is for all of it.
_PURPOSES = {
    'composition_interfaces': 'components',
    'rcl_interfaces': 'components',
    'lifecycle_msgs': 'lifecycle nodes',
    'rosgraph_msgs': 'timers on ROS time',
}


def needed_packages(plan: Plan) -> list[str]:
    """Return the Python packages of ROS that a launch cannot do without."""
    has_components = any(True for _ in plan.components())
    needs = {
        'rclpy': True,
        'composition_interfaces': has_components,
        'rcl_interfaces': has_components,
        'lifecycle_msgs': any(p.is_lifecycle for p in plan.processes())
        or any(c.is_lifecycle for c in plan.components())
        or any(True for _ in plan.changes_of_state()),
        'rosgraph_msgs': _has_ros_timer(plan),
    }
    return [name for name, is_needed in needs.items() if is_needed]


def are_beside(
    packages: Sequence[str], python: str, environment: Mapping[str, str]
) -> bool:
    """
    Tell whether files show that a Python finds packages.

    That saves asking it. Where they do not, it may find them all the same.

    :param python: The path of the environment's Python
    """
    folders = [
        f for f in environment.get('PYTHONPATH', '').split(':') if f[:1] == '/'
    ]
    prefix = os.path.dirname(os.path.dirname(python))
    # of a virtual environment; with several versions it is open which counts
    own = glob.glob(f'{glob.escape(prefix)}/lib/python3*/site-packages')
    if len(own) == 1:
        folders += own
    return all(
        any(os.path.isfile(f'{f}/{name}/__init__.py') for f in folders)
        for name in packages
    )


def missing_packages(
    missing: Sequence[str], python: str, environment: Mapping[str, str]
) -> str:
    """
    Say what the environment lacks, and how to get it.

    :param python: The path of the environment's Python
    """
    names = ', '.join(f"'{name}'" for name in missing)
    purposes = {_PURPOSES[m]: None for m in missing if m in _PURPOSES}
    purpose = ' and '.join(purposes) or 'what it does in ROS'
    packages = 'packages' if len(missing) > 1 else 'package'
    text = (
        f'for {purpose} this launch needs the Python {packages} {names}, '
        f'which {python} does not find in the environment that was sourced. '
    )
    distribution = environment.get('ROS_DISTRO')
    dashed = [name.replace('_', '-') for name in missing]
    if distribution:
        packages = ' '.join(f'ros-{distribution}-{n}' for n in dashed)
        text += f'Install what is missing: sudo apt install {packages}'
    else:
        wheels = ' '.join(f'ros-{name}' for name in dashed if name in _WHEELS)
        source = [m for m in missing if m.replace('_', '-') not in _WHEELS]
        ways = []
        if wheels:
            ways.append(f'pip install {wheels}')
        if source:
            ways.append(f'build {" and ".join(source)} in the workspace')
        text += (
            'Source ROS 2 (source /opt/ros/DISTRO/setup.bash), or, with the '
            f'wheels: {", and ".join(ways)}'
        )
    depends = ''.join(f'<exec_depend>{m}</exec_depend>' for m in missing)
    return f'{text}. In package.xml: {depends}'


# what there is on PyPI
_WHEELS = ('rclpy', 'rcl-interfaces', 'lifecycle-msgs', 'rosgraph-msgs')


def _has_ros_timer(plan: Plan) -> bool:
    pending = list(plan.entries)
    while pending:
        entry = pending.pop()
        if isinstance(entry, Timer):
            if entry.on_ros_time:
                return True
            pending.extend(entry.entries)
    return False
