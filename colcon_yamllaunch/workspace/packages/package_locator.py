# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where the files of packages are, or are going to be once it is built."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
import os
from pathlib import Path
from typing import TYPE_CHECKING

from colcon_yamllaunch.common.errors import WorkspaceError
from colcon_yamllaunch.common.files import names_in, split_path, text_of
from colcon_yamllaunch.common.suggestions import no_package
from colcon_yamllaunch.workspace.packages.package import (
    Package,
    prefix_of,
    source_files,
)

if TYPE_CHECKING:
    from colcon_yamllaunch.workspace.packages.python_modules import (
        ExposedNames,
    )

_AMENT_INDEX = 'share/ament_index/resource_index/packages'
_COMPONENT_INDEX = 'share/ament_index/resource_index/rclcpp_components'
_COLCON_INDEX = 'share/colcon-core/packages'


class PackageLocator:
    """
    The packages of a workspace and of the underlays that are sourced.

    A package of the workspace is always where it will be installed, whether
    it has been built or not. It wins over one of the same name elsewhere.

    :param environment: The variables that tell the underlays
    """

    def __init__(
        self,
        packages: Iterable[Package],
        install_base: Path,
        merge_install: bool,
        environment: Mapping[str, str],
    ) -> None:
        self._packages: dict[str, Package] = {}
        for package in packages:
            self._packages.setdefault(package.name, package)
        self._install_base = install_base
        self._merge_install = merge_install
        self._environment = environment
        self._ament = _prefixes(environment, 'AMENT_PREFIX_PATH')
        self._colcon = _prefixes(environment, 'COLCON_PREFIX_PATH')

    def package(self, name: str) -> Package | None:
        """Return a package of the workspace, or None."""
        return self._packages.get(name)

    def packages(self) -> Iterable[Package]:
        """Return the packages of the workspace."""
        return self._packages.values()

    def no_package(self, name: str, *otherwise: str) -> WorkspaceError:
        """Return what to say of a package that is not there."""
        names, environment = self.names(), self._environment
        return WorkspaceError(
            *no_package(name, names, environment, *otherwise)
        )

    def undeclared_owner(self, module: str, user: str | None) -> str | None:
        """
        Return the package that has a Python module, if its user omits it.

        :param user: The package that imports it
        """
        package = self._packages.get(user or '')
        if package is None:
            return None
        # few launches miss a module
        from colcon_yamllaunch.workspace.packages import python_modules

        return python_modules.undeclared_owner(
            module, package, self.packages()
        )

    @cached_property
    def exposed(self) -> 'ExposedNames':
        """The actions and substitutions that packages bring."""
        # most launch files use none
        from colcon_yamllaunch.workspace.packages import python_modules

        return python_modules.ExposedNames(self._environment, self.packages())

    def prefix(self, name: str) -> str | None:
        """Return the prefix of a package, or None if there is no such one."""
        if name in self._packages:
            base = self._install_base
            return str(prefix_of(name, base, self._merge_install))
        if name in ('', '.', '..') or os.sep in name:
            return None
        for prefix in self._ament:
            if os.path.isfile(prefix / _AMENT_INDEX / name):
                return str(prefix)
        for prefix in self._colcon:
            for candidate in (prefix, prefix / name):
                if os.path.isfile(candidate / _COLCON_INDEX / name):
                    return str(candidate)
        return None

    def share(self, name: str) -> str | None:
        """Return the share folder of a package, or None."""
        prefix = self.prefix(name)
        return prefix and str(Path(prefix, 'share', name))

    def names(self) -> tuple[str, ...]:
        """Return the names of all packages, for suggestions; this is slow."""
        names = set(self._packages)
        for prefix in self._ament:
            names.update(names_in(prefix / _AMENT_INDEX))
        for prefix in self._colcon:
            names.update(names_in(prefix / _COLCON_INDEX))
            names.update(
                child
                for child in names_in(prefix)
                if os.path.isfile(prefix / child / _COLCON_INDEX / child)
            )
        return tuple(sorted(names))

    def executable(self, package: str, name: str) -> str | None:
        """
        Return the path of a program of a package, or None.

        That of a package of the workspace need not be there yet.
        """
        prefix = self.prefix(package)
        if prefix is None:
            return None
        path = Path(prefix, 'lib', package, name)
        if package in self._packages or is_executable(path):
            return str(path)
        return None

    def executables(self, package: str) -> tuple[str, ...]:
        """
        Return the names of the programs that a package has installed.

        One in a subfolder goes by its path from `lib/PACKAGE`.
        """
        prefix = self.prefix(package)
        if prefix is None:
            return ()
        folder = Path(prefix, 'lib', package)
        names = sorted(name for name, _ in source_files(folder))
        return tuple(n for n in names if is_executable(folder / n))

    def plugins(self, package: str) -> tuple[str, ...] | None:
        """
        Return the components that a package has installed.

        None when it has installed no list of them. As in the container, the
        first prefix with such a list counts (`ament_index_cpp`).
        """
        own = self.prefix(package)
        prefixes = [] if own is None else [Path(own)]
        for prefix in (*prefixes, *self._ament):
            path = prefix / _COMPONENT_INDEX / package
            if os.path.isfile(path):
                return tuple(read_component_index(text_of(path)))
        return None

    def source_of(self, path: str) -> str | None:
        """
        Return the file in a package's source that is installed at a path.

        It is the one of the same relative path, else the only one of that
        name in the package, else None.

        :param path: Below the share folder of a package of the workspace
        """
        found = self.shared(path)
        if found is None:
            return None
        package, relative = found
        candidate = package.path / relative
        if os.path.exists(candidate):
            return str(candidate)
        same = [
            package.path / name
            for name, _ in source_files(package.path)
            if Path(name).name == relative.name
        ]
        return str(same[0]) if len(same) == 1 else None

    def shared(self, path: str) -> tuple[Package, Path] | None:
        """Split a path into a package and what is below its share folder."""
        normal = Path(os.path.normpath(path))
        # <package>/share/<package>/…, or share/<package>/… when merged
        package = self._named(normal, 1 if self._merge_install else 2)
        if package is None:
            return None
        share = Path(self.share(package.name) or '')
        if not normal.is_relative_to(share):
            return None
        return package, normal.relative_to(share)

    def package_of(self, path: str) -> Package | None:
        """Return the package of the workspace whose source has a path."""
        real = Path(os.path.realpath(path))
        for folder in (real, *real.parents):
            package = self._by_place.get(_place(folder))
            if package is not None:
                return package
        return None

    def installed_path(self, package: str, source_file: str) -> str | None:
        """
        Return where a file of a package's source is usually installed.

        It is the same relative path below the share folder, or None when the
        file is not the package's.
        """
        own = self._packages.get(package)
        if own is None:
            return None
        folder = Path(os.path.realpath(own.path))
        real = Path(os.path.realpath(source_file))
        if not real.is_relative_to(folder):
            return None
        share = self.share(package) or ''
        return str(share / real.relative_to(folder))

    def owner(self, path: str) -> Package | None:
        """Return the package of the workspace whose prefix has a path."""
        # when merged, the path tells whose it is in lib/ and share/ only
        where = 1 if self._merge_install else 0
        return self._named(Path(os.path.normpath(path)), where)

    @cached_property
    def _by_place(self) -> dict[tuple[int, int] | None, Package]:
        """The packages by their folders, behind all links."""
        found = {_place(p.path): p for p in self._packages.values()}
        found.pop(None, None)
        return found

    def _named(self, path: Path, where: int) -> Package | None:
        """Return the package that a part of an installed path names."""
        if not path.is_relative_to(self._install_base):
            return None
        parts = path.relative_to(self._install_base).parts
        return self._packages.get(parts[where]) if where < len(parts) else None


def read_component_index(text: str) -> Iterator[str]:
    """
    Iterate over the components in what the ament index says of a package.

    There is one a line, with its library: `CLASS;PATH` (rclcpp_components).
    """
    for line in text.splitlines():
        plugin, semicolon, _ = line.partition(';')
        if semicolon and plugin.strip():
            yield plugin.strip()


def is_executable(path: Path) -> bool:
    """Return whether a path is a file that the user may run."""
    return os.path.isfile(path) and os.access(path, os.X_OK)


def _prefixes(environment: Mapping[str, str], name: str) -> list[Path]:
    return [Path(entry) for entry in split_path(environment.get(name))]


def _place(folder: Path) -> tuple[int, int] | None:
    """Return what names a folder for good; None if it is not there."""
    try:
        status = os.stat(folder)
    except OSError:
        return None
    return status.st_dev, status.st_ino
