# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Files in which something is kept that can be found out again."""

from collections.abc import Mapping
from contextlib import suppress
import json
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.text_files import content_of
from colcon_yamllaunch.common.text_files import write_file


def read_json(path: Path) -> Any:
    """Return what a file holds, None if it is not there or damaged."""
    try:
        return json.loads(content_of(path))
    except (OSError, ValueError, RecursionError):
        return None


def write_json(
    path: Path, values: Mapping[str, Any], mode: int = 0o666
) -> None:
    """
    Write a file that appears complete or, where it cannot, not at all.

    :param path: The file; its folder is made if necessary
    :param values: What it is to hold
    :param mode: Who may read and write it
    """
    with suppress(OSError):
        write_file(path, json.dumps(values).encode(), mode)
