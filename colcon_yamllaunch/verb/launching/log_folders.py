# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The log folders of launches, of which the oldest are deleted.

A launch holds a lock on its folder as long as it runs, whatever becomes of
it, so that no other launch deletes the folder.
"""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import contextmanager
from contextlib import suppress
import fcntl
import os
from pathlib import Path
import re
import shutil
import time

from colcon_core.location import get_log_path
from colcon_yamllaunch.runtime.record.launch_logs import COMMON_LOG
from colcon_yamllaunch.runtime.record.log_files import lock_folder
from colcon_yamllaunch.verb.cli.environment_variables import KEPT_LOG_FOLDERS
from colcon_yamllaunch.verb.cli.environment_variables import LOG_FOLDERS
from colcon_yamllaunch.verb.cli.log_base import default_log_base
from colcon_yamllaunch.verb.cli.log_base import is_writable
from colcon_yamllaunch.verb.cli.log_base import LOG_PATH
from colcon_yamllaunch.verb.cli.messages import say

_ALL = 'all'
# as colcon names them, and log_folder_of() where there is no workspace
_NAME = re.compile(r'launch_(\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d)(?:_(\d+))?')


@contextmanager
def locked(folder: Path | None) -> Iterator[None]:
    """Keep other launches from deleting a folder, made if it is missing."""
    descriptor = None
    if folder is not None:
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
        descriptor = lock_folder(folder)
    try:
        yield
    finally:
        if descriptor is not None:
            os.close(descriptor)


def delete_old_log_folders(
    folder: Path,
    environment: Mapping[str, str],
    warn: Callable[[str], None],
) -> None:
    """
    Delete the oldest folders beside that of a launch.

    As many are kept of launches that ran as, apart from these, of inspections.
    The last launch, to which `latest` leads, and what cannot be deleted stay.

    :param folder: The folder of the launch, which stays
    :param warn: Is told that the user's wish is no number
    """
    kept = _kept(environment, warn)
    if kept is None:
        return
    links = (folder.parent / n for n in ('latest', 'latest_launch'))
    latest = {path.resolve() for path in (folder, *links)}
    ran: list[Path] = []
    inspected: list[Path] = []
    for path in _folders(folder.parent):
        if path.resolve() not in latest:
            (ran if (path / COMMON_LOG).exists() else inspected).append(path)
    for paths in (ran, inspected):
        for path in paths[: max(0, len(paths) - kept)]:
            _delete(path)


def _kept(
    environment: Mapping[str, str], warn: Callable[[str], None]
) -> int | None:
    text = environment.get(LOG_FOLDERS.name) or str(KEPT_LOG_FOLDERS)
    if text == _ALL:
        return None
    if text.isascii() and text.isdigit():
        return int(text)
    warn(
        f"colcon launch: {LOG_FOLDERS.name} is a number or '{_ALL}', not "
        f"'{text}': no log folder is deleted"
    )
    return None


def _folders(base: Path) -> list[Path]:
    """Return the folders of launches, the oldest first."""
    found = []
    try:
        with os.scandir(base) as entries:
            for entry in entries:
                match = _NAME.fullmatch(entry.name)
                if match and entry.is_dir(follow_symlinks=False):
                    key = match[1], int(match[2] or 0)
                    found.append((key, Path(entry.path)))
    except OSError:
        return []
    return [path for _, path in sorted(found)]


def _delete(folder: Path) -> None:
    descriptor = lock_folder(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    if descriptor is not None:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(descriptor)


def log_folder_of(
    log_base: str | None, environment: Mapping[str, str]
) -> Path | None:
    """Return the folder for the logs of this launch, None for no logs."""
    path: Path | None = get_log_path()
    if path is not None:
        return path.absolute()
    if log_base is not None or environment.get(LOG_PATH):
        return None
    # there is no workspace to write to: the logs go where ROS 2 keeps them
    stamp = time.strftime('%Y-%m-%d_%H-%M-%S')
    folder = ros_log_folder(environment) / f'launch_{stamp}_{os.getpid()}'
    usual = default_log_base('launch')
    if not is_writable(folder.parent):
        places = ' and '.join(str(p) for p in (usual, folder.parent) if p)
        say(
            f'colcon launch: warning: {places} cannot be written to; there '
            'are no logs'
        )
        return None
    if usual is not None:
        say(
            f'colcon launch: warning: the log folder {usual} cannot be '
            f'written to; the logs are in {folder}'
        )
    return folder


def ros_log_folder(environment: Mapping[str, str]) -> Path:
    """Return where ROS 2 logs (rcl_logging_get_logging_directory)."""
    own = environment.get('ROS_LOG_DIR')
    if own:
        return Path(own).expanduser().absolute()
    home = environment.get('ROS_HOME') or '~/.ros'
    return Path(home).expanduser().absolute() / 'log'
