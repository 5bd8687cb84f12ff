# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Where a launch keeps its logs, and what the user wants of older ones."""

from collections.abc import Callable
from collections.abc import Iterator
from collections.abc import Mapping
from contextlib import contextmanager
from contextlib import suppress
import os
from pathlib import Path
import time
from typing import Any

from colcon_core.location import get_log_path
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.observers.log_files import lock_folder
from colcon_yamllaunch.observers.log_store import LogStore
from colcon_yamllaunch.verb.cli.environment_variables import ALL_LOGS_LIMIT
from colcon_yamllaunch.verb.cli.environment_variables import KEPT_LOG_FOLDERS
from colcon_yamllaunch.verb.cli.environment_variables import LOG_FOLDERS
from colcon_yamllaunch.verb.cli.environment_variables import LOG_TOTAL
from colcon_yamllaunch.verb.cli.log_base import default_log_base
from colcon_yamllaunch.verb.cli.log_base import is_writable
from colcon_yamllaunch.verb.cli.log_base import LOG_PATH
from colcon_yamllaunch.verb.cli.messages import say
from colcon_yamllaunch.verb.cli.option_values import read_size

_ALL = 'all'


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


def log_store_of(
    folder: Path,
    environment: Mapping[str, str],
    warn: Callable[[str], None],
) -> LogStore | None:
    """
    Return the log folders beside that of a launch, as the user wants them.

    :param folder: The folder of the launch
    :param warn: Is told that the user's wish is no number or size; then there
      is no answer, as nothing is to be deleted
    """
    text = environment.get(LOG_FOLDERS.name) or str(KEPT_LOG_FOLDERS)
    if text != _ALL and not (text.isascii() and text.isdigit()):
        warn(
            f"colcon launch: {LOG_FOLDERS.name} is a number or '{_ALL}', not "
            f"'{text}': no log folder is deleted"
        )
        return None
    kept = None if text == _ALL else int(text)
    limit: int | None = ALL_LOGS_LIMIT
    if total := environment.get(LOG_TOTAL.name):
        try:
            limit = read_size(LOG_TOTAL.name, total)
        except UserError as e:
            warn(f'colcon launch: {e}: no log folder is deleted')
            return None
    return LogStore(folder, kept, limit)


def log_folder_of(known: Any, environment: Mapping[str, str]) -> Path | None:
    """Return the folder for the logs of this launch, None for no logs."""
    path: Path | None = get_log_path()
    if path is not None:
        return path.absolute()
    if known.log_base is not None or environment.get(LOG_PATH):
        return None
    # there is no workspace to write to: the logs go where ROS 2 keeps them
    stamp = time.strftime('%Y-%m-%d_%H-%M-%S')
    folder = ros_log_folder(environment) / f'launch_{stamp}_{os.getpid()}'
    usual = default_log_base(known)
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
