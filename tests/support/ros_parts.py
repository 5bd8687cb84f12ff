# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
An underlay with component containers, as no wheels of ROS 2 have them.

`composition_interfaces` and `tf2_msgs` are built by colcon with the real
generators of messages. A container (`rclcpp_components/component_container`)
and components to load into it (`composition`) are in Python, so they are just
copied. What they can do wrong stands in their files, in
`ros_parts/prefix/lib`.
"""

import fcntl
import os
from pathlib import Path
import shutil
import subprocess
import sys

from support.ros_setup import variables_after
from support.user import User

PARTS = Path(__file__).with_name('ros_parts')
#: What is found by name: `component_container` also as these.
OTHER_NAMES = ('component_container_mt', 'component_container_isolated')
#: Seconds; some ten are usual.
DEADLINE = 600
#: What the shell that runs the tests may have sourced.
SOURCED = (
    'AMENT_PREFIX_PATH',
    'CMAKE_PREFIX_PATH',
    'COLCON_PREFIX_PATH',
    'PYTHONPATH',
)


def plain_environment() -> dict[str, str]:
    """Return this process's environment with nothing sourced in it."""
    kept = {k: v for k, v in os.environ.items() if k not in SOURCED}
    programs = str(Path(sys.executable).parent)
    return kept | {'PATH': os.pathsep.join([programs, kept['PATH']])}


def build_once(folder: Path) -> Path:
    """
    Build the underlay, unless another process has done it or does it.

    :param folder: The folder that all these processes share
    :returns: its install space, with all packages in one prefix
    """
    root = folder / 'ros_parts'
    done = folder / 'ros_parts_done'
    with (folder / 'ros_parts_lock').open('w') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            shutil.rmtree(root, ignore_errors=True)
            _build(root)
            done.touch()
    return root / 'install'


def sourced(install: Path) -> dict[str, str]:
    """Return the environment that the underlay's setup script makes."""
    return variables_after(install / 'setup.bash', plain_environment())


def source_for(user: User, install: Path, domain_id: int) -> None:
    """
    Have a user source the underlay, and see no launches of others.

    :param domain_id: The `ROS_DOMAIN_ID` of all nodes of the user
    """
    user.environment |= sourced(install) | {
        'HOME': user.environment['HOME'],
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_DOMAIN_ID': str(domain_id),
        'TMPDIR': str(user.root.parent),
    }


def _build(root: Path) -> None:
    for name in ('composition_interfaces', 'tf2_msgs'):
        shutil.copytree(PARTS / name, root / 'src' / name)
    # the generators look each other up in the index of the wheels
    environment = plain_environment() | {'AMENT_PREFIX_PATH': sys.prefix}
    built = subprocess.run(
        ['colcon', 'build', '--merge-install'],
        cwd=root,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=DEADLINE,
        check=False,
    )
    assert built.returncode == 0, built.stdout
    install = root / 'install'
    shutil.copytree(PARTS / 'prefix', install, dirs_exist_ok=True)
    programs = install / 'lib/rclcpp_components'
    for name in OTHER_NAMES:
        (programs / name).symlink_to('component_container')
