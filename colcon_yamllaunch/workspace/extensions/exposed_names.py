# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The actions and substitutions that packages expose, without running them.

A module says `@expose_action('name')` or `@expose_substitution('name')` when
it is imported (`launch.frontend.expose`), so what a module of an extension
imports of its own package is looked at, too.
"""

import ast
from collections.abc import Iterable
from collections.abc import Iterator
from collections.abc import Mapping
from itertools import chain
import os
from pathlib import Path

from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.workspace.extensions.entry_points import Extension
from colcon_yamllaunch.workspace.extensions.entry_points import (
    extensions_in_source,
)
from colcon_yamllaunch.workspace.extensions.entry_points import (
    installed_extensions,
)
from colcon_yamllaunch.workspace.extensions.entry_points import python_folders
from colcon_yamllaunch.workspace.packages.package import Package

#: How many modules of an extension are looked at.
MAXIMUM_MODULES = 1000
#: The largest module that is (bytes).
MAXIMUM_SIZE = 1024 * 1024
#: The packages of ROS 2 itself: of what they have, most is known.
OF_ROS = ('launch', 'launch_ros')

_ACTION, _SUBSTITUTION = 'expose_action', 'expose_substitution'


class ExposedNames:
    """
    The actions and substitutions that packages expose.

    Packages are looked at when a name is asked for first, those of ROS 2
    itself only when no other has the name.

    :param environment: Where the packages are
    :param packages: The packages of the workspace, built or not
    """

    def __init__(
        self, environment: Mapping[str, str], packages: Iterable[Package]
    ) -> None:
        self._environment = environment
        self._packages = packages
        self._found: tuple[dict[str, str], dict[str, str]] | None = None
        self._of_ros: tuple[dict[str, str], dict[str, str]] | None = None
        self._folders: list[str] = []
        self._not_installed: set[str] = set()

    def action(self, name: str) -> str | None:
        """Return the package that exposes an action, None when none does."""
        return self._owner(name, 0)

    def substitution(self, name: str) -> str | None:
        """Return the package that exposes a substitution, or None."""
        return self._owner(name, 1)

    def actions(self) -> Mapping[str, str]:
        """Return all actions, with their packages."""
        return self._ros()[0] | self._others()[0]

    def substitutions(self) -> Mapping[str, str]:
        """Return all substitutions, with their packages."""
        return self._ros()[1] | self._others()[1]

    def is_installed(self, package: str) -> bool:
        """Say whether a package that exposes something is installed."""
        return package not in self._not_installed

    def _owner(self, name: str, kind: int) -> str | None:
        return self._others()[kind].get(name) or self._ros()[kind].get(name)

    def _others(self) -> tuple[dict[str, str], dict[str, str]]:
        if self._found is None:
            self._folders = python_folders(self._environment)
            installed = [
                extension
                for extension in installed_extensions(self._folders)
                if extension.package not in OF_ROS
                and extension.module not in OF_ROS
            ]
            in_source = [
                extension
                for package in self._packages
                for extension in extensions_in_source(
                    package.name, package.path
                )
                if extension.module not in OF_ROS
                and _file_of(extension.module, extension.folders) is not None
            ]
            # a distribution may have another name than its package
            there = {extension.module for extension in installed}
            own = {extension.module for extension in in_source}
            self._not_installed = {
                extension.package
                for extension in in_source
                if extension.module not in there
            }
            # what a package of the workspace has is what its source has
            others = (e for e in installed if e.module not in own)
            self._found = _names(chain(in_source, others))
        return self._found

    def _ros(self) -> tuple[dict[str, str], dict[str, str]]:
        if self._of_ros is None:
            self._others()
            folders = tuple(self._folders)
            self._of_ros = _names(Extension(n, n, folders) for n in OF_ROS)
        return self._of_ros


def _names(
    extensions: Iterable[Extension],
) -> tuple[dict[str, str], dict[str, str]]:
    actions: dict[str, str] = {}
    substitutions: dict[str, str] = {}
    for extension in extensions:
        for kind, name in exposed_by(extension):
            names = actions if kind == _ACTION else substitutions
            names.setdefault(name, extension.package)
    return actions, substitutions


def exposed_by(extension: Extension) -> Iterator[tuple[str, str]]:
    """Return what an extension exposes, as what exposes it and the name."""
    pending = _with_parents(extension.module)
    seen: set[str] = set()
    while pending and len(seen) < MAXIMUM_MODULES:
        module = pending.pop()
        path = _file_of(module, extension.folders)
        if module in seen or path is None:
            continue
        seen.add(module)
        text = _text_of(path)
        tree = _parsed(text)
        yield from _exposed_in(tree)
        is_package = path.name == '__init__.py'
        if is_package and 'import_module' in text:
            # which modules it is, only running it would tell
            folder = path.parent
            pending += [f'{module}.{f.stem}' for f in folder.glob('*.py')]
            inner = folder.glob('*/__init__.py')
            pending += [f'{module}.{f.parent.name}' for f in inner]
        top = module.partition('.')[0]
        for name in _imported(tree, module, is_package):
            if name.partition('.')[0] == top:
                pending += _with_parents(name)


def _with_parents(module: str) -> list[str]:
    """Return a module and the packages around, which Python imports, too."""
    parts = module.split('.')
    return ['.'.join(parts[:n]) for n in range(len(parts), 0, -1)]


def _file_of(module: str, folders: Iterable[str]) -> Path | None:
    relative = module.replace('.', '/')
    for folder in folders:
        for end in ('/__init__.py', '.py'):
            path = Path(folder, relative + end)
            if os.path.isfile(path):
                return path
    return None


def _text_of(path: Path) -> str:
    try:
        return content_of(path, MAXIMUM_SIZE).decode(errors='replace')
    except OSError:
        return ''


def _parsed(text: str) -> ast.AST:
    try:
        return ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ast.Module([], [])


def _exposed_in(tree: ast.AST) -> Iterator[tuple[str, str]]:
    texts: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and _is_text(node.value):
            for target in node.targets:
                if isinstance(target, ast.Name):
                    texts[target.id] = ast.literal_eval(node.value)
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and node.args:
            kind = _last_name(node.func)
            argument = node.args[0]
            if kind not in (_ACTION, _SUBSTITUTION):
                continue
            if _is_text(argument):
                yield kind, ast.literal_eval(argument)
            elif isinstance(argument, ast.Name) and argument.id in texts:
                yield kind, texts[argument.id]


def _imported(tree: ast.AST, module: str, is_package: bool) -> Iterator[str]:
    """Return the modules, or names in modules, that a module imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ''
            if node.level:
                around = module.split('.')
                keep = len(around) - node.level + is_package
                base = '.'.join([*around[: max(0, keep)], *base.split('.')])
                base = base.rstrip('.')
            yield base
            yield from (f'{base}.{alias.name}' for alias in node.names)


def _last_name(node: ast.expr) -> str:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ''


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)
