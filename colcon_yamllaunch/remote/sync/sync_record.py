# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What earlier launches have brought to a workspace, kept there.

Only what stands here is replaced or deleted later: all else somebody made
there.
"""

from collections.abc import Mapping
from contextlib import suppress
import json
import os
from pathlib import Path
import time
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import Fingerprint
from colcon_yamllaunch.common.json_files import read_json
from colcon_yamllaunch.remote.sync.tree_entries import digest_of
from colcon_yamllaunch.remote.sync.tree_entries import Entry

#: The name of the record, below the workspace.
RECORD_NAME = '.colcon_launch.synced.json'
#: To be raised when what is in it changes.
_VERSION = 1
#: How long a file system's clock takes at most to move on (seconds); see
#: `fingerprint.TICK`.
_SETTLED = 0.03


class SyncRecord:
    """
    The record of one workspace.

    A tree is what was brought from one folder: its `origin`, the workspace
    that it comes from; the `digest` of its entries, empty while they are being
    brought; `files`, the entries that are there, by paths relative to the
    tree, with the times that files had; `found`, the paths of those that were
    there already as they were to be, which are never deleted; `coming`, the
    entries of a transfer that has not ended; and `built`, those of files that
    a build there has written into its sources since.

    :param root: The workspace
    """

    def __init__(self, root: str) -> None:
        self._path = Path(root, RECORD_NAME)
        self.trees: dict[str, dict[str, Any]] = {}
        found = read_json(self._path)
        with suppress(KeyError, TypeError, AttributeError):
            if found['version'] == _VERSION:
                self.trees = {
                    str(place): {
                        'origin': str(tree['origin']),
                        'digest': str(tree['digest']),
                        'files': dict(tree['files']),
                        'found': list(tree['found']),
                        'coming': dict(tree['coming']),
                        'built': dict(tree['built']),
                    }
                    for place, tree in found['trees'].items()
                }

    def write(self) -> None:
        """
        Write it.

        :raises UserError: when it cannot be written
        """
        temporary = self._path.with_name(f'{RECORD_NAME}.{os.getpid()}')
        values = {'version': _VERSION, 'trees': self.trees}
        try:
            try:
                with temporary.open('wb') as file:
                    file.write(json.dumps(values).encode())
                temporary.replace(self._path)
            finally:
                temporary.unlink(missing_ok=True)
        except OSError as e:
            raise UserError(
                f'cannot write {self._path}: {e.strerror}. Make room there, '
                'or make the workspace there writable'
            ) from e


def recorded(entry: Entry, path: str) -> Entry:
    """Return an entry that is there, with the times of a file."""
    if entry[0] != 'f':
        return entry
    now = Fingerprint.of(os.lstat(path))
    return [*entry[:3], *_times(now)]


def is_untouched(entry: Entry, path: str, status: os.stat_result) -> bool:
    """
    Tell whether a file there is as it was recorded.

    :raises UserError: when it cannot be read
    """
    now = Fingerprint.of(status)
    if len(entry) > 3 and entry[3:] == _times(now) and now.ctime:
        return True
    return digest_of(path, status) == str(entry[2])


def let_settle() -> None:
    """Wait until a change of what is there now would show in its times."""
    time.sleep(_SETTLED)


def _times(now: Fingerprint) -> list[int]:
    # what may change without a trace is read again
    ctime = now.ctime if now.is_settled else 0
    return [now.size, now.mtime, ctime, now.inode]


def empty_tree(origin: str) -> dict[str, Any]:
    """Return the record of a tree of which nothing was brought."""
    values: Mapping[str, Any] = {
        'origin': origin,
        'digest': '',
        'files': {},
        'found': [],
        'coming': {},
        'built': {},
    }
    return dict(values)
