# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The name of a Python package, without running its `setup.py`.

colcon runs it for the name, and so does a launch, which builds the package
anyway. Who only looks reads it: the name that `setup()` is given as a text,
or by a variable that is one, else that of `setup.cfg` or `pyproject.toml`.
"""

import ast
from collections.abc import Iterator
from collections.abc import Sequence
from pathlib import Path
import re

from colcon_yamllaunch.common.text_files import text_of

_SECTION = re.compile(
    r'^\[(?:metadata|project)\]\s*$(.*?)(?=^\[|\Z)', re.M | re.S
)
_NAME = re.compile(r'^name\s*[=:]\s*[\'"]?([\w.-]+)', re.M)


def written_name(folder: Path) -> str | None:
    """Return the name of a Python package as far as its files write it."""
    names = list(_in_setup(text_of(folder / 'setup.py')))
    return names[0] if names else configured_name(folder)


def configured_name(
    folder: Path, files: Sequence[str] = ('setup.cfg', 'pyproject.toml')
) -> str | None:
    """Return the name that the metadata files of a package give it."""
    for file in files:
        for section in _SECTION.findall(text_of(folder / file)):
            found = _NAME.search(section)
            if found:
                return found[1]
    return None


def _in_setup(text: str) -> Iterator[str | None]:
    """Return the names that `setup()` is given, None for one not known."""
    try:
        nodes = list(ast.walk(ast.parse(text)))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return
    values: dict[str, str | None] = {}
    for node in nodes:
        for target in getattr(node, 'targets', ()):
            if isinstance(node, ast.Assign) and isinstance(target, ast.Name):
                known = _text(node.value) if target.id not in values else None
                values[target.id] = known
    for node in nodes:
        if isinstance(node, ast.Call) and _name_of(node.func) == 'setup':
            for keyword in node.keywords:
                if keyword.arg == 'name':
                    name = _name_of(keyword.value)
                    yield _text(keyword.value) or values.get(name or '')


def _name_of(node: ast.expr) -> str | None:
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else None


def _text(node: ast.expr) -> str | None:
    value = node.value if isinstance(node, ast.Constant) else None
    return value if isinstance(value, str) else None
