# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Questions to git, which may be missing."""

from collections.abc import Mapping
import os
from pathlib import Path
import subprocess

#: How long git may take to answer (seconds).
GIT_TIMEOUT = 10.0


def git_output(
    folder: Path, environment: Mapping[str, str], *words: str
) -> str:
    """Return what a command of git prints, '' if it fails."""
    try:
        done = subprocess.run(
            ['git', *words],
            cwd=folder,
            env=dict(environment),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=GIT_TIMEOUT,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ''
    return os.fsdecode(done.stdout)
