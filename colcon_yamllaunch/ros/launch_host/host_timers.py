# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What launch files do later."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from host_visit import Visitor


def install(visitor: Visitor) -> None:
    """Let timers be told as blocks."""
    del visitor
