# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is to be launched, and all that the result depends on."""

from collections.abc import Callable
from collections.abc import Mapping
from dataclasses import field
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile
from colcon_yamllaunch.language.vocabulary.package_lookup import FindExposed
from colcon_yamllaunch.language.vocabulary.package_lookup import NothingExposed
from colcon_yamllaunch.language.vocabulary.package_lookup import Packages

if TYPE_CHECKING:
    from colcon_yamllaunch.language.evaluation.launch_worker import (
        LaunchWorker,
    )


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
    :param exposed: Gives the actions and substitutions that packages bring
    :param host: Returns what reads launch files in Python; without it,
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
    host: 'Callable[[], LaunchWorker] | None' = None
    trees: dict[str, LaunchFile] = field(default_factory=dict, compare=False)
