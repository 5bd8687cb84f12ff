# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Making what was written survive a power cut."""

from collections.abc import Iterable
from contextlib import suppress
import os
from pathlib import Path

# what is written later, or None if all is written at once
_put_off: list[Path] | None = None


def put_off() -> None:
    """Postpone flushing of all disks to :func:`catch_up`."""
    global _put_off
    _put_off = []


def catch_up() -> None:
    """Write what was put off."""
    global _put_off
    folders, _put_off = _put_off, None
    if folders:
        sync_file_systems(folders)


def sync_file_systems(folders: Iterable[Path]) -> None:
    """
    Write all that is not yet on the disks of some folders, in one call each.

    Folders on the same disk count once. Where this cannot be done, nothing is.
    """
    if _put_off is not None:
        _put_off.extend(folders)
        return
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
