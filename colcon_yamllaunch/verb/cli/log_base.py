# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Where colcon keeps its logs for this command.

colcon makes `log/` in the current folder before it calls the verb. So the
choice is made when colcon has parsed the command line: in the workspace if
there is one that can be written to, else nowhere.
"""

from collections.abc import Iterable
import os
from pathlib import Path
import re
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.text_files import text_of
from colcon_yamllaunch.verb.cli.command_line import split_line
from colcon_yamllaunch.verb.cli.launch_options import control_action
from colcon_yamllaunch.workspace.packages.trust import Trust
from colcon_yamllaunch.workspace.packages.trust import UntrustedError
from colcon_yamllaunch.workspace.packages.workspace_root import find_root

#: The variable that colcon takes the folder for logs from.
LOG_PATH = 'COLCON_LOG_PATH'

#: The variable that names a workspace to use outside of all.
WORKSPACE = 'ROS_WORKSPACE'

#: How much room there has to be for logs (bytes).
LEAST_ROOM = 64 * 1024

# what a launch file of any language has if it, or what it includes, names a
# package
_PACKAGE = re.compile('pkg|package|include', re.IGNORECASE)

#: What the path of a launch file ends in.
PATH_SUFFIXES = ('.yaml', '.yml', '.launch', '.xml', '.py')


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
    if verb != 'run':
        try:
            values, positionals, _ = split_line(known, verb)
        except UserError:
            # the verb says so
            return None
    shows = values.version or getattr(values, 'help_all', False)
    if shows or (verb == 'launch' and control_action(values, positionals)):
        return None
    try:
        root = find_workspace(
            values.workspace,
            [word for word in positionals if not word.startswith('-')],
            builds=values.build_all or values.paths is not None,
        )
    except UntrustedError:
        # the verb says so; its log folder is not to be written to either
        return None
    return None if root is None else root / 'log'


def find_workspace(
    given: str | Path | None,
    positionals: Iterable[str],
    *,
    builds: bool = False,
) -> Path | None:
    """
    Find the workspace that is given, or else the one around.

    Outside of all it is that of the variable `ROS_WORKSPACE`, if that names
    a folder.

    :param given: The value of `--workspace`, if given
    :param positionals: Words, the path of a launch file maybe among them
    :param builds: Whether the user asks for a build, whatever is launched
    :raises UntrustedError: when it belongs to somebody else
    """
    if given is not None:
        return _trusted(Path(given).expanduser().absolute())
    files = (Path(w) for w in positionals if w.endswith(PATH_SUFFIXES))
    file = next((f for f in files if os.path.isfile(f)), None)
    # the search takes long where there are many folders
    searches = builds or file is None or _may_name_package(file)
    cwd = Path.cwd()
    root = find_root(cwd, searches=searches)
    folder = cwd if file is None else file.absolute().parent
    if root is None and folder != cwd:
        root = find_root(folder, searches=searches)
    if root is None and os.environ.get(WORKSPACE):
        folder = Path(os.environ[WORKSPACE]).expanduser()
        # what is relative would mean another one in each folder
        return _trusted(folder) if folder.is_absolute() else None
    return root


def _may_name_package(file: Path) -> bool:
    return _PACKAGE.search(text_of(file)) is not None


def _trusted(folder: Path) -> Path | None:
    if not os.path.isdir(folder):
        return None
    Trust(os.environ).check(Path(os.path.realpath(folder)))
    return folder


def workspace_root(
    given: Path | None,
    positionals: Iterable[str],
    *,
    builds: bool = False,
) -> Path | None:
    """
    Return what :func:`find_workspace` finds.

    :raises UserError: when the folder that is given does not exist, or what is
      found belongs to somebody else
    """
    if given is not None and not os.path.isdir(given):
        raise UserError(f"there is no workspace folder '{given}'")
    return find_workspace(given, positionals, builds=builds)


def is_writable(folder: Path) -> bool:
    """Tell whether a folder, which may have to be made, can be written to."""
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
