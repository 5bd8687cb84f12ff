# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The log folder of a launch, and the rules for those of older launches."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
import os
from pathlib import Path
import time
from typing import Any, TYPE_CHECKING

from colcon_core.location import get_log_path
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.messages import say
from colcon_yamllaunch.observers.log_files import lock_folder
from colcon_yamllaunch.verb.command_line import request_of, split_line
from colcon_yamllaunch.verb.environment_variables import (
    ALL_LOGS_LIMIT,
    KEPT_LOG_FOLDERS,
    LOG_FOLDERS,
    LOG_TOTAL,
)
from colcon_yamllaunch.verb.options import read_size
from colcon_yamllaunch.verb.target import find_workspace

if TYPE_CHECKING:
    from colcon_yamllaunch.observers.log_store import LogStore

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
) -> 'LogStore | None':
    """
    Return the log folders beside that of a launch, as the user wants them.

    :param folder: The folder of the launch
    :param warn: Receives a line if the user's wish is no number or size; then
      None is returned, as nothing is to be deleted
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
    # a launch may have no logs
    from colcon_yamllaunch.observers.log_store import LogStore

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


#: The variable that colcon takes the folder for logs from.
LOG_PATH = 'COLCON_LOG_PATH'

#: How much room there has to be for logs (bytes).
LEAST_ROOM = 64 * 1024


def choose_log_base(known: Any) -> None:
    """Make colcon log in the workspace unless the user says where."""
    if not os.environ.get(LOG_PATH):
        folder = default_log_base(known)
        usable = folder is not None and is_writable(folder)
        os.environ[LOG_PATH] = str(folder) if usable else os.devnull


def default_log_base(known: Any) -> Path | None:
    """
    Return the log folder of the workspace that the command line is about.

    None stands for no workspace, or nothing to log.
    """
    verb = known.verb_name
    if verb == 'create':
        # maybe there is no workspace yet
        return None
    values = known
    positionals: list[str] = []
    try:
        if verb != 'run':
            values, positionals, _ = split_line(known, verb)
        if values.version or getattr(values, 'help_all', False):
            return None
        if getattr(values, 'demo', False):
            # its workspace is yet to be made
            return None
        if verb == 'launch' and (
            request_of(values, positionals) or values.remove_service
        ):
            return None
        root = find_workspace(
            values.workspace,
            [word for word in positionals if not word.startswith('-')],
            builds=values.build_all or values.paths is not None,
        )
    except UserError:
        # the verb reports it; workspaces that are not trusted get no logs
        return None
    return None if root is None else root / 'log'


def is_writable(folder: Path) -> bool:
    """Return whether `folder`, which may be missing, can be written to."""
    # colcon shows a traceback if it cannot make the folder
    while not os.path.exists(folder) and folder != folder.parent:
        folder = folder.parent
    return (
        os.path.isdir(folder)
        and os.access(folder, os.W_OK | os.X_OK)
        and _has_room(folder)
    )


def _has_room(folder: Path) -> bool:
    disk = os.statvfs(folder)
    blocks = disk.f_bavail if os.getuid() else disk.f_bfree
    # some file systems do not count blocks or files
    return (disk.f_blocks == 0 or blocks * disk.f_frsize >= LEAST_ROOM) and (
        disk.f_files == 0 or disk.f_favail > 0
    )
