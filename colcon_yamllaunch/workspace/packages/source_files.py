# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The files that a package's source consists of."""

from collections.abc import Iterator
import os
from pathlib import Path
import re
import stat

from colcon_yamllaunch.workspace.packages.workspace_root import IGNORE_MARKERS

_SKIPPED_FOLDERS = {
    *('.git', '.hg', '.svn', '.bzr', 'CVS', '.vscode', '.idea', '.vs'),
    *('__pycache__', '.cache', '.pytest_cache', '.mypy_cache', '.ruff_cache'),
    *('.hypothesis', '.eggs', '.tox', '.nox'),
}
#: Left by editors and by others: *~ .#* #*# .*.sw? *.kate-swp 4913 *.pyc …
_SKIPPED_FILES = re.compile(
    r'.*~|\.#.*|#.*#|\..*\.sw.|.*\.kate-swp|4913'
    r'|.*___jb_(tmp|old)___|\.goutputstream-.*|\.~lock\..*#'
    r'|.*\.pyc|\.coverage|\.nfs.*|\.fuse_hidden.*|\.DS_Store',
    re.DOTALL,
)
_BUILD_FOLDERS = ('build', 'install', 'log')


def source_files(folder: Path) -> Iterator[tuple[str, os.stat_result]]:
    """
    Iterate over the files of a package's source, by path and status.

    Left out is what version control, editors, caches and colcon itself put
    there. Symbolic links are followed; a dangling one is a file on its own.
    They come in no particular order.
    """
    pending = [(str(folder), '')]
    seen: set[tuple[int, int]] = set()
    while pending:
        path, below = pending.pop()
        for entry in entries_of(path):
            try:
                status = entry.stat()
            except OSError:
                status = entry.stat(follow_symlinks=False)
            relative = below + entry.name
            if not stat.S_ISDIR(status.st_mode):
                if not is_skipped_file(entry.name):
                    yield relative, status
                continue
            place = (status.st_dev, status.st_ino)
            if place not in seen and not is_skipped_folder(entry):
                seen.add(place)
                pending.append((entry.path, relative + os.sep))


def is_skipped_file(name: str) -> bool:
    """Tell whether a file belongs to an editor or a cache, by its name."""
    return _SKIPPED_FILES.fullmatch(name) is not None


def is_skipped_folder(entry: os.DirEntry[str]) -> bool:
    """Tell whether nothing in a folder belongs to the source."""
    if entry.name in _SKIPPED_FOLDERS or entry.name.endswith('.egg-info'):
        return True
    if entry.name not in _BUILD_FOLDERS:
        return False
    return any(
        os.path.lexists(Path(entry.path, marker)) for marker in IGNORE_MARKERS
    )


def entries_of(path: str) -> list[os.DirEntry[str]]:
    """Return what is in a folder, nothing if it cannot be read."""
    try:
        with os.scandir(path) as entries:
            return list(entries)
    except OSError:
        return []
