# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Finding the files that a part names. Runs on the machine."""

from collections.abc import Callable
from collections.abc import Mapping
import os
from typing import Any


def look(
    arguments: Mapping[str, Any], _say: Callable[[str], None]
) -> dict[str, Any]:
    """
    Return the paths without a file or folder, as `missing`.

    :param arguments: `paths`, absolute or with a leading `~/`
    """
    paths = arguments['paths']
    return {
        'missing': [
            path
            for path in paths
            if not os.path.exists(os.path.expanduser(path))
        ]
    }
