# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Waiting for what other processes do."""

from collections.abc import Callable
from pathlib import Path
import time
from typing import Any

#: Seconds after which something will not happen any more.
DEADLINE = 180.0


def wait_until(condition: Callable[[], Any]) -> Any:
    """Return the first true value of a condition."""
    deadline = time.monotonic() + DEADLINE
    while not (value := condition()):
        assert time.monotonic() < deadline, 'it did not happen'
        time.sleep(0.01)
    return value


def is_running(pid: int) -> bool:
    """Return whether a process runs; a zombie does not count as running."""
    try:
        stat = Path(f'/proc/{pid}/stat').read_text(encoding='ascii')
    except (FileNotFoundError, ProcessLookupError):
        return False
    return stat.rpartition(') ')[2][0] not in 'ZX'
