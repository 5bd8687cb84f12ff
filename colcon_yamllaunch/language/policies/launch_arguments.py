# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What declares a launch argument, and what is said where nothing does."""

from collections.abc import Collection
from collections.abc import Iterable
from pathlib import Path

from colcon_yamllaunch.common.suggestions import did_you_mean
from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.language.syntax.diagnostics import error
from colcon_yamllaunch.language.syntax.diagnostics import LaunchError
from colcon_yamllaunch.language.tree.launch_tree import LaunchFile

#: The actions that declare one.
ARGUMENT_ACTIONS = ('arg', 'bool_arg')
#: Those that every process heeds, as in ROS 2.
PROCESS_ARGUMENTS = (
    'launch-prefix',
    'launch-prefix-filter',
    'emulate_tty',
    'sigterm_timeout',
    'sigkill_timeout',
)


def declared_arguments(files: Iterable[LaunchFile]) -> set[str]:
    """Return the launch arguments that some launch files declare."""
    return {
        entity.item.texts['name'].plain
        for file in files
        for entity in file.walk()
        if entity.action.name in ARGUMENT_ACTIONS
    }


def written_in_python(paths: Iterable[str]) -> set[str]:
    """Return the launch arguments that launch files in Python declare."""
    from colcon_yamllaunch.language.python_files.python_source import (
        written_arguments,
    )

    return {a.name for path in paths for a in written_arguments(path)}


def in_python(paths: Iterable[str], names: Iterable[str]) -> set[str]:
    """Return those of some names that launch files in Python have."""
    texts = [text_of(Path(path)) for path in paths]
    return {
        name
        for name in names
        if any(f"'{name}'" in t or f'"{name}"' in t for t in texts)
    }


def undeclared_argument(name: str, hint: str) -> LaunchError:
    """Return the warning of a given argument that no launch file knows."""
    message = f"no launch file declares the launch argument '{name}'"
    return error(message, hint=hint).as_warning()


def undeclared_hint(name: str, declared: Collection[str]) -> str:
    """Return what may be meant by an argument that is not declared."""
    listed = ', '.join(sorted(declared)) or 'none'
    return did_you_mean(name, declared) or f'it declares {listed}'
