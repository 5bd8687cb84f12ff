# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Waiting for the clock that a file system stamps files with."""

from pathlib import Path
import tempfile
import time

from colcon_yamllaunch.common.fingerprint import fingerprint


def let_files_settle(folder: Path) -> None:
    """Wait until any change of the files that are there would show."""
    with tempfile.NamedTemporaryFile(dir=folder) as newest:
        while not fingerprint(newest.name).is_settled:
            time.sleep(0.002)
