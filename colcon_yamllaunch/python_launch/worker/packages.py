# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Packages of ROS that launch files name."""

from __future__ import annotations

from functools import wraps
import os
import sys
from typing import Any, TYPE_CHECKING
import warnings

from .errors import chain
from .imports import when_imported

if TYPE_CHECKING:
    from .visit import Visitor

#: Keeps the package that an error is about.
_PACKAGE = '_launch_worker_package'


class Packages:
    """
    The packages of the workspace, some of which may not be built yet.

    :param visitor: Is told which packages are named
    """

    def __init__(self, visitor: Visitor) -> None:
        self._visitor = visitor
        self._named: set[object] = set()
        #: The prefix of each package of the workspace.
        self.prefixes: dict[str, str] = {}
        #: Those whose prefix was told though nothing is there yet.
        self.future: list[str] = []
        #: The files that are read for those that are not installed yet.
        self._located: dict[str, str | None] = {}
        #: Where those will be that were found elsewhere.
        self._installed: dict[str, str] = {}

    def set(self, packages: dict[str, Any]) -> None:
        """Record the packages of the workspace."""
        self.prefixes = {n: p['prefix'] for n, p in packages.items()}
        self._located.clear()

    def install(self) -> None:
        """Make package lookups find those of the workspace."""
        # it says that of those that are not built yet
        warnings.filterwarnings('ignore', 'Share (directory|path) for ')
        when_imported('ament_index_python.packages', self._wrap_index)
        when_imported(
            'launch_ros.substitutions.executable_in_package',
            self._wrap_executable,
        )

    def name(self, package: str, position: Any = None) -> None:
        """Report the name of a package, once for each position."""
        position = position or self._visitor.here()
        key = (package, tuple(position or ()))
        if key not in self._named:
            self._named.add(key)
            self._visitor.say('package', name=package, position=position)

    def begin(self) -> None:
        """Begin to tell anew which packages are named."""
        self._named.clear()
        self.future.clear()

    def located(self, path: str) -> str:
        """Return the file to read for one that may not be installed yet."""
        path = os.path.abspath(path)
        if os.path.exists(path) or self._owner(path) is None:
            return path
        if path not in self._located:
            answer = self._visitor.ask('locate', path=path)
            self._located[path] = answer.get('path')
        return self._located[path] or path

    def source(self, path: str) -> str:
        """Return the same for a file whose path goes to a process."""
        found = self.located(path)
        if found == os.path.abspath(path):
            return path
        self._installed[found] = path
        return found

    def installed(self, path: str) -> str:
        """Return the path that a file will have for the process."""
        return self._installed.get(path, path)

    def missing(self, error: BaseException) -> str | None:
        """Return the package that is missing, or not built, for an error."""
        for one in chain(error):
            name = getattr(one, _PACKAGE, None)
            if isinstance(name, str):
                return name
            if isinstance(one, ModuleNotFoundError) and one.name:
                name = one.name.partition('.')[0]
                if name in self.prefixes:
                    return name
            if isinstance(one, OSError) and isinstance(one.filename, str):
                owner = self._owner(os.path.abspath(one.filename))
                if owner is not None:
                    return owner
        # with its files it may go well
        return self.future[0] if self.future else None

    def _owner(self, path: str) -> str | None:
        """Return the package that a path is to be installed by."""
        parts = path.split(os.sep)
        for index, name in enumerate(parts):
            # PREFIX/share/NAME/…, PREFIX/lib/NAME/…
            prefix = self.prefixes.get(name)
            if prefix is not None and (
                prefix == os.sep.join(parts[: index - 1])
            ):
                return name
        found = [
            name
            for name, prefix in self.prefixes.items()
            if path.startswith(prefix + os.sep)
        ]
        return found[0] if len(found) == 1 else None

    def _wrap_index(self, module: Any) -> None:
        packages = self
        find = module.get_package_prefix

        @wraps(find)
        def get_package_prefix(package_name: str) -> Any:
            try:
                prefix = find(package_name)
            except LookupError as e:
                if package_name not in packages.prefixes:
                    setattr(e, _PACKAGE, package_name)
                    raise
                packages.future.append(package_name)
                prefix = packages.prefixes[package_name]
            packages.name(package_name)
            return prefix

        module.get_package_prefix = get_package_prefix
        name = module.__name__.rpartition('.')[0]
        parent: Any = sys.modules.get(name)
        if hasattr(parent, 'get_package_prefix'):
            parent.get_package_prefix = get_package_prefix

    def _wrap_executable(self, module: Any) -> None:
        packages = self
        visitor = self._visitor
        cls = module.ExecutableInPackage
        perform = cls.perform

        @wraps(perform)
        def perform_reported(self: Any, context: Any) -> Any:
            package = visitor.text_of(self.package)
            name = visitor.text_of(self.executable)
            prefix = packages.prefixes.get(package)
            try:
                path = perform(self, context)
            except Exception:
                if prefix is None or not name:
                    raise
                path = os.path.join(prefix, 'lib', package, name)
            visitor.say(
                'executable',
                package=package,
                name=name,
                path=path,
                position=visitor.here(),
            )
            return path

        cls.perform = perform_reported
