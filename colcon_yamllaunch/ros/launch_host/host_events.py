# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What launch files do when something happens."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from host_entries import Entries
    from host_visit import Visitor


def install(visitor: Visitor, entries: Entries) -> None:
    """Let the visitor handle events, and answer requests for them."""
    del visitor, entries
