# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Cache files in JSON: losing one only costs time."""

from collections.abc import Mapping
from contextlib import suppress
import json
from pathlib import Path
from typing import Any

from colcon_yamllaunch.common.text_files import content_of, write_file


def read_json(path: Path) -> Any:
    """Return what a file holds, None if it is not there or damaged."""
    try:
        return json.loads(content_of(path))
    except (OSError, ValueError, RecursionError):
        return None


def write_json(
    path: Path, values: Mapping[str, Any], mode: int = 0o666
) -> None:
    """Write a file as :func:`save_json` does, if that is possible."""
    with suppress(OSError):
        save_json(path, values, mode)


def save_json(
    path: Path, values: Mapping[str, Any], mode: int = 0o666
) -> None:
    """
    Write a file that appears complete or not at all, with its folder.

    :param values: What it is to hold
    :param mode: Who may read and write it
    :raises OSError: when it cannot be written
    """
    write_file(path, json.dumps(values).encode(), mode)
