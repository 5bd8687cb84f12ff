# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The imports of launch files: patched, postponed and reported."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
import os
import sys
from types import ModuleType
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from .visit import Visitor

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
