# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The process of `ros_client`, and the pipes to it.

It runs with the Python of the sourced environment, which may be another than
ours. Messages are JSON objects, one a line.
"""

from collections.abc import Mapping, Sequence
import glob
import os
from pathlib import Path
from typing import Any, TYPE_CHECKING

from colcon_yamllaunch.engine import events, limits
from colcon_yamllaunch.engine.composition import Composition
from colcon_yamllaunch.engine.helper_process import HelperProcess, pythons
from colcon_yamllaunch.plan.plan import Plan

if TYPE_CHECKING:
    from colcon_yamllaunch.engine.engine import Engine, EngineSettings

#: The program; it imports nothing of this package.
PROGRAM = Path(__file__).with_name('ros_client.py')

#: The features that need the Python packages; all need rclpy.
_PURPOSES = {
    'composition_interfaces': 'components',
    'rcl_interfaces': 'parameters',
    'lifecycle_msgs': 'lifecycle nodes',
    'rosgraph_msgs': 'timers on ROS time',
    'tf2_msgs': 'transforms',
}
_READINESS = 'the readiness of processes'
_ANYTHING = 'what it does in ROS'
#: Packages on PyPI.
_WHEELS = ('rclpy', 'rcl-interfaces', 'lifecycle-msgs', 'rosgraph-msgs')


class RosLink:
    """
    The client process of a launch.

    :param engine: Starts it as a process of the launch
    """

    def __init__(
        self, plan: Plan, engine: 'Engine', settings: 'EngineSettings'
    ) -> None:
        self._engine = engine
        self._environment = settings.environment
        self._process = HelperProcess(
            engine.loop,
            self._spawn,
            self._handle,
            self._lost,
            settings.client_log,
        )
        self._packages = needed_packages(plan)
        self._has_conditions = any(True for _ in plan.ros_conditions())
        self._pythons = pythons(self._environment.get('PATH', os.defpath))
        self._python = self._first_found = 0
        #: The components and lifecycle nodes of the launch.
        self.composition = Composition(
            plan, self._process.send, engine.emit, engine.loop, engine.state
        )
        #: Whether the environment has the needed packages.
        self.is_found = are_beside(
            self._packages, self._pythons[0], self._environment
        )
        # whether a client confirmed that
        self._is_sure = False
        # of the first Python
        self._missing: list[str] | None = None
        #: Why no launch is possible in this environment, if any reason.
        self.error: str | None = None

    def expect(self, more: Plan) -> None:
        """
        Add the needs of more entries, from the next start on.

        As the launch runs already, it goes on if the environment lacks them.
        """
        needed = dict.fromkeys([*self._packages, *needed_packages(more)])
        self._packages = list(needed)
        self._has_conditions |= any(True for _ in more.ros_conditions())
        self.is_found = True

    def start(self) -> None:
        """Start the client, without waiting until it is ready."""
        self._process.start()

    def hang_up(self) -> None:
        """End the client, as no requests follow."""
        self._process.stop()

    def close(self) -> None:
        """End the client, at the latest after a moment."""
        group = self._process.pid
        self._process.close(limits.CLIENT_END_TIMEOUT)
        if group:
            self._engine.release_group(group)

    def _spawn(self, streams: tuple[int, int, int]) -> int:
        python = self._pythons[self._python]
        words = [python, str(PROGRAM), *self._packages]
        return self._engine.start_client_program(words, streams)

    def _lost(self, ending: str, was_killed: bool) -> None:
        """
        Handle that there is no client; start another one, or give up.

        :param was_killed: Whether a signal ended it, so that its Python may
          be right all the same
        """
        if self.error is not None:
            return
        was_ready = self.composition.has_client
        self.composition.client_died()
        is_last = self._python + 1 == len(self._pythons)
        if not (was_ready or was_killed or is_last):
            # another Python may find what this one cannot import
            self._python += 1
            self._process.restart_now()
            return
        if not was_ready and not was_killed:
            self._python = self._first_found
        if not self.is_found:
            self.error = f'the ROS client {ending}{self._last_words()}'
            return
        if not self._process.restart_later():
            self.composition.client_given_up(
                f'the ROS client ended {self._process.ends} times, at last '
                f'it {ending}{self._last_words()}'
            )
            return
        text = f'the ROS client {ending}, and is started again'
        self._engine.emit(events.Warned(text))

    def _last_words(self) -> str:
        last = self._process.last_line()
        return f': {last}' if last else ''

    def _handle(self, message: dict[str, Any]) -> None:
        """Handle a message of the client."""
        match message:
            case {'event': 'found', 'missing': [*missing]}:
                self._found([str(name) for name in missing])
            case _:
                self.composition.handle(message)

    def _found(self, missing: list[str]) -> None:
        if not missing:
            if not self._is_sure:
                self._first_found = self._python
            self.is_found = self._is_sure = True
            return
        if self._missing is None:
            # the first Python matters most
            self._missing = missing
        is_last = self._python + 1 == len(self._pythons)
        if is_last and not self._is_sure:
            self.error = missing_packages(
                self._missing,
                self._pythons[0],
                self._environment,
                _READINESS if self._has_conditions else _ANYTHING,
            )
            if self.is_found:
                # the launch began, as the files looked complete
                self.composition.client_given_up(self.error)


def needed_packages(plan: Plan) -> list[str]:
    """Return the Python packages of ROS that a launch needs."""
    has_components = any(True for _ in plan.components())
    conditions = {condition.kind for condition in plan.ros_conditions()}
    needs = {
        'rclpy': True,
        'composition_interfaces': has_components,
        'rcl_interfaces': has_components or 'parameter' in conditions,
        'lifecycle_msgs': any(p.is_lifecycle for p in plan.processes())
        or any(c.is_lifecycle for c in plan.components())
        or any(True for _ in plan.changes_of_state())
        or 'lifecycle' in conditions,
        'rosgraph_msgs': plan.has_ros_timer,
        'tf2_msgs': 'transform' in conditions,
    }
    return [name for name, is_needed in needs.items() if is_needed]


def are_beside(
    packages: Sequence[str], python: str, environment: Mapping[str, str]
) -> bool:
    """
    Return whether files show that a Python finds packages.

    That is faster than asking it. If False, it may find them all the same.

    :param python: The path of the environment's Python
    """
    folders = [
        f for f in environment.get('PYTHONPATH', '').split(':') if f[:1] == '/'
    ]
    prefix = os.path.dirname(os.path.dirname(python))
    # of a virtual environment; it is unclear which of several versions counts
    own = glob.glob(f'{glob.escape(prefix)}/lib/python3*/site-packages')
    if len(own) == 1:
        folders += own
    return all(
        any(os.path.isfile(f'{f}/{name}/__init__.py') for f in folders)
        for name in packages
    )


def missing_packages(
    missing: Sequence[str],
    python: str,
    environment: Mapping[str, str],
    default: str = _ANYTHING,
) -> str:
    """
    Return an error about missing packages, with the fix.

    :param python: The path of the environment's Python
    :param default: What needs those that all uses need
    """
    names = ', '.join(f"'{name}'" for name in missing)
    purposes = {_PURPOSES[m]: None for m in missing if m in _PURPOSES}
    purpose = ' and '.join(purposes) or default
    noun = 'packages' if len(missing) > 1 else 'package'
    text = (
        f'for {purpose} this launch needs the Python {noun} {names}, '
        f'which {python} does not find in the environment that was sourced. '
    )
    distribution = environment.get('ROS_DISTRO')
    dashed = [name.replace('_', '-') for name in missing]
    if distribution:
        from colcon_yamllaunch.common.suggestions import on_debian

        packages = [f'ros-{distribution}-{name}' for name in dashed]
        text += f'Install what is missing, {on_debian(*packages)}'
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
