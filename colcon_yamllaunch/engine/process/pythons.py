# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The Pythons of an environment, which may have other packages than ours."""

import os

from colcon_yamllaunch.engine import limits

_PYTHON = 'python3'


def pythons(path: str) -> list[str]:
    """
    Return the Pythons of an environment; the first one counts most.

    :param path: The folders to search, separated by colons
    """
    found: dict[str, str] = {}
    for folder in path.split(':'):
        candidate = os.path.join(folder, _PYTHON)
        if os.path.isfile(candidate) and os.access(candidate, os.X_OK):
            # not that of the program: each virtual environment is one
            found.setdefault(os.path.realpath(folder), candidate)
    # whose lack is reported when it is started
    return list(found.values())[: limits.PYTHONS] or [_PYTHON]
