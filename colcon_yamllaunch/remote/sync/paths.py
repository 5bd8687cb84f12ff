# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Looks on a machine for the files that its part of a launch names."""

from collections.abc import Callable
from collections.abc import Mapping
import os
from typing import Any


def look(
    arguments: Mapping[str, Any], _say: Callable[[str], None]
) -> dict[str, Any]:
    """
    Return which paths there is nothing at.

    :param arguments: `paths`, absolute ones or such that begin with `~/`
    """
    paths = arguments['paths']
    return {
        'missing': [
            path
            for path in paths
            if not os.path.exists(os.path.expanduser(path))
        ]
    }
