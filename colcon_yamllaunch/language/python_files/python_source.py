# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What stands in a launch file in Python, read without running it."""

import ast
from collections.abc import Iterator
from pathlib import Path

from colcon_yamllaunch.common.files import text_of
from colcon_yamllaunch.language.evaluation.findings import DeclaredArgument
from colcon_yamllaunch.plan.position import Position

# what takes the name of a package first, by the name that it is called by
_PACKAGE_CALLS = frozenset(
    (
        'FindPackage',
        'FindPackagePrefix',
        'FindPackageShare',
        'get_package_prefix',
        'get_package_share_directory',
        'get_package_share_path',
    )
)
_PACKAGE_KEYWORDS = ('package', 'package_name')
_ARGUMENT = 'DeclareLaunchArgument'


def named_packages(path: str) -> Iterator[tuple[str, Position]]:
    """Iterate over the names of packages that stand in a launch file."""
    for call in _calls(path):
        values = [k.value for k in call.keywords if k.arg in _PACKAGE_KEYWORDS]
        if _name(call) in _PACKAGE_CALLS:
            values += call.args[:1]
        for value in values:
            text = _text(value)
            if text:
                column = value.col_offset + 1
                yield text, Position(path, value.lineno, column)


def written_arguments(path: str) -> Iterator[DeclaredArgument]:
    """Iterate over the launch arguments that a launch file declares."""
    for call in _calls(path):
        keywords = {k.arg: k.value for k in call.keywords}
        first = call.args[0] if call.args else keywords.get('name')
        if _name(call) != _ARGUMENT or first is None:
            continue
        name = _text(first)
        if name is None:
            continue
        default = keywords.get('default_value')
        if len(call.args) > 1:
            default = call.args[1]
        choices = keywords.get('choices')
        yield DeclaredArgument(
            name,
            Position(path, call.lineno, call.col_offset + 1),
            _text(keywords.get('description')),
            # one that is computed shows only when it runs
            '…' if default and _text(default) is None else _text(default),
            tuple(filter(None, map(_text, choices.elts)))
            if isinstance(choices, ast.List | ast.Tuple)
            else (),
        )


def _calls(path: str) -> Iterator[ast.Call]:
    try:
        tree = ast.parse(text_of(Path(path)))
    except (OSError, SyntaxError, ValueError, RecursionError):
        # who runs it says what is wrong
        return
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            yield node


def _name(call: ast.Call) -> str:
    function = call.func
    if isinstance(function, ast.Attribute):
        return function.attr
    return function.id if isinstance(function, ast.Name) else ''


def _text(node: ast.expr | None) -> str | None:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    return None
