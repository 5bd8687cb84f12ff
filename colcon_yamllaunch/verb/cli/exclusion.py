# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Options that exclude one another."""

from collections.abc import Sequence

from colcon_yamllaunch.common.errors import WorkspaceError


def option_of(name: str) -> str:
    """Get an option as it is typed, from its name in parsed options."""
    return f'--{name}'.replace('_', '-')


def at_most_one(given: Sequence[str]) -> None:
    """
    Refuse options that were given together and exclude one another.

    :param given: Those of them that were given, as they are typed
    :raises WorkspaceError: if it is more than one
    """
    if len(given) > 1:
        raise excluded(given[0], given[1])


def excluded(one: str, other: str) -> WorkspaceError:
    """Get the error for two options, as they are typed."""
    return WorkspaceError(f'{one} and {other} exclude one another')
