# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Where colcon keeps its logs for this command.

colcon makes `log/` in the current folder before it calls the verb. So the
choice is made while the arguments are added: in the workspace if there is one,
else nowhere.
"""

import os
from pathlib import Path
import sys

#: The variable that colcon takes the folder for logs from.
LOG_PATH = 'COLCON_LOG_PATH'

#: What the path of a launch file ends in.
PATH_SUFFIXES = ('.yaml', '.yml', '.launch', '.xml', '.py')

_WORKSPACE = '--workspace'


def choose_log_base() -> None:
    """Make colcon log in the workspace unless the user says where."""
    if not os.environ.get(LOG_PATH):
        root = root_of(sys.argv[1:])
        os.environ[LOG_PATH] = (
            os.devnull if root is None else str(root / 'log')
        )


def root_of(argv: list[str]) -> Path | None:
    """
    Find the workspace that a command line is about.

    :param argv: The command line
    """
    from colcon_yamllaunch.workspace.root import find_root

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


def _option(argv: list[str]) -> str | None:
    value = None
    for index, word in enumerate(argv):
        if word == _WORKSPACE:
            value = argv[index + 1] if index + 1 < len(argv) else None
        elif word.startswith(f'{_WORKSPACE}='):
            value = word.partition('=')[2]
    return value
