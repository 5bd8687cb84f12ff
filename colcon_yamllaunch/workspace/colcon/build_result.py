# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""How a build by colcon ended."""

from colcon_yamllaunch.common.frozen import dataclass

#: The exit code of a build that the user stopped (128 + SIGINT).
INTERRUPTED = 130


@dataclass(frozen=True, slots=True)
class BuildResult:
    """
    How a build ended.

    :param returncode: 0, what colcon returned, or :data:`INTERRUPTED`
    :param built: The names of the packages that were built successfully
    :param failed: The names of those that were begun in vain, if known
    """

    returncode: int
    built: frozenset[str]
    failed: frozenset[str] = frozenset()
