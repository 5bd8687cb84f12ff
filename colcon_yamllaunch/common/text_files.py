# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Files that other programs and people write."""

from pathlib import Path


def text_of(path: Path) -> str:
    """Return the text of a file, whatever is in it; empty without one."""
    try:
        # what is no file, such as a named pipe, may have no end
        if not path.is_file():
            return ''
        return path.read_text(encoding='utf-8', errors='replace')
    except OSError:
        return ''
