# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Variables that list folders, such as PATH."""

import os


def split_path(value: str | None) -> list[str]:
    """Return the entries of a variable such as PATH that are not empty."""
    return [entry for entry in (value or '').split(os.pathsep) if entry]
