# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Telling whether a file or folder is as it was, without reading it.

The time of the last change of status is part of it: unlike that of the last
modification no program can set it back.
"""

from collections.abc import Iterable
import os
import stat
import time

#: A file that was written so shortly before it was looked at may be written
#: again without another time stamp (nanoseconds).
RACY_AGE = 2_000_000_000
#: Size, times of modification and of the change of status, number of the
#: file; a list, as JSON gives it back.
State = list[int]


def state_of(path: str) -> State | None:
    """
    Get the state of a file or folder.

    :param path: Links are followed; a dangling one is a file on its own
    :returns: None when there is nothing
    """
    try:
        status = os.stat(path)
    except OSError:
        try:
            status = os.lstat(path)
        except OSError:
            return None
    return state_from(status)


def state_from(status: os.stat_result) -> State:
    """Get the state of what has a status."""
    # the size of a folder tells nothing that its times do not tell
    size = -1 if stat.S_ISDIR(status.st_mode) else status.st_size
    return [size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino]


def states_of(paths: Iterable[str]) -> dict[str, State | None]:
    """Get the states of some paths."""
    return {path: state_of(path) for path in paths}


def is_settled(state: State | None) -> bool:
    """
    Tell whether any later change would show in the state.

    One within the same tick of the file system's clock would not.

    :param state: The state, which was got a moment ago
    """
    if state is None:
        return True
    # a time in the future is as good as one long ago
    return not 0 <= time.time_ns() - state[2] < RACY_AGE
