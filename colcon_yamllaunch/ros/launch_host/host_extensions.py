# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Actions and substitutions of other packages in YAML and XML files."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from host_visit import Visitor


def install(visitor: Visitor) -> None:
    """Let the visitor answer requests for them."""
    del visitor
