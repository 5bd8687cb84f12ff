# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""A running launch at one moment, as its server describes it."""

from collections.abc import Mapping
from dataclasses import fields
from dataclasses import MISSING
from typing import Any

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.runtime.control.protocol import ProtocolError


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
    :param phase: `waiting`, `running`, `stopping`, `respawn` or `ended`, see
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


@dataclass(frozen=True, slots=True)
class LaunchState(About):
    """
    A launch.

    :param pid: The process id of the launcher
    :param seconds: For how long it has been running
    :param stopping: Whether everything is being stopped
    :param log_folder: The folder with its logs, if it writes any
    :param processes: Its processes, in the order of the plan
    """

    pid: int
    seconds: float
    stopping: bool
    log_folder: str | None
    processes: tuple[ProcessState, ...]


def from_json(data: object) -> LaunchState:
    """
    Read a launch from a JSON object with the names of its attributes.

    What is not known here is left out.

    :raises ProtocolError: when something is missing
    """
    try:
        launch = _known(LaunchState, data)
        launch['processes'] = tuple(
            ProcessState(**_known(ProcessState, p))
            for p in launch['processes']
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
