# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Packages of ROS that launch files name, and modules that they import."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
import os
import sys
from types import ModuleType
from typing import Any, TYPE_CHECKING
import warnings

from .errors import chain

if TYPE_CHECKING:
    from .visit import Visitor

#: Keeps the package that an error is about.
_PACKAGE = '_launch_worker_package'
#: All messages of ROS import it, for arrays that launch files hardly ever
#: have, and that takes a fifth of the time that `launch_ros` takes.
RUN_LATER = 'numpy'
#: Folders of what is installed, and what the paths of Python begin with.
_INSTALLED = ('site-packages', 'dist-packages')
_PREFIXES = (sys.prefix, sys.base_prefix)


class _Finder(MetaPathFinder):
    """Finds modules to which something is done once they are imported."""

    def __init__(self) -> None:
        self.waiting: dict[str, list[Callable[[Any], object]]] = {}

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None,
        target: ModuleType | None = None,
    ) -> ModuleSpec | None:
        if fullname not in self.waiting:
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is None or spec.loader is None:
            return None
        loader: Any = spec.loader
        run = loader.exec_module

        def exec_module(module: ModuleType) -> None:
            run(module)
            for do in self.waiting.pop(fullname, ()):
                do(module)

        loader.exec_module = exec_module
        return spec


_finder = _Finder()


def when_imported(name: str, do: Callable[[Any], object]) -> None:
    """Call something with a module, now or once it is imported."""
    module = sys.modules.get(name)
    if module is not None:
        do(module)
        return
    if _finder not in sys.meta_path:
        sys.meta_path.insert(0, _finder)
    _finder.waiting.setdefault(name, []).append(do)


def run_later() -> None:
    """
    Postpone imports that may be unused until they are used.

    `importlib.util.LazyLoader` does not do: there, the second import is a use.
    """
    sys.meta_path.insert(0, _LaterFinder())


class _Unused(ModuleType):
    """A module that was imported; the first use runs it."""

    def __getattr__(self, name: str) -> Any:
        _run(self)
        return getattr(self, name)


class _Unrun(Loader):
    """Imports a module without running it."""

    def __init__(self, loader: Any) -> None:
        self.loader = loader

    def exec_module(self, module: ModuleType) -> None:
        module.__class__ = _Unused


class _Known(Loader):
    """Imports a module that came while it was looked for."""

    def __init__(self, module: ModuleType) -> None:
        self._module = module
        self._spec = module.__spec__

    def create_module(self, spec: ModuleSpec) -> ModuleType:  # noqa: ARG002
        return self._module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self._spec


class _LaterFinder(MetaPathFinder):
    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None,
        target: ModuleType | None = None,
    ) -> ModuleSpec | None:
        if fullname == RUN_LATER:
            spec = PathFinder.find_spec(fullname, path, target)
            if spec is not None and spec.loader is not None:
                spec.loader = _Unrun(spec.loader)
            return spec
        parent = sys.modules.get(RUN_LATER)
        if fullname.startswith(RUN_LATER + '.') and isinstance(
            parent, _Unused
        ):
            _run(parent)
            if fullname in sys.modules:
                # else it is run once more, for another module
                known = _Known(sys.modules.pop(fullname))
                return ModuleSpec(fullname, known)
        return None


def _run(module: ModuleType) -> None:
    spec: Any = module.__spec__
    unrun = spec.loader
    spec.loader = module.__loader__ = unrun.loader
    module.__class__ = ModuleType
    try:
        spec.loader.exec_module(module)
    except BaseException:
        # the next use says the same
        spec.loader = unrun
        module.__class__ = _Unused
        raise


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


def report_modules(visitor: Visitor) -> None:
    """Report the imported modules before each `done`."""
    own = set(sys.modules)
    told = set(own)
    libraries = tuple(p + os.sep + 'lib' for p in _PREFIXES)

    def tell() -> None:
        for name in set(sys.modules) - told:
            told.add(name)
            path = getattr(sys.modules.get(name), '__file__', None)
            if not isinstance(path, str):
                continue
            real = os.path.realpath(path)
            is_installed = any(n in real.split(os.sep) for n in _INSTALLED)
            # others a user may edit
            if not is_installed and not real.startswith(libraries):
                visitor.say('read', path=path)

    def forget() -> None:
        told.intersection_update(own)

    visitor.before_done.append(tell)
    visitor.forget.append(forget)
