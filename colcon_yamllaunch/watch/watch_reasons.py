# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What `--watch --why` says of each change."""

from collections.abc import Iterable
from collections.abc import Iterator
import os

from colcon_yamllaunch.common.printable import one_line
from colcon_yamllaunch.watch.changes import Change
from colcon_yamllaunch.watch.consequences import Consequence

_HAPPENED = {
    'new': 'is new',
    'changed': 'changed',
    'deleted': 'was deleted',
    'mode': 'can be run now, or no more',
    'again': 'is as before, but was not for a moment',
}


def why_lines(found: Iterable[Consequence], cwd: str = '') -> Iterator[str]:
    """
    Iterate over lines that tell what follows from changes, and why.

    :param cwd: The folder that paths are shown from
    """
    by_change: dict[Change, list[Consequence]] = {}
    for one in found:
        by_change.setdefault(one.change, []).append(one)
    for change, all_of_it in by_change.items():
        path = one_line(shown_path(change.path, cwd))
        what = '; '.join(_described(one) for one in all_of_it)
        yield f'[watch] {path} {_HAPPENED[change.kind]}: {what}'


def shown_path(path: str, cwd: str) -> str:
    """Return a path as it is shown: from the current folder, if below."""
    if cwd and path.startswith(cwd.rstrip(os.sep) + os.sep):
        return os.path.relpath(path, cwd)
    return path


def _described(one: Consequence) -> str:
    names = ', '.join(one.names)
    match one.action:
        case 'ignore':
            return f'nothing to do, as {one.reason}'
        case 'build':
            return f'build {names}, as {one.reason}'
        case 'replan':
            return f'evaluate the launch file, as {one.reason}'
        case 'restart':
            return f'restart {names}, as {one.reason}'
        case 'restart after build':
            return f'restart {names} after the build, as {one.reason}'
