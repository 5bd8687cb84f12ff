# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where something is written."""

import os
from typing import Protocol

from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.common.printable import one_line


@dataclass(frozen=True, slots=True)
class Position:
    """
    A place in a file.

    :param path: The file as it was named or found
    :param line: The line, counted from 1
    :param column: The column in characters, counted from 1
    """

    path: str
    line: int
    column: int

    def __str__(self) -> str:
        return f'{self.path}:{self.line}:{self.column}'

    @property
    def position(self) -> 'Position':
        """The position itself, which is a span, too."""
        return self

    @property
    def length(self) -> int:
        """One character."""
        return 1


class Span(Protocol):
    """Something that is written somewhere."""

    @property
    def position(self) -> Position:
        """Where it starts."""

    @property
    def length(self) -> int:
        """How many characters it takes there, 1 if that does not matter."""


def shown_path(path: str, cwd: str) -> str:
    """Return the path as a user in `cwd` would write it."""
    relative = os.path.relpath(path, cwd)
    return path if relative.startswith('..') else relative


def shown_position(position: Position, cwd: str) -> str:
    """Return a position with its path as a user in `cwd` would write it."""
    path = one_line(shown_path(position.path, cwd))
    return f'{path}:{position.line}:{position.column}'
