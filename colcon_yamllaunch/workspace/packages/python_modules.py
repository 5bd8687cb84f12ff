# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which packages of a workspace have which Python modules, and use them."""

import ast
from collections.abc import Iterable
from collections.abc import Iterator
import os
from pathlib import Path
from typing import NamedTuple

from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.workspace.packages.package import Package
from colcon_yamllaunch.workspace.packages.source_files import source_files

_TESTS = frozenset(('test', 'tests'))


class Import(NamedTuple):
    """
    An import of a module of another package.

    :param path: The file
    :param line: The line, counted from 1
    :param column: The column, counted from 1
    :param module: The module, up to the first dot
    :param owner: The package that has it
    """

    path: Path
    line: int
    column: int
    module: str
    owner: str


def undeclared_owner(
    module: str, user: Package, packages: Iterable[Package]
) -> str | None:
    """
    Return the package that has a module and is not declared by its user.

    A package has the module of its own name, as packages with interfaces do,
    and those whose folders it has.

    :param packages: The packages of the workspace
    """
    declared = user.build_depends | user.run_depends | {user.name}
    owners = [p for p in packages if p.name == module] or [
        p for p in packages if os.path.isfile(p.path / module / '__init__.py')
    ]
    if not owners or any(owner.name in declared for owner in owners):
        return None
    return owners[0].name


def undeclared_imports(
    user: Package, packages: Iterable[Package]
) -> Iterator[Import]:
    """
    Find what a package imports of packages that it does not declare.

    Its tests do not count, and neither do files that are no Python.

    :param packages: The packages of the workspace
    """
    packages = tuple(packages)
    owners: dict[str, str | None] = {}
    for name, _ in sorted(source_files(user.path), key=lambda file: file[0]):
        path = user.path / name
        if path.suffix != '.py' or _TESTS.intersection(Path(name).parts):
            continue
        tree = _parsed(path)
        for module, node in _imports(ast.walk(tree) if tree else ()):
            if module not in owners:
                owners[module] = undeclared_owner(module, user, packages)
            owner = owners[module]
            if owner is not None:
                yield Import(
                    path, node.lineno, node.col_offset + 1, module, owner
                )


def certain_imports(path: Path) -> Iterator[tuple[str, ast.stmt]]:
    """
    Iterate over the modules that a script imports as it starts.

    None where it changes `sys.path`.
    """
    tree = _parsed(path)
    if tree is None or 'sys.path' in text_of(path):
        return
    yield from _imports(tree.body)


def _parsed(path: Path) -> ast.Module | None:
    try:
        return ast.parse(path.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError):
        return None


def _imports(nodes: Iterable[ast.AST]) -> Iterator[tuple[str, ast.stmt]]:
    for node in nodes:
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name.partition('.')[0], node
        # relative ones stay in the package
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield (node.module or '').partition('.')[0], node
