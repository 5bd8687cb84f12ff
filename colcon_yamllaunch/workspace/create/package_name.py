# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Names for packages and nodes.

What a package should be called says REP 144. catkin_pkg lets more pass, and
so do we, with a warning; what no tool could work with is an error.
"""

from collections.abc import Iterator
import keyword
import re
import sys

from colcon_yamllaunch.common.errors import UserError

_PACKAGE = re.compile(r'[a-zA-Z][a-zA-Z0-9_-]*')
_NODE = re.compile(r'[a-zA-Z][a-zA-Z0-9_]*')
#: Names that CMake (policy CMP0037) and ament_cmake keep for themselves.
_CMAKE_TARGETS = frozenset(
    (
        *(
            'all',
            'clean',
            'depend',
            'edit_cache',
            'help',
            'install',
            'package',
        ),
        *('rebuild_cache', 'test', 'uninstall'),
    )
)


def check_package_name(name: str, build_type: str) -> None:
    """
    Check that a package may have a name.

    :param build_type: Such as `ament_python`
    :raises UserError: when it may not
    """
    if not _PACKAGE.fullmatch(name):
        raise UserError(
            f"'{name}' is no name for a package",
            'REP 144 asks for lower case letters, digits and underscores, and '
            'a letter first',
        )
    module = module_name(name)
    if keyword.iskeyword(module):
        raise UserError(
            f"'{name}' is no name for a package: it is a reserved word of "
            'Python, so its Python modules could not be imported'
        )
    if build_type == 'ament_python' and module in sys.stdlib_module_names:
        raise UserError(
            f"'{name}' is no name for a Python package: Python has a module "
            'of this name itself'
        )


def dislikes(name: str) -> Iterator[str]:
    """Iterate over what REP 144 has against a name that works all the same."""
    if name != name.lower():
        yield 'lower case letters only'
    if '-' in name:
        yield "underscores in place of '-'"
    if '__' in name:
        yield 'no underscores in a row'
    if len(name) < 2:
        yield 'at least two characters'


def advised_name(name: str) -> str:
    """Return a name as REP 144 asks for, made of another one."""
    words = re.sub(r'(?<=[a-z0-9])(?=[A-Z])', '_', name)
    return re.sub(r'[-_]+', '_', words).strip('_').lower()


def check_node_name(name: str, build_type: str, is_cpp: bool = False) -> None:
    """
    Check that a node, and so its Python module or program, may have a name.

    :param build_type: Such as `ament_python`
    :param is_cpp: Whether it is written in C++
    :raises UserError: when it may not
    """
    if not _NODE.fullmatch(name):
        raise UserError(
            f"'{name}' is no name for a node",
            'it consists of letters, digits and underscores, with a letter '
            'first',
        )
    if is_cpp:
        if name in _CMAKE_TARGETS:
            raise UserError(
                f"'{name}' is no name for a node written in C++: CMake has a "
                'target of this name itself'
            )
        return
    if keyword.iskeyword(name) or keyword.iskeyword(class_name(name)):
        raise UserError(
            f"'{name}' is no name for a node written in Python: it is a "
            'reserved word there'
        )
    hidden = sys.stdlib_module_names | {'rclpy'}
    if build_type != 'ament_python' and name in hidden:
        raise UserError(
            f"'{name}' is no name for a node here: scripts/{name}.py would "
            f"hide Python's own module '{name}' from itself"
        )


def default_node_name(package: str) -> str:
    """Return the name of a package's node when none is given."""
    name = module_name(package)
    return name if name.endswith('_node') else f'{name}_node'


def module_name(package: str) -> str:
    """Return the name of a package's Python module."""
    return package.replace('-', '_')


def class_name(node: str) -> str:
    """Return the name of the class of a node."""
    words = node.split('_')
    return ''.join(word[:1].upper() + word[1:] for word in words)
