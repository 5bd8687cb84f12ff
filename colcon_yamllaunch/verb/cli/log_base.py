# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Where colcon keeps its logs for this command.

colcon makes `log/` in the current folder before it calls the verb. So the
choice is made while the arguments are added: in the workspace if there is one
that can be written to, else nowhere.
"""

import os
from pathlib import Path
import sys

from colcon_yamllaunch.common.errors import WorkspaceError

#: The variable that colcon takes the folder for logs from.
LOG_PATH = 'COLCON_LOG_PATH'

#: What the path of a launch file ends in.
PATH_SUFFIXES = ('.yaml', '.yml', '.launch', '.xml', '.py')

_WORKSPACE = '--workspace'


def choose_log_base(argv: list[str] | None = None) -> None:
    """
    Make colcon log in the workspace unless the user says where.

    :param argv: The part of the command line that tells the workspace; by
      default all of it
    """
    if not os.environ.get(LOG_PATH):
        from colcon_yamllaunch.verb.cli.control_options import is_control

        argv = sys.argv[1:] if argv is None else argv
        folder = None if is_control(argv) else default_log_base(argv)
        usable = folder is not None and _is_writable(folder)
        os.environ[LOG_PATH] = str(folder) if usable else os.devnull


def default_log_base(argv: list[str]) -> Path | None:
    """
    Return the log folder of the workspace, if there is a workspace.

    :param argv: The command line
    """
    root = root_of(argv)
    return None if root is None else root / 'log'


def root_of(argv: list[str]) -> Path | None:
    """
    Find the workspace that a command line is about.

    :param argv: The command line
    """
    from colcon_yamllaunch.workspace.packages.workspace_root import find_root

    given = _option(argv)
    if given is not None:
        folder = Path(given).expanduser().absolute()
        return folder if folder.is_dir() else None
    root = find_root(Path.cwd())
    for word in argv if root is None else ():
        if word.endswith(PATH_SUFFIXES):
            path = Path(word)
            if path.is_file():
                return find_root(path.absolute().parent)
    return root


def workspace_root(given: Path | None, words: list[str]) -> Path | None:
    """
    Return the workspace that is given, or else the one around.

    :param given: The value of `--workspace`, if given
    :param words: The words of the command line
    :raises WorkspaceError: if the folder does not exist
    """
    if given is None:
        return root_of(words)
    if not given.is_dir():
        raise WorkspaceError(f"there is no workspace folder '{given}'")
    return given.absolute()


def _is_writable(folder: Path) -> bool:
    # colcon shows a traceback if it cannot make the folder
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)


def _option(argv: list[str]) -> str | None:
    value = None
    for index, word in enumerate(argv):
        if word == _WORKSPACE:
            value = argv[index + 1] if index + 1 < len(argv) else None
        elif word.startswith(f'{_WORKSPACE}='):
            value = word.partition('=')[2]
    return value
