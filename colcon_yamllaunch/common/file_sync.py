# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Making what was written survive a power cut."""

from collections.abc import Iterable
from contextlib import suppress
import os
from pathlib import Path


def sync_file_systems(folders: Iterable[Path]) -> None:
    """
    Write all that is not yet on the disks of some folders, in one call each.

    Folders on the same disk count once. Where this cannot be done, nothing is.
    """
    # this takes some milliseconds, and few launches build
    import ctypes

    done = set()
    for folder in folders:
        with suppress(OSError, AttributeError):
            descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            try:
                device = os.fstat(descriptor).st_dev
                if device not in done:
                    # of Linux, see syncfs(2); Python has only sync(2), which
                    # waits for all disks there are
                    ctypes.CDLL(None).syncfs(descriptor)
                    done.add(device)
            finally:
                os.close(descriptor)
