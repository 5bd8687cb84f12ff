# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Files under `build/` in which something is remembered between launches."""

from collections.abc import Mapping
import json
import os
from pathlib import Path
from typing import Any


def read_json(path: Path) -> Any:
    """Read a file; None if it is not there or damaged."""
    try:
        return json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None


def write_json(path: Path, values: Mapping[str, Any]) -> None:
    """
    Write a file so that it appears complete or not at all.

    :raises OSError: when it cannot be written
    """
    temporary = path.with_name(f'{path.name}.{os.getpid()}')
    try:
        temporary.write_text(json.dumps(values), encoding='utf-8')
        temporary.replace(path)
    except OSError:
        temporary.unlink(missing_ok=True)
        raise
