# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is to be launched, and all that the result depends on."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import field
from typing import Any, Protocol, TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass

if TYPE_CHECKING:
    from colcon_yamllaunch.language.syntax.launch_tree import LaunchFile


class Packages(Protocol):
    """The packages that a launch file may name."""

    def prefix(self, name: str) -> str | None:
        """
        Return the install prefix of a package, or None when there is none.

        The prefix of a package that is yet to be built is where it will be.
        """

    def names(self) -> Iterable[str]:
        """Return the names of all packages."""

    def own_names(self) -> Iterable[str]:
        """Return the names of the packages of the workspace."""

    def executable(self, package: str, name: str) -> str | None:
        """
        Return the path of a package's program, or None when there is none.

        The program of a package that is yet to be built may not exist.
        """

    def explain_executable(self, package: str, name: str) -> str:
        """Return why a package has no such program, and the fix."""

    def locate(self, path: str) -> tuple[str, str] | None:
        """
        Return the path that a launch file goes by and the path to read.

        It may not be installed yet; None when there is no such file.

        :param path: The absolute path as a launch file writes it
        """

    def may_appear(self, path: str) -> bool:
        """Return whether a build may create a missing path."""

    def rule_for(self, path: str) -> str | None:
        """Return how to install a file that only the source has, or None."""

    def similar(self, path: str) -> Iterable[str]:
        """Return files that could be meant by a path that is not there."""


class Exposed(Protocol):
    """The actions and substitutions of packages (`expose_action`)."""

    def action(self, name: str) -> str | None:
        """Return the package that has an action, None when none has."""

    def substitution(self, name: str) -> str | None:
        """Return the package that has a substitution, None when none has."""

    def actions(self) -> Mapping[str, str]:
        """Return all such actions, with their packages; this is slow."""

    def substitutions(self) -> Mapping[str, str]:
        """Return all such substitutions, with their packages."""

    def is_installed(self, package: str) -> bool:
        """Return whether the package is installed."""


class NothingExposed:
    """No package has actions or substitutions."""

    def action(self, _name: str) -> str | None:
        """Return None."""
        return None

    def substitution(self, _name: str) -> str | None:
        """Return None."""
        return None

    def actions(self) -> Mapping[str, str]:
        """Return nothing."""
        return {}

    def substitutions(self) -> Mapping[str, str]:
        """Return nothing."""
        return {}

    def is_installed(self, _package: str) -> bool:
        """Return False."""
        return False


#: Returns the actions of packages; called for the first unknown name.
FindExposed = Callable[[], Exposed]


#: A message of the worker or for it; see `python_launch/worker/channel.py`.
WorkerMessage = Mapping[str, Any]


class WorkerError(Exception):
    """The worker cannot answer; the text says what became of it."""


class NoWorkerError(WorkerError):
    """There is no worker, as the environment lacks what it needs."""


class WorkerTimeoutError(WorkerError):
    """The worker does not answer; the text says for how long."""


class LaunchWorker(Protocol):
    """A process that reads launch files with ROS 2's own packages."""

    def send(self, message: WorkerMessage) -> None:
        """
        Send a message.

        :raises WorkerError: when there is none, or it has ended
        """

    def receive(self) -> WorkerMessage:
        """
        Wait for the next message.

        :raises WorkerTimeoutError: when none comes in time
        :raises WorkerError: when the worker has ended
        """

    def doing(self) -> WorkerMessage:
        """Return what the worker is doing, a message `where`, and end it."""


@dataclass(frozen=True, slots=True)
class Request:
    """
    A launch file, and what it is to be evaluated with.

    :param name: The path that the launch file goes by
    :param path: The file to read
    :param packages: The packages that there are
    :param environment: The environment that the launch runs in
    :param arguments: The launch arguments that are given
    :param cwd: The folder that relative paths start from, absolute
    :param log_folder: The folder that `$(log_dir)` names
    :param exposed: Returns the actions and substitutions of packages
    :param open_worker: Returns what reads launch files in Python; without it,
      `ros2 launch` runs them
    :param trees: The launch files that were read before, by their paths; one
      whose text is another now is read anew, and takes its place
    """

    name: str
    path: str
    packages: Packages
    environment: Mapping[str, str]
    arguments: Mapping[str, str]
    cwd: str
    log_folder: str = ''
    exposed: FindExposed = NothingExposed
    open_worker: Callable[[], LaunchWorker] | None = None
    trees: 'dict[str, LaunchFile]' = field(default_factory=dict, compare=False)
