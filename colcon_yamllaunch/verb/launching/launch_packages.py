# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The packages as the launch language sees them."""

from collections.abc import Container
from collections.abc import Iterable
from collections.abc import Mapping
from functools import cache
import os
from pathlib import Path

from colcon_yamllaunch.language.vocabulary.package_lookup import Exposed
from colcon_yamllaunch.language.vocabulary.package_lookup import FindExposed
from colcon_yamllaunch.workspace.packages.package_locator import PackageLocator

# what explains mistakes is imported where it is needed


class LaunchPackages:
    """
    The packages of a workspace and its underlays.

    :param built: Whether all that was to be built has been built
    :param only_there: Packages that are not built here, as only what runs on
      other machines needs them
    """

    def __init__(
        self,
        locator: PackageLocator,
        *,
        built: bool,
        only_there: Container[str] = (),
    ) -> None:
        self._locator = locator
        self._built = built
        self._only_there = only_there
        self.prefix = locator.prefix
        self.names = locator.names
        self.executable = locator.executable
        #: The paths that are not there, but taken for granted before a build.
        self.expected: set[str] = set()
        #: The launch files that were found in a source only, in order.
        self.not_installed: dict[str, None] = {}

    def own_names(self) -> Iterable[str]:
        """Return the names of the packages of the workspace."""
        return [package.name for package in self._locator.packages()]

    def explain_executable(self, package: str, name: str) -> str:
        """Say why a package has no such program, and the way out."""
        from colcon_yamllaunch.workspace.packages.missing_files import (
            missing_executable,
        )

        return str(missing_executable(self._locator, package, name) or '')

    def locate(self, path: str) -> tuple[str, str] | None:
        """
        Find a launch file, in the source of a package of the workspace.

        It goes by the path that it has, or will have, in the install space,
        unless a build has shown that it is not installed.
        """
        if self._locator.shared(path) is not None:
            source = self._locator.source_of(path)
            if source is not None and os.path.isfile(Path(source)):
                if os.path.exists(Path(path)) or self.may_appear(path):
                    return path, source
                self.not_installed[path] = None
                return source, source
        return (path, path) if os.path.isfile(Path(path)) else None

    def may_appear(self, path: str) -> bool:
        """
        Say whether a build may bring a path that is not there.

        Such a path is remembered as expected.
        """
        owner = self._locator.owner(path)
        if owner is None:
            return False
        if owner.name in self._only_there:
            return True
        if self._built:
            return False
        self.expected.add(path)
        return True

    def rule_for(self, path: str) -> str | None:
        """Say how to install a file that only a source has, None if none."""
        from colcon_yamllaunch.workspace.packages.missing_files import (
            not_installed,
        )

        found = not_installed(self._locator, path)
        return None if found is None else found.hint

    def similar(self, path: str) -> Iterable[str]:
        """Return the names of files in its folder that could be meant."""
        from colcon_yamllaunch.workspace.packages.launch_files import (
            find_launch_files,
        )

        shared = self._locator.shared(path)
        if shared is not None:
            package, file = shared
            files = map(Path, find_launch_files(package.path))
            return [f.name for f in files if f.parent == file.parent]
        try:
            return os.listdir(os.path.dirname(path))
        except OSError:
            return ()


def exposed_by_packages(
    locator: PackageLocator, environment: Mapping[str, str]
) -> FindExposed:
    """
    Return what gives the actions and substitutions that packages bring.

    :param environment: Where the packages are that are installed
    """

    @cache
    def find() -> Exposed:
        # most launch files use none
        from colcon_yamllaunch.workspace.extensions.exposed_names import (
            ExposedNames,
        )

        return ExposedNames(environment, locator.packages())

    return find
