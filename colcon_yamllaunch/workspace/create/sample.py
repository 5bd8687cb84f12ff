# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Copying the sample workspace.

In the repository, `sample_ws` beside this module is a link to the folder at
the top; the wheel and the sdist have its files in this place.
"""

from collections.abc import Iterator
from pathlib import Path
import shutil

from colcon_yamllaunch.workspace.create.new_package import (
    make_executable,
    new_folder,
)

SAMPLE = Path(__file__).parent / 'sample_ws'
#: Its launch file that needs nothing but Python.
LAUNCH_FILE = ('talk', 'talk.yaml')

#: What colcon makes in a workspace, such as in a clone that is used.
_PRODUCTS = ('build', 'install', 'log')


def copy_sample(folder: Path) -> None:
    """
    Copy the sample workspace.

    :param folder: Where to; it must not be there yet
    :raises UserError: when it is there or cannot be written; then nothing is
      left of it
    """
    with new_folder(folder, 'name another one: --example DIR'):
        for path in _files():
            source, copy = SAMPLE / path, folder / path
            copy.parent.mkdir(parents=True, exist_ok=True)
            # an installed file may be read-only, and lack its executable bit
            shutil.copyfile(source, copy)
            if copy.read_bytes().startswith(b'#!'):
                make_executable(copy)


def _files() -> Iterator[Path]:
    """Yield the files by their paths, without what was built or cached."""
    for path in sorted(SAMPLE.rglob('*')):
        relative = path.relative_to(SAMPLE)
        if relative.parts[0] in _PRODUCTS or any(
            part.startswith(('.', '__pycache__')) or part.endswith('.egg-info')
            for part in relative.parts
        ):
            continue
        if path.is_file():
            yield relative
