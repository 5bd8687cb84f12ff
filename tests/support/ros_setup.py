# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A ROS 2 that has `launch`, for the tests that need it.

`launch` and `launch_ros` are not among the wheels of ROS 2, so such tests run
where COLCON_LAUNCH_TEST_SETUP names a `setup.bash`: that of a ROS 2 which came
by apt, or of any prefix that has them for the Python of these tests.
"""

from dataclasses import dataclass
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys

#: Names the setup script.
VARIABLE = 'COLCON_LAUNCH_TEST_SETUP'
SKIPPED = (
    'needs `launch` of ROS 2: COLCON_LAUNCH_TEST_SETUP is to name a '
    'setup.bash that has it, such as /opt/ros/jazzy/setup.bash'
)
#: Seconds; a loaded machine needs some.
_DEADLINE = 120
_NEEDED = 'import launch, launch_ros.actions, rclpy'
#: What the shell that runs the tests may have set.
_FOREIGN = re.compile(
    r'AMENT_|CMAKE_PREFIX_PATH|COLCON|ROS_|PYTHONPATH|OVERRIDE_LAUNCH|'
    r'RMW_|RCUTILS_|_ROS_WHEELS_'
)
#: By it, the Python of the wheels knows that it has seen to the libraries.
_WHEELS_DONE = '_ROS_WHEELS_BOOTSTRAP_COMPLETE'


@dataclass(frozen=True)
class RosSetup:
    """
    A ROS 2 with `launch`.

    :param environment: What a shell has that sourced it, and in which the
      installed `colcon` is found
    """

    environment: dict[str, str]

    @property
    def python(self) -> str:
        """The Python that can import `launch`."""
        python = shutil.which('python3', path=self.environment['PATH'])
        assert python is not None
        return python


def read_setup(folder: Path) -> RosSetup | None:
    """
    Source what the variable names; return None when it names nothing.

    :param folder: A folder for what is to be found in `PATH`
    :raises AssertionError: when there is no `launch` in it
    """
    script = os.environ.get(VARIABLE)
    if not script:
        return None
    programs = Path(sys.executable).parent
    # Where the system's Python has `launch`, it is to be the one that is
    # found, and the libraries of the wheels must not mix with its own.
    link = folder / 'colcon'
    link.symlink_to(programs / 'colcon')
    environment = _sourced(script, folder) | {_WHEELS_DONE: '1'}
    if _has_launch(environment):
        return RosSetup(environment)
    environment = _sourced(script, programs)
    assert _has_launch(environment), (
        f'no python3 can import `launch`, `launch_ros` and `rclpy` where '
        f'{script} is sourced, which {VARIABLE} names'
    )
    return RosSetup(environment)


def variables_after(
    script: str | Path, environment: dict[str, str]
) -> dict[str, str]:
    """Return the variables of a shell after it has sourced a script."""
    printed = subprocess.run(
        ['bash', '-c', '. "$1" >/dev/null && exec env -0', 'bash', script],
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
        timeout=_DEADLINE,
        check=True,
    ).stdout
    pairs = (line.partition('=') for line in printed.split('\0') if line)
    return {name: value for name, _, value in pairs if name != '_'}


def _sourced(script: str, programs: Path) -> dict[str, str]:
    """Return the variables of a shell that sources a script."""
    environment = {
        k: v for k, v in os.environ.items() if not _FOREIGN.match(k)
    }
    if _WHEELS_DONE in os.environ:
        # it was set on the way to this process
        environment.pop('LD_LIBRARY_PATH', None)
    venv = Path(sys.prefix, 'bin')
    path = [
        p for p in environment['PATH'].split(os.pathsep) if Path(p) != venv
    ]
    environment.pop('VIRTUAL_ENV', None)
    environment['PATH'] = os.pathsep.join([str(programs), *path])
    found = variables_after(script, environment)
    # the script may have put its own in front
    found['PATH'] = os.pathsep.join([str(programs), found['PATH']])
    return found


def _has_launch(environment: dict[str, str]) -> bool:
    ended = subprocess.run(
        ['python3', '-c', _NEEDED],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=_DEADLINE,
        check=False,
    )
    return ended.returncode == 0
