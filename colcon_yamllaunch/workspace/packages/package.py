# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What is known about a package of the workspace."""

from pathlib import Path

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.text_files import text_of


@dataclass(frozen=True, slots=True)
class Package:
    """
    A package whose source is in the workspace.

    :param name: The name that other packages and launch files use
    :param path: The absolute path of the folder with the source
    :param type: How colcon builds it, such as `ros.ament_cmake` or `cmake`
    :param build_depends: Names of what it needs to be built
    :param run_depends: Names of what it, or who builds on it, needs later
    """

    name: str
    path: Path
    type: str
    build_depends: frozenset[str] = frozenset()
    run_depends: frozenset[str] = frozenset()


def prefix_of(name: str, install_base: Path, merge_install: bool) -> Path:
    """
    Return the folder that a package is installed into.

    :param merge_install: Whether all packages share one prefix
    """
    return install_base if merge_install else install_base / name


def is_merged(install_base: Path) -> bool:
    """Tell whether an install folder has the merged layout already."""
    marker = install_base / '.colcon_install_layout'
    return text_of(marker).rstrip() == 'merged'
