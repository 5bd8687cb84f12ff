# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A running launch at one moment, as its server describes it."""

from collections.abc import Iterator
from collections.abc import Mapping
from dataclasses import fields
from dataclasses import MISSING
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.control.protocol import ProtocolError

#: The state of a lifecycle node that has not told it (lifecycle_msgs/State).
UNKNOWN = 'unknown'


@dataclass(frozen=True, slots=True)
class About:
    """
    What a launch is known by.

    :param title: What was launched, as the user called it
    :param package: The package that was named, if one was
    :param file: The path of the launch file
    :param folder: Where the user was
    """

    title: str
    package: str | None
    file: str
    folder: str


@dataclass(frozen=True, slots=True)
class ProcessState:
    """
    A process of a launch.

    :param label: Its name in output and logs
    :param phase: `waiting`, `running`, `stopping`, `respawn`, `ended` or, on
      a machine that nothing is heard of, `unknown`, see
      `tasks.Phase`
    :param pid: Its process id, which is that of its group, while it runs
    :param seconds: For how long it has been running, or ended
    :param restarts: How often it has been started again
    :param ending: How it ended, as a part of a sentence; empty while it runs
    :param executable: The name of its program
    :param node: The full name of its ROS node as far as it is known
    :param package: The package that the program belongs to, if any
    :param log: The path of the log with all of its output, if it has one
    :param terminal: Whether keys can be typed at it now
    :param name: What ROS 2 calls it, its program and number, as
      `talker.py-2`; None where that is not known
    :param lifecycle: The state of its lifecycle node, such as `active`;
      `unknown` until that is heard of, None for any other process
    :param machine: The name of the machine that it runs on, where its process
      id is one, or None for this one
    :param cpu: The share of one processor that it takes there, 1.0 for all of
      it, as far as that is known; None for one that runs here
    :param memory: Its memory there in bytes, likewise
    """

    label: str
    phase: str
    pid: int | None
    seconds: float
    restarts: int
    ending: str
    executable: str
    node: str | None
    package: str | None
    log: str | None
    terminal: bool
    name: str | None = None
    lifecycle: str | None = None
    machine: str | None = None
    cpu: float | None = None
    memory: int | None = None

    @property
    def local_pid(self) -> int | None:
        """Its process id, if it runs on this machine."""
        return self.pid if self.machine is None else None


@dataclass(frozen=True, slots=True)
class ComponentState:
    """
    A component of a launch.

    :param label: Its name in output and logs
    :param phase: `waiting`, `loading`, `loaded`, `unloading`, `unloaded`,
      `failed` or `unknown`, see `component_task.LoadPhase`
    :param seconds: For how long that has been so
    :param ending: Why it could not be loaded or unloaded; empty otherwise
    :param plugin: The class of its node
    :param node: The full name of its node as far as it is known
    :param package: The package that has the plugin
    :param container: The full name of the node of its container
    :param process: The label of the container, None where that is not one of
      the launch's processes
    :param log: The path of the container's log, if it has one
    :param lifecycle: As that of a process
    :param machine: The name of the machine that it is on, None for this one
    """

    label: str
    phase: str
    seconds: float
    ending: str
    plugin: str
    node: str | None
    package: str
    container: str
    process: str | None
    log: str | None
    lifecycle: str | None
    machine: str | None = None


@dataclass(frozen=True, slots=True)
class MachineState:
    """
    A machine that parts of a launch run on.

    :param link: `up`, `lost` while nothing is heard of it, `gone` when that
      is for good, `done` when its part has ended
    :param reason: Why it is lost or gone, as a part of a sentence; or empty
    """

    name: str
    link: str
    reason: str = ''


#: What a launch consists of, and what has a name.
Part = ProcessState | ComponentState


@dataclass(frozen=True, slots=True)
class LaunchState(About):
    """
    A launch.

    :param pid: The process id of the launcher
    :param seconds: For how long it has been running
    :param stopping: Whether everything is being stopped
    :param log_folder: The folder with its logs, if it writes any
    :param processes: Its processes, in the order of the plan
    :param components: Its components, likewise
    :param watch: What came of the last change, if it goes on with its files
      (`--watch`); empty before the first one
    :param watch_failed: Whether that failed
    :param watch_paused: Whether nothing follows from changes for the time
      being
    :param machines: The machines that parts of it run on, besides this one
    """

    pid: int
    seconds: float
    stopping: bool
    log_folder: str | None
    processes: tuple[ProcessState, ...]
    components: tuple[ComponentState, ...] = ()
    watch: str | None = None
    watch_failed: bool = False
    watch_paused: bool = False
    machines: tuple[MachineState, ...] = ()

    def parts(self) -> Iterator[Part]:
        """Iterate over all that has a name, components below containers."""
        for process in self.processes:
            yield process
            yield from self.components_of(process.label)
        yield from self.components_of(None)

    def components_of(self, process: str | None) -> Iterator[ComponentState]:
        """
        Iterate over the components of a container.

        :param process: Its label; None for containers of others
        """
        return (c for c in self.components if c.process == process)


def from_json(data: object) -> LaunchState:
    """
    Read a launch from a JSON object with the names of its attributes.

    What is not known here is left out. What came with a later version may
    be missing.

    :raises ProtocolError: when something is missing
    """
    try:
        launch = _known(LaunchState, data)
        launch['processes'] = tuple(
            ProcessState(**_known(ProcessState, p))
            for p in launch['processes']
        )
        launch['components'] = tuple(
            ComponentState(**_known(ComponentState, c))
            for c in launch.get('components', ())
        )
        launch['machines'] = tuple(
            MachineState(**_known(MachineState, m))
            for m in launch.get('machines', ())
        )
        return LaunchState(**launch)
    except (AttributeError, KeyError, TypeError) as error:
        raise ProtocolError('the launch is not described in full') from error


def _known(kind: type[Any], data: object) -> dict[str, Any]:
    if not isinstance(data, Mapping):
        raise TypeError
    return {
        f.name: data[f.name]
        for f in fields(kind)
        # what has a default came later than others: who wrote the data may
        # not know it
        if f.name in data or f.default is MISSING
    }
