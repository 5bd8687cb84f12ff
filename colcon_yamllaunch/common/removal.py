# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Removing what was built."""

from pathlib import Path
import shutil

from colcon_yamllaunch.common.errors import WorkspaceError


def remove_folder(path: Path, why: str) -> None:
    """
    Remove a folder, or the link to one; nothing if there is none.

    :param path: The folder
    :param why: Why, as a part of a sentence
    :raises WorkspaceError: when it cannot be removed
    """
    try:
        if path.is_symlink():
            path.unlink()
        elif path.is_dir():
            shutil.rmtree(path)
    except OSError as e:
        raise WorkspaceError(
            f'cannot remove {path}{why}: {e.strerror}. Remove it, then try '
            'again'
        ) from e
