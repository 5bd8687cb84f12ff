# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Where temporary files may go.

Python's :mod:`tempfile` ends in the current folder, which is the user's
workspace, where none of the usual places can be written to.
"""

from collections.abc import Mapping
import os
from pathlib import Path

#: Where everybody may write, as the Filesystem Hierarchy Standard has it; the
#: last one is in memory, so that a full disk does not matter to it (glibc).
SHARED_FOLDERS = ('/tmp', '/var/tmp', '/dev/shm')


def temporary_folders(environment: Mapping[str, str]) -> tuple[Path, ...]:
    """
    Return the folders for temporary files, the one to be tried first.

    :param environment: `TMPDIR` in it comes first if it is absolute (POSIX)
    """
    own = environment.get('TMPDIR', '')
    folders = (own, *SHARED_FOLDERS) if os.path.isabs(own) else SHARED_FOLDERS
    return tuple(Path(folder) for folder in dict.fromkeys(folders))
