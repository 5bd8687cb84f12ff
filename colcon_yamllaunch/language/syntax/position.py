# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where something is written."""

from colcon_yamllaunch.common.frozen import dataclass


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
